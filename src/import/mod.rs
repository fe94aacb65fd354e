//! Files of points: CSV, tables with blanks, point clouds (XYZ), airfoils (`.dat`) and JSON arrays.
//!
//! [`read`] is the only entry. It knows nothing of HTTP or of jobs: a file becomes points, and what is
//! wrong with it is told at its line. What it is, is seen from what is in it:
//!
//! - `notation`: what separates columns, and decimals;
//! - `layout`: which columns are coordinates, and what is a title, a remark or a damaged point;
//! - `table`: lines become points, with titles above them and remarks below them; `plain`: those of
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
mod lattice;
mod layout;
mod notation;
mod off;
mod plain;
mod table;

use std::borrow::Cow;

use crate::fit::points::{Grid, Points};
use crate::model::short::without_mark;

/// The most mistakes of a file that are told.
const MOST_MISTAKES: usize = 10;

/// What is known of a file beside what is in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hints {
    /// Whether it is a curve or a surface; the file shows it where nobody says it.
    pub kind: Option<Kind>,
    /// How many rows and columns a surface has.
    pub size: Option<Grid>,
    /// Whether a curve is closed; the file shows it where nobody says it.
    pub closed: Option<bool>,
    /// Whether the order of points is known to be meant, so that it is not looked at.
    pub ordered: bool,
    /// The most points that may be in it.
    pub most: usize,
}

/// What points are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Of a curve, in their order.
    Curve,
    /// Of a surface, row by row.
    Surface,
}

/// The points of a file.
#[derive(Debug, PartialEq)]
pub(crate) struct Imported {
    /// The points; those of a grid row by row.
    pub points: Points,
    /// The rows and columns of a surface.
    pub grid: Option<Grid>,
    /// The indices of missing points of a surface, increasing.
    pub missing: Vec<usize>,
    /// Whether the curve is closed, so that the copy of its first point has been taken away.
    pub closed: bool,
    /// Whether the points seem to have no order along a curve.
    pub unordered: bool,
    /// The line of each point, from 1.
    pub lines: Vec<u32>,
    /// What the file calls itself.
    pub name: Option<String>,
    /// What was found out about it, in sentences.
    pub notices: Vec<String>,
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The line, from 1; none if it is about the whole file.
    pub line: Option<usize>,
    /// What is wrong there.
    pub detail: String,
}

impl Mistake {
    fn at(line: usize, detail: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            detail: detail.into(),
        }
    }

    fn of_file(detail: impl Into<String>) -> Self {
        Self {
            line: None,
            detail: detail.into(),
        }
    }
}

/// Reads a file of points in UTF-8, with a mark before it or without; tells the first mistakes.
pub(crate) fn read(file: &[u8], hints: &Hints) -> Result<Imported, Vec<Mistake>> {
    let file = without_mark(file);
    // Where all of it is UTF-8, which is found out much faster than where it is not.
    let text = str::from_utf8(file).map(Cow::Borrowed);
    let text = text.unwrap_or_else(|_| String::from_utf8_lossy(file));
    if array::is_array(&text) {
        return array::read(&text, hints).map_err(|mistake| vec![mistake]);
    }
    let table = match off::vertices(&text) {
        None => airfoil::around(table::read(&text, hints.most)?),
        Some(vertices) => {
            let vertices = vertices.map_err(|mistake| vec![mistake])?;
            let lines = table::read(vertices.text, hints.most);
            let mut table = lines.map_err(|mistakes| below(mistakes, vertices.above))?;
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
