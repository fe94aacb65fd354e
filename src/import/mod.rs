//! Files of points: CSV, tables with blanks, point clouds (XYZ), airfoils (`.dat`) and JSON arrays.
//!
//! [`read`] is the only entry. It knows nothing of HTTP or of jobs: a file becomes points, and what is
//! wrong with it is reported at its line. What it is, is seen from what is in it:
//!
//! - `notation`: what separates columns, and decimals;
//! - `layout`: which columns are coordinates, and what is a title, a remark or a damaged point;
//! - `lines`: lines become points of a `table`, with titles above them and remarks below them; `plain`: those of
//!   large files, by all threads;
//! - `array`: points, rows of points and rows of heights in JSON;
//! - `off`: the vertices of meshes (OFF);
//! - `airfoil`: upper and lower sides one after the other (Lednicer) become one curve around, and what
//!   MSES has above the points is known;
//! - `closing`: an outline that comes back to its first point is closed;
//! - `lattice`: rows of points become a surface.

mod airfoil;
mod array;
mod closing;
mod imported;
mod lattice;
mod layout;
mod lines;
mod mistake;
mod notation;
mod off;
mod plain;
mod table;

use std::borrow::Cow;

use crate::model::short::without_mark;

pub(crate) use imported::{Hints, Imported, Kind};
pub(crate) use mistake::Mistake;

/// Reads a file of points in UTF-8, with a mark before it or without; or reports its first mistakes.
pub(crate) fn read(file: &[u8], hints: &Hints) -> Result<Imported, Vec<Mistake>> {
    let file = without_mark(file);
    // Where all of it is UTF-8, which is found out much faster than where it is not.
    let text = str::from_utf8(file).map(Cow::Borrowed);
    let text = text.unwrap_or_else(|_| String::from_utf8_lossy(file));
    if array::is_array(&text) {
        return array::read(&text, hints).map_err(|mistake| vec![mistake]);
    }
    let table = match off::vertices(&text) {
        None => airfoil::around(lines::read(&text, hints.most)?),
        Some(vertices) => {
            let vertices = vertices.map_err(|mistake| vec![mistake])?;
            let table = lines::read(vertices.text, hints.most);
            let mut table = table.map_err(|mistakes| below(mistakes, vertices.above))?;
            table.move_down(vertices.above);
            table.notices.insert(0, vertices.notice);
            table.is_mesh = vertices.faces > 0;
            table.breaks.clear();
            table
        }
    };
    lattice::arranged(table, hints).map_err(|mistake| vec![mistake])
}

/// The mistakes of a part of a file below so many lines.
fn below(mut mistakes: Vec<Mistake>, lines: usize) -> Vec<Mistake> {
    for line in mistakes.iter_mut().filter_map(|it| it.line.as_mut()) {
        *line += lines;
    }
    mistakes
}

#[cfg(test)]
mod tests;
