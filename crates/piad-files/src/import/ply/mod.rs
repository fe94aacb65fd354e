//! PLY files, as text and binary: the vertices of meshes and clouds are points, between which the faces are; colours are not
//! read.
//!
//! - `header`: the elements of the file;
//! - `body`: the vertices and the faces.

mod body;
mod header;

use super::byte_lines::{ByteLines, words};
use super::cloud::{mesh_notice, not_read, too_few};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Part;
use body::Body;
use header::{Element, Header};

/// Returns true if a file is PLY: its first line could be the title of a table.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    let mut lines = ByteLines::new(bytes);
    let mut first_word = || lines.next_filled().and_then(|line| words(line).next());
    let known: [&[u8]; 4] = [b"format", b"comment", b"obj_info", b"element"];
    first_word() == Some(b"ply") && first_word().is_some_and(|word| known.contains(&word))
}

/// The vertices, which have no order.
pub(super) fn read(bytes: &[u8], hints: &Hints) -> Result<Part, FileErrors> {
    let header = Header::read(bytes)?;
    let place = header
        .elements
        .iter()
        .position(|it| it.name == header::VERTEX);
    let (above, element) = place
        .and_then(|place| Some((header.elements.get(..place)?, header.elements.get(place)?)))
        .ok_or_else(|| FileError::of_file("the header has no element vertex (PLY)"))?;
    let mut body = Body::new(&header);
    above
        .iter()
        .try_for_each(|above| body.skip(above))
        .ok_or_else(|| too_few(0, element.count, "vertices", "PLY"))?;
    let below = header.elements.get(place.unwrap_or_default() + 1..);
    Ok(vertices((element, below.unwrap_or_default()), body, hints)?)
}

fn vertices(
    (element, below): (&Element, &[Element]),
    mut body: Body<'_>,
    hints: &Hints,
) -> Result<Part, FileError> {
    let coordinates = element.coordinates()?;
    let (cloud, numbers) = body.vertices(element, &coordinates, hints)?;
    let face = below.iter().position(|it| it.name == "face");
    let mut triangles = Vec::new();
    let mut faces = 0;
    if let Some((between, face)) =
        face.and_then(|face| Some((below.get(..face)?, below.get(face)?)))
    {
        faces = face.count;
        let passed = between.iter().try_for_each(|it| body.skip(it));
        passed.ok_or_else(|| too_few(0, faces, "faces", "PLY"))?;
        if let Some(corners) = face.corners().filter(|_| coordinates.len() == 3) {
            triangles = body
                .faces(face, corners, numbers.len())?
                .renumbered(&numbers)
                .triangles;
        }
    }
    let mut notices = vec![mesh_notice(cloud.len(), faces, "PLY")];
    let others = element.properties.iter().enumerate();
    let others = others.filter(|(index, _)| !coordinates.contains(index));
    let others = others.map(|(_, property)| property.name.as_str());
    notices.extend(not_read("Properties", others));
    Ok(Part {
        triangles,
        ..cloud.part(notices)?
    })
}

#[cfg(test)]
mod tests;
