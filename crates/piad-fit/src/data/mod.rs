//! Data points and their arrays.
//!
//! - `points`: ordered points, stored coordinate by coordinate; `grid`: their arrangement; `input`: both as callers
//!   have them;
//! - `missing`: grids with missing points; `no_data`: values that mark them in files of heights;
//! - `weights`: weights of rational fits; `point_order`: whether points have an order along a curve; `nearest_order`: that order; `corners`: where a
//!   polyline has corners; `outliers`: points that are wrong;
//! - `distances` and `blocks`: lengths of residuals, and their norms in blocks;
//! - `aligned`, `bounds`, `monotonic`, `quantiles`: arrays of numbers; `vectors` of space.

pub(crate) mod aligned;
pub(crate) mod blocks;
pub(crate) mod bounds;
pub(crate) mod corners;
pub(crate) mod distances;
pub(crate) mod grid;
mod input;
pub(crate) mod missing;
pub(crate) mod monotonic;
pub(crate) mod nearest_order;
pub(crate) mod no_data;
pub(crate) mod outliers;
pub(crate) mod point_order;
pub(crate) mod points;
pub(crate) mod quantiles;
pub(crate) mod vectors;
pub(crate) mod weights;

pub use grid::Grid;
pub use input::{IntoGrid, IntoPoints};
pub use points::{MAX_DIMENSION, MAX_SURFACE_DIMENSION, Points};
