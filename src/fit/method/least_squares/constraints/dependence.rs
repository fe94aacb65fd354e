//! Conditions that follow from others, or contradict them.
//!
//! The rows of C are brought to length one, and orthogonalized one after the other by a Cholesky
//! decomposition of `C Cᵀ`: its pivots are the squared distances of a row from the span of those
//! before it. A row without distance is a sum of others, and its value either is the same sum of
//! theirs or not.

use super::conditions::{Condition, conditions, unfit};
use crate::fit::interrupt;
use crate::fit::invalid::{Invalid, Place, Setting};
use crate::fit::method::least_squares::settings::{EndPoints, LeastSquares};
use crate::fit::setup::Setup;

/// A row of length one whose squared distance from the span of others is below this depends on them.
const DEPENDENT: f64 = 1e-12;

/// Values that differ by less than this part of the data are equal: the square root of
/// [`DEPENDENT`], as that is how exactly a dependent row is the sum of others.
const EQUAL: f64 = 1e-6;

/// A row takes part in a sum with a factor above this.
const TAKES_PART: f64 = 1e-6;

/// The conditions of a fit without those that follow from others: end points that are fixed already,
/// and those for which something else is asked, unless they are asked for by name.
///
/// # Errors
///
/// The first constraint that is wrong, follows from others or contradicts them.
pub(in super::super) fn independent(
    setup: &Setup,
    settings: &LeastSquares,
) -> Result<Vec<Condition>, Invalid> {
    let mut basis = Orthogonal::default();
    let mut kept: Vec<Condition> = Vec::new();
    for mut condition in conditions(setup, settings)? {
        interrupt::check();
        condition.normalize();
        let Some(factors) = basis.insert(&condition, &kept) else {
            kept.push(condition);
            continue;
        };
        let agrees = agrees(&condition, &kept, &factors, setup);
        let others = || names(condition.constraint, &kept, &factors);
        match condition.constraint {
            Some(index) => {
                let others = others();
                let detail = match agrees {
                    true => format!("follows from {others} already: leave one of them out"),
                    false => format!(
                        "cannot be obeyed together with {others}: the control points there have too little freedom"
                    ),
                };
                return Err(unfit(index, &detail));
            }
            None if !agrees && settings.ends == EndPoints::Interpolated => {
                let others = others();
                let detail = format!(
                    "the data points at the ends cannot be interpolated together with {others}: name the end_points \"free\""
                );
                return Err(Invalid::at(Place::Setting(Setting::EndPoints), detail));
            }
            None => {}
        }
    }
    Ok(kept)
}

impl Condition {
    /// Brings the row to length one, unless it is zero.
    fn normalize(&mut self) {
        let largest = self.row.iter().fold(0.0, |m: f64, (_, x)| m.max(x.abs()));
        if largest > 0.0 {
            let square: f64 = self.row.iter().map(|(_, x)| (x / largest).powi(2)).sum();
            let length = square.sqrt();
            let scale = |x: &mut f64| *x = *x / largest / length;
            self.row.iter_mut().for_each(|(_, x)| scale(x));
            self.value.iter_mut().for_each(scale);
        }
    }
}

/// The Cholesky factor of `C Cᵀ` of the rows so far.
#[derive(Default)]
struct Orthogonal {
    rows: Vec<Vec<f64>>,
}

impl Orthogonal {
    /// Adds a row of length one, or returns its factors as a sum of the `kept` ones.
    ///
    /// The factor of `C Cᵀ` has its condition squared: what is left of the row is computed itself, and
    /// reduced once more (corrected semi-normal equations; Björck 1987).
    fn insert(&mut self, condition: &Condition, kept: &[Condition]) -> Option<Vec<f64>> {
        let mut left = Remainder::of(condition, kept);
        let first = self.forward(kept.iter().map(|other| left.dot(other)).collect());
        let mut factors = self.backward(first.clone());
        left.subtract(&factors, kept);
        let again = self.forward(kept.iter().map(|other| left.dot(other)).collect());
        let again = self.backward(again);
        left.subtract(&again, kept);
        factors.iter_mut().zip(&again).for_each(|(x, y)| *x += y);
        let pivot = left.square();
        if pivot <= DEPENDENT {
            return Some(factors);
        }
        let mut row = first;
        row.push(pivot.sqrt());
        self.rows.push(row);
        None
    }

    /// Solves `L x = b`.
    fn forward(&self, mut b: Vec<f64>) -> Vec<f64> {
        for k in 0..b.len() {
            let (before, rest) = b.split_at_mut(k);
            let known = self.rows[k].iter().zip(&*before);
            let known: f64 = known.map(|(a, b)| a * b).sum();
            rest[0] = (rest[0] - known) / self.rows[k][k];
        }
        b
    }

    /// Solves `Lᵀ x = b`.
    fn backward(&self, mut b: Vec<f64>) -> Vec<f64> {
        for k in (0..b.len()).rev() {
            b[k] /= self.rows[k][k];
            let factor = b[k];
            for (x, entry) in b[..k].iter_mut().zip(&self.rows[k]) {
                *x -= factor * entry;
            }
        }
        b
    }
}

/// What is left of a row when sums of others are taken away, for all control points.
struct Remainder(Vec<f64>);

impl Remainder {
    fn of(condition: &Condition, kept: &[Condition]) -> Self {
        let entries = kept.iter().chain([condition]).flat_map(|it| &it.row);
        let count = entries.map(|(index, _)| index + 1).max().unwrap_or(0);
        let mut left = vec![0.0; count];
        for &(index, x) in &condition.row {
            left[index] += x;
        }
        Self(left)
    }

    fn dot(&self, other: &Condition) -> f64 {
        other.row.iter().map(|&(index, x)| self.0[index] * x).sum()
    }

    fn subtract(&mut self, factors: &[f64], kept: &[Condition]) {
        for (factor, other) in factors.iter().zip(kept) {
            for &(index, x) in &other.row {
                self.0[index] -= factor * x;
            }
        }
    }

    fn square(&self) -> f64 {
        self.0.iter().map(|x| x * x).sum()
    }
}

/// Whether the value of a condition is the same sum of others as its row.
fn agrees(condition: &Condition, kept: &[Condition], factors: &[f64], setup: &Setup) -> bool {
    (0..condition.value.len()).all(|c| {
        let terms = kept.iter().zip(factors);
        let terms = terms.map(|(other, factor)| factor * other.value[c]);
        let (sum, size) = terms.fold((0.0, setup.diagonal()), |(sum, size), term: f64| {
            (sum + term, size + term.abs())
        });
        (condition.value[c] - sum).abs() <= EQUAL * size
    })
}

/// The constraints that take part in a sum besides the constraint that is this sum, as a message names
/// them.
fn names(own: Option<usize>, kept: &[Condition], factors: &[f64]) -> String {
    let part = kept.iter().zip(factors);
    let part = part.filter(|(_, factor)| factor.abs() > TAKES_PART);
    let mut indices: Vec<usize> = part.filter_map(|(other, _)| other.constraint).collect();
    indices.sort_unstable();
    indices.dedup();
    let all = indices.len();
    indices.retain(|index| Some(*index) != own);
    match &indices[..] {
        [] if all > 0 => "what else it asks for itself".to_owned(),
        [] => "nothing: no control point takes part in it".to_owned(),
        [index] => format!("constraint {index}"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(ToString::to_string).collect();
            format!("constraints {} and {last}", first.join(", "))
        }
    }
}
