//! One direction of the parameter domain: its basis at the parameters of the data.
//!
//! A direction has n parameters, one for each data point, and n *free* control points (fewer in a
//! least-squares fit). There can be more basis functions than free control points:
//!
//! - open, with knots at the data: `n + p − 1` functions. The first control point belongs to the
//!   first ⌊p/2⌋ + 1 of them, the last one to the last ones, and these *copies* move together
//!   (LBW05 (3.2));
//! - closed: the functions of a period and p more, which belong to the control points of the next
//!   turn.
//!
//! For example with n = 5 points and degree 3, where functions are numbered from 0:
//!
//! ```text
//! function                       0  1  2  3  4  5  6
//! control point, at the data     0  0  1  2  3  4  4
//! control point, closed (n = 4)  3  0  1  2  3  0  1
//! ```
//!
//! - in pieces that meet at corners ([`pieces`](super::pieces)): a function for each free control point, and more of
//!   pieces with few of them.
//!
//! Weights of the functions make the basis rational, `w_j B_j / Σ_k w_k B_k` (LBW05 (3.7)).

use std::ops::Range;
use std::sync::Arc;

use super::Basis;
use super::pieces::Pieces;
use crate::data::points::normalizing_scale;
use crate::invalid::{Axis, Invalid, Place, Side};

/// One direction of a validated problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// The basis, without weights.
    pub basis: Basis,
    /// Strictly increasing parameters of the data, within the domain of the basis.
    pub parameters: Arc<Vec<f64>>,
    /// The number of free control points.
    free: usize,
    /// Which functions share control points.
    sharing: Sharing,
    /// A weight for each basis function of a rational basis.
    weights: Option<Vec<f64>>,
    /// True if a least-squares fit starts from equal shares of the data's indices.
    spread_start: bool,
}

/// The copies of the outermost control point on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CopyRule {
    /// They are equal to it.
    Equal,
    /// They differ from it by constants ([`crate::ends`]).
    Constant,
    /// The one copy of a cubic is `(1 − β) c_0 + β c_2`, with β.
    Natural(f64),
}

/// How basis functions share control points.
#[derive(Clone, Debug, PartialEq)]
enum Sharing {
    /// The first control point is repeated `front_copies` times in front, the last one behind: with
    /// knots at the data there are more basis functions than data points (LBW05 (3.2)).
    Open {
        front_copies: usize,
        /// The rules of the copies on both sides.
        copies: [CopyRule; 2],
    },
    /// The first control points follow the last ones, after a period of the parameters.
    Closed { period: f64 },
    /// Pieces that meet at corners, of a closed direction with a period of the parameters.
    Pieces {
        pieces: Arc<Pieces>,
        period: Option<f64>,
    },
}

impl Direction {
    /// An open direction without weights: the first control point is repeated `front_copies` times
    /// in front, and the last one as often behind as there are functions left.
    pub(crate) fn open(
        basis: Basis,
        parameters: Arc<Vec<f64>>,
        free: usize,
        front_copies: usize,
    ) -> Self {
        Self {
            basis,
            parameters,
            free,
            sharing: Sharing::Open {
                front_copies,
                copies: [CopyRule::Equal; 2],
            },
            weights: None,
            spread_start: false,
        }
    }

    /// A direction without weights, in pieces that meet at corners; with a period it is closed.
    pub(crate) fn in_pieces(
        basis: Basis,
        parameters: Arc<Vec<f64>>,
        pieces: Pieces,
        period: Option<f64>,
    ) -> Self {
        let pieces = Arc::new(pieces);
        Self {
            free: pieces.free(),
            sharing: Sharing::Pieces { pieces, period },
            ..Self::open(basis, parameters, 0, 0)
        }
    }

    /// A closed direction without weights, whose parameters repeat after `period`.
    pub(crate) fn closed(
        basis: Basis,
        parameters: Arc<Vec<f64>>,
        free: usize,
        period: f64,
    ) -> Self {
        Self {
            basis,
            parameters,
            free,
            sharing: Sharing::Closed { period },
            weights: None,
            spread_start: false,
        }
    }

    /// The same with other parameters of the data.
    pub(crate) fn with_parameters(&self, parameters: Vec<f64>) -> Self {
        Self {
            parameters: Arc::new(parameters),
            ..self.clone()
        }
    }

    /// The same with other copies on both sides.
    pub(crate) fn with_copies(mut self, rules: [CopyRule; 2]) -> Self {
        if let Sharing::Open { copies, .. } = &mut self.sharing {
            *copies = rules;
        }
        self
    }

    /// The same, where a least-squares fit starts from equal shares of the data's indices.
    pub(crate) fn with_spread_start(mut self) -> Self {
        self.spread_start = true;
        self
    }

    /// Returns true if a least-squares fit starts from equal shares of the data's indices, which do not depend on the
    /// direction of the data, as spread knots do; otherwise it starts from every k-th point.
    pub(crate) fn starts_spread(&self) -> bool {
        self.spread_start
    }

    /// The same with fixed weights: one for each free control point, or for each basis function.
    pub(crate) fn with_weights(mut self, weights: Vec<f64>, axis: Axis) -> Result<Self, Invalid> {
        self.weights = Some(self.complete_weights(weights, axis)?);
        Ok(self)
    }

    /// The parameters as they would be given: on closed curves with the end of the period.
    pub fn explicit_parameters(&self) -> Arc<Vec<f64>> {
        let mut values = Arc::clone(&self.parameters);
        if let Some(period) = self.period() {
            let end = values[0] + period;
            Arc::make_mut(&mut values).push(end);
        }
        values
    }

    /// The period of the parameters of a closed direction.
    pub fn period(&self) -> Option<f64> {
        match self.sharing {
            Sharing::Closed { period } => Some(period),
            Sharing::Pieces { period, .. } => period,
            Sharing::Open { .. } => None,
        }
    }

    /// The number of free control points.
    pub fn free(&self) -> usize {
        self.free
    }

    /// Returns true if it returns to its start: a closed direction is periodic, or clamped at its first corner.
    pub fn is_closed(&self) -> bool {
        self.period().is_some()
    }

    /// Returns true if the basis has weights.
    pub fn is_rational(&self) -> bool {
        self.weights.is_some()
    }

    /// The weights of the basis functions of a rational basis.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The free control point that basis function `j` is multiplied with. On closed curves function
    /// ⌊p/2⌋ is centred on the first data point.
    pub fn free_index(&self, j: usize) -> usize {
        match &self.sharing {
            Sharing::Pieces { pieces, .. } => pieces.free_index(j),
            Sharing::Open { front_copies, .. } => {
                j.saturating_sub(*front_copies).min(self.free - 1)
            }
            // Basis function p/2 is centred on the first data point.
            Sharing::Closed { .. } => {
                (j + self.free - self.basis.degree() / 2 % self.free) % self.free
            }
        }
    }

    /// The rule of the copies on one side, if there are any.
    fn rule(&self, side: Side) -> Option<CopyRule> {
        match (&self.sharing, side) {
            (Sharing::Open { copies, .. }, Side::Start) => Some(copies[0]),
            (Sharing::Open { copies, .. }, Side::End) => Some(copies[1]),
            (Sharing::Closed { .. } | Sharing::Pieces { .. }, _) => None,
        }
    }

    /// The number of copies of the outermost control point on one side.
    pub(crate) fn copies(&self, side: Side) -> usize {
        match (&self.sharing, side) {
            (Sharing::Open { front_copies, .. }, Side::Start) => *front_copies,
            (Sharing::Open { front_copies, .. }, Side::End) => {
                self.basis.functions() - self.free - front_copies
            }
            (Sharing::Closed { .. } | Sharing::Pieces { .. }, _) => 0,
        }
    }

    /// Returns true if copies of the end point give the curve a zero derivative on one side.
    pub(crate) fn stands_still(&self, side: Side) -> bool {
        self.copies(side) > 0 && self.rule(side) == Some(CopyRule::Equal)
    }

    /// The part β of the next control point in the copy of a natural end.
    pub(crate) fn natural(&self, side: Side) -> Option<f64> {
        match self.rule(side)? {
            CopyRule::Natural(beta) => Some(beta),
            CopyRule::Equal | CopyRule::Constant => None,
        }
    }

    /// The side on which function `j` has a copy, rather than a control point of its own.
    fn copied(&self, j: usize) -> Option<Side> {
        let from_end = self.basis.functions() - 1 - j;
        if (1..=self.copies(Side::Start)).contains(&j) {
            Some(Side::Start)
        } else if (1..=self.copies(Side::End)).contains(&from_end) {
            Some(Side::End)
        } else {
            None
        }
    }

    /// The free control point that the control point of function `j` is equal to, if it is equal to
    /// one.
    pub fn equal_to(&self, j: usize) -> Option<usize> {
        if let Sharing::Pieces { pieces, .. } = &self.sharing {
            return match pieces.parts(j)[..] {
                [(index, _)] => Some(index),
                _ => None,
            };
        }
        let rule = self.copied(j).and_then(|side| self.rule(side));
        let equal = rule.is_none_or(|rule| rule == CopyRule::Equal);
        equal.then(|| self.free_index(j))
    }

    /// The free control points of which the control point of function `j` consists, each with its
    /// part, but for a constant.
    pub fn parts(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        let (first, others) = self.first_and_other_parts(j);
        std::iter::once(first).chain(others)
    }

    fn first_and_other_parts(&self, j: usize) -> ((usize, f64), Vec<(usize, f64)>) {
        if let Sharing::Pieces { pieces, .. } = &self.sharing {
            let mut parts = pieces.parts(j);
            return (parts.remove(0), parts);
        }
        let own = self.free_index(j);
        let side = self.copied(j);
        let beta = side.and_then(|side| self.natural(side));
        let next = match side {
            Some(Side::End) => own.saturating_sub(1),
            _ => own + 1,
        };
        let others = beta.map(|beta| (next, beta)).into_iter().collect();
        ((own, 1.0 - beta.unwrap_or(0.0)), others)
    }

    /// Makes values of functions from `start` on those of free control points: place k becomes the
    /// value of [`Self::free_index`] of function `start + k`. Only natural ends and short pieces change something.
    pub(crate) fn share(&self, start: usize, values: &mut [f64]) {
        if let Sharing::Pieces { pieces, .. } = &self.sharing {
            return pieces.share(start, values);
        }
        let last = self.basis.functions() - 1;
        let place = |side| {
            let beta = self.natural(side)?;
            let (function, next) = match side {
                Side::Start => (1, 2),
                Side::End => (last - 1, last - 2),
            };
            let own: usize = function.checked_sub(start)?;
            let next: usize = next.checked_sub(start)?;
            let value = beta * values.get(own)?;
            (next < values.len()).then_some((own, next, value))
        };
        let moves = [Side::Start, Side::End].map(place);
        for (own, next, value) in moves.into_iter().flatten() {
            values[own] -= value;
            values[next] += value;
        }
    }

    /// The basis functions whose control points free control point `index` is a part of, increasing.
    pub fn functions_of(&self, index: usize) -> impl Iterator<Item = usize> + Clone {
        let functions = self.basis.functions();
        let (own, other) = match &self.sharing {
            Sharing::Pieces { pieces, .. } => {
                let [one, other] = pieces.functions_of(index);
                (one.step_by(1), other)
            }
            Sharing::Open { front_copies, .. } => {
                let own = index + front_copies;
                let first = match index {
                    0 => 0,
                    1 if self.natural(Side::Start).is_some() => own - 1,
                    _ => own,
                };
                let end = match self.free - 1 - index {
                    0 => functions,
                    1 if self.natural(Side::End).is_some() => own + 2,
                    _ => own + 1,
                };
                ((first..end).step_by(1), 0..0)
            }
            Sharing::Closed { .. } => {
                let first = (index + self.basis.degree() / 2) % self.free;
                ((first..functions).step_by(self.free), 0..0)
            }
        };
        own.chain(other)
    }

    /// The indices j for which each of the functions j … j + p has a control point of its own, next
    /// to that of the function before it (around the end on closed curves): then a row of the
    /// collocation matrix that begins with function j needs no sums.
    pub fn own_functions(&self) -> Range<usize> {
        let degree = self.basis.degree();
        match &self.sharing {
            Sharing::Pieces { pieces, .. } if pieces.are_plain() => {
                0..self.free.saturating_sub(degree)
            }
            Sharing::Pieces { .. } => 0..0,
            Sharing::Open { front_copies, .. } => {
                let front_copies = *front_copies;
                let [start, end] = [Side::Start, Side::End].map(|side| self.natural(side));
                let first = front_copies + usize::from(start.is_some());
                let end = degree + usize::from(end.is_some());
                first..front_copies + self.free.saturating_sub(end)
            }
            Sharing::Closed { .. } => 0..self.basis.functions(),
        }
    }

    /// Writes the values at `t`, in the domain of the basis, of the functions that can differ from
    /// zero there, with their weights, into `values` (p + 1 numbers), and returns the index of the
    /// first of them.
    pub fn evaluate(&self, t: f64, values: &mut [f64]) -> usize {
        let start = self.basis.evaluate(self.within(t), values);
        self.weigh(start, values)
    }

    /// The parameter `t` in the domain of the basis. The knots of closed directions of even degree lie between the
    /// parameters: where the last one is next to the end of the period, rounding may put it after that end.
    pub(crate) fn within(&self, t: f64) -> f64 {
        let (low, high) = self.basis.domain();
        match self.period() {
            Some(_) if t > high => t - (high - low),
            // Closed directions with corners begin at the first of them.
            Some(_) if t < low => t + (high - low),
            _ => t,
        }
    }

    /// Makes the values of the functions from `start` on rational, if the direction has weights; returns `start`.
    /// Weights of any magnitude are accurate: products that would over- or underflow are scaled.
    pub fn weigh(&self, start: usize, values: &mut [f64]) -> usize {
        if let Some(weights) = &self.weights {
            // w_j B_j / Σ w_k B_k (LBW05 (3.7)).
            let weights = &weights[start..];
            let sum: f64 = values
                .iter()
                .zip(weights)
                .map(|(value, weight)| value * weight)
                .sum();
            // Products that have left the range of numbers are brought back by a common factor.
            let largest = || {
                let shown = values
                    .iter()
                    .zip(weights)
                    .filter(|(value, _)| **value > 0.0);
                shown.fold(0.0, |largest: f64, (_, weight)| largest.max(*weight))
            };
            let factor = if sum.is_normal() {
                1.0
            } else {
                normalizing_scale(largest())
            };
            let mut sum = 0.0;
            for (value, weight) in values.iter_mut().zip(weights) {
                // Weights of functions that vanish here may be too large for the factor.
                if *value > 0.0 {
                    *value *= factor * weight;
                    sum += *value;
                }
            }
            values.iter_mut().for_each(|value| *value /= sum);
        }
        start
    }

    /// One weight for each basis function, if one is given for each of them or for each free
    /// control point.
    fn complete_weights(&self, weights: Vec<f64>, axis: Axis) -> Result<Vec<f64>, Invalid> {
        for (index, &value) in weights.iter().enumerate() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Invalid::axis_weight(axis, index, value));
            }
        }
        let functions = self.basis.functions();
        let given = weights.len();
        if given == self.free {
            Ok((0..functions)
                .map(|j| weights[self.free_index(j)])
                .collect())
        } else if given == functions && !matches!(self.sharing, Sharing::Closed { .. }) {
            Ok(weights)
        } else {
            Err(Invalid::at(
                Place::AxisWeights(axis),
                format!(
                    "{given} weights given; {free} are needed (one for each free control point) or {functions} (end copies included)",
                    free = self.free
                ),
            ))
        }
    }
}
