//! The body of a PLY file: elements one after the other, in lines or in bytes.

use super::super::binary::Cursor;
use super::super::byte_lines::{ByteLines, number, text, words};
use super::super::cloud::{Cloud, too_few};
use super::super::error::FileError;
use super::super::imported::Hints;
use super::super::mesh::{Faces, not_there};
use super::header::{Element, Header, PropertyKind};
use crate::text::quoted;

/// The elements that are not read yet.
pub(super) enum Body<'a> {
    Text(ByteLines<'a>),
    Binary(Cursor<'a>),
}

impl<'a> Body<'a> {
    pub(super) fn new(header: &Header<'a>) -> Self {
        match header.endian {
            None => Self::Text(header.body.clone()),
            Some(endian) => Self::Binary(Cursor::new(header.body.rest(), endian)),
        }
    }

    /// Skips all elements of a kind; `None` if the file ends before.
    pub(super) fn skip(&mut self, element: &Element) -> Option<()> {
        // Elements without properties are no lines, and no bytes.
        if element.properties.is_empty() {
            return Some(());
        }
        match self {
            Self::Text(lines) => (0..element.count).try_for_each(|_| lines.next_filled().map(drop)),
            Self::Binary(cursor) => match element.size() {
                Some(size) => cursor.skip(size.checked_mul(usize::try_from(element.count).ok()?)?),
                None => (0..element.count).try_for_each(|_| record(cursor, element, |_, _| {})),
            },
        }
    }

    /// The vertices, whose coordinates are these properties, and the index of each in the cloud; `u32::MAX` of one that is
    /// left out.
    ///
    /// # Errors
    ///
    /// If the file ends early, a line is not a vertex, or there are more of them than the limit.
    pub(super) fn vertices(
        &mut self,
        element: &Element,
        coordinates: &[usize],
        hints: &Hints,
    ) -> Result<(Cloud, Vec<u32>), FileError> {
        let room = match self {
            // Two numbers and their separators.
            Self::Text(lines) => lines.rest().len() / 4,
            Self::Binary(cursor) => cursor.len() / element.least_size().max(1),
        };
        let room = room.min(usize::try_from(element.count).unwrap_or(room));
        let mut numbers = Vec::with_capacity(room.min(hints.most));
        let mut cloud = Cloud::new(coordinates.len(), room, hints.most);
        let mut point = vec![0.0; coordinates.len()];
        for found in 0..element.count {
            let set = |property: usize, value: f64| {
                let place = coordinates.iter().position(|it| *it == property);
                if let Some(coordinate) = place.and_then(|place| point.get_mut(place)) {
                    *coordinate = value;
                }
            };
            let read = match self {
                Self::Binary(cursor) => record(cursor, element, set).map(|()| None),
                Self::Text(lines) => match lines.next_filled() {
                    Some(line) => vertex(line, lines.number, element, set)?,
                    None => None,
                },
            };
            let early = || too_few(found as usize, element.count, "vertices", "PLY");
            let before = cloud.len();
            cloud.push(&point, read.ok_or_else(early)?)?;
            numbers.push(if cloud.len() > before {
                before as u32
            } else {
                u32::MAX
            });
        }
        Ok((cloud, numbers))
    }

    /// The faces, whose corners are this property, between this number of vertices.
    ///
    /// If the file ends early, a line is not a face, a vertex does not exist, or there are more triangles than the
    /// limit.
    ///
    /// If the file ends early, a line is no face, a vertex is not there, or there are more triangles than the limit.
    pub(super) fn faces(
        &mut self,
        element: &Element,
        corners: usize,
        vertices: usize,
    ) -> Result<Faces, FileError> {
        let mut faces = Faces::default();
        let mut found: Vec<f64> = Vec::new();
        let mut indices = Vec::new();
        for k in 0..element.count {
            found.clear();
            let line = match self {
                Self::Binary(cursor) => {
                    face_record(cursor, element, corners, &mut found).map(|()| None)
                }
                Self::Text(lines) => match lines.next_filled() {
                    Some(line) => {
                        face_line(line, lines.number, element, corners, &mut found)?;
                        Some(Some(lines.number))
                    }
                    None => None,
                },
            };
            let line = line.ok_or_else(|| too_few(k as usize, element.count, "faces", "PLY"))?;
            indices.clear();
            for &index in &found {
                if !(index >= 0.0 && index < vertices as f64 && index.fract() == 0.0) {
                    return Err(not_there(&index.to_string(), vertices, "PLY", line));
                }
                indices.push(index as u32);
            }
            faces.push(&indices, line)?;
        }
        Ok(faces)
    }
}

/// Skips one element, and returns the values of its properties that are numbers.
fn record(
    cursor: &mut Cursor<'_>,
    element: &Element,
    mut set: impl FnMut(usize, f64),
) -> Option<()> {
    for (index, property) in element.properties.iter().enumerate() {
        match property.kind {
            PropertyKind::Scalar(kind) => set(index, cursor.number(kind)?),
            PropertyKind::List { count, item } => {
                let count = cursor.count(count)?;
                cursor.skip(count.checked_mul(item.size())?)?;
            }
        }
    }
    Some(())
}

/// Skips a face, and returns the values of one of its lists.
fn face_record(
    cursor: &mut Cursor<'_>,
    element: &Element,
    corners: usize,
    found: &mut Vec<f64>,
) -> Option<()> {
    for (index, property) in element.properties.iter().enumerate() {
        match property.kind {
            PropertyKind::Scalar(kind) => cursor.skip(kind.size())?,
            PropertyKind::List { count, item } if index == corners => {
                for _ in 0..cursor.count(count)? {
                    found.push(cursor.number(item)?);
                }
            }
            PropertyKind::List { count, item } => {
                let count = cursor.count(count)?;
                cursor.skip(count.checked_mul(item.size())?)?;
            }
        }
    }
    Some(())
}

/// Reads the line of a face, and returns the values of one of its lists.
fn face_line(
    line: &[u8],
    at: usize,
    element: &Element,
    corners: usize,
    found: &mut Vec<f64>,
) -> Result<(), FileError> {
    let mut words = words(line);
    let mut value = || {
        let word = words.next().and_then(number);
        word.ok_or_else(|| FileError::at(at, "this is no face with its properties (PLY)"))
    };
    for (index, property) in element.properties.iter().enumerate() {
        let first = value()?;
        if let PropertyKind::List { .. } = property.kind {
            for _ in 0..first as u64 {
                let item = value()?;
                if index == corners {
                    found.push(item);
                }
            }
        }
    }
    Ok(())
}

/// Reads the line of a vertex, and returns its number.
fn vertex(
    line: &[u8],
    at: usize,
    element: &Element,
    mut set: impl FnMut(usize, f64),
) -> Result<Option<Option<usize>>, FileError> {
    let mut words = words(line);
    let mut value = |name: &str| {
        let word = words.next().ok_or_else(|| {
            let detail = format!(
                "this vertex has no {}, its properties end before",
                quoted(name)
            );
            FileError::at(at, detail)
        })?;
        number(word).ok_or_else(|| {
            let detail = format!("{}: {} is no number", quoted(name), quoted(&text(word)));
            FileError::at(at, detail)
        })
    };
    for (index, property) in element.properties.iter().enumerate() {
        let first = value(&property.name)?;
        match property.kind {
            PropertyKind::Scalar(_) => set(index, first),
            PropertyKind::List { .. } => {
                // A count that is not a number, or is huge, ends with the line.
                for _ in 0..first as u64 {
                    value(&property.name)?;
                }
            }
        }
    }
    if words.next().is_some() {
        let detail = "there is more in this line than the properties of a vertex";
        return Err(FileError::at(at, detail));
    }
    Ok(Some(Some(at)))
}
