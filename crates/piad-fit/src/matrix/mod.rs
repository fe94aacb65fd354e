//! The collocation matrix `B[i][j] = B_j(t_i)` as an operator, and what follows from its eigenvalues.
//!
//! - `bands` and `collocation`: the matrix of a direction; `tensor`: that of a curve or a grid, a tensor product;
//!   `sparse`: that of scattered points; `operator`: any of them;
//! - `transform`: the transform U, where it is a fixed linear map;
//! - `spectrum`: eigenvalues and rates; `stability`: whether a transform diverges; `rates`: classical PIA with each
//!   basis; `forecast`: the forecast of the convergence of a fit.

mod bands;
pub(crate) mod collocation;
pub(crate) mod forecast;
pub(crate) mod operator;
pub(crate) mod rates;
pub(crate) mod sparse;
pub(crate) mod spectrum;
pub(crate) mod stability;
pub(crate) mod tensor;
pub(crate) mod transform;
