//! Parameters of scattered points of a surface: each has a (u, v) of its own.
//!
//! Parameters of scattered points of a surface: each has its own (u, v).

mod circle;
mod cylinder;
mod mesh;
mod normals;
mod pairs;
mod plane;
mod rectangle;
mod sections;
mod sphere;
mod unfolding;

use std::sync::Arc;

use super::LARGEST;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};

pub use cylinder::Cylinder;
pub use mesh::{FoldedTriangles, MAX_TRIANGLES, Mesh, MeshUnfolding, pieces};
pub use pairs::{Domain, Pairs};
pub(crate) use plane::nearest_to_their_plane;
pub use sections::{Sections, is_stack};
pub use sphere::Sphere;

use mesh::{Choice, Solved};
use plane::{Plane, no_plane, no_third_coordinate};
use unfolding::Neighbourhoods;

/// The rule for the parameters of scattered points.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Scattered {
    /// Given u and v of each point.
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
    /// From section to section, and along them.
    Sections(Sections),
    /// As vertices of a mesh: their places on a surface that unfolds all triangles, or mean value coordinates.
    Mesh(Mesh),
}

/// A plane of two coordinates; the first is u.
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

impl Scattered {
    /// The parameters u and v of all points, finite numbers. A direction that is requested as closed is closed even if
    /// the points do not go all around.
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
            Self::Auto => return self.chosen(points)?.parameters_by(points, some, closed),
            Self::Mesh(mesh) => mesh.solved(points, closed[0])?.pairs,
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
            Self::Sections(sections) => sections.parameters(points, closed)?,
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

    /// The rule for points: itself, or for `Auto` the one that unfolds them best. Among the rules on which points do
    /// not fold, the first one is taken that keeps nearly as many neighbours together as the best: the plane nearest to
    /// the points, those of two coordinates, a cylinder, a sphere.
    ///
    /// # Errors
    ///
    /// Why the points have not even a plane.
    pub fn chosen(&self, points: &Points) -> Result<Self, Invalid> {
        match self {
            Self::Sections(sections) => return Ok(Self::Sections(sections.known(points)?)),
            Self::Auto if points.dimension() == 3 => {}
            Self::Auto => return Ok(Self::Plane),
            Self::Mesh(mesh) => {
                let choice = mesh.solved(points, false)?.choice;
                return Ok(Self::of_mesh(mesh, choice));
            }
            other => return Ok(other.clone()),
        }
        Self::Plane.parameters(points, [false; 2])?;
        let planes = [
            CoordinatePlane::Xy,
            CoordinatePlane::Xz,
            CoordinatePlane::Yz,
        ];
        let planes = std::iter::once(Self::Plane).chain(planes.map(Self::Coordinates));
        let cylinder = Cylinder::default().known(points).map(Self::Cylinder);
        let sphere = Sphere::default().known(points).map(Self::Sphere);
        let in_space = Neighbourhoods::new(points);
        let unfold = |rule: Self| {
            // Points of a plane have no range in another one, and one height on a cylinder far away.
            let pairs = rule.parameters(points, [false; 2]).ok()?;
            Some((in_space.unfolded(&pairs), rule))
        };
        let rules = planes.chain(cylinder).chain(sphere);
        let mut rules: Vec<_> = rules.filter_map(unfold).collect();
        if rules.iter().any(|(unfolding, _)| !unfolding.folds) {
            rules.retain(|(unfolding, _)| !unfolding.folds);
        }
        let most = rules.iter().map(|(unfolding, _)| unfolding.kept);
        let most = most.fold(0.0, f64::max);
        let mut rules = rules.into_iter();
        let simplest = rules.find(|(unfolding, _)| unfolding.kept >= most - SIMPLER);
        Ok(simplest.map_or(Self::Plane, |(_, rule)| rule))
    }

    /// The bytes of the triangles of a mesh.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len() * size_of::<[u32; 3]>(),
            _ => 0,
        }
    }

    /// Measures of a mesh that are found with its parameters; `None` for other rules.
    ///
    /// # Errors
    ///
    /// Why the mesh has no parameters.
    pub(crate) fn unfolded(
        &self,
        points: &Points,
        closed: [bool; 2],
    ) -> Result<Option<Unfolded>, Invalid> {
        let Self::Mesh(mesh) = self else {
            return Ok(None);
        };
        let Solved {
            choice,
            pairs,
            folded,
        } = mesh.solved(points, closed[0])?;
        Ok(Some(Unfolded {
            rule: Self::of_mesh(mesh, choice),
            pairs,
            folded,
        }))
    }

    /// The rule for a mesh.
    fn of_mesh(mesh: &Mesh, choice: Choice) -> Self {
        match choice {
            Choice::Plane => Self::Plane,
            Choice::Cylinder(cylinder) => Self::Cylinder(cylinder),
            Choice::Sphere(sphere) => Self::Sphere(sphere),
            Choice::MeanValue => Self::Mesh(Mesh {
                unfolding: MeshUnfolding::MeanValue,
                ..mesh.clone()
            }),
        }
    }
}

/// A mesh with parameters.
pub(crate) struct Unfolded {
    /// The rule that was taken.
    pub rule: Scattered,
    pub pairs: Pairs,
    /// The triangles that it turns over.
    pub folded: Option<FoldedTriangles>,
}

/// A simpler surface is taken if it keeps this part less of the neighbours.
const SIMPLER: f64 = 0.03;

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
