//! Points in JSON: lists of points, rows of points and rows of heights, which are read straight into the arrays that
//! are computed with.

mod limits;
mod points;

pub use limits::{LONG, ListLimits};
pub use points::{Coordinates, Rows, check_count, read_points, read_rows, read_sections};
