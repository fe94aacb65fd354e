//! The schedule of a curve with corners: each piece between two of them is a fit by itself, and a level of the curve
//! has a level of each of them, the last one of those that have ended.

use std::fmt::Debug;
use std::sync::Arc;

use super::schedules::{Fit, Levels};
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::knot_selection::clamped_breaks;
use crate::problem::Problem;
use crate::termination::Outcome;

/// The fit of a piece at some level.
pub(super) trait Piece: Debug + Send + Sync {
    /// Moves on, unless this is the last level.
    fn advance(&mut self);

    /// How the fit ends, if this is its last level.
    fn outcome(&self) -> Option<Outcome>;

    /// The fit with the knots of this level.
    fn problem(&self) -> &Problem;

    /// The control points of this level.
    fn control_points(&self) -> &Points;

    /// How far they are from the data.
    fn error(&self) -> FitError;
}

/// The fits of the pieces.
#[derive(Debug)]
pub(super) struct Pieces {
    pieces: Vec<Box<dyn Piece>>,
    has_begun: bool,
}

impl Pieces {
    /// Those of a curve with corners, each with its first level.
    pub(super) fn new(
        whole: &Problem,
        start: impl Fn(&Arc<Problem>) -> Option<Box<dyn Piece>>,
    ) -> Option<Self> {
        let problems = whole.pieces().ok().filter(|pieces| !pieces.is_empty())?;
        let pieces: Option<Vec<Box<dyn Piece>>> = problems.iter().map(start).collect();
        Some(Self {
            pieces: pieces?,
            has_begun: false,
        })
    }

    /// The curve of all pieces.
    fn joined(&self, whole: &Arc<Problem>) -> Option<Fit> {
        let of_pieces: Option<Vec<Vec<f64>>> = self
            .pieces
            .iter()
            .map(|it| clamped_breaks::of(it.problem().u()))
            .collect();
        let of_pieces = of_pieces?;
        let degree = whole.u().basis.degree();
        let breaks = clamped_breaks::joined(degree, of_pieces.iter().map(Vec::as_slice));
        let u = whole.with_breaks(whole.u(), &breaks, self.parameters(whole)?)?;
        Some(Fit {
            control_points: Arc::new(self.control_points(&u)),
            problem: Arc::new(whole.with_directions([u])),
            error: self.error(whole)?,
        })
    }

    /// The control points of all pieces, in the order of those of a direction.
    fn control_points(&self, u: &Direction) -> Points {
        let mut all = Points::zeros(self.pieces[0].control_points().dimension(), u.free());
        let mut function = 0;
        for piece in &self.pieces {
            let points = piece.control_points();
            for i in 0..points.len() {
                all.set(u.free_index(function + i), points.point(i));
            }
            function += points.len() - 1;
        }
        all
    }

    /// The parameters of the data, which pieces may have moved.
    fn parameters(&self, whole: &Problem) -> Option<Arc<Vec<f64>>> {
        let mut parameters = Arc::clone(&whole.u().parameters);
        let (_, settings) = whole.method().automatic()?;
        if !settings.correct_parameters {
            return Some(parameters);
        }
        let all = Arc::make_mut(&mut parameters);
        let (count, period) = (all.len(), whole.u().period().unwrap_or(0.0));
        for (piece, data) in self.pieces.iter().zip(whole.data_of_pieces()?) {
            for (index, t) in data.zip(piece.problem().u().parameters.iter()) {
                all[index % count] = t - (index / count) as f64 * period;
            }
        }
        Some(parameters)
    }

    /// The distances of all data; corners, which two pieces have, are at none.
    fn error(&self, whole: &Problem) -> Option<FitError> {
        let count = whole.grid().count();
        let mut all = self.pieces[0].error();
        (all.max, all.sum) = (-1.0, 0.0);
        let errors = || self.pieces.iter().map(|it| it.error());
        let largest = errors().fold(0.0, |most: f64, error| most.max(error.rms));
        let mut squares = 0.0;
        for (error, data) in errors().zip(whole.data_of_pieces()?) {
            if error.max > all.max || error.max.is_nan() {
                (all.max, all.at) = (error.max, (data.start + error.at) % count);
            }
            all.sum += error.sum;
            // Squares of distances in any unit stay within the range of numbers.
            let share = if largest > 0.0 {
                error.rms / largest
            } else {
                0.0
            };
            squares += share * share * data.len() as f64;
        }
        all.rms = largest * (squares / count as f64).sqrt();
        Some(all)
    }
}

impl Levels for Pieces {
    fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        if self.has_begun {
            let left = self.pieces.iter_mut().filter(|it| it.outcome().is_none());
            // Each of them moves on.
            if left.map(|piece| piece.advance()).count() == 0 {
                return None;
            }
        }
        self.has_begun = true;
        self.joined(whole)
    }

    /// Converged if all pieces have, else as the first one that has not.
    fn outcome(&self) -> Option<Outcome> {
        let outcomes: Option<Vec<Outcome>> = self.pieces.iter().map(|it| it.outcome()).collect();
        let failed = outcomes?.into_iter().find(|it| *it != Outcome::Converged);
        Some(failed.unwrap_or(Outcome::Converged))
    }
}
