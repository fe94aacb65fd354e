//! Surfaces that obey and weigh more than distances, over knots that a schedule chooses.
//!
//! What is known of their data is that of scattered points, also where the points are a grid.

use std::sync::Arc;

use super::constrained::Constrained;
use super::settings::{Fairness, LeastSquares};
use crate::data::distances::Distances;
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::surface::{Data, Fit, Nearest, ScatteredData, SurfaceLevel};
use crate::setup::Setup;

/// The data of a surface, and what is minimized.
#[derive(Debug)]
pub(crate) struct ConstrainedSurface {
    scattered: ScatteredData,
    /// What is minimized; with less and less fairness, of which the first is taken that is within the tolerance.
    constrained: Vec<Constrained>,
    tolerance: f64,
    /// Whether a fairness term keeps the surface away from its data.
    fair: bool,
}

impl ConstrainedSurface {
    pub(crate) fn new(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        Self {
            scattered: ScatteredData::new(setup.data(), &point_by_point(setup), setup.tolerance()),
            constrained: vec![Constrained::new(setup, settings)],
            tolerance: setup.tolerance(),
            fair: settings.has_energy(),
        }
    }

    /// With some fairness, and stiff gaps, that nobody asked for.
    pub(crate) fn fair(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        let with = |value: f64| LeastSquares {
            fairness: Some(Fairness {
                value,
                order: 2,
                by_data: false,
            }),
            ..settings.clone()
        };
        Self {
            constrained: FAIRNESS.map(|it| Constrained::new(setup, &with(it))).into(),
            fair: true,
            ..Self::new(setup, settings)
        }
    }

    /// The nearest surface with so much fairness.
    fn nearest_by(
        &self,
        constrained: &Constrained,
        lines: &[Breaks; 2],
        near: Option<&Points>,
    ) -> Option<Nearest> {
        let control_points = constrained.minimum(lines, near, None)?;
        Some(Nearest {
            left: self.scattered.left(lines, &control_points),
            control_points,
        })
    }
}

/// How fair a surface is that is kept near its data where there are none, by decades as far as its tolerance asks for.
const FAIRNESS: [f64; 4] = [1e-9, 1e-10, 1e-11, 1e-12];

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

    fn nearest(&self, lines: &[Breaks; 2], from: Option<&SurfaceLevel>) -> Option<Nearest> {
        let near = from.map(|level| level.over(lines));
        let mut nearest = None;
        for constrained in &self.constrained {
            nearest = self.nearest_by(constrained, lines, near.as_ref());
            let points = nearest.as_ref().map(|it| &it.control_points);
            let distances = points.map(|points| self.distances(lines, points));
            if distances.is_some_and(|it| it.max <= self.tolerance) {
                break;
            }
        }
        nearest
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
