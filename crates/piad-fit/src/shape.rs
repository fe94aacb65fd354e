//! Fitted curves and surfaces: evaluation and derivatives.

use std::sync::Arc;

use super::problem::Problem;
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::geometry::nurbs::sampling::Jet;
use crate::geometry::nurbs::{KnotVector, Nurbs};
use crate::geometry::outline::Outline;

/// The fitted shape: a [`Curve`] or a [`Surface`].
pub trait Shape: Sized + sealed::Sealed {
    /// The shape of a level of a problem.
    #[doc(hidden)]
    fn of(problem: &Problem, control_points: &Points, error: FitError) -> Self;
}

mod sealed {
    /// Seals the trait.
    pub trait Sealed {}

    impl Sealed for super::Curve {}
    impl Sealed for super::Surface {}
}

/// A fitted curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    nurbs: Nurbs,
    error: FitError,
}

/// A fitted surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    nurbs: Nurbs,
    error: FitError,
    outline: Option<Arc<Outline>>,
}

/// A parameter of a closed direction, moved into the domain by whole periods.
fn inside(direction: &KnotVector, t: f64) -> f64 {
    let (low, high) = direction.domain();
    match direction.closed && !(low..=high).contains(&t) {
        true => low + (t - low).rem_euclid(high - low),
        false => t,
    }
}

/// The first coordinates of three, for the dimension of the points.
fn cut(place: [f64; 3], dimension: usize) -> Vec<f64> {
    place.into_iter().take(dimension).collect()
}

impl Curve {
    /// The interval of its parameters.
    pub fn domain(&self) -> (f64, f64) {
        self.nurbs.u.domain()
    }

    /// The point at a parameter, with as many coordinates as the data. Parameters outside of the
    /// [domain](Self::domain) are clamped to it; on a closed curve they wrap around.
    pub fn eval(&self, t: f64) -> Vec<f64> {
        self.coordinates(t, |jet| jet.point)
    }

    /// The derivative with respect to the parameter (PT97 (4.8)); at a knot that from the right.
    pub fn derivative(&self, t: f64) -> Vec<f64> {
        self.coordinates(t, |jet| jet.du)
    }

    /// A vector of all coordinates, of which three are evaluated at a time.
    fn coordinates(&self, t: f64, vector: impl Fn(&Jet) -> [f64; 3]) -> Vec<f64> {
        let site = self.nurbs.u.site_at(inside(&self.nurbs.u, t));
        let dimension = self.nurbs.points.dimension();
        let three = |first: usize| {
            let jets = self.nurbs.evaluate_from(first, &[site], &[]);
            let vector = jets.first().map_or([0.0; 3], &vector);
            cut(vector, dimension - first)
        };
        (0..dimension).step_by(3).flat_map(three).collect()
    }

    /// Its distances from the data, in their unit.
    pub fn error(&self) -> FitError {
        self.error
    }

    /// Its degree, knots, control points and weights.
    pub fn nurbs(&self) -> &Nurbs {
        &self.nurbs
    }
}

impl Surface {
    /// The intervals of its parameters u and v.
    pub fn domain(&self) -> [(f64, f64); 2] {
        let u = self.nurbs.u.domain();
        [u, self.nurbs.v.as_ref().map_or(u, |v| v.domain())]
    }

    /// The point at (u, v), with as many coordinates as the data. Parameters outside of the
    /// [domain](Self::domain) are clamped to it.
    pub fn eval(&self, u: f64, v: f64) -> Vec<f64> {
        cut(self.jet(u, v).point, self.nurbs.points.dimension())
    }

    /// The derivatives with respect to u and v (PT97 (4.20)).
    pub fn derivatives(&self, u: f64, v: f64) -> [Vec<f64>; 2] {
        let jet = self.jet(u, v);
        [jet.du, jet.dv].map(|derivative| cut(derivative, self.nurbs.points.dimension()))
    }

    fn jet(&self, u: f64, v: f64) -> Jet {
        let along = self.nurbs.u.site_at(u);
        let across = self.nurbs.v.iter().map(|knots| knots.site_at(v));
        let jets = self.nurbs.evaluate(&[along], &across.collect::<Vec<_>>());
        jets.into_iter().next().unwrap_or_default()
    }

    /// Its distances from the data, in their unit.
    pub fn error(&self) -> FitError {
        self.error
    }

    /// The outline of the data in the parameters of the surface, if it is trimmed.
    pub fn outline(&self) -> Option<&Outline> {
        self.outline.as_deref()
    }

    /// Its degrees, knots, control points and weights.
    pub fn nurbs(&self) -> &Nurbs {
        &self.nurbs
    }
}

impl Shape for Curve {
    fn of(problem: &Problem, control_points: &Points, error: FitError) -> Self {
        let nurbs = Nurbs::of(problem, control_points);
        Self { nurbs, error }
    }
}

impl Shape for Surface {
    fn of(problem: &Problem, control_points: &Points, error: FitError) -> Self {
        Self {
            nurbs: Nurbs::of(problem, control_points),
            error,
            outline: problem.outline().cloned(),
        }
    }
}
