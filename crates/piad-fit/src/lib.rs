//! Fits Bézier, B-spline and NURBS curves and surfaces to points by progressive iterative approximation (PIA).
//!
//! The points are the first control points; each iteration adds to every control point the vector from the curve to its
//! data point. The crate is pure and deterministic: it does no input or output, reads no clock and needs no unsafe
//! code.
//!
//! # Example
//!
//! A cubic B-spline through five points, by classical PIA:
//!
//! ```
//! use piad_fit::{Fit, Method};
//!
//! let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 3.0], [5.0, 2.0], [6.0, 0.0]];
//! let fit = Fit::curve(&points).method(Method::Global).tolerance(1e-9).prepare()?;
//! for level in fit.levels() {
//!     println!("{}: {:e}", level.iteration, level.error.max);
//! }
//! let curve = fit.solve()?;
//! let t = fit.parameters()[2];
//! assert!((curve.eval(t)[1] - 3.0).abs() <= 1e-9);
//! println!("{:?} {:?}", curve.eval(t), curve.derivative(t));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`programs`] has ten more.
//!
//! # The iteration
//!
//! Data `P` (points of R^d, d = 1, 2, 3), parameters `t_0 < … < t_n`, a basis `B_0 … B_n` and its
//! collocation matrix `B[i][j] = B_j(t_i)`. *Level* 0 is the curve of the initial control points
//! `X = P`; level k is the curve after k updates:
//!
//! ```text
//! Δ = P − B X        residual: the adjusting vectors, one per data point
//! X ← X + U Δ        update
//! ```
//!
//! Every method is a choice of the transform `U` and of level 0 (Deng13). A surface is the same
//! loop with `B = B_u ⊗ B_v`, which is never formed: `Δ = P − B_u X B_vᵀ`. A homogeneous fit is the
//! same loop with one coordinate more, the weight.
//!
//! # Terms
//!
//! - *Data points* P, n of a curve and n × m of a surface; *control points* X: those of the curve.
//!   *Free* control points move; end copies repeat them.
//! - *Level* k: the curve after k updates. *Residual*, or *adjusting vectors*: Δ, one for each data
//!   point. *Step*: by how much a control point moves.
//! - *Distance*: ‖Δ_i‖, in data units, of which the largest is *the error* of a level. *Tolerance*:
//!   the largest error that is accepted.
//! - *Rate*: the factor by which an update changes the error; *transform*: U.
//! - *Direction*: u or v of a surface, the one of a curve; *parameters* t: where on it data points
//!   lie.
//! - *Line*: a row or column of the grid of a surface. *Lane*: an array with one coordinate of all
//!   points. *Block*: up to 1024 points whose norms are summed up together.
//! - *Plain loop* and *sweep*: two ways to compute the same levels.
//!
//! # Guarantees
//!
//! - Levels are pure functions of the problem: the same numbers to the last bit, whatever the path,
//!   the number of threads, the instruction set, or how many levels are computed at once.
//! - Data of any magnitude and any position are fitted alike; numbers that leave the range of `f64`
//!   end an iteration with an outcome, never with a panic.
//! - All validation errors are found before the first level, with their location.
//! - Memory and time follow from the sizes, before anything is computed.
//!
//! # Modules, in the order in which a fit is made
//!
//! - [`Fit`]: the request; [`Prepared`]: what can be iterated; [`Curve`], [`Surface`]: the results;
//! - [`data`]: points, grids of points, missing ones, weights;
//! - [`parameters`]: parameters of the data points;
//! - [`basis`]: Bernstein, Said–Ball, Wang–Ball and B-spline; knots and end conditions;
//! - `linear`: banded, dense and sparse matrices and their factorizations;
//! - `matrix`: the collocation matrix B as an operator, its eigenvalues and the rates that follow;
//! - `ends`: control points that the end conditions determine;
//! - `setup`: what is fitted, independent of the method; [`geometry`]: evaluation, NURBS form, samples, distances;
//! - [`method`]: a file for each method: its settings, level 0, transform U, stop rule and forecast;
//! - `knot_selection`: as few control points as a tolerance needs;
//! - `problem`: validation, sizes and admission; [`invalid`]: validation errors; `warning`: accepted but doubtful
//!   input;
//! - `iteration`: the loop, sweeps over memory, termination and predictions;
//! - `trim`: the outline of the data of a surface.
//!
//! Modules use those above them in this list, and not those below.
//!
//! Sources: Lin, Bao, Wang, *Totally positive bases and progressive iteration approximation*,
//! Comput. Math. Appl. 50 (2005) — **LBW05**; Lin, Wang, Dong, *Constructing iterative non-uniform
//! B-spline curve and surface to fit data points*, Science in China F 47 (2004) — **LWD04**;
//! Delgado, Peña, *Progressive iterative approximation and bases with the fastest convergence
//! rates*, CAGD 24 (2007) — **DP07**; Lin, *Local progressive-iterative approximation format for
//! blending curves and patches*, CAGD 27 (2010) — **Lin10**; Deng, Guan, Wang, Deng, *An extension
//! of a new kind of graphics fitting method*, Appl. Math. Inf. Sci. 7 (2013) — **Deng13**; Piegl,
//! Tiller, *The NURBS Book*, 2nd ed. (1997) — **PT97**.

pub mod basis;
pub mod data;
pub(crate) mod ends;
#[doc(hidden)]
pub mod engine;
mod fit;
pub mod geometry;
pub(crate) mod interrupt;
pub mod invalid;
pub(crate) mod iteration;
pub(crate) mod kind_info;
pub(crate) mod knot_selection;
pub(crate) mod linear;
pub(crate) mod matrix;
pub mod method;
pub mod parameters;
pub(crate) mod problem;
pub mod programs;
#[cfg(test)]
mod properties;
pub(crate) mod setup;
mod shape;
pub(crate) mod termination;
pub(crate) mod trim;
pub(crate) mod warning;
#[cfg(feature = "serde")]
#[cfg(test)]
mod written;

pub use data::{Grid, Points};
pub use fit::{Fit, Level, Levels, NotConverged, Prepared};
pub use geometry::{FitError, KnotVector, Nurbs};
pub use invalid::Invalid;
pub use method::Method;
pub use shape::{Curve, Shape, Surface};
