//! Internal interface for piad and piad-files. It may change at any time.

pub use crate::basis::choice::DirectionChoice;
pub use crate::basis::direction::Direction;
pub use crate::data::aligned::Lane;
pub use crate::data::point_order::is_unordered;
pub use crate::geometry::evaluation::Geometry;
pub use crate::iteration::bases::Bases;
pub use crate::iteration::system::System;
pub use crate::iteration::{Iteration, Level};
pub use crate::kind_info::KindInfo;
pub use crate::matrix::forecast::Forecast;
pub use crate::matrix::spectrum::least_eigenvalue;
pub use crate::matrix::tensor::Tensor;
pub use crate::parameters::{Parametrized, is_stack, parameters};
pub use crate::problem::Problem;
pub use crate::problem::admission::Admission;
pub use crate::problem::request::{Request, Tolerance, Trim, Weights};
pub use crate::setup::Setup;
pub use crate::termination::{Outcome, Reason};
pub use crate::trim::trimmed;
pub use crate::warning::Warning;

/// The version of the arithmetic: programs with the same version compute the same bits. It increases with each change
/// that changes the bits of any level.
pub const KERNEL: u32 = 7;

/// Lengths of curves.
pub mod arc_length {
    pub use crate::geometry::arc_length::ArcLength;
}

/// Fits that deviate from their data between neighbours.
pub mod between {
    pub use crate::geometry::between::excesses;
}

/// B-splines by the Cox–de Boor recurrence.
pub mod bspline {
    pub use crate::basis::bspline::{evaluate, find_span};
}

/// The shape of curves and surfaces.
pub mod curvature {
    pub use crate::geometry::curvature::{
        CurveSamples, CurveShape, Extreme, Extremes, Joint, KnotLine, MOST_DEGENERATE, MOST_JOINTS,
        Sides, SurfaceSamples, SurfaceShape,
    };
}

/// Nearest points, and distances from them.
pub mod foot {
    pub use crate::geometry::foot::deviation::Deviation;
    pub use crate::geometry::foot::memory;
}

/// Ends computations that have been abandoned.
pub mod interrupt {
    pub use crate::interrupt::{Interrupted, Meter, check, until};
}

/// Limits of local fits.
pub mod limit {
    pub use crate::iteration::limit::{
        LIMIT_COST, LocalLimit, MOST_ADJUSTED, NoLimit, local_limit,
    };
}

/// Evaluation of NURBS.
pub mod nurbs {
    pub use crate::geometry::nurbs::sampling::{Jet, SpanParameter, steps_between};
}

/// Classical PIA with each basis.
pub mod rates {
    pub use crate::matrix::rates::{BasisRate, MOST_DEGREE, MOST_POINTS, compare};
}

/// Points of curves and surfaces at equal steps of their parameters.
pub mod samples {
    pub use crate::geometry::samples::{Samples, Uniform, multiplications};
}

/// Levels in one pass over memory.
pub mod sweep {
    pub use crate::iteration::sweep::{LEVELS, Measured, Plan, Sweep};
}

/// The outlines of surfaces.
pub mod outline {
    pub use crate::geometry::trimmed_area::trimmed_area;
}

/// Vectors of space.
pub mod vectors {
    pub use crate::data::vectors::{cross, dot, in_space, length, minus, unit};
}
