//! glTF 2.0 as one binary file (GLB): a triangle mesh of a surface, lines along a curve.

use serde_json::{Value, json};

use super::error::ExportError;
use super::fitted::{Fitted, GENERATOR};
use super::format::Format;
use super::mesh::Mesh;
use super::nurbs::Nurbs;

/// Codes of the specification: component types (3.6.2.2), buffer view targets (5.11.5) and modes
/// of primitives (5.24.4).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// The curve or surface as a GLB file.
pub(super) fn write(nurbs: &Nurbs, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let mesh = Mesh::new(nurbs, fitted.options.samples, Format::Gltf)?;
    let mut file = Buffers::default();
    let (low, high) = bounds(&mesh.positions);
    let position = file.vectors(&mesh.positions, Some((low, high)));
    let mut attributes = json!({"POSITION": position});
    let (mode, indices) = if mesh.triangles.is_empty() {
        // Separate lines: strips, which would need no indices, are left out by some readers.
        (LINES, file.indices(mesh.lines.as_flattened()))
    } else {
        attributes["NORMAL"] = json!(file.vectors(&mesh.normals, None));
        (TRIANGLES, file.indices(mesh.triangles.as_flattened()))
    };
    let primitive = json!({
        "attributes": attributes,
        "indices": indices,
        "mode": mode,
        "material": 0,
    });
    Ok(container(
        &document(fitted, &mesh, primitive, &file),
        file.bytes,
    ))
}

/// The JSON of the file. Its vertices have the coordinates of the fit; glTF has its y axis upwards
/// where CAD has z (section 3.4), so the node is turned by −90° about x.
fn document(fitted: &Fitted<'_>, mesh: &Mesh, primitive: Value, file: &Buffers) -> Value {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let [x, y, z] = mesh.origin;
    let title = fitted.title();
    json!({
        "asset": {"version": "2.0", "generator": GENERATOR},
        "scene": 0,
        "scenes": [{"name": title, "nodes": [0]}],
        "nodes": [{
            "name": title,
            "mesh": 0,
            "rotation": [-half, 0.0, 0.0, half],
            "translation": [x, z, -y],
        }],
        "meshes": [{
            "name": title,
            "primitives": [primitive],
            "extras": {"description": fitted.description()},
        }],
        "materials": [{
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.23, 0.48, 0.73, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.6,
            },
            "doubleSided": true,
        }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.bytes.len()}],
    })
}

/// The binary data and the JSON that says what is where in it.
#[derive(Debug, Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffers {
    /// Appends vectors, and returns the number of their accessor. Positions have bounds.
    fn vectors(&mut self, vectors: &[[f32; 3]], bounds: Option<([f32; 3], [f32; 3])>) -> usize {
        let start = self.bytes.len();
        for vector in vectors {
            for x in vector {
                self.bytes.extend(x.to_le_bytes());
            }
        }
        let mut accessor = json!({
            "componentType": FLOAT,
            "count": vectors.len(),
            "type": "VEC3",
        });
        if let Some((low, high)) = bounds {
            accessor["min"] = json!(low);
            accessor["max"] = json!(high);
        }
        self.view(start, ARRAY_BUFFER, accessor)
    }

    /// Appends numbers of vertices, and returns the number of their accessor.
    fn indices(&mut self, indices: &[u32]) -> usize {
        let start = self.bytes.len();
        for index in indices {
            self.bytes.extend(index.to_le_bytes());
        }
        let accessor = json!({
            "componentType": UNSIGNED_INT,
            "count": indices.len(),
            "type": "SCALAR",
        });
        self.view(start, ELEMENT_ARRAY_BUFFER, accessor)
    }

    fn view(&mut self, start: usize, target: u32, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": start,
            "byteLength": self.bytes.len() - start,
            "target": target,
        }));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in positions {
        for c in 0..3 {
            low[c] = low[c].min(position[c]);
            high[c] = high[c].max(position[c]);
        }
    }
    (low, high)
}

/// Header, JSON chunk and binary chunk, each padded to four bytes (section 4.4). All lengths are
/// far below the four gigabytes of their fields, because meshes are bounded.
fn container(document: &Value, mut binary: Vec<u8>) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    let length = |file: &mut Vec<u8>, bytes: usize| file.extend((bytes as u32).to_le_bytes());
    file.extend(b"glTF");
    length(&mut file, 2);
    length(&mut file, total);
    length(&mut file, json.len());
    file.extend(b"JSON");
    file.extend(json);
    length(&mut file, binary.len());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}
