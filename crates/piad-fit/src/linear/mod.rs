//! Linear algebra along the lines of a grid: banded matrices, and factorizations that solve.
//!
//! A *line* is a contiguous array of numbers, one coordinate of a curve or of a row of a surface.
//! Matrices are those of one direction: n rows, one for each data point, and as many columns as
//! there are free control points. With bandwidth w (p + 1 for B-splines of degree p, cyclic for
//! closed ones) they take n w numbers, a product with a line n w multiplications, and a
//! factorization O(n w²).
//!
//! - `banded`: matrices with a few consecutive entries in each row, made by `pack`, and `columns`
//!   of them;
//! - `map`: linear maps of lines, and tensor products of them;
//! - `inverse`: `B⁻¹` by `elimination` without pivots, by banded `lu` or by `dense` LU;
//! - `qr`: the transform of the extended method, of cyclic matrices by `bordered`;
//! - `triangular`: least-squares factorizations of the matrices that `rows` collects;
//! - `symmetric`: symmetric banded matrices and their Cholesky factors;
//! - `stencil`: symmetric matrices over the functions of a grid, by diagonals;
//! - `bicgstab`: sparse systems that are not symmetric (`sparse_rows`), with a multigrid cycle (`aggregation`);
//! - `conjugate`: steps of conjugate gradients; `vectors`: sums over vectors;
//! - `band`: cyclic matrices on their way into a factorization.

mod aggregation;
mod band;
pub(crate) mod banded;
pub(crate) mod bicgstab;
mod bordered;
pub(crate) mod columns;
pub(crate) mod conjugate;
mod dense;
mod elimination;
mod inverse;
pub(crate) mod lu;
mod map;
mod pack;
pub(crate) mod qr;
pub(crate) mod rows;
pub(crate) mod sparse_rows;
pub(crate) mod stencil;
pub(crate) mod symmetric;
pub(crate) mod triangular;
pub(crate) mod vectors;

pub(crate) use band::folded;
pub(super) use dense::{Dense, DenseMap};
pub(crate) use inverse::Inverse;
pub(crate) use map::{LineMap, apply_tensor};
