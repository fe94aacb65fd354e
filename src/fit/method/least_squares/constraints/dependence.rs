//! Conditions that follow from others, or contradict them.
//!
//! The rows of C are brought to length one, and orthogonalized one after the other by a Cholesky
//! decomposition of `C Cᵀ`: its pivots are the squared distances of a row from the span of those
//! before it. A row without distance is a sum of others, and its value either is the same sum of
//! theirs or not.

use super::conditions::{Condition, conditions};
use super::mistake::ConstraintsMistake as Mistake;
use crate::fit::interrupt;
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
) -> Result<Vec<Condition>, Mistake> {
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
            Some(index) if agrees => {
                let others = others();
                return Err(Mistake::Redundant { index, others });
            }
            Some(index) => {
                let others = others();
                return Err(Mistake::Contradictory { index, others });
            }
            None if !agrees && settings.ends == EndPoints::Interpolated => {
                return Err(Mistake::EndsContradict { others: others() });
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

    /// The product with another row.
    fn dot(&self, other: &Self) -> f64 {
        let factor = |index: usize| other.row.iter().find(|(other, _)| *other == index);
        let products = self.row.iter();
        products
            .filter_map(|&(index, x)| factor(index).map(|(_, y)| x * y))
            .sum()
    }
}

/// The Cholesky factor of `C Cᵀ` of the rows so far.
#[derive(Default)]
struct Orthogonal {
    rows: Vec<Vec<f64>>,
}

impl Orthogonal {
    /// Adds a row of length one, or returns its factors as a sum of the `kept` ones.
    fn insert(&mut self, condition: &Condition, kept: &[Condition]) -> Option<Vec<f64>> {
        let mut row: Vec<f64> = kept.iter().map(|other| condition.dot(other)).collect();
        for k in 0..row.len() {
            let (before, rest) = row.split_at_mut(k);
            let known = self.rows[k].iter().zip(&*before);
            let known: f64 = known.map(|(a, b)| a * b).sum();
            rest[0] = (rest[0] - known) / self.rows[k][k];
        }
        let pivot = condition.dot(condition) - row.iter().map(|x| x * x).sum::<f64>();
        if pivot > DEPENDENT {
            row.push(pivot.sqrt());
            self.rows.push(row);
            return None;
        }
        // Lᵀ c = row.
        for k in (0..row.len()).rev() {
            row[k] /= self.rows[k][k];
            let factor = row[k];
            for (x, entry) in row[..k].iter_mut().zip(&self.rows[k]) {
                *x -= factor * entry;
            }
        }
        Some(row)
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
