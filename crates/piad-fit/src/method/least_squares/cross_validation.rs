//! The fairness for noisy data, by generalised cross-validation (Craven, Wahba, *Smoothing noisy data with spline
//! functions*, Numer. Math. 31 (1979)):
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
//! data with spline functions*, Numer. Math. 47 (1985)): a value f takes O(m p²) of a curve, and O(m (p n)²) of a surface
//! with n control points in a row, of which fewer values are tried. The stiffness of gaps counts beside M.

use super::fairness::Energy;
use super::objective::weights;
use super::settings::{EndPoints, Fairness, LeastSquares};
use super::solver::{MAX_SURFACE_MULTIPLICATIONS, places, row};
use crate::interrupt;
use crate::linear::symmetric::SymmetricBand;
use crate::matrix::operator::Operator;
use crate::setup::Setup;

/// Values of f: powers of ten from this one on, by quarters.
const FIRST_POWER: f64 = -14.0;

/// The number of values, up to ten.
const VALUES: usize = 61;

/// A score that is at most this multiple of the smallest is as good.
const FLAT: f64 = 1.02;

/// With less freedom left than this part of the data a score is rounding.
const LEAST_LEFT: f64 = 1e-6;

/// Distances whose root mean square is below this part of the size of the data are no noise.
const NO_NOISE: f64 = 1e-9;

/// Of surfaces every fourth value is tried first, a power of ten, and then those around the best.
const COARSE: usize = 4;

/// The first of them.
const FIRST_OF_SURFACES: usize = 8;

/// The most values that are tried of surfaces.
const VALUES_OF_SURFACES: usize = 22;

/// The fairness of a fit: that of the cross-validation, or the largest of the values that are tried with which the
/// distances are within a tolerance, if that is less.
///
/// # Errors
///
/// Why the data determine none.
pub(crate) fn chosen(
    setup: &Setup,
    settings: &LeastSquares,
    tolerance: Option<f64>,
) -> Result<f64, &'static str> {
    let equations = Equations::new(setup, settings).ok_or(UNKNOWN)?;
    let tried = |values: &mut dyn Iterator<Item = usize>| -> Vec<(f64, Score)> {
        let scores = values.filter_map(|k| {
            interrupt::check();
            let fairness = 10_f64.powf(FIRST_POWER + k as f64 / 4.0);
            Some((fairness, equations.score(fairness)?))
        });
        scores.collect()
    };
    let scores = match setup.v() {
        None => tried(&mut (0..VALUES)),
        Some(_) if equations.cost() > MAX_SURFACE_MULTIPLICATIONS => return Err(TOO_MANY),
        Some(_) => {
            let mut scores = tried(&mut (FIRST_OF_SURFACES..VALUES).step_by(COARSE));
            let best = scores.iter().min_by(|a, b| a.1.value.total_cmp(&b.1.value));
            let (best, _) = best.ok_or(UNKNOWN)?;
            let best = ((best.log10() - FIRST_POWER) * 4.0).round() as usize;
            let around = (best + 1).saturating_sub(COARSE)..(best + COARSE).min(VALUES);
            scores.extend(tried(&mut around.filter(|k| *k != best)));
            scores.sort_by(|a, b| a.0.total_cmp(&b.0));
            scores
        }
    };
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

/// There are too many control points for the factors that a choice takes.
const TOO_MANY: &str =
    "there are too many control points for the data to choose it: give a number, or fewer of them";

/// The data determine no curve with any fairness.
const UNKNOWN: &str = "the data do not determine the noise: give a number, or fewer control points";

/// They have no noise.
const NOTHING: &str = "the data have no noise, so that there is nothing to smooth: leave fairness out, or give a number";

/// The result for a value of f.
struct Score {
    /// V.
    value: f64,
    /// The largest distance from a data point, and the root mean square of all.
    largest: f64,
    rms: f64,
}

/// The equations of a fit without fairness, and its energy.
struct Equations<'a> {
    setup: &'a Setup,
    matrix: Operator,
    /// How much each datum counts: nothing if it is missing.
    weights: Vec<f64>,
    /// The sum of the weights, and how many data have one.
    sum: f64,
    count: usize,
    /// The place of each control point, in the order in which the matrices are narrow.
    places: Vec<usize>,
    /// M, K, and what the stiffness of gaps adds to M.
    data: SymmetricBand,
    energy: SymmetricBand,
    gaps: Option<SymmetricBand>,
    /// `AᵀΩP / Σω` of each coordinate.
    pulls: Vec<Vec<f64>>,
    /// Control points at interpolated ends of a curve, each with its data point.
    fixed: Vec<(usize, usize)>,
}

impl<'a> Equations<'a> {
    fn new(setup: &'a Setup, settings: &'a LeastSquares) -> Option<Self> {
        let given = weights(setup, settings);
        let (data, direction) = (setup.data(), setup.u());
        let is_there = |i: usize| setup.missing().is_none_or(|it| !it.contains(i));
        let weight = |i: usize| match is_there(i) {
            true => given.as_ref().map_or(1.0, |weights| weights[i]),
            false => 0.0,
        };
        let weights: Vec<f64> = (0..data.len()).map(weight).collect();
        let count = weights.iter().filter(|weight| **weight > 0.0).count();
        let sum: f64 = weights.iter().sum();
        let matrix = setup.collocation();
        let (places, width) = narrow(setup, &matrix);
        let free = places.len();
        let mut of_data = SymmetricBand::new(free, width);
        let mut pulls = vec![vec![0.0; free]; data.dimension()];
        for (i, weight) in weights
            .iter()
            .enumerate()
            .filter(|(_, weight)| **weight > 0.0)
        {
            let row = entries(&matrix, i);
            of_data.add_products(&row, weight / sum, &places);
            for (pull, lane) in pulls.iter_mut().zip(data.lanes()) {
                row.iter()
                    .for_each(|&(j, a)| pull[places[j]] += a * weight / sum * lane[i]);
            }
        }
        let order = settings.fairness.map_or(2, |it| it.order);
        let banded = |value: f64, gap_stiffness: Option<f64>| {
            let fairness = Fairness {
                value,
                order,
                by_data: false,
            };
            let settings = LeastSquares {
                fairness: Some(fairness),
                gap_stiffness,
                ..settings.clone()
            };
            let mut band = SymmetricBand::new(free, width);
            Energy::new(setup, &settings, 1.0)?
                .each_row(|row| band.add_products(&row, 1.0, &places));
            Some(band)
        };
        let is_fixed = settings.ends == EndPoints::Interpolated && !direction.is_closed();
        let [first, last] = setup.ends();
        let ends = [(0, first), (free - 1, last)];
        Some(Self {
            energy: banded(1.0, Some(0.0))?,
            gaps: setup
                .v()
                .and_then(|_| banded(0.0, settings.gap_stiffness())),
            setup,
            matrix,
            weights,
            sum,
            count,
            fixed: if is_fixed && setup.v().is_none() {
                ends.to_vec()
            } else {
                Vec::new()
            },
            places,
            data: of_data,
            pulls,
        })
    }

    /// The approximate number of multiplications that the choice takes for a surface.
    fn cost(&self) -> usize {
        let band = self.data.width.saturating_mul(self.data.width);
        let factor = self.places.len().saturating_mul(band);
        factor.saturating_mul(VALUES_OF_SURFACES)
    }

    /// The score of a value of f; `None` where rounding decides.
    fn score(&self, fairness: f64) -> Option<Score> {
        let mut whole = self.data.plus(&self.energy, fairness);
        if let Some(gaps) = &self.gaps {
            whole = whole.plus(gaps, 1.0);
        }
        let fixed: Vec<usize> = self.fixed.iter().map(|(j, _)| self.places[*j]).collect();
        let coupling: Vec<Vec<f64>> = fixed.iter().map(|&place| whole.column(place)).collect();
        fixed.iter().for_each(|&place| whole.fix(place));
        let factor = whole.factor()?;
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
            factor.solve(&mut x);
            for (i, square) in squares.iter_mut().enumerate() {
                let entries = entries(&self.matrix, i).into_iter();
                let value: f64 = entries.map(|(j, a)| a * x[self.places[j]]).sum();
                *square += (lane[i] - value) * (lane[i] - value);
            }
        }
        let weighted = squares
            .iter()
            .zip(&self.weights)
            .map(|(x, weight)| weight * x);
        let mean = weighted.sum::<f64>() / self.sum;
        let trace = factor.trace_of_inverse_times(&self.data, &fixed) + fixed.len() as f64;
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

/// The places of the control points in which the matrices are narrow, and how many entries a row has up to its diagonal.
fn narrow(setup: &Setup, matrix: &Operator) -> (Vec<usize>, usize) {
    let columns = setup.control_grid().columns;
    match matrix {
        Operator::Sparse(sparse) => {
            let [along, _] = sparse.widths();
            (
                (0..sparse.control_grid().count()).collect(),
                along * columns,
            )
        }
        Operator::Tensor(tensor) => {
            let (places, width) = places(&tensor.u, setup.u());
            let lines = places.into_iter().map(|place| place as usize * columns);
            let places = lines.flat_map(|line| line..line + columns);
            (places.collect(), width * columns)
        }
    }
}

/// The row of a datum.
fn entries(matrix: &Operator, i: usize) -> Vec<(usize, f64)> {
    let tensor = match matrix {
        Operator::Sparse(sparse) => return sparse.row(i).collect(),
        Operator::Tensor(tensor) => tensor,
    };
    let Some(v) = &tensor.v else {
        return row(&tensor.u, i);
    };
    let (columns, across) = (v.columns(), row(v, i % v.rows()));
    let along = row(&tensor.u, i / v.rows());
    let products = along.iter().flat_map(|&(k, a)| {
        let across = across.iter();
        across.map(move |&(l, b)| (k * columns + l, a * b))
    });
    products.collect()
}

#[cfg(test)]
mod tests;
