//! The engine of fits that choose their knots ([`crate::knot_selection`]).
//!
//! Levels come from a schedule. Each has its own knots, and so its own problem: that of the
//! fit with other directions. One level is computed ahead, as only then is known whether a level is
//! the last one.
//!
//! A fit that is within the tolerance at its data and far from them in between continues with a second schedule
//! ([`careful`]).

mod alone;
mod careful;
mod pieces;
mod schedules;

use std::sync::Arc;

use self::alone::Alone;
use self::careful::Reach;
use self::pieces::{Piece, Pieces};
use self::schedules::{Fit, Schedules};
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::problem::Problem;
use crate::termination::{Outcome, Reason};

/// The fit at some level, and the schedule that leads on.
#[derive(Debug)]
pub(crate) struct Automatic {
    whole: Arc<Problem>,
    schedule: Schedules,
    now: Fit,
    next: Option<Fit>,
    /// The number of the level, and that of the level of the last change of knots.
    number: usize,
    knots_since: usize,
    /// True if the last level deviates from its data in gaps.
    leaves: bool,
}

impl Automatic {
    /// Level 0 of an automatic fit; `None` of any other.
    pub(crate) fn start(problem: &Arc<Problem>) -> Option<Self> {
        Self::started(problem, false)
    }

    /// Without data in some places it is kept near the others from the beginning.
    fn started(problem: &Arc<Problem>, has_gaps: bool) -> Option<Self> {
        let (settings, automatic) = problem.method().automatic()?;
        let careful = has_gaps.then(|| Schedules::careful_surface(problem));
        let is_gappy = !problem.request().missing.is_empty();
        let mut schedule = match (problem.alone(), problem.corners()) {
            (Some((alone, inliers)), _) => match Self::started(alone, is_gappy) {
                Some(fit) => {
                    Schedules::Several(Box::new(Alone::new(Box::new(fit), Arc::clone(inliers))))
                }
                None => Schedules::Nowhere,
            },
            (None, Some(_)) => Self::of_pieces(problem),
            (None, None) => careful
                .flatten()
                .or_else(|| Schedules::new(problem, (settings, automatic)))
                .unwrap_or(Schedules::Nowhere),
        };
        let now = schedule.next(problem).unwrap_or_else(|| {
            // Not even the first level has finite numbers.
            let count = problem.control_grid().count();
            let nowhere = Points::zeros(problem.dimension(), count);
            Fit {
                problem: Arc::clone(problem),
                control_points: Arc::new(nowhere),
                error: FitError::unknown(),
            }
        });
        let mut automatic = Self {
            whole: Arc::clone(problem),
            schedule,
            now,
            next: None,
            number: 0,
            knots_since: 0,
            leaves: false,
        };
        automatic.next = automatic.following();
        Some(automatic)
    }

    /// The schedule of a curve with corners.
    fn of_pieces(problem: &Problem) -> Schedules {
        let start = |piece: &Arc<Problem>| {
            let piece = Self::start(piece)?;
            Some(Box::new(piece) as Box<dyn Piece>)
        };
        match Pieces::new(problem, start) {
            Some(pieces) => Schedules::Several(Box::new(pieces)),
            None => Schedules::Nowhere,
        }
    }

    /// Returns true if fewer control points than data are allowed.
    fn is_limited(&self) -> bool {
        let settings = self.whole.method().automatic();
        settings.is_some_and(|(settings, _)| settings.u < self.whole.grid().rows)
    }

    /// The level after this one, from another schedule if this one has ended with a fit that deviates from its data.
    fn following(&mut self) -> Option<Fit> {
        if let Some(next) = self.schedule.next(&self.whole) {
            return Some(next);
        }
        if self.schedule.outcome() != Some(Outcome::Converged) {
            return None;
        }
        if !self.schedule.is_careful()
            && self.now.leaves(Reach::Near)
            && let Some(careful) = self.schedule.careful(&self.whole, &self.now)
        {
            (self.schedule, self.leaves) = (careful, true);
            return self.schedule.next(&self.whole);
        }
        self.leaves = self.now.leaves(Reach::Far);
        None
    }

    /// Moves on, unless this is the last level: how many control points there are now, and how far
    /// they are from the data.
    pub(crate) fn step(&mut self) -> (usize, FitError) {
        if let Some(next) = self.next.take() {
            self.number += 1;
            let (new, old) = (next.problem.directions(), self.now.problem.directions());
            if !new.map(|it| &it.basis).eq(old.map(|it| &it.basis)) {
                self.knots_since = self.number;
            }
            self.now = next;
            self.next = self.following();
        }
        (self.now.control_points.len(), self.now.error)
    }

    /// The fit with the knots, and the parameters, of this level.
    pub(crate) fn problem(&self) -> &Arc<Problem> {
        &self.now.problem
    }

    /// The control points of this level.
    pub(crate) fn control_points(&self) -> &Arc<Points> {
        &self.now.control_points
    }

    /// How far they are from the data.
    pub(crate) fn error(&self) -> FitError {
        self.now.error
    }

    /// The level from which on the knots are what they are now.
    pub(crate) fn knots_since(&self) -> usize {
        self.knots_since
    }

    /// How the fit ends, if this is its last level.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        let over = self.next.is_none();
        over.then(|| match self.schedule.outcome() {
            Some(Outcome::Converged) if self.leaves => Outcome::Stalled(Reason::Between),
            // It would be within the tolerance at its data alone.
            Some(Outcome::Minimum) if self.leaves => Outcome::Stalled(Reason::Between),
            Some(Outcome::Exhausted) if self.leaves && !self.is_limited() => {
                Outcome::Stalled(Reason::Between)
            }
            outcome => outcome.unwrap_or(Outcome::Overflow),
        })
    }
}

impl Piece for Automatic {
    fn advance(&mut self) {
        self.step();
    }

    fn outcome(&self) -> Option<Outcome> {
        self.outcome()
    }

    fn problem(&self) -> &Problem {
        &self.now.problem
    }

    fn control_points(&self) -> &Points {
        &self.now.control_points
    }

    fn error(&self) -> FitError {
        self.error()
    }
}
