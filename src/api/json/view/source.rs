//! Sources of large arrays of numbers with random access.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use piad_fit::data::Points;
use piad_fit::engine::samples::{Samples, Uniform};
use piad_fit::engine::{Direction, Geometry, Problem};
use piad_fit::invalid::Axis;

/// An array of numbers. It is shared between threads and lives until all of it has been sent.
pub(crate) trait Source: Send + Sync + 'static {
    /// Copies the numbers from `start` on, until `numbers` is full.
    fn fill(&self, start: usize, numbers: &mut [f64]);

    /// Returns true if numbers are computed when they are copied, rather than in memory.
    fn is_computed(&self) -> bool {
        false
    }

    /// Returns true if all finite numbers stay finite in 32 bits; `None` if that is unknown without a look at each of
    /// them.
    fn fits_32_bits(&self) -> Option<bool> {
        None
    }
}

impl Source for Box<dyn Source> {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        self.as_ref().fill(start, numbers);
    }

    fn is_computed(&self) -> bool {
        self.as_ref().is_computed()
    }

    fn fits_32_bits(&self) -> Option<bool> {
        self.as_ref().fits_32_bits()
    }
}

impl Source for Vec<f64> {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        numbers.copy_from_slice(&self[start..start + numbers.len()]);
    }
}

/// The coordinates of points, point by point.
impl Source for Points {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        self.copy_flat(start / self.dimension(), numbers);
    }
}

/// The coordinates of samples, sample by sample.
impl Source for Samples {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        Samples::fill(self, start / self.dimension(), numbers);
    }

    fn is_computed(&self) -> bool {
        true
    }

    /// Samples lie in the convex hull of the control points if all weights are positive.
    fn fits_32_bits(&self) -> Option<bool> {
        let geometry = self.geometry();
        let fits = |(row, column)| geometry.place(row, column).all(|x| (x as f32).is_finite());
        Some(geometry.is_within_hull() && geometry.places().all(fits))
    }
}

impl Source for Uniform {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        for (k, t) in numbers.iter_mut().enumerate() {
            *t = self.at(start + k);
        }
    }
}

/// The complete control net of a level, end copies included: the coordinates of its points.
pub(crate) struct NetPoints {
    /// The setup of the fit.
    pub problem: Arc<Problem>,
    /// The free control points.
    pub control_points: Arc<Points>,
}

/// A part of the net that follows in memory, or a control point by itself.
enum Part {
    /// These free control points.
    Free(Range<usize>),
    /// The control point at this row and column, which is not a free one.
    Single(usize, usize),
}

impl NetPoints {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::new(&self.problem, &self.control_points)
    }

    /// Calls `visit` for each part of the net from `start` on, with its offset from `start`.
    fn each(&self, start: usize, count: usize, mut visit: impl FnMut(usize, Part)) {
        let geometry = self.geometry();
        let is_surface = self.problem.v().is_some();
        let across = geometry.columns().unwrap_or(usize::MAX);
        let equal_to = |place: usize| match is_surface {
            true => geometry.equal_to(place / across, place % across),
            false => geometry.equal_to(place, 0),
        };
        let mut k = 0;
        while k < count {
            let place = start + k;
            let Some(index) = equal_to(place) else {
                match is_surface {
                    true => visit(k, Part::Single(place / across, place % across)),
                    false => visit(k, Part::Single(place, 0)),
                }
                k += 1;
                continue;
            };
            let most = (count - k).min(across - place % across);
            let next = |n: usize| equal_to(place + n) == Some(index + n);
            // Only points at the ends are repeated, so the length of the run is found by bisection.
            let run = first_not(most, next);
            visit(k, Part::Free(index..index + run));
            k += run;
        }
    }
}

/// The first number from 1 to `most` for which a monotone predicate does not hold, by bisection; `most` if
/// it holds for all before that.
fn first_not(most: usize, holds: impl Fn(usize) -> bool) -> usize {
    if holds(most - 1) {
        return most;
    }
    let (mut low, mut high) = (1, most - 1);
    while low < high {
        let middle = (low + high) / 2;
        match holds(middle) {
            true => low = middle + 1,
            false => high = middle,
        }
    }
    low
}

impl Source for NetPoints {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        let dimension = self.problem.dimension();
        let lanes = self.control_points.lanes();
        let count = numbers.len() / dimension;
        self.each(start / dimension, count, |k, part| {
            let points = match part {
                Part::Free(points) => points,
                Part::Single(row, column) => {
                    let place = self.geometry().place(row, column);
                    let to = numbers[k * dimension..].iter_mut();
                    to.zip(place).for_each(|(to, x)| *to = x);
                    return;
                }
            };
            let places = &mut numbers[k * dimension..][..points.len() * dimension];
            if lanes.len() == dimension {
                return self.control_points.copy_flat(points.start, places);
            }
            // The last coordinate of homogeneous ones is the weight.
            let part = |c: usize| &lanes[c][points.clone()];
            for c in 0..dimension {
                let to = places.iter_mut().skip(c).step_by(dimension);
                let from = part(c).iter().zip(part(dimension));
                to.zip(from).for_each(|(to, (x, weight))| *to = x / weight);
            }
        });
    }

    /// All free control points are in the net: no need to put them in its order first.
    fn fits_32_bits(&self) -> Option<bool> {
        if self.problem.is_homogeneous() {
            return None;
        }
        let geometry = self.geometry();
        let functions = self.problem.directions().map(|it| it.basis.functions());
        let lanes = self.control_points.lanes();
        let mut fits = lanes.iter().all(|lane| all_fit_32_bits(lane));
        self.each(0, functions.product(), |_, part| {
            if let Part::Single(row, column) = part {
                fits &= geometry.place(row, column).all(|x| all_fit_32_bits(&[x]));
            }
        });
        Some(fits)
    }
}

/// Returns true if all finite numbers stay finite in 32 bits.
pub(super) fn all_fit_32_bits(numbers: &[f64]) -> bool {
    // Without branches, so that the loop is vectorised.
    let fits = |x: f64| (x as f32).is_finite() | !x.is_finite();
    numbers.iter().fold(true, |all, &x| all & fits(x))
}

/// The weights of the control net of a homogeneous fit.
pub(crate) struct NetWeights(pub NetPoints);

impl Source for NetWeights {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        let Self(net) = self;
        if let Some(weights) = net.control_points.lanes().last() {
            net.each(start, numbers.len(), |k, part| match part {
                Part::Free(points) => {
                    numbers[k..k + points.len()].copy_from_slice(&weights[points]);
                }
                Part::Single(row, column) => {
                    numbers[k] = net.geometry().weight(row, column).unwrap_or(1.0);
                }
            });
        }
    }
}

/// Numbers of a direction: its parameters, knots or weights.
pub(crate) struct Along {
    /// The setup of the fit.
    pub problem: Arc<Problem>,
    /// The direction.
    pub(super) axis: Axis,
    /// The kind of numbers.
    pub(super) numbers: fn(&Direction) -> Cow<'_, [f64]>,
}

impl Along {
    fn all(&self) -> Cow<'_, [f64]> {
        let v = self.problem.v().filter(|_| self.axis == Axis::V);
        (self.numbers)(v.unwrap_or(self.problem.u()))
    }

    /// Their number.
    pub(crate) fn count(&self) -> usize {
        self.all().len()
    }
}

impl Source for Along {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        numbers.copy_from_slice(&self.all()[start..start + numbers.len()]);
    }
}
