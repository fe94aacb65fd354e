//! What a file of points becomes, and what is known of it before.

use piad_fit::data::{Grid, Points};

/// What is known of a file beside what is in it.
#[derive(Clone, Copy, Debug)]
pub struct Hints {
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

impl Default for Hints {
    /// Nothing is known, and there may be any number of points.
    fn default() -> Self {
        Self {
            kind: None,
            size: None,
            closed: None,
            ordered: false,
            most: usize::MAX,
        }
    }
}

/// What points are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of a curve, in their order.
    Curve,
    /// Of a surface, row by row.
    Surface,
}

/// The points of a file.
#[derive(Debug, PartialEq)]
pub struct Imported {
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
