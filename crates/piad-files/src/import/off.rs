//! Meshes in OFF files: the vertices are points, and faces are between them.

use super::cloud::too_few;
use super::columns::Columns;
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::line::{line_end, without_comment};
use super::lines;
use super::mesh::{Faces, not_there};
use super::part::{Order, Part};

/// The signature; letters before `OFF` name the values that follow the coordinates of a vertex.
const KEYWORDS: [&str; 5] = ["OFF", "COFF", "NOFF", "CNOFF", "STOFF"];

/// The number of coordinates of vertices.
const DIMENSION: usize = 3;

/// The lines of the vertices of a mesh.
struct Vertices<'a> {
    /// These lines.
    text: &'a str,
    /// The number of lines above them.
    above: usize,
    /// The numbers of vertices and faces of the mesh.
    count: usize,
    faces: usize,
    /// The lines below the vertices, with the number of those above.
    below: Lines<'a>,
    /// The notice about the file.
    notice: String,
}

/// Returns true if a text is an OFF file.
pub(super) fn is_off(text: &str) -> bool {
    vertices(text).is_some()
}

/// The vertices of a mesh, which have no order.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Part, FileErrors> {
    let vertices = vertices(text).unwrap_or_else(|| Err(FileError::of_file("this is no OFF file")));
    let vertices = vertices?;
    // The first column is x, also where it counts.
    let hints = Hints {
        columns: Some(Columns::first(DIMENSION)),
        ..hints.clone()
    };
    let part = lines::read(vertices.text, &hints);
    let mut part = part.map_err(|errors| errors.moved_down(vertices.above))?;
    part.move_down(vertices.above);
    part.notices.insert(0, vertices.notice);
    if vertices.faces > 0 {
        part.order = Order::None;
        part.triangles = faces(vertices.below, vertices.faces, vertices.count)?.triangles;
    }
    part.breaks.clear();
    Ok(part)
}

/// The vertices of a mesh; `None` if the text is not an OFF file. It is an error if there are fewer than announced.
fn vertices(text: &str) -> Option<Result<Vertices<'_>, FileError>> {
    let mut lines = Lines {
        rest: Some(text),
        end: line_end(text),
        passed: 0,
    };
    let mut head = lines.next()?.split_whitespace();
    head.next().filter(|word| KEYWORDS.contains(word))?;
    let beside: Vec<&str> = head.collect();
    let counts = match beside.is_empty() {
        true => lines.next()?.split_whitespace().collect(),
        false => beside,
    };
    let counts: Option<Vec<usize>> = counts.iter().map(|count| count.parse().ok()).collect();
    let (count, faces) = match counts?[..] {
        [count, faces] | [count, faces, _] if count > 0 => (count, faces),
        _ => return None,
    };
    let (above, body) = (lines.passed, lines.rest.unwrap_or_default());
    let found = (0..count).take_while(|_| lines.next().is_some()).count();
    if found < count {
        let detail = format!("the file has {found} vertices, and says that it has {count} (OFF)");
        return Some(Err(FileError::of_file(detail)));
    }
    let below = lines.rest.map_or(0, str::len);
    let notice = match faces {
        0 => format!("The points are the {count} vertices of the file (OFF)."),
        _ => format!("The file has a mesh of {count} vertices and {faces} faces (OFF)."),
    };
    Some(Ok(Vertices {
        text: body.get(..body.len() - below).unwrap_or(body),
        above,
        count,
        faces,
        below: lines,
        notice,
    }))
}

/// The faces below the vertices: a count, the indices of the corners, and maybe a colour.
fn faces(mut lines: Lines<'_>, count: usize, vertices: usize) -> Result<Faces, FileError> {
    let mut faces = Faces::default();
    let mut corners = Vec::new();
    for found in 0..count {
        let Some(line) = lines.next() else {
            return Err(too_few(found, count as u64, "faces", "OFF"));
        };
        let at = lines.passed;
        let mut words = line.split_whitespace();
        let said: Option<usize> = words.next().and_then(|word| word.parse().ok());
        let said = said.ok_or_else(|| {
            FileError::at(
                at,
                "this is no face: the number of its corners, and their indices (OFF)",
            )
        })?;
        corners.clear();
        for word in words.take(said) {
            let index = word
                .parse::<u32>()
                .ok()
                .filter(|index| (*index as usize) < vertices);
            let index = index.ok_or_else(|| not_there(word, vertices, "OFF", Some(at)))?;
            corners.push(index);
        }
        if corners.len() < said {
            let detail = format!(
                "this face has {} corners, and says that it has {said} (OFF)",
                corners.len()
            );
            return Err(FileError::at(at, detail));
        }
        faces.push(&corners, Some(at))?;
    }
    Ok(faces)
}

/// The lines of a text that are neither blank nor comments.
struct Lines<'a> {
    rest: Option<&'a str>,
    end: char,
    /// The number of lines passed, including these.
    passed: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        loop {
            let text = self.rest.filter(|text| !text.is_empty())?;
            let (line, below) = match text.split_once(self.end) {
                Some((line, below)) => (line, Some(below)),
                None => (text, None),
            };
            self.rest = below;
            self.passed += 1;
            let line = without_comment(line);
            if !line.is_empty() {
                return Some(line);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::import::tests::HINTS;
    use crate::import::{Hints, Imported, Kind, read};

    fn surface() -> Hints {
        Hints {
            kind: Some(Kind::Surface),
            ..HINTS
        }
    }

    fn points(text: &str) -> Imported {
        read(text.as_bytes(), &surface()).unwrap()
    }

    fn errors(text: &str) -> Vec<(Option<usize>, String)> {
        let errors = read(text.as_bytes(), &surface()).unwrap_err().0.into_iter();
        errors.map(|it| (it.line, it.detail)).collect()
    }

    #[test]
    fn vertices_of_off_files_are_the_points() {
        let vertices = "0 0 0\n1 0 1\n\n0.9 1 2 # a corner\n0 1.1 1\n";
        for (head, above) in [
            ("OFF\n4 2 5\n", 2),
            ("OFF\n# made by hand\n\n4 2\n", 4),
            ("COFF 4 2 0\n", 1),
            ("OFF\r\n4 2 5\r\n", 2),
        ] {
            let file = points(&format!("{head}{vertices}3 0 1 2\n3 0 2 3\n"));
            assert_eq!(file.points.len(), 4, "{head}");
            assert_eq!(file.lines, [1, 2, 4, 5].map(|line| line + above));
            assert_eq!((&file.name, file.points.lane(0)[2]), (&None, 0.9));
            assert!(
                file.notices[0].contains("a mesh of 4 vertices and 2 faces"),
                "{:?}",
                file.notices
            );
        }
        let cloud = points(&format!("OFF\n4 0 0\n{vertices}"));
        assert!(
            cloud.notices[0].contains("4 vertices"),
            "{:?}",
            cloud.notices
        );
        // Too few lines, a damaged one, and a title that looks like one.
        assert_eq!(
            errors(&format!("OFF\n5 0 0\n{vertices}")),
            [(
                None,
                "the file has 4 vertices, and says that it has 5 (OFF)".to_owned()
            )]
        );
        assert_eq!(errors("OFF\n2 1 0\n0 0 0\n1 x 0\n")[0].0, Some(4));
        let titled = points("OFF\n0.5 1\n2 3\n");
        assert_eq!(titled.points.lane(0), [0.5, 2.0]);
    }
}
