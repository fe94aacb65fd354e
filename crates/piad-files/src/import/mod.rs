//! Files of points: CSV, tables with blanks, point clouds (XYZ), airfoils (`.dat`) and JSON arrays.
//!
//! [`read`] is the only entry. It knows nothing of HTTP or of jobs: a file becomes points, and what is
//! wrong with it is reported at its line. What it is, is seen from what is in it:
//!
//! - `number_format`: what separates columns, and decimals;
//! - `layout`: which columns are coordinates, and what is a title, a remark or a damaged point;
//! - `lines`: lines become points of a `table`, with titles above them and remarks below them; `fast_path`: those of
//!   large files, by all threads;
//! - `array`: points, rows of points and rows of heights in JSON;
//! - `off`: the vertices of meshes (OFF);
//! - `airfoil`: upper and lower sides one after the other (Lednicer) become one curve around, and what
//!   MSES has above the points is known;
//! - `closed_outline`: an outline that comes back to its first point is closed;
//! - `repeated`: points that equal the one before them are kept once;
//! - `grid_detection`: rows of points become a surface.

mod airfoil;
mod array;
mod closed_outline;
mod error;
mod fast_path;
mod grid_detection;
mod imported;
mod layout;
mod lines;
mod number_format;
mod off;
mod repeated;
mod table;

use std::borrow::Cow;

use crate::short::without_mark;

pub use error::{FileError, FileErrors};
pub use imported::{Hints, Imported, Kind};

/// Reads a file of points in UTF-8, with or without a byte-order mark.
///
/// # Errors
///
/// The first ten errors of the file, each with its line.
pub fn read(file: &[u8], hints: &Hints) -> Result<Imported, FileErrors> {
    let file = without_mark(file);
    // Where all of it is UTF-8, which is found out much faster than where it is not.
    let text = str::from_utf8(file).map(Cow::Borrowed);
    let text = text.unwrap_or_else(|_| String::from_utf8_lossy(file));
    if array::is_array(&text) {
        return Ok(array::read(&text, hints)?);
    }
    let table = match off::vertices(&text) {
        None => airfoil::around(lines::read(&text, hints.most)?),
        Some(vertices) => {
            let vertices = vertices?;
            let table = lines::read(vertices.text, hints.most);
            let mut table = table.map_err(|errors| below(errors, vertices.above))?;
            table.move_down(vertices.above);
            table.notices.insert(0, vertices.notice);
            table.is_mesh = vertices.faces > 0;
            table.breaks.clear();
            table
        }
    };
    Ok(grid_detection::arranged(table, hints)?)
}

/// The errors of the part of a file that begins below this number of lines.
fn below(mut errors: FileErrors, lines: usize) -> FileErrors {
    for line in errors.0.iter_mut().filter_map(|it| it.line.as_mut()) {
        *line += lines;
    }
    errors
}

#[cfg(test)]
mod tests;
