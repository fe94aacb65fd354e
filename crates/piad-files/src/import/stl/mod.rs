//! STL files, text and binary: the vertices of triangles are points, without duplicates.
//!
//! - `text`: files that begin with `solid`;
//! - `binary`: triangles of 50 bytes.

mod binary;
mod text;

use std::collections::HashMap;

use super::cloud::Cloud;
use super::error::FileError;
use super::mesh::Faces;
use super::part::Part;

pub(super) use binary::{is_binary, read_binary};
pub(super) use text::{is_text, read_text};

/// The corners of triangles. Programs write the same corner with the same digits in each triangle.
struct Corners {
    cloud: Cloud,
    /// The index of each corner.
    seen: HashMap<[u64; 3], u32>,
    /// The corners of the triangle that is not complete.
    open: Vec<u32>,
    faces: Faces,
}

impl Corners {
    /// No corners yet, at most `most` of them later.
    fn new(most: usize) -> Self {
        Self {
            cloud: Cloud::new(3, 0, most),
            seen: HashMap::new(),
            open: Vec::new(),
            faces: Faces::default(),
        }
    }

    /// Appends a corner, the third one of a triangle with this; 0 and -0 are the same.
    fn push(&mut self, corner: [f64; 3], line: Option<usize>) -> Result<(), FileError> {
        let key = corner.map(|x| (x + 0.0).to_bits());
        let index = match self.seen.get(&key) {
            Some(index) => *index,
            None => {
                let before = self.cloud.len();
                self.cloud.push(&corner, line)?;
                let index = match self.cloud.len() > before {
                    true => before as u32,
                    false => u32::MAX,
                };
                self.seen.insert(key, index);
                index
            }
        };
        self.open.push(index);
        if self.open.len() == 3 {
            if !self.open.contains(&u32::MAX) {
                self.faces.push(&self.open, line)?;
            }
            self.open.clear();
        }
        Ok(())
    }

    /// The corners of this many triangles.
    fn part(self, triangles: usize) -> Result<Part, FileError> {
        let notice = format!(
            "The file has a mesh of {} vertices and {triangles} triangles (STL).",
            self.cloud.len()
        );
        Ok(Part {
            triangles: self.faces.triangles,
            ..self.cloud.part(vec![notice])?
        })
    }
}

#[cfg(test)]
mod tests;
