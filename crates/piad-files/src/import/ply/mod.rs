//! PLY files, as text and binary: the vertices of meshes and clouds are points; faces and colours are not read.
//!
//! - `header`: what is in the file;
//! - `body`: the vertices.

mod body;
mod header;

use super::byte_lines::{ByteLines, words};
use super::cloud::{mesh_notice, not_read, too_few};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Part;
use body::Body;
use header::{Element, Header};

/// Returns true if a file is PLY: what such files begin with could be the title of a table.
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
    Ok(vertices(&header, element, body, hints)?)
}

fn vertices(
    header: &Header<'_>,
    element: &Element,
    mut body: Body<'_>,
    hints: &Hints,
) -> Result<Part, FileError> {
    let coordinates = element.coordinates()?;
    let cloud = body.vertices(element, &coordinates, hints)?;
    let faces = header.elements.iter().find(|it| it.name == "face");
    let faces = faces.map_or(0, |faces| faces.count);
    let mut notices = vec![mesh_notice(cloud.len(), faces, "PLY")];
    let others = element.properties.iter().enumerate();
    let others = others.filter(|(index, _)| !coordinates.contains(index));
    let others = others.map(|(_, property)| property.name.as_str());
    notices.extend(not_read("Properties", others));
    cloud.part(notices)
}

#[cfg(test)]
mod tests;
