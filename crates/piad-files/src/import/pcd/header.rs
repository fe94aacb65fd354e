//! The head of a PCD file: the fields of a point and the storage of the points.

use super::super::binary::Scalar;
use super::super::byte_lines::{ByteLines, text, words};
use super::super::error::FileError;
use crate::text::quoted;

/// The keywords of a head.
const KEYWORDS: [&[u8]; 10] = [
    b"VERSION",
    b"FIELDS",
    b"COLUMNS",
    b"SIZE",
    b"TYPE",
    b"COUNT",
    b"WIDTH",
    b"HEIGHT",
    b"POINTS",
    b"VIEWPOINT",
];

/// The storage of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Data {
    Text,
    Binary,
    Compressed,
}

/// The head of a file.
pub(super) struct Header<'a> {
    pub(super) fields: Vec<Field>,
    /// The number of points.
    pub(super) count: usize,
    pub(super) data: Data,
    /// The bytes below the head.
    pub(super) body: ByteLines<'a>,
}

/// The fields of a point.
pub(super) struct Field {
    pub(super) name: String,
    /// The bytes of each value.
    size: usize,
    /// `None` if it is unknown.
    kind: Option<Scalar>,
    /// The number of values.
    pub(super) count: usize,
}

/// A field that is a coordinate.
pub(super) struct Coordinate<'a> {
    pub(super) name: &'a str,
    pub(super) kind: Scalar,
    /// The number of values of a point before it.
    pub(super) column: usize,
    /// The number of bytes of a point before it.
    pub(super) offset: usize,
}

/// Returns true if a file is PCD.
pub(in super::super) fn is_pcd(bytes: &[u8]) -> bool {
    let mut lines =
        ByteLines::new(bytes).filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let mut is_next = |expected: &[&[u8]]| {
        let line = lines.next().unwrap_or_default();
        words(line)
            .next()
            .is_some_and(|word| expected.contains(&word))
    };
    is_next(&[b"VERSION", b"FIELDS", b"COLUMNS"]) && is_next(&KEYWORDS)
}

/// The lines of a head, without their keywords.
#[derive(Default)]
struct Lines {
    names: Vec<String>,
    sizes: Vec<usize>,
    types: Vec<String>,
    counts: Vec<usize>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
}

impl Lines {
    /// Reads a line of the head; `None` if it is invalid.
    fn take(&mut self, line: &[u8]) -> Option<()> {
        let mut words = words(line);
        let keyword = words.next()?;
        let words: Vec<String> = words.map(|word| text(word).into_owned()).collect();
        let numbers = || {
            words
                .iter()
                .map(|word| word.parse().ok())
                .collect::<Option<Vec<usize>>>()
        };
        let number = || match numbers()?[..] {
            [number] => Some(number),
            _ => None,
        };
        match keyword {
            b"FIELDS" | b"COLUMNS" => self.names = words,
            b"SIZE" => self.sizes = numbers()?,
            b"TYPE" => self.types = words,
            b"COUNT" => self.counts = numbers()?,
            b"WIDTH" => self.width = Some(number()?),
            b"HEIGHT" => self.height = Some(number()?),
            b"POINTS" => self.points = Some(number()?),
            b"VERSION" | b"VIEWPOINT" => {}
            _ => return None,
        }
        Some(())
    }

    /// The fields; `None` if there are not as many of all.
    fn fields(&self) -> Option<Vec<Field>> {
        let names = self.names.len();
        let counts_match = self.counts.is_empty() || self.counts.len() == names;
        if self.sizes.len() != names || self.types.len() != names || !counts_match {
            return None;
        }
        let counts = self.counts.iter().copied().chain(std::iter::repeat(1));
        let types = self.types.iter().zip(&self.sizes);
        let fields = self.names.iter().zip(types).zip(counts);
        let field = |((name, (kind, size)), count): ((&String, (&String, &usize)), usize)| Field {
            name: name.clone(),
            size: *size,
            kind: scalar(kind, *size),
            count,
        };
        Some(fields.map(field).collect())
    }
}

impl<'a> Header<'a> {
    /// Reads the head.
    ///
    /// # Errors
    ///
    /// The error in it.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, FileError> {
        let mut body = ByteLines::new(bytes);
        let mut lines = Lines::default();
        let data = loop {
            let Some(line) = body.next_filled() else {
                return Err(FileError::of_file("the header has no line DATA (PCD)"));
            };
            if line.starts_with(b"#") {
                continue;
            }
            let data = data(line);
            if data.is_none() && lines.take(line).is_none() {
                let detail = format!("{} is not a line of a PCD header", quoted(&text(line)));
                return Err(FileError::at(body.number, detail));
            }
            if let Some(data) = data {
                break data;
            }
        };
        let error = |detail: &str| FileError::of_file(detail);
        let fields = lines.fields().ok_or_else(|| {
            error(
                "the lines FIELDS, SIZE, TYPE and COUNT of the header are not of one length (PCD)",
            )
        })?;
        let size = lines
            .width
            .and_then(|it| it.checked_mul(lines.height.unwrap_or(1)));
        let count = lines
            .points
            .or(size)
            .ok_or_else(|| error("the header has no line POINTS (PCD)"))?;
        if size.is_some_and(|size| size != count) {
            return Err(error(
                "POINTS of the header is not WIDTH times HEIGHT (PCD)",
            ));
        }
        Ok(Self {
            fields,
            count,
            data,
            body,
        })
    }

    /// The fields x, y and, if there is one, z.
    ///
    /// # Errors
    ///
    /// If there are none.
    pub(super) fn coordinates(&self) -> Result<Vec<Coordinate<'_>>, FileError> {
        let found = ["x", "y", "z"].into_iter().map_while(|name| {
            let place = self.fields.iter().position(|it| it.name == name)?;
            let (before, field) = (self.fields.get(..place)?, self.fields.get(place)?);
            let columns = before.iter().map(|it| it.count);
            let bytes = before.iter().map(|it| it.count.saturating_mul(it.size));
            Some(Coordinate {
                name: &field.name,
                kind: field.kind.filter(|_| field.count == 1)?,
                column: columns.fold(0, usize::saturating_add),
                offset: bytes.fold(0, usize::saturating_add),
            })
        });
        let found: Vec<Coordinate<'_>> = found.collect();
        match found.len() {
            2.. => Ok(found),
            _ => {
                let detail = "the points have no fields x and y that are numbers (PCD)";
                Err(FileError::of_file(detail))
            }
        }
    }

    /// The bytes of a point.
    ///
    /// # Errors
    ///
    /// If no file can have that many.
    pub(super) fn record_size(&self) -> Result<usize, FileError> {
        let mut sizes = self.fields.iter().map(|it| it.count.checked_mul(it.size));
        let size = sizes.try_fold(0_usize, |sum, size| sum.checked_add(size?));
        let huge = || FileError::of_file("the fields of a point are too large (PCD)");
        size.filter(|size| *size > 0).ok_or_else(huge)
    }
}

/// The content of the last line of a head.
fn data(line: &[u8]) -> Option<Data> {
    let mut words = words(line);
    match (words.next()?, words.next()?) {
        (b"DATA", b"ascii") => Some(Data::Text),
        (b"DATA", b"binary") => Some(Data::Binary),
        (b"DATA", b"binary_compressed") => Some(Data::Compressed),
        _ => None,
    }
}

fn scalar(kind: &str, size: usize) -> Option<Scalar> {
    Some(match (kind, size) {
        ("I", 1) => Scalar::I8,
        ("U", 1) => Scalar::U8,
        ("I", 2) => Scalar::I16,
        ("U", 2) => Scalar::U16,
        ("I", 4) => Scalar::I32,
        ("U", 4) => Scalar::U32,
        ("I", 8) => Scalar::I64,
        ("U", 8) => Scalar::U64,
        ("F", 4) => Scalar::F32,
        ("F", 8) => Scalar::F64,
        _ => return None,
    })
}
