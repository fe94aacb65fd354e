//! The transform U of the update `X ← X + U Δ`, as far as it is a fixed linear map.
//!
//! On surfaces `U = U_u ⊗ U_v`, which is applied one direction after the other. U is never formed,
//! but for given matrices: it is a factor, a factorization, or the collocation matrix itself.
//!
//! | transform | a level of a curve of n points and degree p | of a polynomial |
//! |---|---|---|
//! | scale | 0 | 0 |
//! | `H Qᵀ` | O(n p) | O(n²) |
//! | `B⁻¹` | O(n p) | O(n²) |
//! | `Bᵀ/ρ` | O(n p) | O(n²) |
//! | given | O(n²) | O(n²) |

use super::operator::Operator;
use crate::data::points::Points;
use crate::linear::qr::Orthogonal;
use crate::linear::{DenseMap, Inverse, apply_tensor};

/// A fixed linear map of all adjusting vectors.
#[derive(Debug)]
pub(crate) enum Transform {
    /// `U = ω I`; also where the method chooses the step by itself.
    Scale(f64),
    /// `U = H Qᵀ`, of each direction.
    Orthogonal(Orthogonal, Option<Orthogonal>),
    /// `U = B⁻¹`, of each direction.
    Inverse(Inverse, Option<Inverse>),
    /// Any matrix, of each direction.
    Dense(DenseMap, Option<DenseMap>),
    /// `U = Bᵀ / ρ`.
    Transposed {
        /// ρ(B Bᵀ).
        rho: f64,
    },
}

impl Transform {
    /// The scratch space, in numbers, that [`Self::apply`] needs, with this collocation matrix of
    /// `count` data points.
    pub(crate) fn scratch(&self, collocation: &Operator, count: usize) -> usize {
        let image = matches!(self, Self::Transposed { .. });
        collocation.scratch() + if image { count } else { 0 }
    }

    /// Applies the transform in place: `points ← U points`.
    pub(crate) fn apply(&self, collocation: &Operator, points: &mut Points, scratch: &mut [f64]) {
        let grid = collocation.data_grid();
        let mut lanes: Vec<&mut [f64]> = points.lanes_mut().iter_mut().map(AsMut::as_mut).collect();
        match self {
            Self::Scale(omega) => {
                let values = lanes.into_iter().flatten();
                values.for_each(|value| *value *= omega);
            }
            Self::Transposed { rho } => {
                let (image, scratch) = scratch.split_at_mut(grid.count());
                for lane in lanes {
                    collocation.apply_transposed(lane, image, scratch);
                    let image = lane.iter_mut().zip(&*image);
                    image.for_each(|(value, image)| *value = image / rho);
                }
            }
            Self::Orthogonal(u, v) => apply_tensor(u, v.as_ref(), grid, &mut lanes, scratch),
            Self::Inverse(u, v) => apply_tensor(u, v.as_ref(), grid, &mut lanes, scratch),
            Self::Dense(u, v) => apply_tensor(u, v.as_ref(), grid, &mut lanes, scratch),
        }
    }

    /// Applies the transform in place and adds other points: `points ← U points + others`.
    pub(crate) fn apply_onto(
        &self,
        collocation: &Operator,
        points: &mut Points,
        others: &Points,
        scratch: &mut [f64],
    ) {
        if let Self::Inverse(Inverse::Positive(u), None) = self {
            let lanes = points.lanes_mut().iter_mut();
            let mut lanes: Vec<&mut [f64]> = lanes.map(AsMut::as_mut).collect();
            let others: Vec<&[f64]> = others.lanes().iter().map(|lane| &lane[..]).collect();
            return u.apply_onto(&mut lanes, &others);
        }
        self.apply(collocation, points, scratch);
        points.add(others);
    }
}
