//! End conditions of curves with knots at the data.
//!
//! With knots at the data a B-spline of degree p has p − 1 control points more than there are data
//! points ([`crate::basis::direction`]). All control points are `c = E x + g` with the free ones x,
//! one for each data point, so that the residual is
//!
//! ```text
//! Δ = P − N c = (P − N g) − (N E) x
//! ```
//!
//! and the loop runs with `B = N E` and the data `P − N g`. Where E repeats the first and the last
//! free control point, B and all rates are those of the papers, whatever g is:
//!
//! | end | E | g | the curve at its end |
//! |---|---|---|---|
//! | repeated (LBW05 (3.2)) | copies | 0 | zero derivative: CAD kernels have no tangent there |
//! | derivatives, given or estimated | copies | constant | has these derivatives at every level |
//! | natural (cubic) | `c_1 = (1 − β) c_0 + β c_2` | 0 | has no second derivative |
//!
//! Estimated derivatives are those of the polynomial through the first points. Its degree is one more than the number
//! of derivatives needed: three points for cubics (Bessel).
//!
//! Requested ends are in [`crate::basis::end_conditions`]. `chosen`: their effect on a direction;
//! - `estimate`: derivatives from points; `copies`: control points from derivatives; `line`: both of
//!   a line of points;
//! - `offsets`: g of a curve and of a surface.

pub(super) mod chosen;
mod copies;
mod estimate;
pub(super) mod line;
pub(super) mod offsets;
