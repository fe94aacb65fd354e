//! Parameters of scattered points of a surface: each has a (u, v) of its own.
//!
//! They are given, or they are places on a simple surface near the points: a [`plane`], a [`cylinder`] or a [`sphere`],
//! or that of them which unfolds the points best ([`unfolding`]), or they are two of the points' own coordinates. All of
//! them are lengths in the unit of the points. A direction that goes all around a cylinder or a sphere is closed. They do
//! not depend on the order of the points but for rounding.

mod circle;
mod cylinder;
mod normals;
mod plane;
mod rectangle;
mod sphere;
mod unfolding;

use std::sync::Arc;

use super::LARGEST;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};

pub use cylinder::Cylinder;
pub(crate) use plane::nearest_to_their_plane;
pub use sphere::Sphere;

use plane::{Plane, no_plane, no_third_coordinate};

/// How scattered points get their parameters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Scattered {
    /// As they are given, u and v of each point.
    Given(Pairs),
    /// Their places on a plane, a cylinder or a sphere, whichever unfolds them best.
    Auto,
    /// Their coordinates in the plane nearest to them, along the sides of the least rectangle around them.
    Plane,
    /// Two of their coordinates themselves.
    Coordinates(CoordinatePlane),
    /// Around the cylinder nearest to them, and along it.
    Cylinder(Cylinder),
    /// Longitude and latitude on the sphere nearest to them.
    Sphere(Sphere),
}

/// A plane of two coordinates, of which the first is u.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum CoordinatePlane {
    /// x and y.
    Xy,
    /// x and z.
    Xz,
    /// y and z.
    Yz,
}

impl CoordinatePlane {
    /// The indices of its coordinates.
    fn axes(self) -> [usize; 2] {
        match self {
            Self::Xy => [0, 1],
            Self::Xz => [0, 2],
            Self::Yz => [1, 2],
        }
    }
}

/// u and v of scattered points, and how far both directions go.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pairs {
    /// u and v of each point.
    pub values: Arc<Points>,
    /// How far u and v go.
    pub domains: [Domain; 2],
}

/// How far a direction of scattered points goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Domain {
    /// From the least to the largest parameter.
    #[default]
    Data,
    /// It is closed, and repeats after this length.
    Closed(f64),
    /// From one number to another one. At a pole all points of that edge of the surface are one.
    Between {
        /// Both ends.
        ends: [f64; 2],
        /// True at an end that is a pole.
        poles: [bool; 2],
    },
}

impl Domain {
    /// The length after which a closed direction repeats.
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Closed(period) => Some(period),
            Self::Data | Self::Between { .. } => None,
        }
    }

    /// Which ends are poles.
    pub fn poles(self) -> [bool; 2] {
        match self {
            Self::Between { poles, .. } => poles,
            Self::Data | Self::Closed(_) => [false; 2],
        }
    }
}

impl Domain {
    /// Refuses ends that are no range, or do not hold all parameters, and poles of u.
    fn check(self, values: &[f64], axis: Axis) -> Result<(), Invalid> {
        let Self::Between { ends, poles } = self else {
            return Ok(());
        };
        let [low, high] = ends;
        let wrong = |detail: String| Err(Invalid::at(Place::Parameters(axis), detail));
        if !(low.is_finite() && high.is_finite() && low < high) {
            return wrong(format!(
                "{low} and {high} are no ends of a direction: the first is less than the second"
            ));
        }
        if poles != [false; 2] && axis == Axis::U {
            return wrong("poles are ends of v".to_owned());
        }
        match values.iter().position(|t| !(low..=high).contains(t)) {
            Some(index) => Err(Invalid::parameter_outside(
                axis,
                index,
                values[index],
                (low, high),
            )),
            None => Ok(()),
        }
    }
}

impl Pairs {
    /// Those of a surface that goes from the least to the largest parameter of each direction.
    pub fn open(values: Arc<Points>) -> Self {
        Self {
            values,
            domains: [Domain::Data; 2],
        }
    }

    /// u or v of all points, and how far they go.
    pub(crate) fn direction(&self, axis: usize) -> (Vec<f64>, Domain) {
        (self.values.lane(axis).to_vec(), self.domains[axis])
    }

    /// Those of some of the points.
    pub(crate) fn of(&self, indices: impl Iterator<Item = usize> + Clone) -> Self {
        Self {
            values: Arc::new(self.values.selected(indices)),
            ..*self
        }
    }
}

impl Scattered {
    /// The parameters u and v of all points, finite numbers. A closed direction that is asked for is closed also where the
    /// points do not go all around.
    ///
    /// # Errors
    ///
    /// Names the parameter that is not a finite number, the wrong number of parameters, or why the
    /// points have no plane, cylinder or sphere.
    pub(crate) fn parameters(&self, points: &Points, closed: [bool; 2]) -> Result<Pairs, Invalid> {
        let all: Vec<usize> = (0..points.len()).collect();
        self.parameters_by(points, &all, closed)
    }

    /// The same, where the plane is that nearest to some of the points.
    pub(crate) fn parameters_by(
        &self,
        points: &Points,
        some: &[usize],
        closed: [bool; 2],
    ) -> Result<Pairs, Invalid> {
        let pairs = match self {
            Self::Given(pairs) => {
                let (given, expected) = (pairs.values.len(), points.len());
                if given != expected {
                    return Err(Invalid::parameter_count(Axis::U, given, expected));
                }
                pairs.clone()
            }
            Self::Auto => return unfolding::best(points)?.parameters_by(points, some, closed),
            Self::Plane => open(Plane::of(points, some)?.parameters()),
            Self::Coordinates(_) if points.dimension() < 2 => return Err(no_plane()),
            Self::Coordinates(plane) => {
                let axes = plane.axes();
                if axes.iter().any(|axis| *axis >= points.dimension()) {
                    return Err(no_third_coordinate());
                }
                open(axes.map(|axis| points.lane(axis).to_vec()))
            }
            Self::Cylinder(cylinder) => cylinder.parameters(points, closed[0])?,
            Self::Sphere(sphere) => sphere.parameters(points, closed[0])?,
        };
        for (axis, at) in [(Axis::U, 0), (Axis::V, 1)] {
            check(pairs.values.lane(at), axis)?;
            pairs.domains[at].check(pairs.values.lane(at), axis)?;
            if closed[at] && pairs.domains[at].period().is_none() {
                return Err(not_around(axis));
            }
        }
        Ok(pairs)
    }

    /// The rule that is taken for some points: that of `Auto`, or itself.
    ///
    /// # Errors
    ///
    /// Why no plane, cylinder or sphere unfolds the points.
    pub fn chosen(&self, points: &Points) -> Result<Self, Invalid> {
        match self {
            Self::Auto => unfolding::best(points),
            other => Ok(other.clone()),
        }
    }
}

/// Parameters of an open surface.
fn open(values: [Vec<f64>; 2]) -> Pairs {
    Pairs::open(Arc::new(Points::from_lanes(values)))
}

/// Refuses parameters that are not finite, or all the same.
fn check(values: &[f64], axis: Axis) -> Result<(), Invalid> {
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        let value = values[index];
        return Err(Invalid::parameter_not_finite(axis, index, value));
    }
    if values.iter().any(|t| t.abs() > LARGEST) {
        return Err(Invalid::parameter_range(axis));
    }
    if values.iter().all(|value| *value == values[0]) {
        return Err(Invalid::at(
            Place::Parameters(axis),
            "all points have the same parameter in this direction: they are no surface",
        ));
    }
    Ok(())
}

/// A direction that is to be closed and does not come back.
fn not_around(axis: Axis) -> Invalid {
    Invalid::at(
        Place::Closed(axis),
        "a closed direction of scattered points goes around a cylinder (u) or a sphere (u), or has a period beside the pairs",
    )
}

#[cfg(test)]
mod tests;
