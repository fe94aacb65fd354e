//! STL files, as text and binary: the corners of triangles are points, each of them once.
//!
//! - `text`: files that begin with `solid`;
//! - `binary`: triangles of 50 bytes.

mod binary;
mod text;

use std::collections::HashSet;

use super::cloud::Cloud;
use super::error::FileError;
use super::part::Part;

pub(super) use binary::{is_binary, read_binary};
pub(super) use text::{is_text, read_text};

/// The corners of triangles. Programs write the same corner with the same digits in each triangle.
struct Corners {
    cloud: Cloud,
    seen: HashSet<[u64; 3]>,
}

impl Corners {
    /// No corners yet, at most `most` of them later.
    fn new(most: usize) -> Self {
        Self {
            cloud: Cloud::new(3, 0, most),
            seen: HashSet::new(),
        }
    }

    /// Appends a corner that was not there before; 0 and -0 are the same.
    fn push(&mut self, corner: [f64; 3], line: Option<usize>) -> Result<(), FileError> {
        match self.seen.insert(corner.map(|x| (x + 0.0).to_bits())) {
            true => self.cloud.push(&corner, line),
            false => Ok(()),
        }
    }

    /// The corners of this many triangles.
    fn part(self, triangles: usize) -> Result<Part, FileError> {
        let notice = format!(
            "The points are the {} vertices of a mesh (STL), whose {triangles} triangles are not read.",
            self.cloud.len()
        );
        self.cloud.part(vec![notice])
    }
}

#[cfg(test)]
mod tests;
