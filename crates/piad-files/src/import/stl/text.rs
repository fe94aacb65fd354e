//! STL as text: `facet`, three lines with a `vertex`, `endfacet`.

use super::super::byte_lines::{ByteLines, number, text, words};
use super::super::error::{FileError, FileErrors};
use super::super::imported::Hints;
use super::super::part::Part;
use super::Corners;
use crate::text::quoted;

/// The keywords of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keyword {
    Solid,
    Facet,
    Vertex,
    EndFacet,
    EndSolid,
    /// `outer loop` and its end, which are skipped.
    Loop,
}

impl Keyword {
    fn of(word: &[u8]) -> Option<Self> {
        Some(match word.to_ascii_lowercase().as_slice() {
            b"solid" => Self::Solid,
            b"facet" => Self::Facet,
            b"vertex" => Self::Vertex,
            b"endfacet" => Self::EndFacet,
            b"endsolid" => Self::EndSolid,
            b"outer" | b"endloop" => Self::Loop,
            _ => return None,
        })
    }

    fn of_line(line: &[u8]) -> Option<Self> {
        Self::of(words(line).next()?)
    }
}

/// Returns true if a text is STL: `solid` could be the title of a table.
pub(in super::super) fn is_text(text: &str) -> bool {
    let mut lines = ByteLines::new(text.as_bytes());
    let mut keyword = || lines.next_filled().and_then(Keyword::of_line);
    keyword() == Some(Keyword::Solid)
        && matches!(keyword(), Some(Keyword::Facet | Keyword::EndSolid))
}

/// The corners of the triangles, which have no order.
pub(in super::super) fn read_text(text: &str, hints: &Hints) -> Result<Part, FileErrors> {
    let mut reader = Reader {
        corners: Corners::new(hints.most),
        name: None,
        triangles: 0,
        inside: None,
        is_open: false,
    };
    let mut lines = ByteLines::new(text.as_bytes());
    while let Some(line) = lines.next_filled() {
        reader.line(line, lines.number)?;
    }
    Ok(reader.end()?)
}

struct Reader {
    corners: Corners,
    name: Option<String>,
    triangles: usize,
    /// The number of corners of the triangle whose end was not read yet.
    inside: Option<usize>,
    /// True below a `solid` without its end.
    is_open: bool,
}

impl Reader {
    fn line(&mut self, line: &[u8], at: usize) -> Result<(), FileError> {
        let unknown = || {
            let detail = format!("{} is not a line of an STL file", quoted(&text(line)));
            FileError::at(at, detail)
        };
        let keyword = Keyword::of_line(line).ok_or_else(unknown)?;
        match (keyword, self.inside) {
            (Keyword::Vertex, Some(count)) => {
                self.inside = Some(count + 1);
                self.vertex(line, at)
            }
            (Keyword::Loop, Some(_)) => Ok(()),
            (Keyword::Solid, None) if !self.is_open => {
                self.is_open = true;
                self.solid(line);
                Ok(())
            }
            (Keyword::Facet, None) if self.is_open => {
                self.inside = Some(0);
                Ok(())
            }
            (Keyword::EndFacet, Some(3)) => {
                self.inside = None;
                self.triangles += 1;
                Ok(())
            }
            (Keyword::EndFacet, Some(count)) => {
                let detail = format!("the triangle that ends here has {count} corners");
                Err(FileError::at(at, detail))
            }
            (Keyword::EndSolid, None) if self.is_open => {
                self.is_open = false;
                Ok(())
            }
            _ => {
                let detail = format!("{} has no place here (STL)", quoted(&text(line)));
                Err(FileError::at(at, detail))
            }
        }
    }

    /// Keeps the name of the first solid.
    fn solid(&mut self, line: &[u8]) {
        let name = text(line.get(5..).unwrap_or_default());
        let name = name.trim();
        if self.name.is_none() && !name.is_empty() {
            self.name = Some(name.replace('\t', " "));
        }
    }

    fn vertex(&mut self, line: &[u8], at: usize) -> Result<(), FileError> {
        let numbers: Vec<Option<f64>> = words(line).skip(1).take(4).map(number).collect();
        let [Some(x), Some(y), Some(z)] = numbers[..] else {
            let detail = format!(
                "{} is no vertex with three numbers (STL)",
                quoted(&text(line))
            );
            return Err(FileError::at(at, detail));
        };
        self.corners.push([x, y, z], Some(at))
    }

    fn end(self) -> Result<Part, FileError> {
        if self.is_open {
            let detail = format!(
                "the file ends below {} triangles, without endsolid (STL)",
                self.triangles
            );
            return Err(FileError::of_file(detail));
        }
        Ok(Part {
            name: self.name,
            ..self.corners.part(self.triangles)?
        })
    }
}
