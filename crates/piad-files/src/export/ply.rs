//! PLY in its binary form: the vertices of surfaces in double precision with their normals, and triangles.

use super::document::Document;
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::format::Format;
use super::mesh::SampledGrid;
use super::sampling::finite;
use super::text::ascii;

/// The number of vertices of a triangle.
const CORNERS: u8 = 3;

/// The meshes of all surfaces as one.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut mesh = Mesh::default();
    document.try_each(|shape| {
        let grid = SampledGrid::new(shape.nurbs, shape.outline, &document.options)?;
        let first = mesh.vertices;
        mesh.append(&grid, &grid.normals(shape.nurbs))?;
        if document.has_parts {
            let last = mesh.vertices.saturating_sub(1);
            let title = ascii(shape.title());
            mesh.comments
                .push_str(&format!("comment vertices {first} to {last}: {title}\n"));
        }
        Ok(())
    })?;
    let mut file = header(document, &mesh).into_bytes();
    file.extend(mesh.vertex_bytes);
    file.extend(mesh.face_bytes);
    Ok(file)
}

/// Vertices and triangles, as they are in the file.
#[derive(Default)]
struct Mesh {
    vertices: usize,
    vertex_bytes: Vec<u8>,
    faces: usize,
    face_bytes: Vec<u8>,
    /// Lines of the header with the vertices of a part.
    comments: String,
}

impl Mesh {
    fn append(&mut self, grid: &SampledGrid, normals: &[[f32; 3]]) -> Result<(), ExportError> {
        let format = Format::Ply;
        let too_large = |_| ExportError::TooLarge { format };
        let first = i32::try_from(self.vertices).map_err(too_large)?;
        let points = finite(&grid.jets, grid.columns())?;
        for (point, normal) in points.iter().zip(normals) {
            self.vertex_bytes
                .extend(point.iter().flat_map(|x| x.to_le_bytes()));
            self.vertex_bytes
                .extend(normal.iter().flat_map(|x| x.to_le_bytes()));
        }
        self.vertices += points.len();
        // Numbers of vertices are signed in files that old programs read.
        i32::try_from(self.vertices).map_err(too_large)?;
        for triangle in &grid.triangles {
            self.face_bytes.push(CORNERS);
            for corner in triangle {
                let number = first.saturating_add_unsigned(*corner);
                self.face_bytes.extend(number.to_le_bytes());
            }
            self.faces += 1;
        }
        Ok(())
    }
}

fn header(document: &Document<'_>, mesh: &Mesh) -> String {
    let title = ascii(&document.title);
    let description = &document.description;
    let Mesh {
        vertices,
        faces,
        comments,
        ..
    } = mesh;
    format!(
        "ply\nformat binary_little_endian 1.0\n\
         comment {title} ({description}), written by {GENERATOR}\n{comments}\
         element vertex {vertices}\n\
         property double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {faces}\n\
         property list uchar int vertex_indices\n\
         end_header\n"
    )
}
