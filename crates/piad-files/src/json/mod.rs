//! Points in JSON: lists of points, rows of points and rows of heights, which are read directly into the arrays of the
//! computation.

mod limits;
mod points;

pub use limits::{LIMITED_LENGTH, ListLimits};
pub use points::{Coordinates, Rows, check_count, read_points, read_rows, read_sections};
