//! STL in its binary form: the triangles of a surface, without units and without names for points.

use super::error::ExportError;
use super::fitted::{Fitted, GENERATOR};
use super::format::Format;
use super::mesh::{Mesh, single};
use super::nurbs::Nurbs;
use super::vectors::{cross, minus, unit};

/// Bytes of the header, and of each triangle.
const HEADER: usize = 80;
const TRIANGLE: usize = 50;

/// The triangles of a surface.
pub(super) fn write(nurbs: &Nurbs, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let format = Format::Stl;
    let mesh = Mesh::new(nurbs, fitted.options.samples, format)?;
    let place = |position: &[f32; 3]| -> Result<[f32; 3], ExportError> {
        let [x, y, z] = [0, 1, 2].map(|c| f64::from(position[c]) + mesh.origin[c]);
        Ok([single(x, format)?, single(y, format)?, single(z, format)?])
    };
    let places: Vec<[f32; 3]> = mesh.positions.iter().map(place).collect::<Result<_, _>>()?;
    let mut file = Vec::with_capacity(HEADER + 4 + TRIANGLE * mesh.triangles.len());
    // A header that begins with "solid" would look like the text form.
    file.extend(GENERATOR.as_bytes());
    file.resize(HEADER, b' ');
    file.extend([0; 4]);
    let mut count = 0_u32;
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
    file[HEADER..HEADER + 4].copy_from_slice(&count.to_le_bytes());
    Ok(file)
}
