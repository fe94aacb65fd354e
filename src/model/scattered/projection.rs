//! The plane, the cylinder or the sphere on which scattered points have their parameters.

use serde::{Deserialize, Serialize};

use crate::model::named::names;
use piad_fit::parameters::{CoordinatePlane, Cylinder, Scattered, Sphere};

/// The surface on which scattered points have their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProjectionSurface {
    Plane,
    Cylinder,
    Sphere,
    Xy,
    Xz,
    Yz,
}

names!(ProjectionSurface, "projection", [
    "plane" => Plane,
    "cylinder" => Cylinder,
    "sphere" => Sphere,
    "xy" => Xy,
    "xz" => Xz,
    "yz" => Yz,
]);

/// A projection with the given parts of its surface.
#[derive(Deserialize, Serialize)]
pub(super) struct Projection {
    pub(super) project: ProjectionSurface,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) axis: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) center: Option<[f64; 3]>,
}

impl Projection {
    /// The rule, or the error for a part that it does not have.
    pub(super) fn rule(self) -> Result<Scattered, &'static str> {
        use ProjectionSurface as S;
        let Self {
            project,
            axis,
            center,
        } = self;
        Ok(match project {
            S::Cylinder => Scattered::Cylinder(Cylinder { axis, center }),
            S::Sphere => Scattered::Sphere(Sphere { axis, center }),
            _ if axis.is_some() => return Err("only a cylinder and a sphere have an axis"),
            _ if center.is_some() => return Err("only a cylinder and a sphere have a center"),
            S::Plane => Scattered::Plane,
            S::Xy => Scattered::Coordinates(CoordinatePlane::Xy),
            S::Xz => Scattered::Coordinates(CoordinatePlane::Xz),
            S::Yz => Scattered::Coordinates(CoordinatePlane::Yz),
        })
    }

    /// The projection of a rule; `None` for pairs, `auto` and meshes.
    pub(super) fn of(rule: &Scattered) -> Option<Self> {
        use ProjectionSurface as S;
        let (project, axis, center) = match *rule {
            Scattered::Given(_) | Scattered::Auto | Scattered::Sections(_) | Scattered::Mesh(_) => {
                return None;
            }
            Scattered::Plane => (S::Plane, None, None),
            Scattered::Coordinates(CoordinatePlane::Xy) => (S::Xy, None, None),
            Scattered::Coordinates(CoordinatePlane::Xz) => (S::Xz, None, None),
            Scattered::Coordinates(CoordinatePlane::Yz) => (S::Yz, None, None),
            Scattered::Cylinder(Cylinder { axis, center }) => (S::Cylinder, axis, center),
            Scattered::Sphere(Sphere { axis, center }) => (S::Sphere, axis, center),
        };
        Some(Self {
            project,
            axis,
            center,
        })
    }
}
