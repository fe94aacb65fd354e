//! Curves and surfaces of given control points: evaluation, NURBS form, samples, and distances from data.
//!
//! - `evaluation`: points and control nets in any basis; `samples`: points at equal steps of the parameters;
//! - `nurbs`: the B-spline form that CAD kernels store; `arc_length`: its length; `curvature`: its shape;
//! - `norms`: distances from the data at their parameters; `foot`: nearest points, and the distances from them;
//! - `between`: curves and surfaces that leave their data between neighbours, by more than their `freedom`;
//! - `fold`: parameters of scattered points that fold;
//! - `outline`: closed curves in the parameters of a surface that bound it; `trimmed_area`: the
//!   area of that part.

pub(crate) mod arc_length;
pub(crate) mod between;
pub(crate) mod curvature;
pub(crate) mod evaluation;
pub(crate) mod fold;
pub(crate) mod foot;
pub(crate) mod freedom;
pub(crate) mod norms;
pub(crate) mod nurbs;
pub(crate) mod outline;
pub(crate) mod samples;
pub(crate) mod trimmed_area;

pub use foot::{NoFootPoints, foot_points};
pub use norms::FitError;
pub use nurbs::{KnotVector, Nurbs};
pub use outline::{Face, Outline};
