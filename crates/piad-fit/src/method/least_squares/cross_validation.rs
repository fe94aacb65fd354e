//! The fairness that noisy data ask for, by generalised cross-validation (Craven, Wahba, *Smoothing noisy data with
//! spline functions*, Numer. Math. 31 (1979)):
//!
//! ```text
//! V(f) = (1/Σω) Σ ω_i ‖P_i − C_f(t_i)‖² / (1 − tr H_f / n)²,   tr H_f = tr (M + f K)⁻¹ M
//! ```
//!
//! with `M = AᵀΩA / Σω` and the energy K of fairness 1. H_f maps the data to the curve; its trace is the number of control
//! points that the fairness leaves. V estimates the mean square of the distances from data that are not there, so its
//! minimum is the best fairness for noise of unknown size. It is flat there: the largest f is taken with V within
//! [`FLAT`] of the minimum.
//!
//! M and K are banded, and so are the parts of the inverse that the trace needs (Hutchinson, de Hoog, *Smoothing noisy
//! data with spline functions*, Numer. Math. 47 (1985)): a value f takes O(m p²).

use std::sync::Arc;

use super::fairness::Energy;
use super::objective::weights;
use super::settings::{EndPoints, Fairness, LeastSquares};
use super::solver::{places, row};
use crate::interrupt;
use crate::matrix::collocation::Collocation;
use crate::setup::Setup;

/// Values of f: powers of ten from this one on, by quarters.
const FIRST_POWER: f64 = -14.0;

/// How many values there are, up to ten.
const VALUES: usize = 61;

/// A score that is at most this multiple of the smallest is as good.
const FLAT: f64 = 1.02;

/// With less freedom left than this part of the data a score is rounding.
const LEAST_LEFT: f64 = 1e-6;

/// Pivots below this part of the diagonal are rounding: the data do not determine the curve.
const SINGULAR: f64 = 1e-13;

/// Distances whose root mean square is below this part of the size of the data are no noise.
const NO_NOISE: f64 = 1e-9;

/// The fairness of a curve: that of the cross-validation, or the largest with which the distances are within a tolerance,
/// if that is less.
///
/// # Errors
///
/// Why the data choose none.
pub(crate) fn chosen(
    setup: &Setup,
    settings: &LeastSquares,
    tolerance: Option<f64>,
) -> Result<f64, &'static str> {
    let equations = Equations::new(setup, settings).ok_or(UNKNOWN)?;
    let scores = (0..VALUES).filter_map(|k| {
        interrupt::check();
        let fairness = 10_f64.powf(FIRST_POWER + k as f64 / 4.0);
        Some((fairness, equations.score(fairness)?))
    });
    let scores: Vec<(f64, Score)> = scores.collect();
    let least = scores
        .iter()
        .map(|(_, it)| it.value)
        .fold(f64::INFINITY, f64::min);
    let largest = |is_good: &dyn Fn(&Score) -> bool| {
        let good = scores.iter().filter(|(_, score)| is_good(score));
        good.map(|(fairness, _)| *fairness).next_back()
    };
    let is_noise = |score: &Score| score.rms > NO_NOISE * setup.diagonal();
    if let Some((_, smallest)) = scores.iter().find(|(_, score)| score.value <= least)
        && !is_noise(smallest)
    {
        return Err(NOTHING);
    }
    let best = largest(&|score| score.value <= FLAT * least).ok_or(UNKNOWN)?;
    let within = tolerance.and_then(|tolerance| largest(&|score| score.largest <= tolerance));
    Ok(within.map_or(best, |within| best.min(within)))
}

/// The data determine no curve with any fairness.
const UNKNOWN: &str = "the data do not say what is noise: give a number, or fewer control points";

/// They have no noise.
const NOTHING: &str = "the data have no noise, so that nothing is to be smoothed: leave fairness out, or give a number";

/// What is known of a value of f.
struct Score {
    /// V.
    value: f64,
    /// The largest distance from a data point, and the root mean square of all.
    largest: f64,
    rms: f64,
}

/// The equations of a curve without fairness, and its energy.
struct Equations<'a> {
    setup: &'a Setup,
    matrix: Collocation,
    weights: Option<Arc<[f64]>>,
    /// The sum of the weights, and how many data have one.
    sum: f64,
    count: usize,
    /// The place of each control point, in the order in which the matrices are narrow.
    places: Vec<usize>,
    /// M and K.
    data: Band,
    energy: Band,
    /// `AᵀΩP / Σω` of each coordinate.
    pulls: Vec<Vec<f64>>,
    /// Control points at interpolated ends, each with its data point.
    fixed: Vec<(usize, usize)>,
}

impl<'a> Equations<'a> {
    fn new(setup: &'a Setup, settings: &'a LeastSquares) -> Option<Self> {
        let weights = weights(setup, settings);
        let (data, direction) = (setup.data(), setup.u());
        let weight = |i: usize| weights.as_ref().map_or(1.0, |weights| weights[i]);
        let count = (0..data.len()).filter(|&i| weight(i) > 0.0).count();
        let sum: f64 = (0..data.len()).map(weight).sum();
        let matrix = setup.tensor().u;
        let (places, width) = places(&matrix, direction);
        let places: Vec<usize> = places.into_iter().map(|place| place as usize).collect();
        let free = direction.free();
        let mut of_data = Band::new(free, width);
        let mut pulls = vec![vec![0.0; free]; data.dimension()];
        for i in 0..data.len() {
            let row = row(&matrix, i);
            of_data.add(&row, weight(i) / sum, &places);
            for (pull, lane) in pulls.iter_mut().zip(data.lanes()) {
                row.iter()
                    .for_each(|&(j, a)| pull[places[j]] += a * weight(i) / sum * lane[i]);
            }
        }
        let order = settings.fairness.map_or(2, |it| it.order);
        let fairness = Fairness {
            value: 1.0,
            order,
            by_data: false,
        };
        let settings = LeastSquares {
            fairness: Some(fairness),
            gap_stiffness: Some(0.0),
            ..settings.clone()
        };
        let mut energy = Band::new(free, width);
        Energy::new(setup, &settings, 1.0)?.each_row(|row| energy.add(&row, 1.0, &places));
        let is_fixed = settings.ends == EndPoints::Interpolated && !direction.is_closed();
        let [first, last] = setup.ends();
        let ends = [(0, first), (free - 1, last)];
        Some(Self {
            setup,
            matrix,
            weights,
            sum,
            count,
            fixed: if is_fixed { ends.to_vec() } else { Vec::new() },
            places,
            data: of_data,
            energy,
            pulls,
        })
    }

    /// The score of a value of f; `None` where rounding decides.
    fn score(&self, fairness: f64) -> Option<Score> {
        let mut whole = self.data.plus(&self.energy, fairness);
        let fixed: Vec<usize> = self.fixed.iter().map(|(j, _)| self.places[*j]).collect();
        let coupling: Vec<Vec<f64>> = fixed.iter().map(|&place| whole.column(place)).collect();
        fixed.iter().for_each(|&place| whole.fix(place));
        whole.factorize()?;
        let (data, n) = (self.setup.data(), self.count as f64);
        let mut squares = vec![0.0; data.len()];
        for (pull, lane) in self.pulls.iter().zip(data.lanes()) {
            let mut x = pull.clone();
            for ((_, datum), column) in self.fixed.iter().zip(&coupling) {
                x.iter_mut()
                    .zip(column)
                    .for_each(|(x, a)| *x -= a * lane[*datum]);
            }
            for (place, (_, datum)) in fixed.iter().zip(&self.fixed) {
                x[*place] = lane[*datum];
            }
            whole.solve(&mut x);
            for (i, square) in squares.iter_mut().enumerate() {
                let entries = row(&self.matrix, i).into_iter();
                let value: f64 = entries.map(|(j, a)| a * x[self.places[j]]).sum();
                *square += (lane[i] - value) * (lane[i] - value);
            }
        }
        let weight = |i: usize| self.weights.as_ref().map_or(1.0, |weights| weights[i]);
        let mean = squares
            .iter()
            .enumerate()
            .map(|(i, x)| weight(i) * x)
            .sum::<f64>()
            / self.sum;
        let trace = whole.trace_of_inverse_times(&self.data, &fixed) + fixed.len() as f64;
        let left = 1.0 - trace / n;
        let is_there = |i: &usize| self.setup.missing().is_none_or(|it| !it.contains(*i));
        let there = (0..squares.len()).filter(is_there);
        let largest = there.map(|i| squares[i]).fold(0.0, f64::max).sqrt();
        (left > LEAST_LEFT).then(|| Score {
            value: mean / (left * left),
            rms: mean.sqrt(),
            largest,
        })
    }
}

/// A symmetric matrix of entries near its diagonal, or its factor L with `L Lᵀ`.
struct Band {
    /// Entries on and below the diagonal of a column.
    width: usize,
    /// Row after row, the diagonal last.
    entries: Vec<f64>,
}

impl Band {
    fn new(order: usize, width: usize) -> Self {
        let width = width.clamp(1, order.max(1));
        Self {
            width,
            entries: vec![0.0; order * width],
        }
    }

    fn order(&self) -> usize {
        self.entries.len() / self.width
    }

    fn index(&self, i: usize, j: usize) -> usize {
        (i + 1) * self.width - 1 - (i - j)
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[self.index(i, j)]
    }

    /// The columns to the left of row i within the band.
    fn first(&self, i: usize) -> usize {
        (i + 1).saturating_sub(self.width)
    }

    /// Adds the products of a row with itself.
    fn add(&mut self, row: &[(usize, f64)], factor: f64, places: &[usize]) {
        for &(a, x) in row {
            for &(b, y) in row {
                let (i, j) = (places[a], places[b]);
                if i >= j {
                    let index = self.index(i, j);
                    self.entries[index] += factor * x * y;
                }
            }
        }
    }

    fn plus(&self, other: &Self, factor: f64) -> Self {
        let pairs = self.entries.iter().zip(&other.entries);
        Self {
            width: self.width,
            entries: pairs.map(|(a, b)| a + factor * b).collect(),
        }
    }

    /// A whole column.
    fn column(&self, j: usize) -> Vec<f64> {
        let entry = |i: usize| match (i.max(j), i.min(j)) {
            (i, j) if i - j < self.width => self.at(i, j),
            _ => 0.0,
        };
        (0..self.order()).map(entry).collect()
    }

    /// Makes a row and its column those of the identity.
    fn fix(&mut self, place: usize) {
        for other in self.first(place)..self.order().min(place + self.width) {
            let index = self.index(place.max(other), place.min(other));
            self.entries[index] = if other == place { 1.0 } else { 0.0 };
        }
    }

    /// Cholesky's factor in its place; `None` if the matrix is not positive definite.
    fn factorize(&mut self) -> Option<()> {
        for i in 0..self.order() {
            let diagonal = self.at(i, i);
            for j in self.first(i)..=i {
                let from = self.first(i).max(self.first(j));
                let products: f64 = (from..j).map(|k| self.at(i, k) * self.at(j, k)).sum();
                let left = self.at(i, j) - products;
                let index = self.index(i, j);
                self.entries[index] = match i == j {
                    true if left <= SINGULAR * diagonal => return None,
                    true => left.sqrt(),
                    false => left / self.at(j, j),
                };
            }
        }
        Some(())
    }

    /// Solves with the factor.
    fn solve(&self, x: &mut [f64]) {
        for i in 0..x.len() {
            let products: f64 = (self.first(i)..i).map(|j| self.at(i, j) * x[j]).sum();
            x[i] = (x[i] - products) / self.at(i, i);
        }
        for i in (0..x.len()).rev() {
            x[i] /= self.at(i, i);
            let value = x[i];
            (self.first(i)..i).for_each(|j| x[j] -= self.at(i, j) * value);
        }
    }

    /// The trace of the inverse of `L Lᵀ` times another matrix, but for fixed places. The entries of the inverse within the
    /// band come from the last to the first:
    ///
    /// ```text
    /// Z_ij = (δ_ij / L_jj − Σ_{k > j} L_kj Z_ki) / L_jj,   i ≥ j
    /// ```
    fn trace_of_inverse_times(&self, other: &Self, fixed: &[usize]) -> f64 {
        let order = self.order();
        let mut inverse = Self::new(order, self.width);
        let mut trace = 0.0;
        for j in (0..order).rev() {
            let end = order.min(j + self.width);
            let pivot = self.at(j, j);
            for i in (j..end).rev() {
                let products = (j + 1..end).map(|k| self.at(k, j) * inverse.at(k.max(i), k.min(i)));
                let unit = if i == j { 1.0 / pivot } else { 0.0 };
                let value = (unit - products.sum::<f64>()) / pivot;
                let index = inverse.index(i, j);
                inverse.entries[index] = value;
                let times = if i == j { 1.0 } else { 2.0 };
                if !fixed.contains(&i) && !fixed.contains(&j) {
                    trace += times * value * other.at(i, j);
                }
            }
        }
        trace
    }
}

#[cfg(test)]
mod tests;
