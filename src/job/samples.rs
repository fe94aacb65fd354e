//! Samples for unit tests.

use crate::job::outline::{Label, Outline};
use crate::job::state::Status;
use crate::job::store::Record;
use piad_fit::basis::{BasisChoice, End, Ends, Knots};
use piad_fit::data::{Grid, Points};
use piad_fit::engine::{DirectionChoice, Problem, Request, Tolerance};
use piad_fit::parameters::Parametrization;

/// A curve through 20 points of a sine.
pub(crate) fn problem() -> Problem {
    sine(20, 10)
}

/// A curve through `count` points of a sine, which ends at `max_iterations`.
pub(crate) fn sine(count: u32, max_iterations: usize) -> Problem {
    let mut points = Points::new(2);
    (0..count).for_each(|i| points.push(&[f64::from(i), f64::from(i).sin()]));
    let u = DirectionChoice {
        ends: Some(Ends::both(End::Repeated)),
        ..DirectionChoice::new(
            BasisChoice::BSpline {
                degree: 3,
                knots: Knots::Data,
            },
            Parametrization::Uniform,
        )
    };
    let grid = Grid {
        rows: points.len(),
        columns: 1,
    };
    Problem::new(Request {
        tolerance: Some(Tolerance::Absolute(0.0)),
        max_iterations,
        ..Request::new(points, grid, u, None)
    })
    .unwrap()
}

/// A job with this problem, which was just accepted.
pub(crate) fn queued() -> Record {
    Record::new(
        Outline::new(Label::default(), &problem(), None),
        Status::QUEUED,
    )
}
