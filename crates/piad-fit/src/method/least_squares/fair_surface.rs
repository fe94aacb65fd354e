//! Surfaces of scattered points with an energy and without conditions, over knots that a schedule chooses.
//!
//! Each has the normal equations of [`ScatteredData`] and of the energy, and conjugate gradients lead from the surface before
//! to near their solution.

use std::sync::Arc;

use super::constrained::over;
use super::fairness::Energy;
use super::settings::{Fairness, LeastSquares};
use crate::basis::direction::Direction;
use crate::data::distances::Distances;
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::knot_selection::surface::{Data, Fit, Nearest, Parameters, ScatteredData, sections};
use crate::linear::stencil::Stencil;
use crate::setup::Setup;

/// The fairness of a surface that is kept near its data where there are none, and the stiffness of its gaps; both are
/// lowered by decades down to its tolerance.
const FAIRNESS: f64 = 1e-9;
const STIFFNESS: f64 = 1e-6;

/// The number of times that they are lowered.
const DECADES: i32 = 6;

/// Less energy is not needed if it lowers the largest distance by less than this part of it.
const GAIN: f64 = 0.01;

/// Normal equations may have this many numbers more than the matrix of the data.
pub(crate) const MORE_NUMBERS: usize = 1_000_000;

/// The data of a surface, and its energy.
#[derive(Debug)]
pub(crate) struct FairSurface {
    setup: Arc<Setup>,
    /// With less and less energy, until the surface is within the tolerance.
    settings: Vec<LeastSquares>,
    scattered: ScatteredData,
}

impl FairSurface {
    /// Of scattered points whose settings ask for an energy and for nothing else besides distances.
    pub(crate) fn new(setup: &Arc<Setup>, settings: &LeastSquares) -> Option<Self> {
        let is_plain = settings.allows_poles() && setup.missing().is_none();
        let v = setup.v().filter(|_| setup.is_scattered())?;
        (is_plain && settings.has_energy()).then(|| Self {
            scattered: scattered(setup, v),
            setup: Arc::clone(setup),
            settings: vec![settings.clone()],
        })
    }

    /// With some fairness, and stiff gaps, which the settings do not ask for.
    pub(crate) fn unasked(setup: &Arc<Setup>, settings: &LeastSquares) -> Option<Self> {
        let lowered = |decades: i32| {
            let factor = 10f64.powi(-decades);
            LeastSquares {
                fairness: Some(Fairness {
                    value: FAIRNESS * factor,
                    order: 2,
                    by_data: false,
                }),
                gap_stiffness: settings.gap_stiffness.or(Some(STIFFNESS * factor)),
                ..settings.clone()
            }
        };
        let all: Vec<LeastSquares> = (0..=DECADES).map(lowered).collect();
        let fair = Self::new(setup, &all[0])?;
        Some(Self {
            settings: all,
            ..fair
        })
    }

    /// The matrix of the energy over some knots.
    fn energy(&self, settings: &LeastSquares, lines: &[Breaks; 2]) -> Option<Stencil> {
        let setup = over(&self.setup, lines)?;
        let energy = Energy::new(&setup, settings, self.setup.data().len() as f64)?;
        let mut stencil = Stencil::zeros(lines.each_ref().map(Breaks::reach));
        let [u, v] = lines;
        let place = |[k, l]: [usize; 2]| [u.of_direction(k), v.of_direction(l)];
        energy.each_entry(|one, other, entry| stencil.add(place(one), place(other), entry));
        Some(stencil)
    }
}

/// The data of a setup, of sections with points between theirs behind them.
fn scattered(setup: &Setup, v: &Direction) -> ScatteredData {
    let parameters = [setup.u(), v].map(|it| Arc::clone(&it.parameters));
    let (poles, tolerance) = (setup.poles(), setup.tolerance());
    let Some((counts, most)) = setup.sections.as_ref().zip(setup.most_of_sections()) else {
        return ScatteredData::new(setup.data(), &parameters, poles, tolerance);
    };
    let (points, parameters) =
        sections::with_points_between(setup.data(), &parameters, counts, v.period());
    ScatteredData::new(&points, &parameters, poles, tolerance).with_most(most)
}

impl Data for FairSurface {
    fn parameters(&self, axis: usize) -> &[f64] {
        self.scattered.parameters(axis)
    }

    fn share(&self) -> f64 {
        self.scattered.share()
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        let degrees =
            [Some(self.setup.u()), self.setup.v()].map(|it| it.map_or(0, |it| it.basis.degree()));
        let diagonals = degrees
            .iter()
            .map(|degree| 2 * degree + 1)
            .product::<usize>();
        let of_rows = degrees.iter().map(|degree| degree + 1).product::<usize>();
        let numbers = counts[0]
            .saturating_mul(counts[1])
            .saturating_mul(diagonals);
        numbers <= MORE_NUMBERS + of_rows * self.setup.data().len() && self.scattered.allows(counts)
    }

    fn nearest(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest> {
        let mut start = from.map(|level| level.over(lines));
        let mut nearest: Option<Nearest> = None;
        for settings in &self.settings {
            let energy = self.energy(settings, lines)?;
            let fair = self.scattered.nearest_from(start, lines, Some(&energy));
            let before = nearest
                .as_ref()
                .map_or(f64::INFINITY, |it| it.distances.max);
            let is_nearer = fair.distances.max < (1.0 - GAIN) * before;
            start = Some(fair.control_points.clone());
            let is_within = fair.distances.max <= self.setup.tolerance();
            nearest = Some(fair);
            if is_within || !is_nearer {
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

    fn corrected(&self, level: &Level<2>) -> Option<(Box<dyn Data>, Parameters)> {
        let (scattered, parameters) = self.scattered.following(level)?;
        let data = Self {
            scattered,
            setup: Arc::clone(&self.setup),
            settings: self.settings.clone(),
        };
        Some((Box::new(data), parameters))
    }

    fn has_floor(&self) -> bool {
        true
    }

    fn prunings(&self) -> usize {
        self.scattered.prunings()
    }
}

#[cfg(test)]
mod tests {
    use crate::Fit;
    use crate::parameters::{CoordinatePlane, Scattered};

    /// A square of hills on its corner: half of the rectangle of its parameters is without data. The surface is within the
    /// tolerance, which asks for less energy than it begins with, and stays near the data in the gaps.
    #[test]
    fn gaps_of_a_turned_square() {
        let place =
            |i: u32| [0.754_877_666, 0.569_840_29].map(|step| (0.5 + f64::from(i) * step).fract());
        let height = |[s, t]: [f64; 2]| {
            let hill = |a: f64, b: f64| (-400.0 * ((s - a).powi(2) + (t - b).powi(2))).exp();
            hill(0.3, 0.3) + hill(0.7, 0.05) + hill(0.98, 0.6)
        };
        let points: Vec<[f64; 3]> = (0..2_500)
            .map(place)
            .map(|[s, t]| [s - t, s + t, height([s, t])])
            .collect();
        let fit = Fit::scattered(&points, Scattered::Coordinates(CoordinatePlane::Xy));
        let surface = fit.tolerance(0.01).prepare().unwrap().solve().unwrap();
        assert!(surface.error().max <= 0.01);
        let [u, v] = surface.domain();
        let at = |(low, high): (f64, f64), i: u32| low + (high - low) * f64::from(i) / 40.0;
        let heights = (0..=40).flat_map(|i| (0..=40).map(move |j| (i, j)));
        for (i, j) in heights {
            let height = surface.eval(at(u, i), at(v, j))[2];
            assert!((-0.3..1.3).contains(&height), "{height} at {i}, {j}");
        }
    }
}
