//! Surfaces that obey and weigh more than distances, over knots that a schedule chooses.
//!
//! What is known of their data is that of scattered points, also where the points are a grid.

use std::sync::Arc;

use super::obeying::Obeying;
use super::settings::{Fairness, LeastSquares};
use crate::fit::points::Points;
use crate::fit::setup::Setup;
use crate::fit::tolerance::distances::Distances;
use crate::fit::tolerance::line::KnotLine;
use crate::fit::tolerance::surface::{Data, Fit, Nearest, ScatteredData, SurfaceLevel};

/// The data of a surface, and what is minimized.
#[derive(Debug)]
pub(in crate::fit) struct ObeyingSurface {
    scattered: ScatteredData,
    obeying: Obeying,
    /// Whether a fairness term keeps the surface away from its data.
    fair: bool,
}

impl ObeyingSurface {
    pub(in crate::fit) fn new(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        Self {
            scattered: ScatteredData::new(setup.data(), &point_by_point(setup), setup.tolerance()),
            obeying: Obeying::new(setup, settings),
            fair: settings.has_energy(),
        }
    }

    /// With some fairness, and stiff gaps, that nobody asked for.
    pub(in crate::fit) fn fair(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        let fairness = Some(Fairness {
            value: FAIRNESS,
            order: 2,
        });
        Self::new(
            setup,
            &LeastSquares {
                fairness,
                ..settings.clone()
            },
        )
    }
}

/// How fair a surface is that is kept near its data where there are none.
const FAIRNESS: f64 = 1e-9;

/// The parameters u and v of each point.
fn point_by_point(setup: &Setup) -> [Arc<Vec<f64>>; 2] {
    let u = &setup.u().parameters;
    let v = setup.v().map_or(u, |v| &v.parameters);
    if setup.is_scattered() {
        return [u, v].map(Arc::clone);
    }
    let rows = u.iter().flat_map(|&t| std::iter::repeat_n(t, v.len()));
    let columns = u.iter().flat_map(|_| v.iter().copied());
    [Arc::new(rows.collect()), Arc::new(columns.collect())]
}

impl Data for ObeyingSurface {
    fn parameters(&self, axis: usize) -> &[f64] {
        self.scattered.parameters(axis)
    }

    fn share(&self) -> f64 {
        self.scattered.share()
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        self.scattered.allows(counts)
    }

    fn nearest(&self, lines: &[KnotLine; 2], from: Option<&SurfaceLevel>) -> Option<Nearest> {
        let near = from.map(|level| level.over(lines));
        let control_points = self.obeying.minimum(lines, near.as_ref(), None)?;
        Some(Nearest {
            left: self.scattered.left(lines, &control_points),
            control_points,
        })
    }

    fn distances(&self, lines: &[KnotLine; 2], control_points: &Points) -> Distances {
        self.scattered.distances(lines, control_points)
    }

    fn prefers(&self, fit: &Fit, finer: &[KnotLine; 2]) -> usize {
        self.scattered.prefers(fit, finer)
    }

    fn has_floor(&self) -> bool {
        self.fair
    }
}
