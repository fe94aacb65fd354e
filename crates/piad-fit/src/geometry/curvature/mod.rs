//! The shape of curves and surfaces: curvature and its extremes, length, area, and continuity at knots.
//!
//! - `curve` and `surface`: the measurements of each; `jets`: curvature of curves; `principal`: of surfaces;
//! - `extremes`: its least and largest values; `degenerate`: where it is undefined;
//! - `joints` and `lines`: continuity at knots of curves and across knot lines of surfaces; `area`: areas.
//!
//! Curvatures that do not exist, where a derivative vanishes or a surface has no normal, are NaN.

pub(crate) mod area;
mod curve;
mod degenerate;
mod extremes;
mod jets;
mod joints;
mod lines;
mod principal;
mod surface;
#[cfg(test)]
mod tests;

pub use curve::{CurveSamples, CurveShape};
pub use degenerate::MOST_DEGENERATE;
pub use extremes::{Extreme, Extremes};
pub use joints::{Joint, MOST_JOINTS, Sides};
pub use lines::KnotLine;
pub use surface::{SurfaceSamples, SurfaceShape};
