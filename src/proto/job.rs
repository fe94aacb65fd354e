//! A job and its message, both ways.

use std::sync::Arc;

use super::basis;
use super::ends;
use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method;
use super::scattered;
use super::stream;
use super::values::{MethodTarget, check_count, chosen, count, some, value};
use crate::model::basis::ParametersInput;
use crate::model::corners::{CornersInput, Creases};
use crate::model::ends::{DirectionEnds, EndsInput};
use crate::model::errors::{OrErrors, ValidationError, ValidationErrors};
use crate::model::job::JobRequest;
use crate::model::lists::PointNumbers;
use crate::model::per_direction::PerDirection;
use crate::model::points::{PointGrid, PointList};
use crate::model::scattered::SurfaceParameters;
use crate::model::serde_helpers::Whole;
use crate::model::shape::{CurveInput, PointOrder, RepeatedPoints};
use crate::model::stop::StopRules;
use crate::model::stream::StreamSpec;
use crate::model::surface::SurfaceInput;
use crate::model::trim::TrimInput;
use crate::model::weights::Rational;
use piad_fit::basis::Corners;
use piad_fit::data::{Grid, MAX_DIMENSION, Points};
use piad_fit::engine::{DirectionChoice, Request, Tolerance, Trim, Weights};
use piad_fit::parameters::Parametrization;

const RATIONALS: [(Rational, pb::Rational); 2] = [
    (Rational::Homogeneous, pb::Rational::Homogeneous),
    (Rational::Fixed, pb::Rational::Fixed),
];

/// The job of a message, with at most this many points.
pub(crate) fn request(input: pb::JobInput, most_points: usize) -> OrErrors<JobRequest> {
    let mut errors = ValidationErrors::default();
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
        // Without points the rest is not validated.
        None => return Ok(request),
        Some(Geometry::Curve(it)) => {
            request.curve = errors.keep(curve(it, most_points));
            target.grid = request
                .curve
                .as_ref()
                .map_or(target.grid, |it| it.points.grid());
        }
        Some(Geometry::Surface(it)) => {
            request.surface = errors.keep(surface(it, most_points));
            let grid = request.surface.as_ref().and_then(SurfaceInput::grid);
            (target.grid, target.surface) = (grid.unwrap_or(target.grid), true);
        }
    }
    let stream = input.stream.map(|it| stream::spec(it, "stream."));
    request.stream = errors.keep(stream.transpose()).flatten();
    request.rational = errors.keep(rational(input.rational)).flatten();
    request.method = errors.keep(method::input(input.method, target)).flatten();
    errors.or(request)
}

fn curve(curve: pb::Curve, most: usize) -> Result<CurveInput, ValidationError> {
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

/// The corners of a message.
fn corners(corners: pb::Corners) -> Option<Corners> {
    Some(match corners.choice? {
        pb::corners::Choice::At(pb::Indices { indices }) => {
            Corners::At(indices.into_iter().map(|index| index as usize).collect())
        }
        pb::corners::Choice::Angle(degrees) => Corners::Found(degrees),
    })
}

/// The lines with these indices, if there are any.
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

fn surface(surface: pb::Surface, most: usize) -> Result<SurfaceInput, ValidationError> {
    let points = points(surface.dimension, &surface.points, most, "surface")?;
    let (rows, columns) = match (surface.rows, surface.columns, &surface.scattered) {
        (0, 0, Some(_)) => (points.len(), 1),
        (rows, columns, _) => (rows as usize, columns as usize),
    };
    let grid = Grid { rows, columns };
    if rows.checked_mul(columns) != Some(points.len()) {
        let given = points.len();
        let detail = format!("{given} points for {rows} rows of {columns} points");
        return Err(ValidationError::at_text("surface.points", detail));
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
        Ok::<_, ValidationError>(DirectionEnds(ends.map(|ends| EndsInput::of(&ends, true))))
    };
    let has_basis = u.basis.is_some() || v.basis.is_some();
    let bases = PerDirection::Each {
        u: basis::read(u.basis, "surface.u.basis")?,
        v: basis::read(v.basis, "surface.v.basis")?,
    };
    let mut input = SurfaceInput {
        basis: has_basis.then_some(bases),
        closed: scattered::closed(&surface.scattered, [u.closed, v.closed]),
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
            return Err(ValidationError::at_text("surface.scattered", detail));
        }
        input.parameters = Some(scattered::read(it, grid)?);
        input.scattered = Some(PointList(points));
        return Ok(input);
    }
    if given {
        let usual = || ParametersInput(Parametrization::usual_of_surface(&points));
        let read = |parameters, field| {
            let parameters = basis::read_parameters(parameters, field)?;
            Ok::<_, ValidationError>(parameters.unwrap_or_else(usual))
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

/// Flat coordinates as points.
fn points(
    dimension: u32,
    flat: &[f64],
    most: usize,
    root: &str,
) -> Result<Points, ValidationError> {
    let dimension = dimension as usize;
    if !(1..=MAX_DIMENSION).contains(&dimension) {
        let detail = format!("points have 1 to {MAX_DIMENSION} coordinates, not {dimension}");
        return Err(ValidationError::at_text(
            format!("{root}.dimension"),
            detail,
        ));
    }
    if !flat.len().is_multiple_of(dimension) {
        let count = flat.len();
        let detail = format!("{count} numbers are no points of {dimension} coordinates");
        return Err(ValidationError::at_text(format!("{root}.points"), detail));
    }
    let count = flat.len() / dimension;
    check_count(count, most, "points", &format!("{root}.points"))?;
    Ok(Points::from_flat(dimension, flat))
}

fn missing(indices: &[u32], count: usize) -> Result<Vec<usize>, ValidationError> {
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
        return Err(ValidationError::at_text(
            format!("surface.missing[{k}]"),
            wrong,
        ));
    }
    Ok(missing)
}

/// The weights of a surface; `field` is that of the weights for each point.
pub(crate) fn surface_weights(
    weights: pb::Weights,
    grid: Grid,
    field: &str,
) -> Result<Option<PerDirection<PointNumbers>>, ValidationError> {
    let pb::Weights { values, u, v } = weights;
    let Grid { rows, columns } = grid;
    let wrong = |detail: String| Err(ValidationError::at_text(field, detail));
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

/// The use of weights.
pub(crate) fn rational(value: i32) -> Result<Option<Rational>, ValidationError> {
    chosen(&RATIONALS, value, "rational")
}

/// When the iteration ends.
pub(crate) fn stop(stop: pb::StopRules) -> StopRules {
    let (tolerance, relative_tolerance) = match stop.rule {
        None => (None, None),
        Some(Rule::Tolerance(value)) => (Some(value), None),
        Some(Rule::RelativeTolerance(value)) => (None, Some(value)),
    };
    // Numbers too large for this machine are beyond any limit.
    let count = |count| usize::try_from(count).unwrap_or(usize::MAX);
    StopRules {
        tolerance,
        relative_tolerance,
        max_iterations: stop.max_iterations.map(count),
    }
}

/// The message for the same problem. The start of an edit is not a part of it: that is its iteration 0.
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
        method: Some(method::requested(
            &request.method,
            request.v.is_some(),
            indices,
        )),
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
        scattered: request.scattered.as_ref().map(scattered::message),
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

/// The use of the weights of a problem.
pub(crate) fn rational_message(request: &Request) -> pb::Rational {
    value(&RATIONALS, Rational::of(request))
}

fn grid_weights(weights: &Weights) -> Option<Vec<f64>> {
    match weights {
        Weights::None => None,
        Weights::Homogeneous(weights) | Weights::FixedGrid(weights) => Some(weights.clone()),
    }
}
