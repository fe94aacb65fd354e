//! The result of reading a file of points, and the hints for it.

use super::columns::Columns;
use crate::wgs84::Origin;
use piad_fit::data::{Grid, Points};

/// Hints for reading a file.
#[derive(Clone, Debug)]
pub struct Hints {
    /// Curve or surface; the file decides if `None`.
    pub kind: Option<Kind>,
    /// The number of rows and columns of a surface.
    pub size: Option<Grid>,
    /// True if a curve is closed; the file decides if `None`.
    pub closed: Option<bool>,
    /// True if the order of points is known to be intended, so that it is not checked.
    pub ordered: bool,
    /// The roles of a table's columns; the file decides if `None`.
    pub columns: Option<Columns>,
    /// The part to read from a file with several.
    pub part: Option<PartChoice>,
    /// True if the parts of the file are sections of a surface; the file decides if `None`.
    pub sections: Option<bool>,
    /// The piece of a mesh to read, from 1, the largest first.
    pub piece: Option<usize>,
    /// True if the times of points are the parameters of a curve.
    pub times: bool,
    /// The most points.
    pub most: usize,
}

impl Default for Hints {
    /// No hints, and any number of points.
    fn default() -> Self {
        Self {
            kind: None,
            size: None,
            closed: None,
            ordered: false,
            columns: None,
            part: None,
            sections: None,
            piece: None,
            times: false,
            most: usize::MAX,
        }
    }
}

/// One of the parts of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartChoice {
    /// By its number, from 1.
    Number(usize),
    /// By its name.
    Name(String),
}

impl PartChoice {
    /// A number, or else a name.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        let number = text.parse().map(Self::Number);
        number.unwrap_or_else(|_| Self::Name(text.to_owned()))
    }
}

/// The kind of geometry that points belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of a curve, in their order.
    Curve,
    /// Of a surface, row by row.
    Surface,
}

/// The points of a file, or of one of its parts.
#[derive(Debug, PartialEq)]
pub struct Imported {
    /// The points; those of a grid row by row.
    pub points: Points,
    /// The rows and columns of a surface.
    pub grid: Option<Grid>,
    /// The numbers of points of the sections of a surface, if the points are sections.
    pub sections: Vec<usize>,
    /// The indices of missing points of a surface, increasing.
    pub missing: Vec<usize>,
    /// True if the curve is closed; its first point is kept once.
    pub closed: bool,
    /// True if the points have no order along a curve.
    pub unordered: bool,
    /// The parameters of the points of a curve, increasing: their times, if requested.
    pub parameters: Option<Vec<f64>>,
    /// The parameters of the rows and of the columns of a grid with gaps, from 0 to 1, if x and y determine them.
    pub line_parameters: Option<[Vec<f64>; 2]>,
    /// The triangles between scattered points that are the vertices of a mesh: the indices of their corners.
    pub triangles: Vec<[u32; 3]>,
    /// The origin of the first two coordinates, if they were longitudes and latitudes.
    pub origin: Option<Origin>,
    /// The line of each point, from 1; empty for files without lines.
    pub lines: Vec<u32>,
    /// The name of the part or the file.
    pub name: Option<String>,
    /// Notices about it, in sentences.
    pub notices: Vec<String>,
}

/// The values with these indices.
pub(super) fn chosen<T: Copy>(values: &[T], indices: &[usize]) -> Vec<T> {
    let value = |index: &usize| values.get(*index).copied();
    indices.iter().filter_map(value).collect()
}
