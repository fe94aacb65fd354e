//! The points of a file, before it is known whether they are those of a curve or of a surface.

use super::error::FileError;
use piad_fit::data::Points;

/// The points of a file in their order.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) points: Points,
    /// The line of each point, from 1.
    pub(super) lines: Vec<u32>,
    /// The indices of points before which there were blank lines.
    pub(super) breaks: Vec<usize>,
    /// Whether the points are the vertices of a mesh, whose order means nothing.
    pub(super) is_mesh: bool,
    pub(super) name: Option<String>,
    pub(super) notices: Vec<String>,
}

impl Table {
    /// Points and their lines, if there are enough.
    pub(super) fn new(points: Points, lines: Vec<u32>) -> Result<Self, FileError> {
        check_count(points.len())?;
        Ok(Self {
            points,
            lines,
            breaks: Vec::new(),
            is_mesh: false,
            name: None,
            notices: Vec::new(),
        })
    }

    /// Counts the lines of a table that stands below so many lines from the beginning of its file.
    pub(super) fn move_down(&mut self, lines: usize) {
        let lines = u32::try_from(lines).unwrap_or(u32::MAX);
        for line in &mut self.lines {
            *line = line.saturating_add(lines);
        }
    }
}

/// What is wrong with a file without points.
pub(super) const NO_POINTS: &str = "there are no points in the file";

/// Refuses files with fewer than two points.
pub(super) fn check_count(count: usize) -> Result<(), FileError> {
    let detail = match count {
        0 => NO_POINTS,
        1 => "there is one point in the file, and a curve has at least 2",
        _ => return Ok(()),
    };
    Err(FileError::of_file(detail))
}
