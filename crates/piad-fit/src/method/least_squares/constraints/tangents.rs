//! The lengths of derivatives of which only the direction is given.
//!
//! With N the matrix of the normal equations, b = C N⁻¹ AᵀΩP − R and G = C N⁻¹ Cᵀ, the least objective among control
//! points with `C X = R` is, but for a constant, Σ bᵀ G⁻¹ b over the coordinates. A tangent k has R_k = s_k v_k, with a
//! unit vector v_k, so that it is a quadratic function of the lengths s,
//!
//! ```text
//! sᵀ H s − 2 hᵀ s,   H_kl = (G⁻¹)_kl v_k·v_l,   h_k = v_k·(G⁻¹ b)_k   with s = 0 in b,
//! ```
//!
//! which is made least among s ≥ 0 (Lawson, Hanson 1974, chapter 23). The rows of C stand in N, too, each with a weight;
//! what they add to G⁻¹ is taken away from its diagonal.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::Projection;
use super::conditions::{Condition, Origin};
use crate::data::points::Points;
use crate::setup::Setup;

/// A tangent whose length changes the objective by less than this part of what its condition does is not
/// determined by the data.
const UNDETERMINED: f64 = 1e-9;

/// A slope below this part of the largest is none.
const FLAT: f64 = 1e-12;

/// The tangents among conditions, and the objective as a function of their lengths.
pub(in super::super) struct Tangents {
    /// Their places among the conditions.
    places: Vec<usize>,
    /// The unit vectors.
    directions: Vec<Vec<f64>>,
    /// The matrix H.
    matrix: DMatrix<f64>,
    /// The vector h.
    slopes: DVector<f64>,
    /// The tangents whose lengths the data determine.
    determined: Vec<bool>,
}

impl Tangents {
    /// Of conditions with the minimum `N⁻¹ AᵀΩP` that does not satisfy them, and the weight of each row in N.
    pub(in super::super) fn new(
        conditions: &[Condition],
        weights: &[f64],
        projection: &Projection,
        minimum: &Points,
    ) -> Self {
        let places = (0..conditions.len()).filter(|&k| conditions[k].is_tangent);
        let places: Vec<usize> = places.collect();
        let inverse: Vec<Vec<f64>> = places
            .iter()
            .map(|&k| projection.inverse_column(k))
            .collect();
        let directions = places.iter().map(|&k| conditions[k].direction());
        let directions: Vec<Vec<f64>> = directions.collect();
        let dot = |i: usize, j: usize| -> f64 {
            let products = directions[i].iter().zip(&directions[j]);
            products.map(|(a, b)| a * b).sum()
        };
        let count = places.len();
        let matrix = DMatrix::from_fn(count, count, |i, j| {
            let weight = if i == j { weights[places[i]] } else { 0.0 };
            (inverse[i][places[j]] - weight) * dot(i, j)
        });
        let apart = |c: usize| projection.apart(c, minimum.lane(c));
        let apart: Vec<Vec<f64>> = (0..minimum.dimension()).map(apart).collect();
        let slope = |i: usize| -> f64 {
            let products = apart.iter().zip(&directions[i]).map(|(apart, v)| {
                let product = apart.iter().zip(&inverse[i]).map(|(x, y)| x * y);
                v * product.sum::<f64>()
            });
            products.sum()
        };
        let determined = (0..count).map(|i| matrix[(i, i)] > UNDETERMINED * inverse[i][places[i]]);
        Self {
            determined: determined.collect(),
            slopes: DVector::from_fn(count, |i, _| slope(i)),
            matrix,
            directions,
            places,
        }
    }

    /// Gives each tangent its length; where the data do not determine it, the derivative is as long as the polygon
    /// through the data over the range of the parameters. Returns the first constraint whose vector the data run
    /// against: its length is zero.
    pub(in super::super) fn settle(
        &self,
        conditions: &mut [Condition],
        setup: &Setup,
    ) -> Option<usize> {
        let lengths = self.lengths();
        let mut reversed = None;
        for (i, &place) in self.places.iter().enumerate() {
            let condition = &mut conditions[place];
            let row = condition.value.iter().map(|x| x * x).sum::<f64>().sqrt();
            let length = match self.determined[i] {
                true => lengths[i],
                false => speed(setup) * row,
            };
            if length == 0.0
                && let Origin::Constraint(index) = condition.origin
            {
                reversed.get_or_insert(index);
            }
            condition.value = self.directions[i].iter().map(|x| x * length).collect();
            condition.is_tangent = false;
        }
        reversed
    }

    /// The lengths with the least objective, none of them below zero.
    fn lengths(&self) -> DVector<f64> {
        let count = self.places.len();
        let mut lengths = DVector::zeros(count);
        let mut positive: Vec<usize> = Vec::new();
        let flat = FLAT * self.slopes.amax();
        for _ in 0..3 * count {
            let slopes = &self.slopes - &self.matrix * &lengths;
            let next = (0..count).filter(|&i| self.determined[i] && !positive.contains(&i));
            let Some(next) = next.max_by(|&i, &j| slopes[i].total_cmp(&slopes[j])) else {
                break;
            };
            if slopes[next] <= flat {
                break;
            }
            positive.push(next);
            // Lengths that would fall below zero leave again, the first of them first.
            while let Some(least) = self.least(&positive) {
                let pairs = || positive.iter().copied().zip(least.iter().copied());
                let falling = pairs().filter(|(_, x)| *x <= 0.0).map(|(i, x)| {
                    let fall = (lengths[i] - x).max(f64::MIN_POSITIVE);
                    (i, lengths[i] / fall)
                });
                let Some((first, step)) = falling.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                    pairs().for_each(|(i, x)| lengths[i] = x);
                    break;
                };
                let moved: Vec<_> = pairs().map(|(i, x)| (i, step * (x - lengths[i]))).collect();
                moved.into_iter().for_each(|(i, x)| lengths[i] += x);
                lengths[first] = 0.0;
                positive.retain(|&i| i != first);
            }
        }
        lengths
    }

    /// The lengths of these tangents with the least objective, of any sign; `None` if there are none.
    fn least(&self, of: &[usize]) -> Option<DVector<f64>> {
        let matrix = self.matrix.select_rows(of).select_columns(of);
        let slopes = self.slopes.select_rows(of);
        (!of.is_empty()).then(|| Cholesky::new(matrix).map(|it| it.solve(&slopes)))?
    }
}

/// The length of the polygon through the data of a curve over the range of the parameters.
fn speed(setup: &Setup) -> f64 {
    let (points, count) = (setup.data(), setup.data().len());
    let edges = count - usize::from(!setup.u().is_closed());
    let lengths = (0..edges).map(|i| points.distance(i, (i + 1) % count));
    let (low, high) = setup.u().basis.domain();
    lengths.sum::<f64>() / (high - low)
}
