//! A fitting problem as requested, before any check.
//!
//! It is plain data: any request can be made, and [`Problem::new`](super::Problem::new) validates it. Large parts are
//! shared, so that clones are cheap.

use std::sync::Arc;

use crate::basis::choice::DirectionChoice;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::method::Method;
use crate::parameters::scattered::Scattered;

/// The requested tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Tolerance {
    /// In data units.
    Absolute(f64),
    /// In units of the diagonal of the data's bounding box.
    Relative(f64),
}

impl Tolerance {
    /// The default tolerance.
    pub const DEFAULT: Self = Self::Relative(1e-6);
}

/// The requested weights of a rational fit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Weights {
    /// None: the curve is polynomial in each span.
    None,
    /// One for each data point: the fit is made in homogeneous coordinates (Lin10, section 2.1).
    Homogeneous(Vec<f64>),
    /// Fixed weights of the directions are in their [`DirectionChoice`]s; these are a grid of fixed
    /// weights of a surface, to be separated (LBW05 (3.8)).
    FixedGrid(Vec<f64>),
}

/// A surface is trimmed to the outline of its data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trim {
    /// The largest distance of the outline from the data, in the unit of the points; `None` means the spacing of the
    /// data.
    pub distance: Option<f64>,
}

/// A fitting problem as requested.
#[derive(Clone, Debug)]
pub struct Request {
    /// The data points; of a surface row by row.
    pub points: Arc<Points>,
    /// Their arrangement: n × 1 of a curve, n × m of a surface.
    pub grid: Grid,
    /// True if the points of a curve are unordered: then they are sorted along it.
    pub unordered: bool,
    /// True if points of a curve that equal the one before them are kept once.
    pub merge_repeated: bool,
    /// Indices of missing points, for least-squares fits; their coordinates are ignored.
    pub missing: Vec<usize>,
    /// The rule for the parameters of scattered points of a surface: then they are in a grid of one column, and the
    /// parameters of the directions are ignored.
    pub scattered: Option<Scattered>,
    /// True if the edges between the points of a curve are data, too.
    pub polyline: bool,
    /// The direction of a curve, or u of a surface.
    pub u: DirectionChoice,
    /// The second direction of a surface.
    pub v: Option<DirectionChoice>,
    /// Weights that are not of a single direction.
    pub weights: Weights,
    /// The method.
    pub method: Method,
    /// Local fits: the indices of the control points that move; all of them if there are none.
    pub selected: Option<Arc<[usize]>>,
    /// The free control points of level 0, in homogeneous coordinates if the fit is; `None` means those of the method.
    pub start: Option<Arc<Points>>,
    /// The breaks of each direction that the given control points belong to, where the fit chooses its knots.
    pub start_breaks: Option<Vec<Arc<Vec<f64>>>>,
    /// The points that a robust fit leaves out, if they are known.
    pub outliers: Option<Arc<[usize]>>,
    /// The least eigenvalue of the collocation matrix, if it is known from a fit with the same one.
    pub lambda_min: Option<f64>,
    /// The largest allowed distance of the curve from a data point. Without one, fits compare with
    /// [`Tolerance::DEFAULT`], and a least-squares fit may end above it.
    pub tolerance: Option<Tolerance>,
    /// The last level that is computed.
    pub max_iterations: usize,
    /// Surfaces: the trimming setting.
    pub trim: Option<Trim>,
}

/// The most iterations where no number is given.
const ITERATIONS: usize = 1000;

impl Request {
    /// Returns true if the data determine the knots: a fit that starts from another one has the knots of that.
    pub fn places_knots(&self) -> bool {
        self.method.is_automatic() || self.u.is_adaptive()
    }

    /// Classical PIA with these directions, without weights and without a tolerance.
    pub fn new(
        points: impl Into<Arc<Points>>,
        grid: Grid,
        u: DirectionChoice,
        v: Option<DirectionChoice>,
    ) -> Self {
        Self {
            points: points.into(),
            grid,
            unordered: false,
            merge_repeated: false,
            missing: Vec::new(),
            scattered: None,
            polyline: false,
            u,
            v,
            weights: Weights::None,
            method: Method::Global,
            selected: None,
            start: None,
            start_breaks: None,
            outliers: None,
            lambda_min: None,
            tolerance: None,
            max_iterations: ITERATIONS,
            trim: None,
        }
    }
}
