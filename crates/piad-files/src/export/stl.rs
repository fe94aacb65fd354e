//! STL in its binary form: the triangles of a surface, without units and without names for points.

use super::document::Document;
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::format::Format;
use super::mesh::{Mesh, single};
use piad_fit::engine::vectors::{cross, minus, unit};

/// Bytes of the header, and of each triangle.
const HEADER: usize = 80;
const TRIANGLE: usize = 50;

/// The triangles of all surfaces.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut file = Vec::new();
    // A header that begins with "solid" would look like the text form.
    file.extend(GENERATOR.as_bytes());
    file.resize(HEADER, b' ');
    file.extend([0; 4]);
    let mut count = 0_usize;
    document.try_each(|shape| {
        let mesh = Mesh::new(shape.nurbs, shape.outline, &document.options, Format::Stl)?;
        count += triangles(&mut file, &mesh)?;
        Ok(())
    })?;
    let format = Format::Stl;
    let count = u32::try_from(count).map_err(|_| ExportError::TooLarge { format })?;
    file[HEADER..HEADER + 4].copy_from_slice(&count.to_le_bytes());
    Ok(file)
}

/// Appends the triangles of a mesh, and returns their number.
fn triangles(file: &mut Vec<u8>, mesh: &Mesh) -> Result<usize, ExportError> {
    let format = Format::Stl;
    let place = |position: &[f32; 3]| -> Result<[f32; 3], ExportError> {
        let [x, y, z] = [0, 1, 2].map(|c| f64::from(position[c]) + mesh.origin[c]);
        Ok([single(x, format)?, single(y, format)?, single(z, format)?])
    };
    let places: Vec<[f32; 3]> = mesh.positions.iter().map(place).collect::<Result<_, _>>()?;
    file.reserve(TRIANGLE * mesh.triangles.len());
    let mut count = 0;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| places[index as usize]);
        // At poles corners coincide: such triangles have no sides and no normal.
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let Some(normal) = unit(cross(minus(b, a), minus(c, a))) else {
            continue;
        };
        let normal = normal.map(|x| x as f32);
        for x in normal.iter().chain(corners.as_flattened()) {
            file.extend(x.to_le_bytes());
        }
        file.extend([0; 2]);
        count += 1;
    }
    Ok(count)
}
