//! The engine of fits that choose their knots ([`crate::knot_selection`]).
//!
//! Levels come from a schedule. Each has its own knots, and so its own problem: that of the
//! fit with other directions. One level is computed ahead, as only then is known whether a level is
//! the last one.
//!
//! A fit that is within the tolerance at its data and far from them in between continues with a more careful schedule
//! ([`careful`]).

mod alone;
mod careful;
mod pieces;
mod schedules;

use std::sync::Arc;

use self::careful::Reach;
use self::schedules::{Fit, Schedules};
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::problem::{Inliers, Problem};
use crate::termination::{Outcome, Reason};

/// The source of levels.
#[derive(Debug)]
enum Source {
    /// A schedule.
    Schedule(Schedules),
    /// The fits of the pieces between corners.
    Pieces(Vec<Automatic>),
    /// The fit without outliers or missing points.
    Alone(Box<Automatic>, Arc<Inliers>),
}

/// The fit at some level, and the source of those that follow.
#[derive(Debug)]
pub(crate) struct Automatic {
    whole: Arc<Problem>,
    source: Source,
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
        let is_gappy = !problem.request().missing.is_empty();
        let source = match (problem.alone(), problem.corners()) {
            (Some((alone, inliers)), _) => Self::started(alone, is_gappy)
                .map(|fit| Source::Alone(Box::new(fit), Arc::clone(inliers))),
            (None, Some(_)) => {
                let pieces = problem.pieces().ok().filter(|pieces| !pieces.is_empty());
                let fits = pieces.and_then(|pieces| pieces.iter().map(Self::start).collect());
                fits.map(Source::Pieces)
            }
            (None, None) => {
                let careful = has_gaps.then(|| Schedules::careful_surface(problem));
                let usual = || Schedules::new(problem, (settings, automatic));
                careful.flatten().or_else(usual).map(Source::Schedule)
            }
        };
        let mut source = source.unwrap_or(Source::Schedule(Schedules::Nowhere));
        let now = source.first(problem).unwrap_or_else(|| {
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
            source,
            now,
            next: None,
            number: 0,
            knots_since: 0,
            leaves: false,
        };
        automatic.next = automatic.following();
        Some(automatic)
    }

    /// Returns true if fewer control points than data are allowed.
    fn is_limited(&self) -> bool {
        let settings = self.whole.method().automatic();
        settings.is_some_and(|(settings, _)| settings.u < self.whole.grid().rows)
    }

    /// The level after this one, from another schedule if this one has ended with a fit that deviates from its data.
    fn following(&mut self) -> Option<Fit> {
        if let Some(next) = self.source.next(&self.whole) {
            return Some(next);
        }
        if self.source.outcome() != Some(Outcome::Converged) {
            return None;
        }
        if let Source::Schedule(schedule) = &mut self.source
            && let Some(careful) = schedule.more_careful(&self.whole, &self.now)
        {
            (*schedule, self.leaves) = (careful, true);
            return schedule.next(&self.whole);
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
        over.then(|| match self.source.outcome() {
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

impl Source {
    /// The first level.
    fn first(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        match self {
            Self::Schedule(schedule) => schedule.next(whole),
            Self::Pieces(pieces) => {
                let fits: Vec<&Fit> = pieces.iter().map(|it| &it.now).collect();
                pieces::joined(whole, &fits)
            }
            Self::Alone(fit, inliers) => alone::of_all(whole, &fit.now, inliers),
        }
    }

    /// The next level, or `None` after the last one. Of several fits each that has not ended moves on.
    fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        let fits = match self {
            Self::Schedule(schedule) => return schedule.next(whole),
            Self::Pieces(pieces) => &mut pieces[..],
            Self::Alone(fit, _) => std::slice::from_mut(&mut **fit),
        };
        let mut have_moved = false;
        for fit in fits.iter_mut().filter(|it| it.outcome().is_none()) {
            fit.step();
            have_moved = true;
        }
        have_moved.then(|| self.first(whole))?
    }

    /// How it has ended, after the last level: converged if all pieces have, else as the first one that has not.
    fn outcome(&self) -> Option<Outcome> {
        match self {
            Self::Schedule(schedule) => schedule.outcome(),
            Self::Alone(fit, _) => fit.outcome(),
            Self::Pieces(pieces) => {
                let outcomes: Option<Vec<_>> = pieces.iter().map(Automatic::outcome).collect();
                let failed = outcomes?.into_iter().find(|it| *it != Outcome::Converged);
                Some(failed.unwrap_or(Outcome::Converged))
            }
        }
    }
}
