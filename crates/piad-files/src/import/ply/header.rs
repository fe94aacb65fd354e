//! The head of a PLY file, which describes its body.

use super::super::binary::{Endian, Scalar};
use super::super::byte_lines::{ByteLines, text, words};
use super::super::error::FileError;
use crate::text::quoted;

/// The name of the vertices.
pub(super) const VERTEX: &str = "vertex";

/// The head of a file, and its body.
pub(super) struct Header<'a> {
    /// The order of bytes; `None` if the file is text.
    pub(super) endian: Option<Endian>,
    pub(super) elements: Vec<Element>,
    /// The body.
    pub(super) body: ByteLines<'a>,
}

/// A list of things of one kind, such as vertices.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    line: usize,
}

pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: PropertyKind,
}

#[derive(Clone, Copy)]
pub(super) enum PropertyKind {
    Scalar(Scalar),
    /// A count and then this many items.
    List {
        count: Scalar,
        item: Scalar,
    },
}

impl<'a> Header<'a> {
    /// Reads the head.
    ///
    /// # Errors
    ///
    /// The error in it, at its line.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, FileError> {
        let mut lines = ByteLines::new(bytes);
        lines.next_filled();
        let (mut format, mut elements) = (None, Vec::new());
        while let Some(line) = lines.next_filled() {
            if line == b"end_header" {
                let missing = || FileError::of_file("the header has no line format (PLY)");
                return Ok(Self {
                    endian: format.ok_or_else(missing)?,
                    elements,
                    body: lines,
                });
            }
            let words: Vec<&[u8]> = words(line).take(6).collect();
            let done = match words[..] {
                [b"comment" | b"obj_info", ..] => Some(()),
                [b"format", kind, ..] => endian(kind).map(|found| format = Some(found)),
                [b"element", name, count] => {
                    Element::new(name, count, lines.number).map(|it| elements.push(it))
                }
                [b"property", ref words @ ..] => Property::new(words).and_then(|property| {
                    let element = elements.last_mut()?;
                    element.properties.push(property);
                    Some(())
                }),
                _ => None,
            };
            done.ok_or_else(|| {
                let detail = format!("{} is not a line of a PLY header", quoted(&text(line)));
                FileError::at(lines.number, detail)
            })?;
        }
        Err(FileError::of_file("the header has no end_header (PLY)"))
    }
}

impl Element {
    fn new(name: &[u8], count: &[u8], line: usize) -> Option<Self> {
        Some(Self {
            name: text(name).into_owned(),
            count: text(count).parse().ok()?,
            properties: Vec::new(),
            line,
        })
    }

    /// The indices of the properties x, y and, if there is one, z.
    ///
    /// # Errors
    ///
    /// If there are none.
    pub(super) fn coordinates(&self) -> Result<Vec<usize>, FileError> {
        let find = |name: &str| {
            let is_it = |property: &Property| {
                let is_scalar = matches!(property.kind, PropertyKind::Scalar(_));
                is_scalar && property.name.eq_ignore_ascii_case(name)
            };
            self.properties.iter().position(is_it)
        };
        let found: Vec<usize> = ["x", "y", "z"].into_iter().map_while(find).collect();
        match found.len() {
            2.. => Ok(found),
            _ => {
                let detail = "the vertices have no properties x and y (PLY)";
                Err(FileError::at(self.line, detail))
            }
        }
    }

    /// The index of the list of the corners of a face, if there is one.
    pub(super) fn corners(&self) -> Option<usize> {
        let is_it = |property: &Property| {
            let is_list = matches!(property.kind, PropertyKind::List { .. });
            is_list && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
        };
        self.properties.iter().position(is_it)
    }

    /// The bytes of each element, if all have the same number.
    pub(super) fn size(&self) -> Option<usize> {
        let sizes = self.properties.iter().map(|property| match property.kind {
            PropertyKind::Scalar(kind) => Some(kind.size()),
            PropertyKind::List { .. } => None,
        });
        sizes.sum()
    }

    /// The fewest bytes of each.
    pub(super) fn least_size(&self) -> usize {
        let sizes = self.properties.iter().map(|property| match property.kind {
            PropertyKind::Scalar(kind) | PropertyKind::List { count: kind, .. } => kind.size(),
        });
        sizes.sum()
    }
}

impl Property {
    /// A property by the words that follow the first one of its line.
    fn new(words: &[&[u8]]) -> Option<Self> {
        let (kind, name) = match words {
            [b"list", count, item, name] => {
                let (count, item) = (scalar(count)?, scalar(item)?);
                (PropertyKind::List { count, item }, name)
            }
            [kind, name] => (PropertyKind::Scalar(scalar(kind)?), name),
            _ => return None,
        };
        Some(Self {
            name: text(name).into_owned(),
            kind,
        })
    }
}

/// The value of `format`; the outer one is `None` if it is unknown.
fn endian(kind: &[u8]) -> Option<Option<Endian>> {
    match kind {
        b"ascii" => Some(None),
        b"binary_little_endian" => Some(Some(Endian::Little)),
        b"binary_big_endian" => Some(Some(Endian::Big)),
        _ => None,
    }
}

/// A type by its old or its new name.
fn scalar(name: &[u8]) -> Option<Scalar> {
    Some(match name {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"int64" => Scalar::I64,
        b"uint64" => Scalar::U64,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return None,
    })
}
