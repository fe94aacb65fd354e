//! glTF 2.0 as one binary file (GLB): a triangle mesh of a surface, lines along a curve.

use serde_json::{Value, json};

use super::document::Document;
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::format::Format;
use super::mesh::Mesh;

/// Codes of the specification: component types (3.6.2.2), buffer view targets (5.11.5) and modes
/// of primitives (5.24.4).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// The most bytes of binary data.
const MOST_BYTES: usize = 3 << 30;

/// The curves and surfaces as a GLB file, a node and a mesh each.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut file = Buffers::default();
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    document.try_each(|shape| {
        let mesh = Mesh::new(shape.nurbs, shape.outline, &document.options, Format::Gltf)?;
        // The title of a fit names the scene, too.
        let title = shape.title();
        nodes.push(node(title, nodes.len(), mesh.origin));
        meshes.push(json!({
            "name": title,
            "primitives": [primitive(&mesh, &mut file)],
            "extras": {"description": document.description_of(shape)},
        }));
        file.check()
    })?;
    let json = json_document(&document.title, nodes, meshes, &file);
    container(&json, file.bytes)
}

/// The lines or triangles of a mesh.
fn primitive(mesh: &Mesh, file: &mut Buffers) -> Value {
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
    json!({
        "attributes": attributes,
        "indices": indices,
        "mode": mode,
        "material": 0,
    })
}

/// The place of a mesh. Its vertices have the coordinates of the fit; glTF has its y axis upwards
/// where CAD has z (section 3.4), so the node is turned by −90° about x.
fn node(title: &str, mesh: usize, [x, y, z]: [f64; 3]) -> Value {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    json!({
        "name": title,
        "mesh": mesh,
        "rotation": [-half, 0.0, 0.0, half],
        "translation": [x, z, -y],
    })
}

/// The JSON of the file.
fn json_document(title: &str, nodes: Vec<Value>, meshes: Vec<Value>, file: &Buffers) -> Value {
    json!({
        "asset": {"version": "2.0", "generator": GENERATOR},
        "scene": 0,
        "scenes": [{"name": title, "nodes": (0..nodes.len()).collect::<Value>()}],
        "nodes": nodes,
        "meshes": meshes,
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

/// The binary data and the JSON that describes its layout.
#[derive(Debug, Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffers {
    /// Refuses more bytes than the fields of a GLB file count, with some room for the JSON.
    fn check(&self) -> Result<(), ExportError> {
        match self.bytes.len() > MOST_BYTES {
            true => Err(ExportError::TooLarge {
                format: Format::Gltf,
            }),
            false => Ok(()),
        }
    }

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

/// Header, JSON chunk and binary chunk, each padded to four bytes (section 4.4).
fn container(document: &Value, mut binary: Vec<u8>) -> Result<Vec<u8>, ExportError> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    let length = |file: &mut Vec<u8>, bytes: usize| -> Result<(), ExportError> {
        let format = Format::Gltf;
        let bytes = u32::try_from(bytes).map_err(|_| ExportError::TooLarge { format })?;
        file.extend(bytes.to_le_bytes());
        Ok(())
    };
    file.extend(b"glTF");
    length(&mut file, 2)?;
    length(&mut file, total)?;
    length(&mut file, json.len())?;
    file.extend(b"JSON");
    file.extend(json);
    length(&mut file, binary.len())?;
    file.extend(b"BIN\0");
    file.extend(binary);
    Ok(file)
}
