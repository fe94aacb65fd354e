//! A job and its message, both ways.

use std::sync::Arc;

use super::basis;
use super::ends;
use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method;
use super::stream;
use super::values::{MethodTarget, check_count, chosen, count, known, some, value};
use crate::model::basis::ParametersInput;
use crate::model::corners::{CornersInput, Creases};
use crate::model::either::Whole;
use crate::model::ends::{DirectionEnds, EndsInput};
use crate::model::iteration::IterationChoice;
use crate::model::job::JobRequest;
use crate::model::lists::PointNumbers;
use crate::model::mistakes::{Mistake, Mistakes, OrMistakes};
use crate::model::per_direction::PerDirection;
use crate::model::points::{PointGrid, PointList};
use crate::model::scattered::{FootPoints, SurfaceParameters};
use crate::model::shape::{CurveInput, PointOrder, RepeatedPoints, SurfaceInput};
use crate::model::stop::StopRules;
use crate::model::stream::StreamSpec;
use crate::model::trim::TrimInput;
use crate::model::weights::Rational;
use piad_fit::basis::Corners;
use piad_fit::data::{Grid, MAX_DIMENSION, Points};
use piad_fit::engine::{DirectionChoice, Request, Tolerance, Trim, Weights};
use piad_fit::parameters::{
    CoordinatePlane, Cylinder, Domain, Mesh, MeshUnfolding, Pairs, Parametrization, Scattered,
    Sections, Sphere,
};

const RATIONALS: [(Rational, pb::Rational); 2] = [
    (Rational::Homogeneous, pb::Rational::Homogeneous),
    (Rational::Fixed, pb::Rational::Fixed),
];

/// The job that a message asks for, with at most so many points.
pub(crate) fn request(input: pb::JobInput, most_points: usize) -> OrMistakes<JobRequest> {
    let mut mistakes = Mistakes::default();
    let mut request = JobRequest {
        name: input.name,
        stop: input.stop.map(stop),
        ..JobRequest::default()
    };
    let mut target = MethodTarget {
        grid: Grid {
            rows: 0,
            columns: 1,
        },
        surface: false,
        most: most_points,
    };
    match input.geometry {
        // Without points the rest is not looked at.
        None => return Ok(request),
        Some(Geometry::Curve(it)) => {
            request.curve = mistakes.keep(curve(it, most_points));
            target.grid = request
                .curve
                .as_ref()
                .map_or(target.grid, |it| it.points.grid());
        }
        Some(Geometry::Surface(it)) => {
            request.surface = mistakes.keep(surface(it, most_points));
            let grid = request.surface.as_ref().and_then(SurfaceInput::grid);
            (target.grid, target.surface) = (grid.unwrap_or(target.grid), true);
        }
    }
    let stream = input.stream.map(|it| stream::spec(it, "stream."));
    request.stream = mistakes.keep(stream.transpose()).flatten();
    request.rational = mistakes.keep(rational(input.rational)).flatten();
    request.method = mistakes.keep(method::input(input.method, target)).flatten();
    mistakes.or(request)
}

fn curve(curve: pb::Curve, most: usize) -> Result<CurveInput, Mistake> {
    let points = points(curve.dimension, &curve.points, most, "curve")?;
    let boundary = (1, points.dimension());
    let ends = ends::read(curve.ends, boundary, "curve.ends")?;
    Ok(CurveInput {
        points: PointList(Arc::new(points)),
        basis: Some(basis::read(curve.basis, "curve.basis")?),
        degree: None,
        parameters: basis::read_parameters(curve.parameters, "curve.parameters")?,
        weights: some(curve.weights).map(PointNumbers::Line),
        closed: Some(curve.closed),
        ends: ends.map(|ends| EndsInput::of(&ends, false)),
        corners: curve.corners.and_then(corners).map(CornersInput),
        polyline: Some(curve.polyline),
        order: curve.unordered.then_some(PointOrder::Nearest),
        repeated_points: curve.merge_repeated.then_some(RepeatedPoints::Merge),
    })
}

/// The corners that a message asks for.
fn corners(corners: pb::Corners) -> Option<Corners> {
    Some(match corners.choice? {
        pb::corners::Choice::At(pb::Indices { indices }) => {
            Corners::At(indices.into_iter().map(|index| index as usize).collect())
        }
        pb::corners::Choice::Angle(degrees) => Corners::Found(degrees),
    })
}

/// The lines that these indices are those of, if there are some.
fn lines(indices: &[u32]) -> Option<Vec<Whole>> {
    let lines = indices.iter().map(|&index| Whole(index as usize));
    (!indices.is_empty()).then(|| lines.collect())
}

/// The message of corners.
fn corners_message(corners: &Corners) -> pb::Corners {
    let choice = match corners {
        Corners::At(indices) => {
            let indices = indices.iter().map(|&index| count(index)).collect();
            pb::corners::Choice::At(pb::Indices { indices })
        }
        Corners::Found(degrees) => pb::corners::Choice::Angle(*degrees),
    };
    pb::Corners {
        choice: Some(choice),
    }
}

/// The number of coordinates in space.
const SPACE: usize = 3;

fn surface(surface: pb::Surface, most: usize) -> Result<SurfaceInput, Mistake> {
    let points = points(surface.dimension, &surface.points, most, "surface")?;
    let (rows, columns) = match (surface.rows, surface.columns, &surface.scattered) {
        (0, 0, Some(_)) => (points.len(), 1),
        (rows, columns, _) => (rows as usize, columns as usize),
    };
    let grid = Grid { rows, columns };
    if rows.checked_mul(columns) != Some(points.len()) {
        let given = points.len();
        let detail = format!("{given} points for {rows} rows of {columns} points");
        return Err(Mistake::at_text("surface.points", detail));
    }
    let missing = missing(&surface.missing, points.len())?;
    let (u, v) = (surface.u.unwrap_or_default(), surface.v.unwrap_or_default());
    let given = u.parameters.is_some() || v.parameters.is_some();
    // Heights with a place become points of space.
    let dimension = match &surface.placement {
        None => points.dimension(),
        Some(_) => SPACE,
    };
    let points = Arc::new(points);
    let ends = |ends, count, field| {
        let ends = ends::read(ends, (count, dimension), field)?;
        Ok::<_, Mistake>(DirectionEnds(ends.map(|ends| EndsInput::of(&ends, true))))
    };
    let has_basis = u.basis.is_some() || v.basis.is_some();
    let bases = PerDirection::Each {
        u: basis::read(u.basis, "surface.u.basis")?,
        v: basis::read(v.basis, "surface.v.basis")?,
    };
    let mut input = SurfaceInput {
        basis: has_basis.then_some(bases),
        closed: closed(&surface.scattered, [u.closed, v.closed]),
        ends: Some(PerDirection::Each {
            u: ends(u.ends, columns, "surface.u.ends")?,
            v: ends(v.ends, rows, "surface.v.ends")?,
        }),
        creases: Some(Creases {
            u: lines(&u.creases),
            v: lines(&v.creases),
        }),
        spacing: surface.placement.map(|it| [it.dx, it.dy]),
        origin: surface.placement.map(|it| [it.x, it.y]),
        trim: surface
            .trim
            .map(|pb::Trim { distance }| TrimInput(Some(Trim { distance }))),
        ..SurfaceInput::default()
    };
    let weights = pb::Weights {
        values: surface.weights,
        u: u.weights,
        v: v.weights,
    };
    input.weights = surface_weights(weights, grid, "surface.weights")?;
    if let Some(it) = surface.scattered {
        if given {
            let detail = "scattered points have no parameters of their directions";
            return Err(Mistake::at_text("surface.scattered", detail));
        }
        input.parameters = Some(scattered(it, grid)?);
        input.scattered = Some(PointList(points));
        return Ok(input);
    }
    if given {
        let usual = || ParametersInput(Parametrization::usual_of_surface(&points));
        let read = |parameters, field| {
            let parameters = basis::read_parameters(parameters, field)?;
            Ok::<_, Mistake>(parameters.unwrap_or_else(usual))
        };
        input.parameters = Some(SurfaceParameters::Grid(PerDirection::Each {
            u: read(u.parameters, "surface.u.parameters")?,
            v: read(v.parameters, "surface.v.parameters")?,
        }));
    }
    input.points = Some(PointGrid {
        points,
        missing,
        grid,
    });
    Ok(input)
}

/// Which directions are closed. Sections say it themselves, or their ends do.
fn closed(
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
fn scattered(
    parameters: pb::ScatteredParameters,
    grid: Grid,
) -> Result<SurfaceParameters, Mistake> {
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
        return Err(Mistake::at_text("surface.columns", detail));
    }
    if !sections.is_empty() {
        let others = foot_points.is_some() || !values.is_empty() || projection != 0;
        let others = others || !triangles.is_empty() || unfolding != 0;
        if others || !axis.is_empty() || !center.is_empty() || u.is_some() || v.is_some() {
            let detail = "sections have parameters of their own";
            return Err(Mistake::at_text("surface.scattered.sections", detail));
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
        return Err(Mistake::at_text("surface.scattered.unfolding", detail));
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
            return Err(Mistake::at_text("surface.scattered.triangles", detail));
        }
        return mesh(&triangles, unfolding);
    }
    if let Some(pb::FootPoints { job, iteration }) = foot_points {
        if projection != pb::Projection::Unspecified || !values.is_empty() {
            let detail = "scattered points have foot points, a projection or values, one of them";
            return Err(Mistake::at_text("surface.scattered.foot_points", detail));
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
        return Err(Mistake::at_text("surface.scattered.u", detail));
    }
    let axis = vector(&axis, "surface.scattered.axis")?;
    let center = vector(&center, "surface.scattered.center")?;
    let has_axis = matches!(
        projection,
        pb::Projection::Cylinder | pb::Projection::Sphere
    );
    if !has_axis && (axis.is_some() || center.is_some()) {
        let detail = "only a cylinder and a sphere have an axis and a center";
        return Err(Mistake::at_text("surface.scattered.axis", detail));
    }
    let rule = match projection {
        pb::Projection::Unspecified if values.is_empty() => Scattered::Auto,
        pb::Projection::Unspecified if !values.len().is_multiple_of(2) => {
            let count = values.len();
            let detail = format!("{count} numbers are no pairs u, v");
            return Err(Mistake::at_text(field, detail));
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
            Err(Mistake::at_text(field, detail))
        }
    }
}

/// The parameters of the vertices of a mesh.
fn mesh(indices: &[u32], unfolding: pb::MeshUnfolding) -> Result<SurfaceParameters, Mistake> {
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        let count = indices.len();
        let detail = format!("{count} indices are no triangles: each has three");
        return Err(Mistake::at_text("surface.scattered.triangles", detail));
    }
    Ok(SurfaceParameters::Scattered(Scattered::Mesh(Mesh {
        triangles: Arc::new(triangles.to_vec()),
        unfolding: match unfolding {
            pb::MeshUnfolding::Unspecified | pb::MeshUnfolding::Auto => MeshUnfolding::Auto,
            pb::MeshUnfolding::MeanValue => MeshUnfolding::MeanValue,
        },
    })))
}

/// How far a direction of explicit parameters goes.
fn domain(domain: Option<pb::ParameterDomain>, field: &str) -> Result<Domain, Mistake> {
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
            Err(Mistake::at_text(field, detail))
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
fn vector(numbers: &[f64], field: &str) -> Result<Option<[f64; 3]>, Mistake> {
    match numbers {
        [] => Ok(None),
        &[x, y, z] => Ok(Some([x, y, z])),
        _ => {
            let detail = format!(
                "{} numbers are no direction or place of space",
                numbers.len()
            );
            Err(Mistake::at_text(field, detail))
        }
    }
}

fn scattered_message(scattered: &Scattered) -> pb::ScatteredParameters {
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

/// Flat coordinates as points.
fn points(dimension: u32, flat: &[f64], most: usize, root: &str) -> Result<Points, Mistake> {
    let dimension = dimension as usize;
    if !(1..=MAX_DIMENSION).contains(&dimension) {
        let detail = format!("points have 1 to {MAX_DIMENSION} coordinates, not {dimension}");
        return Err(Mistake::at_text(format!("{root}.dimension"), detail));
    }
    if !flat.len().is_multiple_of(dimension) {
        let count = flat.len();
        let detail = format!("{count} numbers are no points of {dimension} coordinates");
        return Err(Mistake::at_text(format!("{root}.points"), detail));
    }
    let count = flat.len() / dimension;
    check_count(count, most, "points", &format!("{root}.points"))?;
    Ok(Points::from_flat(dimension, flat))
}

fn missing(indices: &[u32], count: usize) -> Result<Vec<usize>, Mistake> {
    let mut missing = Vec::with_capacity(indices.len().min(count));
    for (k, &index) in indices.iter().enumerate() {
        let index = index as usize;
        let wrong = if index >= count {
            format!("{index} is not one of the {count} points")
        } else if missing.last() >= Some(&index) {
            "indices of missing points increase".to_owned()
        } else {
            missing.push(index);
            continue;
        };
        return Err(Mistake::at_text(format!("surface.missing[{k}]"), wrong));
    }
    Ok(missing)
}

/// The weights of a surface; `field` is that of the weights for each point.
pub(crate) fn surface_weights(
    weights: pb::Weights,
    grid: Grid,
    field: &str,
) -> Result<Option<PerDirection<PointNumbers>>, Mistake> {
    let pb::Weights { values, u, v } = weights;
    let Grid { rows, columns } = grid;
    let wrong = |detail: String| Err(Mistake::at_text(field, detail));
    match (values.is_empty(), u.is_empty() && v.is_empty()) {
        (true, true) => Ok(None),
        (false, false) => wrong("weights of points and of directions exclude each other".into()),
        (true, false) => Ok(Some(PerDirection::Each {
            u: PointNumbers::Line(u),
            v: PointNumbers::Line(v),
        })),
        (false, true) if values.len() != rows * columns => {
            let given = values.len();
            wrong(format!(
                "{given} weights for {rows} rows of {columns} points: one for each is needed"
            ))
        }
        (false, true) => Ok(Some(PerDirection::Both(PointNumbers::Grid {
            values,
            columns,
        }))),
    }
}

/// How weights are used.
pub(crate) fn rational(value: i32) -> Result<Option<Rational>, Mistake> {
    chosen(&RATIONALS, value, "rational")
}

/// When the iteration ends.
pub(crate) fn stop(stop: pb::StopRules) -> StopRules {
    let (tolerance, relative_tolerance) = match stop.rule {
        None => (None, None),
        Some(Rule::Tolerance(value)) => (Some(value), None),
        Some(Rule::RelativeTolerance(value)) => (None, Some(value)),
    };
    // Too many for this machine are too many for any limit.
    let count = |count| usize::try_from(count).unwrap_or(usize::MAX);
    StopRules {
        tolerance,
        relative_tolerance,
        max_iterations: stop.max_iterations.map(count),
    }
}

/// The message that would ask for the same problem again. The start of an edit is not a part of it: that
/// is its iteration 0.
pub(crate) fn message(
    name: Option<String>,
    request: &Request,
    stream: Option<&StreamSpec>,
) -> pb::JobInput {
    let selected = request.selected.as_deref().unwrap_or_default();
    let indices = selected.iter().map(|&index| count(index)).collect();
    pb::JobInput {
        name,
        geometry: Some(match &request.v {
            None => Geometry::Curve(curve_message(request)),
            Some(v) => Geometry::Surface(surface_message(request, v)),
        }),
        rational: rational_message(request).into(),
        method: Some(method::asked(&request.method, request.v.is_some(), indices)),
        stop: Some(pb::StopRules {
            rule: request.tolerance.map(|tolerance| match tolerance {
                Tolerance::Absolute(value) => Rule::Tolerance(value),
                Tolerance::Relative(value) => Rule::RelativeTolerance(value),
            }),
            max_iterations: Some(request.max_iterations as u64),
        }),
        stream: stream.map(stream::options),
    }
}

fn curve_message(request: &Request) -> pb::Curve {
    let fixed = request.u.weights.clone();
    pb::Curve {
        dimension: count(request.points.dimension()),
        points: request.points.to_flat(),
        basis: Some(basis::message(&request.u.basis)),
        parameters: Some(basis::parameters_message(&request.u.parameters)),
        weights: grid_weights(&request.weights).or(fixed).unwrap_or_default(),
        closed: request.u.closed,
        ends: request.u.ends.as_ref().map(ends::message),
        corners: request.u.corners.as_ref().map(corners_message),
        polyline: request.polyline,
        unordered: request.unordered,
        merge_repeated: request.merge_repeated,
    }
}

fn surface_message(request: &Request, v: &DirectionChoice) -> pb::Surface {
    let scattered = request.scattered.is_some();
    pb::Surface {
        dimension: count(request.points.dimension()),
        rows: count(request.grid.rows),
        columns: count(request.grid.columns),
        points: request.points.to_flat(),
        missing: request.missing.iter().map(|&index| count(index)).collect(),
        scattered: request.scattered.as_ref().map(scattered_message),
        u: Some(direction(&request.u, scattered)),
        v: Some(direction(v, scattered)),
        weights: grid_weights(&request.weights).unwrap_or_default(),
        placement: None,
        trim: request.trim.map(|Trim { distance }| pb::Trim { distance }),
    }
}

fn direction(choice: &DirectionChoice, scattered: bool) -> pb::SurfaceDirection {
    pb::SurfaceDirection {
        basis: Some(basis::message(&choice.basis)),
        parameters: (!scattered).then(|| basis::parameters_message(&choice.parameters)),
        closed: choice.closed,
        weights: choice.weights.clone().unwrap_or_default(),
        ends: choice.ends.as_ref().map(ends::message),
        creases: choice
            .corners
            .iter()
            .flat_map(Corners::indices)
            .map(|&index| count(index))
            .collect(),
    }
}

/// How the weights of a problem are used.
pub(crate) fn rational_message(request: &Request) -> pb::Rational {
    value(&RATIONALS, Rational::of(request))
}

fn grid_weights(weights: &Weights) -> Option<Vec<f64>> {
    match weights {
        Weights::None => None,
        Weights::Homogeneous(weights) | Weights::FixedGrid(weights) => Some(weights.clone()),
    }
}
