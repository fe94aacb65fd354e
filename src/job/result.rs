//! The stored result of a fit: its last level.

use std::sync::Arc;

use super::frame::Frame;
use piad_fit::data::Points;
use piad_fit::engine::{Bases, Level, Problem};

/// The geometry of the last level of a job.
#[derive(Clone, Debug)]
pub(crate) struct LastGeometry {
    /// The free control points.
    pub control_points: Arc<Points>,
    /// The knots, of a fit that has chosen them.
    pub bases: Option<Arc<Bases>>,
}

impl LastGeometry {
    /// The result of the last frame.
    pub(super) fn of(frame: &Frame) -> Self {
        Self {
            control_points: Arc::clone(&frame.control_points),
            bases: frame.problem.bases().map(Arc::new),
        }
    }

    /// Recomputes the last frame, of a level of this problem.
    pub(crate) fn frame(self, level: Level, problem: Arc<Problem>) -> Arc<Frame> {
        let problem = match &self.bases {
            None => problem,
            Some(bases) => Arc::new(problem.with_bases(bases)),
        };
        Arc::new(Frame::last(level, problem, self.control_points))
    }
}

impl From<Arc<Points>> for LastGeometry {
    fn from(control_points: Arc<Points>) -> Self {
        Self {
            control_points,
            bases: None,
        }
    }
}
