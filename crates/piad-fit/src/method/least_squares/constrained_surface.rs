//! Surfaces with constraints or more than distances, over knots that a schedule chooses.
//!
//! Their data are treated as scattered points, also where they are a grid.

use std::sync::Arc;

use super::constrained::Constrained;
use super::settings::LeastSquares;
use crate::data::distances::Distances;
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::knot_selection::surface::{Data, Fit, Nearest, ScatteredData};
use crate::setup::Setup;

/// The data of a surface, and the objective.
#[derive(Debug)]
pub(crate) struct ConstrainedSurface {
    scattered: ScatteredData,
    /// The objective.
    constrained: Constrained,
    /// True if a fairness term keeps the surface away from its data.
    fair: bool,
}

impl ConstrainedSurface {
    pub(crate) fn new(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        Self {
            scattered: ScatteredData::new(
                setup.data(),
                &point_by_point(setup),
                [false; 2],
                setup.tolerance(),
            ),
            constrained: Constrained::new(setup, settings),
            fair: settings.has_energy(),
        }
    }
}

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

impl Data for ConstrainedSurface {
    fn parameters(&self, axis: usize) -> &[f64] {
        self.scattered.parameters(axis)
    }

    fn share(&self) -> f64 {
        self.scattered.share()
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        self.scattered.allows(counts)
    }

    fn nearest(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest> {
        let near = from.map(|level| level.over(lines));
        let control_points = self.constrained.minimum(lines, near.as_ref(), None)?;
        Some(self.scattered.with_distances(lines, control_points))
    }

    fn distances(&self, lines: &[Breaks; 2], control_points: &Points) -> Distances {
        self.scattered.distances(lines, control_points)
    }

    fn prefers(&self, fit: &Fit, finer: &[Breaks; 2]) -> usize {
        self.scattered.prefers(fit, finer)
    }

    fn has_floor(&self) -> bool {
        self.fair
    }
}
