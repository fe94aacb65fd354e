//! The limit of a local fit, in closed form.
//!
//! With the adjusted points I and the fixed points J the control points of I move by
//! `δ = B_II⁻¹ Δ_I⁰` in all, and the difference vectors of J converge to (Lin10, Theorem 2)
//!
//! ```text
//! Δ_J = Δ_J⁰ − B_JI B_II⁻¹ Δ_I⁰
//! ```
//!
//! It takes O(|I|³) for the dense factorization of B_II.

use nalgebra::DVector;

use super::Iteration;
use crate::data::points::Points;

/// The most adjusted points for which the limit is computed: it takes O(n³).
pub const MOST_ADJUSTED: usize = 1000;

/// The most multiplications of the limit, of the LU decomposition of B_II.
pub const LIMIT_COST: usize = MOST_ADJUSTED.pow(3) / 3;

/// Where the difference vectors of the fixed points end.
#[derive(Clone, Debug)]
pub struct LocalLimit {
    /// The fixed points, by index.
    pub fixed: Vec<usize>,
    /// Their difference vectors, in homogeneous coordinates if the fit is.
    pub differences: Points,
}

/// Why there is no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoLimit {
    /// The method is not local.
    NotLocal,
    /// Too many points are adjusted.
    TooMany(usize),
    /// `B_II` is singular to working precision.
    Singular,
}

/// The limit of the difference vectors of the fixed points; `start` is the iteration at level 0.
///
/// # Errors
///
/// The method is not local, it adjusts more than [`MOST_ADJUSTED`] points, or B_II is singular.
pub fn local_limit(start: &Iteration) -> Result<LocalLimit, NoLimit> {
    let system = start.system();
    let problem = system.problem();
    let adjusted = problem.method().algorithm().adjusted(problem.setup());
    let adjusted = adjusted.ok_or(NoLimit::NotLocal)?;
    let count = problem.grid().count();
    if adjusted.len() > MOST_ADJUSTED {
        return Err(NoLimit::TooMany(adjusted.len()));
    }
    let mut place = vec![None; count];
    for (k, &index) in adjusted.iter().enumerate() {
        place[index] = Some(k);
    }
    let fixed: Vec<usize> = (0..count).filter(|&index| place[index].is_none()).collect();
    let (Some(residual), Some(matrix)) = (start.residual(), system.collocation().tensor()) else {
        return Err(NoLimit::NotLocal);
    };
    let lu = matrix.principal_block(&adjusted, &place).lu();

    // The adjusted points move by δ = B_II⁻¹ Δ_I in all; the others stay.
    let mut differences = Points::zeros(residual.dimension(), fixed.len());
    let mut scratch = vec![0.0; system.collocation().scratch()];
    let (mut moves, mut image) = (vec![0.0; count], vec![0.0; count]);
    let lanes = differences.lanes_mut().iter_mut();
    for (differences, residual) in lanes.zip(residual.lanes()) {
        let right = DVector::from_iterator(adjusted.len(), adjusted.iter().map(|&i| residual[i]));
        let delta = lu.solve(&right).ok_or(NoLimit::Singular)?;
        for (&index, delta) in adjusted.iter().zip(delta.iter()) {
            moves[index] = *delta;
        }
        system.collocation().apply(&moves, &mut image, &mut scratch);
        for (difference, &index) in differences.iter_mut().zip(&fixed) {
            *difference = residual[index] - image[index];
        }
    }
    Ok(LocalLimit { fixed, differences })
}
