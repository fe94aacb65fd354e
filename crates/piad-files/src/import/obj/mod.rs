//! OBJ files: the vertices of a mesh are points, connected by its faces, and each polyline is a curve. Free-form
//! geometry is not read.
//!
//! - `statements`: lines and their keywords;
//! - `polylines`: the curves.

mod polylines;
mod statements;

use super::byte_lines::number;
use super::cloud::{Cloud, mesh_notice};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::mesh::Faces;
use super::part::{Part, Parts};
use crate::text::{plain, quoted};
use polylines::{Polylines, no_vertex, vertex_index};
use statements::{Kind, Statements};

/// Returns true if a text is OBJ: lines of such files down to a vertex.
pub(super) fn is_obj(text: &str) -> bool {
    for (_, line) in Statements::new(text) {
        let mut words = line.split_whitespace();
        match words.next().map(Kind::of) {
            Some(Kind::Vertex) => {
                let numbers = words.map_while(|word| number(word.as_bytes()));
                return numbers.count() >= 3;
            }
            None | Some(Kind::Unknown) => return false,
            Some(_) => {}
        }
    }
    false
}

/// The polylines, each in its order; or else the vertices, which have none.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let mut reader = Reader {
        vertices: Cloud::new(3, text.len() / 8, hints.most),
        polylines: Polylines::new(hints.most),
        faces: Faces::default(),
        corners: Vec::new(),
        last: (0, 0),
        seen: Seen::default(),
        name: None,
        names: 0,
    };
    for (number, line) in Statements::new(text) {
        reader.line(&line, number)?;
    }
    Ok(reader.end()?)
}

struct Reader {
    vertices: Cloud,
    polylines: Polylines,
    faces: Faces,
    /// Those of the face that is read.
    corners: Vec<u32>,
    /// The largest index of a corner, and its line.
    last: (u32, usize),
    seen: Seen,
    /// The object or the group that the lines belong to.
    name: Option<String>,
    /// The number of names.
    names: usize,
}

/// Statements that were skipped.
#[derive(Default)]
struct Seen {
    faces: u64,
    weights: bool,
    colours: bool,
    free_form: bool,
    /// The number of lines without a statement, and the first such line.
    unknown: usize,
    first_unknown: usize,
}

impl Reader {
    fn line(&mut self, line: &str, at: usize) -> Result<(), FileError> {
        let mut words = line.split_whitespace();
        match words.next().map_or(Kind::Unknown, Kind::of) {
            Kind::Vertex => return self.vertex(words, at),
            Kind::Polyline => {
                let name = self.name.as_deref();
                return self.polylines.push(words, self.vertices.len(), name, at);
            }
            Kind::Face => return self.face(words, at),
            Kind::FreeForm => self.seen.free_form = true,
            Kind::Name => {
                // Each polyline below has a copy.
                let name = words.collect::<Vec<&str>>().join(" ");
                self.names += 1;
                self.name = Some(plain(&name).into_owned()).filter(|name| !name.is_empty());
            }
            Kind::Other => {}
            Kind::Unknown => {
                if self.seen.unknown == 0 {
                    self.seen.first_unknown = at;
                }
                self.seen.unknown += 1;
            }
        }
        Ok(())
    }

    fn face<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        at: usize,
    ) -> Result<(), FileError> {
        self.seen.faces += 1;
        self.corners.clear();
        for word in words {
            let vertex = vertex_index(word, self.vertices.len(), at)?;
            let vertex = u32::try_from(vertex).unwrap_or(u32::MAX);
            if vertex > self.last.0 {
                self.last = (vertex, at);
            }
            self.corners.push(vertex);
        }
        let count = self.corners.len();
        if count < 3 {
            let detail = format!("a face has at least 3 corners, and this one {count} (OBJ)");
            return Err(FileError::at(at, detail));
        }
        self.faces.push(&self.corners, Some(at))
    }

    fn vertex<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        at: usize,
    ) -> Result<(), FileError> {
        let mut vertex = [0.0; 3];
        let (mut count, mut weight) = (0, 1.0);
        for word in words {
            let value = number(word.as_bytes()).filter(|value| value.is_finite());
            let value = value.ok_or_else(|| {
                let detail = format!("{} is no number", quoted(word));
                FileError::at(at, detail)
            })?;
            match vertex.get_mut(count) {
                Some(coordinate) => *coordinate = value,
                None if count == 3 => weight = value,
                None => {}
            }
            count += 1;
        }
        match count {
            3 => {}
            4 => self.seen.weights |= weight != 1.0,
            6 | 7 => self.seen.colours = true,
            _ => {
                let detail = format!("this vertex has {count} numbers, and not 3, 4, 6 or 7 (OBJ)");
                return Err(FileError::at(at, detail));
            }
        }
        self.vertices.push(&vertex, Some(at))
    }

    fn end(self) -> Result<Parts, FileError> {
        let mut notices = self.seen.notices();
        if self.polylines.is_empty() {
            let mesh = mesh_notice(self.vertices.len(), self.seen.faces, "OBJ");
            notices.insert(0, mesh);
            let name = self.name.filter(|_| self.names == 1);
            let ((last, line), count) = (self.last, self.vertices.len());
            if line > 0 && last as usize >= count {
                return Err(no_vertex(u64::from(last) + 1, count, line));
            }
            return Ok(Part {
                name,
                triangles: self.faces.triangles,
                ..self.vertices.part(notices)?
            }
            .into());
        }
        if self.seen.faces > 0 {
            let notice = format!("The faces of the file are not read ({}).", self.seen.faces);
            notices.insert(0, notice);
        }
        let (points, lines) = self.vertices.into_points();
        let parts = self.polylines.parts(&points, &lines)?;
        notices.insert(
            0,
            match parts.len() {
                1 => "The file has a polyline (OBJ).".to_owned(),
                count => format!("The file has {count} polylines (OBJ)."),
            },
        );
        Ok(Parts { parts, notices })
    }
}

impl Seen {
    fn notices(&self) -> Vec<String> {
        let mut notices = Vec::new();
        let mut say = |is_said: bool, notice: &str| {
            if is_said {
                notices.push(notice.to_owned());
            }
        };
        say(self.weights, "The weights of the vertices are not read.");
        say(self.colours, "The colours of the vertices are not read.");
        say(
            self.free_form,
            "The free-form curves and surfaces of the file are not read; the vertices may be their control points.",
        );
        match self.unknown {
            0 => {}
            1 => notices.push(format!(
                "Line {} is not understood and not read.",
                self.first_unknown
            )),
            count => notices.push(format!(
                "{count} lines are not understood and not read, the first of them line {}.",
                self.first_unknown
            )),
        }
        notices
    }
}

#[cfg(test)]
mod tests;
