//! The parameters of scattered points and their message, both ways.

use std::sync::Arc;

use super::messages as pb;
use super::values::{count, known};
use crate::model::errors::ValidationError;
use crate::model::iteration::IterationChoice;
use crate::model::per_direction::PerDirection;
use crate::model::scattered::{FootPoints, SurfaceParameters};
use piad_fit::data::{Grid, Points};
use piad_fit::parameters::{
    CoordinatePlane, Cylinder, Domain, Mesh, MeshUnfolding, Pairs, Scattered, Sections, Sphere,
};

/// The closed directions. For sections they follow from a setting or from their ends.
pub(super) fn closed(
    scattered: &Option<pb::ScatteredParameters>,
    [u, v]: [bool; 2],
) -> Option<PerDirection<bool>> {
    let sections = scattered.as_ref().filter(|it| !it.sections.is_empty());
    let (is_said, v) = match sections.map(|it| it.closed_sections) {
        None => (true, v),
        Some(said) => (u || v || said.is_some(), said.unwrap_or(v)),
    };
    is_said.then_some(PerDirection::Each { u, v })
}

/// The parameters of scattered points.
pub(super) fn read(
    parameters: pb::ScatteredParameters,
    grid: Grid,
) -> Result<SurfaceParameters, ValidationError> {
    let pb::ScatteredParameters {
        projection,
        values,
        foot_points,
        axis,
        center,
        u,
        v,
        sections,
        closed_sections,
        triangles,
        unfolding,
    } = parameters;
    if grid.is_rows() {
        let detail = "scattered points have one column, or neither rows nor columns";
        return Err(ValidationError::at_text("surface.columns", detail));
    }
    if !sections.is_empty() {
        let others = foot_points.is_some() || !values.is_empty() || projection != 0;
        let others = others || !triangles.is_empty() || unfolding != 0;
        if others || !axis.is_empty() || !center.is_empty() || u.is_some() || v.is_some() {
            let detail = "sections have parameters of their own";
            return Err(ValidationError::at_text(
                "surface.scattered.sections",
                detail,
            ));
        }
        let counts: Vec<usize> = sections.iter().map(|&count| count as usize).collect();
        return Ok(SurfaceParameters::Scattered(Scattered::Sections(
            Sections {
                closed: closed_sections,
                ..Sections::new(counts)
            },
        )));
    }
    let field = "surface.scattered.values";
    let projection = known(projection, "surface.scattered.projection")?;
    let unfolding = known(unfolding, "surface.scattered.unfolding")?;
    if triangles.is_empty() && unfolding != pb::MeshUnfolding::Unspecified {
        let detail = "an unfolding is that of triangles";
        return Err(ValidationError::at_text(
            "surface.scattered.unfolding",
            detail,
        ));
    }
    if !triangles.is_empty() {
        let is_alone = projection == pb::Projection::Unspecified
            && values.is_empty()
            && foot_points.is_none()
            && [&axis, &center].iter().all(|it| it.is_empty())
            && u.is_none()
            && v.is_none();
        if !is_alone {
            let detail = "a mesh has triangles and an unfolding, and nothing else";
            return Err(ValidationError::at_text(
                "surface.scattered.triangles",
                detail,
            ));
        }
        return mesh(&triangles, unfolding);
    }
    if let Some(pb::FootPoints { job, iteration }) = foot_points {
        if projection != pb::Projection::Unspecified || !values.is_empty() {
            let detail = "scattered points have foot points, a projection or values, one of them";
            return Err(ValidationError::at_text(
                "surface.scattered.foot_points",
                detail,
            ));
        }
        let iteration = iteration.map(IterationChoice::of);
        return Ok(SurfaceParameters::FootPoints(FootPoints { job, iteration }));
    }
    let domains = match [u, v] {
        [None, None] => None,
        [u, v] => Some([
            domain(u, "surface.scattered.u")?,
            domain(v, "surface.scattered.v")?,
        ]),
    };
    if domains.is_some() && values.is_empty() {
        let detail = "domains are those of values";
        return Err(ValidationError::at_text("surface.scattered.u", detail));
    }
    let axis = vector(&axis, "surface.scattered.axis")?;
    let center = vector(&center, "surface.scattered.center")?;
    let has_axis = matches!(
        projection,
        pb::Projection::Cylinder | pb::Projection::Sphere
    );
    if !has_axis && (axis.is_some() || center.is_some()) {
        let detail = "only a cylinder and a sphere have an axis and a center";
        return Err(ValidationError::at_text("surface.scattered.axis", detail));
    }
    let rule = match projection {
        pb::Projection::Unspecified if values.is_empty() => Scattered::Auto,
        pb::Projection::Unspecified if !values.len().is_multiple_of(2) => {
            let count = values.len();
            let detail = format!("{count} numbers are no pairs u, v");
            return Err(ValidationError::at_text(field, detail));
        }
        pb::Projection::Unspecified => {
            let values = Arc::new(Points::from_flat(2, &values));
            let domains = domains.unwrap_or_default();
            let pairs = Pairs { values, domains };
            return Ok(SurfaceParameters::Scattered(Scattered::Given(pairs)));
        }
        pb::Projection::Plane => Scattered::Plane,
        pb::Projection::Cylinder => Scattered::Cylinder(Cylinder { axis, center }),
        pb::Projection::Sphere => Scattered::Sphere(Sphere { axis, center }),
        pb::Projection::Xy => Scattered::Coordinates(CoordinatePlane::Xy),
        pb::Projection::Xz => Scattered::Coordinates(CoordinatePlane::Xz),
        pb::Projection::Yz => Scattered::Coordinates(CoordinatePlane::Yz),
    };
    match values.is_empty() {
        true => Ok(SurfaceParameters::Scattered(rule)),
        false => {
            let detail = "numbers are given, but there is a projection";
            Err(ValidationError::at_text(field, detail))
        }
    }
}

/// The parameters of the vertices of a mesh.
fn mesh(
    indices: &[u32],
    unfolding: pb::MeshUnfolding,
) -> Result<SurfaceParameters, ValidationError> {
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        let count = indices.len();
        let detail = format!("{count} indices are no triangles: each has three");
        return Err(ValidationError::at_text(
            "surface.scattered.triangles",
            detail,
        ));
    }
    Ok(SurfaceParameters::Scattered(Scattered::Mesh(Mesh {
        triangles: Arc::new(triangles.to_vec()),
        unfolding: match unfolding {
            pb::MeshUnfolding::Unspecified | pb::MeshUnfolding::Auto => MeshUnfolding::Auto,
            pb::MeshUnfolding::MeanValue => MeshUnfolding::MeanValue,
        },
    })))
}

/// The extent of a direction of explicit parameters.
fn domain(domain: Option<pb::ParameterDomain>, field: &str) -> Result<Domain, ValidationError> {
    let Some(domain) = domain else {
        return Ok(Domain::Data);
    };
    let pb::ParameterDomain {
        period,
        low,
        high,
        pole_low,
        pole_high,
    } = domain;
    let poles = [pole_low, pole_high];
    match (period, low, high) {
        (Some(period), None, None) if poles == [false; 2] => Ok(Domain::Closed(period)),
        (None, Some(low), Some(high)) => Ok(Domain::Between {
            ends: [low, high],
            poles,
        }),
        (None, None, None) if poles == [false; 2] => Ok(Domain::Data),
        _ => {
            let detail = "a direction has a period, or low and high with their poles";
            Err(ValidationError::at_text(field, detail))
        }
    }
}

fn domain_message(domain: Domain) -> Option<pb::ParameterDomain> {
    match domain {
        Domain::Data => None,
        Domain::Closed(period) => Some(pb::ParameterDomain {
            period: Some(period),
            ..Default::default()
        }),
        Domain::Between {
            ends: [low, high],
            poles: [pole_low, pole_high],
        } => Some(pb::ParameterDomain {
            period: None,
            low: Some(low),
            high: Some(high),
            pole_low,
            pole_high,
        }),
    }
}

/// Three numbers, or none.
fn vector(numbers: &[f64], field: &str) -> Result<Option<[f64; 3]>, ValidationError> {
    match numbers {
        [] => Ok(None),
        &[x, y, z] => Ok(Some([x, y, z])),
        _ => {
            let detail = format!(
                "{} numbers are no direction or place of space",
                numbers.len()
            );
            Err(ValidationError::at_text(field, detail))
        }
    }
}

pub(super) fn message(scattered: &Scattered) -> pb::ScatteredParameters {
    let on = |projection: pb::Projection| pb::ScatteredParameters {
        projection: projection.into(),
        ..Default::default()
    };
    let around = |projection, axis: Option<[f64; 3]>, center: Option<[f64; 3]>| {
        let numbers = |vector: Option<[f64; 3]>| vector.map_or(Vec::new(), Vec::from);
        pb::ScatteredParameters {
            axis: numbers(axis),
            center: numbers(center),
            ..on(projection)
        }
    };
    match scattered {
        Scattered::Given(Pairs { values, domains }) => {
            let [u, v] = domains.map(domain_message);
            pb::ScatteredParameters {
                values: values.to_flat(),
                u,
                v,
                ..Default::default()
            }
        }
        Scattered::Sections(Sections { counts, closed }) => pb::ScatteredParameters {
            sections: counts.iter().map(|&it| count(it)).collect(),
            closed_sections: *closed,
            ..Default::default()
        },
        Scattered::Auto => pb::ScatteredParameters::default(),
        Scattered::Mesh(Mesh {
            triangles,
            unfolding,
        }) => pb::ScatteredParameters {
            triangles: triangles.as_flattened().to_vec(),
            unfolding: match unfolding {
                MeshUnfolding::Auto => pb::MeshUnfolding::Unspecified,
                MeshUnfolding::MeanValue => pb::MeshUnfolding::MeanValue,
            }
            .into(),
            ..Default::default()
        },
        Scattered::Plane => on(pb::Projection::Plane),
        Scattered::Coordinates(CoordinatePlane::Xy) => on(pb::Projection::Xy),
        Scattered::Coordinates(CoordinatePlane::Xz) => on(pb::Projection::Xz),
        Scattered::Coordinates(CoordinatePlane::Yz) => on(pb::Projection::Yz),
        Scattered::Cylinder(Cylinder { axis, center }) => {
            around(pb::Projection::Cylinder, *axis, *center)
        }
        Scattered::Sphere(Sphere { axis, center }) => {
            around(pb::Projection::Sphere, *axis, *center)
        }
    }
}
