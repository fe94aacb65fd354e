//! Schedules that keep a fit near its data where there are none: curves with points between the
//! data, surfaces with the most fairness that their tolerance allows. A fit that still deviates from its data has
//! stalled.

use std::sync::Arc;

use super::schedules::{Between, Fit, Schedules, options, parameters};
use crate::geometry::between::{self, Excursion};
use crate::knot_selection::Options;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::equations;
use crate::knot_selection::guide::Guide;
use crate::knot_selection::knot_conversion::in_lines;
use crate::knot_selection::schedule::Schedule;
use crate::knot_selection::surface::{Data, GridData, SurfaceSchedule};
use crate::method::FairSurface;
use crate::problem::Problem;

/// How fair a curve with points between its data is, so that it has no spikes between these: a multiple of the energy of
/// spans of equal length.
const FAIRNESS: f64 = 1e-6;

/// The largest deviation of a fit from its data in gaps.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Reach {
    /// Beyond this the fit continues: a curve should need only a part of the freedom of its data.
    Near,
    /// Beyond this a fit has stalled, or continues once more.
    Far,
}

impl Reach {
    /// Surfaces of scattered data: how far outside of their bounding box, as a part of its diagonal; planes leave it in
    /// corners without data.
    fn outside(self) -> f64 {
        match self {
            Self::Near => 0.1,
            Self::Far => 1.0,
        }
    }
}

impl Schedules {
    /// The schedule that keeps a fit nearer to its data where there are none: of curves from a level on, of surfaces
    /// from the coarsest knots on. `None` if the fit is near them, or nothing keeps it nearer.
    pub(super) fn more_careful(&self, whole: &Problem, now: &Fit) -> Option<Self> {
        let (reach, is_dense) = match self {
            Self::Curve(_, None) | Self::Surface(_) => (Reach::Near, false),
            Self::Curve(_, Some(Between::Guide(guide))) if !guide.is_dense => (Reach::Far, true),
            _ => return None,
        };
        if !now.leaves(reach) {
            return None;
        }
        if whole.v().is_some() {
            return Self::careful_surface(whole);
        }
        let (settings, _) = whole.method().automatic()?;
        let problem = &*now.problem;
        let u = problem.u();
        let lines = [Breaks::of(u)?];
        let guide = Guide::new(problem.data(), &u.parameters, u.period(), is_dense);
        let most = Guide::most_control_points(problem.data().len());
        let options = Options {
            first: Some(in_lines(&now.control_points, &lines)),
            lines,
            parameters: [Arc::clone(&guide.parameters)],
            tolerance: problem.tolerance(),
            max_control_points: [settings.u.min(most)],
            correct_parameters: false,
        };
        let weights = guide.weights(problem.tolerance(), settings.data_weights.as_deref());
        let points = Arc::clone(&guide.points);
        let minimum = equations::LeastSquares {
            points: Arc::clone(&points),
            data_weights: Some(Arc::new(weights)),
            // Where it is given, there is no more of it.
            fairness: settings.fairness.map_or(FAIRNESS, |_| 0.0),
            freedom: Some(Arc::clone(&guide.freedom)),
        };
        let schedule = Schedule::new(points, options, minimum);
        Some(Self::Curve(Box::new(schedule), Some(Between::Guide(guide))))
    }
}

impl Schedules {
    /// The same of a surface.
    pub(super) fn careful_surface(problem: &Problem) -> Option<Self> {
        let (settings, automatic) = problem.method().automatic()?;
        let setup = problem.setup();
        let data: Box<dyn Data> = match problem.is_scattered() {
            // Where it is given, there is no more of it.
            _ if !settings.is_plain_surface() || settings.fairness.is_some() => return None,
            true => Box::new(FairSurface::unasked(setup, settings)?),
            false => {
                let data = GridData::new(problem.data(), problem.grid(), parameters(problem)?);
                Box::new(data.fair(problem.tolerance()))
            }
        };
        let options = Options {
            first: None,
            ..options(problem, (settings, automatic))?
        };
        Some(Self::FairSurface(Box::new(SurfaceSchedule::new(
            data, options,
        ))))
    }
}

impl Fit {
    /// Returns true if it deviates from its data more than this allows.
    pub(super) fn leaves(&self, reach: Reach) -> bool {
        let (problem, points) = (&*self.problem, &*self.control_points);
        if problem.is_scattered() {
            return between::outside(problem, points) > reach.outside();
        }
        let allowed = problem.tolerance();
        let excursion = match reach {
            Reach::Near => Excursion::of_part(problem, points, allowed),
            Reach::Far => Excursion::of(problem, points, allowed),
        };
        excursion.is_some_and(|it| it.excess() > allowed)
    }
}
