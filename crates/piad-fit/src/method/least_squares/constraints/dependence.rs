//! Conditions that follow from others, or contradict them.
//!
//! The rows of C are brought to length one, and orthogonalized one after the other by a Cholesky
//! decomposition of `C Cᵀ`: its pivots are the squared distances of a row from the span of those
//! before it. A row without distance is a sum of others, and its value either is the same sum of
//! theirs or not.

use super::conditions::{Condition, Origin, conditions, unfit};
use crate::interrupt;
use crate::invalid::{Invalid, Place, Setting};
use crate::method::least_squares::settings::LeastSquares;
use crate::setup::Setup;

/// A row of length one whose squared distance from the span of others is below this has too little freedom.
const DEPENDENT: f64 = 1e-12;

/// One whose squared distance is below this part of the squares of the factors is a sum of others to rounding.
const FOLLOWS: f64 = 1e-24;

/// Values that differ by less than this part of the data, and of what they are a sum of, are equal.
const EQUAL: f64 = 1e-11;

/// A row takes part in a sum with a factor above this.
const TAKES_PART: f64 = 1e-6;

/// The conditions of a fit without those that follow from others.
///
/// # Errors
///
/// The first constraint that is wrong, or that cannot be obeyed together with others.
pub(in super::super) fn independent(
    setup: &Setup,
    settings: &LeastSquares,
) -> Result<Vec<Condition>, Invalid> {
    let mut basis = Orthogonal::default();
    let mut kept: Vec<Condition> = Vec::new();
    for mut condition in conditions(setup, settings)? {
        interrupt::check();
        let length = condition.normalize();
        let Some(sum) = basis.insert(&condition, &kept) else {
            kept.push(condition);
            continue;
        };
        let (off, size) = sum.disagreement(&condition, &kept, setup);
        if sum.is_exact && off <= EQUAL * size {
            continue;
        }
        return Err(contradiction(&condition, &kept, &sum, off * length));
    }
    Ok(kept)
}

/// A condition that contradicts others: they lead to a value that is `off` by this amount.
fn contradiction(condition: &Condition, kept: &[Condition], sum: &Sum, off: f64) -> Invalid {
    let (others, ends) = names(condition.origin, kept, &sum.factors);
    let advice = match ends {
        true => ", or release the ends with \"end_points\": \"free\"",
        false => "",
    };
    let differs = match off.is_finite() {
        true => format!(", with which it differs by {off:.3e}"),
        false => String::new(),
    };
    let detail = format!(
        "cannot be obeyed together with {others}{differs}: the control points there have too little freedom; use more control points or fewer constraints{advice}"
    );
    match condition.origin {
        Origin::Constraint(index) => unfit(index, &detail),
        end => Invalid::at(
            Place::Setting(Setting::EndPoints),
            format!("{} {detail}", end.name()),
        ),
    }
}

impl Condition {
    /// Brings the row to length one, unless it is zero; returns the length that it had.
    fn normalize(&mut self) -> f64 {
        let largest = self.row.iter().fold(0.0, |m: f64, (_, x)| m.max(x.abs()));
        if largest == 0.0 {
            return 1.0;
        }
        let square: f64 = self.row.iter().map(|(_, x)| (x / largest).powi(2)).sum();
        let length = square.sqrt();
        let scale = |x: &mut f64| *x = *x / largest / length;
        self.row.iter_mut().for_each(|(_, x)| scale(x));
        self.value.iter_mut().for_each(scale);
        largest * length
    }
}

/// A row as a sum of others.
struct Sum {
    factors: Vec<f64>,
    /// To rounding.
    is_exact: bool,
}

impl Sum {
    /// How far the value of a condition is from the same sum of others, and the size of the data and of the terms of
    /// the sum. A tangent that takes part has any length: it agrees with one of the same direction only.
    fn disagreement(&self, condition: &Condition, kept: &[Condition], setup: &Setup) -> (f64, f64) {
        let terms = || kept.iter().zip(&self.factors);
        let mut part =
            terms().filter(|(other, factor)| other.is_tangent && factor.abs() > TAKES_PART);
        let tangents = (part.next(), part.next());
        let mut value = condition.value.clone();
        let mut sum = vec![0.0; condition.value.len()];
        let mut size = setup.diagonal();
        for (other, factor) in terms().filter(|(other, _)| !other.is_tangent) {
            sum.iter_mut()
                .zip(&other.value)
                .for_each(|(sum, value)| *sum += factor * value);
            size += other
                .value
                .iter()
                .fold(0.0, |m: f64, x| m.max((factor * x).abs()));
        }
        match (condition.is_tangent, tangents) {
            (false, (None, _)) => {}
            (true, (None, _)) => {
                value = condition.direction();
                let along: f64 = value.iter().zip(&sum).map(|(v, x)| v * x).sum();
                value.iter_mut().for_each(|x| *x *= along.max(0.0));
            }
            (true, (Some((other, factor)), None)) if *factor > 0.0 => {
                (value, sum, size) = (condition.direction(), other.direction(), 1.0);
            }
            _ => return (f64::INFINITY, size),
        }
        let off = value
            .iter()
            .zip(&sum)
            .map(|(value, sum)| (value - sum).abs());
        (off.fold(0.0, f64::max), size)
    }
}

/// The Cholesky factor of `C Cᵀ` of the rows so far.
#[derive(Default)]
struct Orthogonal {
    rows: Vec<Vec<f64>>,
}

impl Orthogonal {
    /// Adds a row of length one, or returns it as a sum of the `kept` ones.
    ///
    /// The factor of `C Cᵀ` has its condition squared: what is left of the row is computed itself, and
    /// reduced once more (corrected semi-normal equations; Björck 1987).
    fn insert(&mut self, condition: &Condition, kept: &[Condition]) -> Option<Sum> {
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
            let squares: f64 = factors.iter().map(|x| x * x).sum();
            let is_exact = pivot <= FOLLOWS * (1.0 + squares);
            return Some(Sum { factors, is_exact });
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

/// The rest of a row after subtracting sums of others, for all control points.
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

impl Origin {
    fn name(self) -> String {
        match self {
            Self::Start => "the interpolated start".to_owned(),
            Self::End => "the interpolated end".to_owned(),
            Self::Corner => "an interpolated corner".to_owned(),
            Self::Constraint(index) => format!("constraint {index}"),
        }
    }
}

/// What takes part in a sum besides the condition that is this sum, as a message names it, and whether
/// interpolated ends do.
fn names(own: Origin, kept: &[Condition], factors: &[f64]) -> (String, bool) {
    let part = kept.iter().zip(factors);
    let part = part.filter(|(_, factor)| factor.abs() > TAKES_PART);
    let mut origins: Vec<Origin> = part.map(|(other, _)| other.origin).collect();
    origins.sort_unstable();
    origins.dedup();
    let all = origins.len();
    origins.retain(|origin| *origin != own);
    let ends = origins
        .iter()
        .any(|it| !matches!(it, Origin::Constraint(_)));
    let names: Vec<String> = origins.iter().map(|it| it.name()).collect();
    let name = match &names[..] {
        [] if all > 0 => "its other conditions".to_owned(),
        [] => "nothing: no control point takes part in it".to_owned(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    };
    (name, ends)
}
