//! Weights of rational fits.
//!
//! There are two kinds. *Homogeneous* fits lift the data, `Q_i = (w_i P_i, w_i)`, and iterate d + 1
//! coordinates with the polynomial basis: the weights of control points change from level to level,
//! and the weight of the curve at t_i approaches w_i (Lin10, section 2.1). Fits with *fixed*
//! weights have a rational basis `w_j B_j / Σ_k w_k B_k`, and iterate d coordinates (LBW05 (3.7));
//! that of a surface is the product of two of them, so that its weights must be products, too
//! (LBW05 (3.8)).

use super::grid::Grid;
use super::points::Points;
use crate::invalid::{Invalid, Place};

/// The largest relative difference of a grid of weights from a product.
const SEPARABLE: f64 = 1e-12;

/// Lifts n points of R^d to homogeneous coordinates, `Q_i = (w_i P_i, w_i)`: n points of R^(d+1)
/// (Lin10, section 2.1).
///
/// # Errors
///
/// The number of weights is not n, one of them is not finite and positive, or products with
/// coordinates overflow or lose digits.
pub(crate) fn lift(points: &Points, weights: &[f64]) -> Result<Points, Invalid> {
    check(weights, points.len())?;
    let mut lanes = Vec::with_capacity(points.dimension() + 1);
    for coordinates in points.lanes() {
        let lane: Vec<f64> = coordinates
            .iter()
            .zip(weights)
            .map(|(x, weight)| x * weight)
            .collect();
        if lane.iter().any(|x| !x.is_finite()) {
            return Err(Invalid::at(
                Place::Weights,
                "the products of weights and coordinates exceed the range of 64-bit numbers: scale them down",
            ));
        }
        check_digits(&lane, coordinates, weights)?;
        lanes.push(lane);
    }
    lanes.push(weights.to_vec());
    Ok(Points::from_lanes(lanes))
}

/// Refuses products that have lost digits: near the end of the range of numbers there are few, and
/// their loss must be no more than rounding of the largest coordinate.
fn check_digits(products: &[f64], coordinates: &[f64], weights: &[f64]) -> Result<(), Invalid> {
    let largest = coordinates.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let lost = |i: usize| (products[i] / weights[i] - coordinates[i]).abs();
    let small = |i: &usize| products[*i].abs() < f64::MIN_POSITIVE;
    let spoilt = |i: &usize| lost(*i) > 4.0 * f64::EPSILON * largest;
    match (0..products.len()).filter(small).find(spoilt) {
        None => Ok(()),
        Some(index) => Err(Invalid::at(
            Place::Weight(index),
            format!(
                "weight {index} is {value}, so small that its products with coordinates lose their digits: scale the weights up",
                value = weights[index]
            ),
        )),
    }
}

/// Writes a grid of weights as products of weights of its rows and of its columns, `w_ij = r_i c_j`
/// with `c_0 = 1`.
///
/// # Errors
///
/// As with [`lift`], and [`Invalid::NotSeparable`] if the weights are not such products to 12
/// digits.
pub(crate) fn separate(weights: &[f64], grid: Grid) -> Result<(Vec<f64>, Vec<f64>), Invalid> {
    check(weights, grid.count())?;
    let first = weights[0];
    let rows: Vec<f64> = weights.iter().step_by(grid.columns).copied().collect();
    let columns: Vec<f64> = weights[..grid.columns].iter().map(|w| w / first).collect();
    for (row, weights) in rows.iter().zip(weights.chunks_exact(grid.columns)) {
        for (column, weight) in columns.iter().zip(weights) {
            if (row * column / weight - 1.0).abs() > SEPARABLE {
                return Err(Invalid::at(
                    Place::Weights,
                    "the grid of fixed weights is not a product of weights of the rows and of the columns, as the rational basis of a surface needs: use homogeneous weights, or give those of both directions",
                ));
            }
        }
    }
    Ok((rows, columns))
}

/// Refuses weights that are not `expected` in number, or not finite and positive.
fn check(weights: &[f64], expected: usize) -> Result<(), Invalid> {
    let given = weights.len();
    if given != expected {
        return Err(Invalid::weight_count(given, expected));
    }
    match weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
        None => Ok(()),
        Some(index) => Err(Invalid::at(
            Place::Weight(index),
            format!(
                "weight {index} is {value}; weights are finite and greater than 0",
                value = weights[index]
            ),
        )),
    }
}
