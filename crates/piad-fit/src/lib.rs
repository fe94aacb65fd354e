//! Progressive iterative approximation: the numerics, with no knowledge of jobs or of the wire.
//!
//! # The one loop
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
//! # Words
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
//! # What can be relied on
//!
//! - Levels are pure functions of the problem: the same numbers to the last bit, whatever the path,
//!   the number of threads, the instruction set, or how many levels are computed at once.
//! - Data of any magnitude and any position are fitted alike; numbers that leave the range of `f64`
//!   end an iteration with an outcome, never with a panic.
//! - Everything that can be wrong with a problem is found before the first level, with its place.
//! - Memory and time are known from the sizes, before anything is computed.
//!
//! # Example
//!
//! A cubic B-spline through points of a sine, by classical PIA:
//!
//! ```
//! use piad_fit::{Fit, Method};
//!
//! let points: Vec<[f64; 2]> = (0..20).map(|i| 0.3 * f64::from(i)).map(|x| [x, x.sin()]).collect();
//! let fit = Fit::curve(&points).method(Method::Global).tolerance(1e-9).prepare()?;
//! for level in fit.levels() {
//!     println!("{}: {:e}", level.iteration, level.error.max);
//! }
//! let curve = fit.solve()?;
//! let t = fit.parameters()[7];
//! assert!((curve.eval(t)[1] - points[7][1]).abs() <= 1e-9);
//! println!("{:?} {:?}", curve.eval(t), curve.derivative(t));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! More of them: [`programs`].
//!
//! # Vocabulary, in the order in which a fit is made
//!
//! - [`points`]: ordered data points and control points, coordinate by coordinate;
//! - [`parameters`]: where on the curve each data point lies;
//! - [`basis`]: Bernstein, Said–Ball, Wang–Ball and B-spline, with [`basis::knots`];
//! - [`direction`]: a basis at the parameters, closed or with weights if asked for;
//! - [`ends`]: how it ends, with knots at the data;
//! - `missing`: grids with holes;
//! - `collocation` and [`tensor`]: `B` as banded or dense operator, and tensor products, over
//!   `linear`;
//! - [`spectrum`]: eigenvalues and rates;
//! - [`method`]: the methods, each with its settings, level 0, transform U, stop rule and forecast;
//! - [`admission`]: what a fit may take; [`interrupt`]: ends what nobody waits for;
//! - [`problem`]: a validated fitting problem, a `setup` with a method; [`invalid`]: everything
//!   that can be wrong with one;
//! - [`system`]: a problem with its collocation matrix and its transform, ready to be iterated;
//! - `blocks`, [`norms`], [`iteration`]: the loop, its errors and its stop rules;
//!   `forecast`, `convergence`, `decay`: when it will end;
//! - `plain`, [`sweep`]: the loop as it is written down, and at the speed of the memory;
//! - `between`: what it does between its data;
//! - [`geometry`]: the curve or surface of some control points; [`samples`]: points of it;
//! - [`nurbs`]: the same as CAD kernels store it, whatever its basis;
//! - [`foot`]: the points of a surface that are nearest to others;
//! - [`limit`]: where local fits end, in closed form;
//! - `tolerance`: as few control points as a tolerance needs;
//! - [`warning`]: what is doubtful about a fit.
//!
//! Sources: Lin, Bao, Wang, *Totally positive bases and progressive iteration approximation*,
//! Comput. Math. Appl. 50 (2005) — **LBW05**; Lin, Wang, Dong, *Constructing iterative non-uniform
//! B-spline curve and surface to fit data points*, Science in China F 47 (2004) — **LWD04**;
//! Delgado, Peña, *Progressive iterative approximation and bases with the fastest convergence
//! rates*, CAGD 24 (2007) — **DP07**; Lin, *Local progressive-iterative approximation format for
//! blending curves and patches*, CAGD 27 (2010) — **Lin10**; Deng, Guan, Wang, Deng, *An extension
//! of a new kind of graphics fitting method*, Appl. Math. Inf. Sci. 7 (2013) — **Deng13**; Piegl,
//! Tiller, *The NURBS Book*, 2nd ed. (1997) — **PT97**.

/// The version of the arithmetic: programs with the same one compute the same bits. It grows with each change
/// after which any level of any problem has other bits.
#[doc(hidden)]
pub const KERNEL: u32 = 2;

#[doc(hidden)]
pub mod about;
#[doc(hidden)]
pub mod admission;
#[doc(hidden)]
pub mod aligned;
mod automatic;
mod bands;
#[doc(hidden)]
pub mod bases;
pub mod basis;
mod between;
mod blocks;
mod bounds;
mod choice;
pub(crate) mod collocation;
mod construction;
mod convergence;
mod decay;
pub mod direction;
mod divergence;
pub mod ends;
mod equations;
pub mod fit;
mod fold;
#[doc(hidden)]
pub mod foot;
mod forecast;
mod functional;
pub mod geometry;
pub mod input;
#[doc(hidden)]
pub mod interrupt;
pub mod invalid;
pub mod iteration;
#[doc(hidden)]
pub mod limit;
pub(crate) mod linear;
pub mod method;
pub(crate) mod missing;
mod monotonic;
mod no_data;
pub mod norms;
pub mod nurbs;
pub(crate) mod operator;
pub mod parameters;
mod plain;
#[doc(hidden)]
pub mod point_order;
pub mod points;
pub mod problem;
pub mod programs;
#[cfg(test)]
mod properties;
mod quadrature;
mod quantiles;
#[doc(hidden)]
pub mod rates;
mod request;
pub mod samples;
pub mod scattered;
pub(crate) mod setup;
pub mod shape;
mod sparse;
pub mod spectrum;
pub mod sweep;
pub mod system;
pub mod tensor;
#[doc(hidden)]
pub mod termination;
pub(crate) mod tolerance;
mod transform;
#[doc(hidden)]
pub mod warning;
mod weights;

pub use fit::{Fit, Level, Levels, NotConverged, Prepared};
pub use invalid::Invalid;
pub use method::Method;
pub use norms::FitError;
pub use nurbs::{KnotVector, Nurbs};
pub use points::{Grid, Points};
pub use shape::{Curve, Surface};
