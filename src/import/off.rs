//! Meshes in OFF files: the vertices are points; the line of counts above them and the faces below are not.

use super::Mistake;
use super::table::{line_end, without_comment};

/// What such files begin with; letters before `OFF` name what follows the coordinates of a vertex.
const KEYWORDS: [&str; 5] = ["OFF", "COFF", "NOFF", "CNOFF", "STOFF"];

/// The lines of the vertices of a mesh.
#[derive(Debug)]
pub(super) struct Vertices<'a> {
    /// These lines.
    pub(super) text: &'a str,
    /// How many lines are above them.
    pub(super) above: usize,
    /// How many faces the mesh has.
    pub(super) faces: usize,
    /// What is said of the file.
    pub(super) notice: String,
}

/// The vertices of a mesh; `None` if the text is no OFF file.
///
/// # Errors
///
/// If there are fewer vertices than the file says.
pub(super) fn vertices(text: &str) -> Option<Result<Vertices<'_>, Mistake>> {
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
        return Some(Err(Mistake::of_file(detail)));
    }
    let below = lines.rest.map_or(0, str::len);
    let notice = match faces {
        0 => format!("The points are the {count} vertices of the file (OFF)."),
        _ => format!(
            "The points are the {count} vertices of a mesh (OFF), whose {faces} faces are not read."
        ),
    };
    Some(Ok(Vertices {
        text: body.get(..body.len() - below).unwrap_or(body),
        above,
        faces,
        notice,
    }))
}

/// The lines of a text that are neither blank nor comments.
struct Lines<'a> {
    rest: Option<&'a str>,
    end: char,
    /// How many lines were passed, these included.
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
