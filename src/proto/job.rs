//! A job and its message, both ways.

use std::sync::Arc;

use super::basis::{self, axis};
use super::ends::{self, flat};
use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method;
use super::stream;
use super::values::{MethodTarget, check_count, count, known, some};
use crate::fit::direction::DirectionChoice;
use crate::fit::method::Method;
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{Request, Tolerance, Weights};
use crate::fit::scattered::Scattered;
use crate::model::job::JobSpec;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::scattered::{BaseSpec, ScatteredSpec};
use crate::model::shape::{AxisSpec, MAX_DIMENSION, ShapeSpec};
use crate::model::stop::StopSpec;
use crate::model::stream::StreamSpec;
use crate::model::weights::{Rational, WeightSpec};

/// The job that a message asks for, with at most so many points.
pub fn spec(input: pb::JobInput, most_points: usize) -> JobSpec {
    let surface = matches!(input.geometry, Some(Geometry::Surface(_)));
    let shape: OrMistakes<ShapeSpec> = match input.geometry {
        None => Err(Mistake::at(SpecPart::Whole, "a curve or a surface is needed").into()),
        Some(Geometry::Curve(it)) => curve(it, most_points).map_err(Into::into),
        Some(Geometry::Surface(it)) => self::surface(it, most_points).map_err(Into::into),
    };
    let scope = MethodTarget {
        points: shape
            .as_ref()
            .map_or(usize::MAX, |shape| shape.grid.count()),
        surface,
        most: most_points,
    };
    let method = method::spec(input.method, scope);
    let stream = input.stream.map(|it| stream::spec(it, "stream."));
    JobSpec {
        name: input.name,
        surface,
        shape,
        rational: rational(input.rational).map_err(Into::into),
        method: method.map(|method| method.unwrap_or(Method::Global.into())),
        stop: stop(input.stop).unwrap_or_default(),
        stream: stream.transpose().map_err(Into::into),
    }
}

fn curve(curve: pb::Curve, most: usize) -> Result<ShapeSpec, Mistake> {
    let points = points(curve.dimension, &curve.points, most, "curve")?;
    let dimension = points.dimension();
    Ok(ShapeSpec {
        grid: Grid {
            rows: points.len(),
            columns: 1,
        },
        points,
        missing: Vec::new(),
        scattered: None,
        u: AxisSpec {
            ends: Ok(ends::spec(curve.ends, (1, dimension), "curve.ends")?),
            ..axis(
                curve.basis,
                (curve.parameters, Parametrization::ChordLength),
                curve.closed,
                "curve",
            )?
        },
        v: None,
        weights: Ok(some(curve.weights).map(WeightSpec::List)),
    })
}

fn surface(surface: pb::Surface, most: usize) -> Result<ShapeSpec, Mistake> {
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
    let scattered = surface.scattered;
    let scattered = scattered.map(|it| self::scattered(it, grid)).transpose()?;
    let missing = missing(&surface.missing, points.len())?;
    let (u, v) = (surface.u.unwrap_or_default(), surface.v.unwrap_or_default());
    if scattered.is_some() && (u.parameters.is_some() || v.parameters.is_some()) {
        let detail = "scattered points have no parameters of their directions";
        return Err(Mistake::at_text("surface.scattered", detail));
    }
    let weights = pb::Weights {
        values: surface.weights,
        u: u.weights,
        v: v.weights,
    };
    let dimension = points.dimension();
    let usual = Parametrization::usual_of_surface(&points);
    Ok(ShapeSpec {
        points,
        grid,
        missing,
        scattered,
        u: AxisSpec {
            ends: Ok(ends::spec(u.ends, (columns, dimension), "surface.u.ends")?),
            ..axis(
                u.basis,
                (u.parameters, usual.clone()),
                u.closed,
                "surface.u",
            )?
        },
        v: Some(AxisSpec {
            ends: Ok(ends::spec(v.ends, (rows, dimension), "surface.v.ends")?),
            ..axis(v.basis, (v.parameters, usual), v.closed, "surface.v")?
        }),
        weights: Ok(surface_weights(weights, grid, "surface.weights")?),
    })
}

/// The parameters of scattered points.
fn scattered(parameters: pb::ScatteredParameters, grid: Grid) -> Result<ScatteredSpec, Mistake> {
    let pb::ScatteredParameters {
        projection,
        values,
        foot_points,
    } = parameters;
    if grid.is_rows() {
        let detail = "scattered points have one column, or neither rows nor columns";
        return Err(Mistake::at_text("surface.columns", detail));
    }
    let field = "surface.scattered.values";
    let projection = known(projection, "surface.scattered.projection")?;
    if let Some(pb::FootPoints { job, iteration }) = foot_points {
        if projection != pb::Projection::Unspecified || !values.is_empty() {
            let detail = "scattered points have foot points, a projection or values, one of them";
            return Err(Mistake::at_text("surface.scattered.foot_points", detail));
        }
        return Ok(ScatteredSpec::FootPoints(BaseSpec {
            job,
            // Too large for this machine is beyond every job.
            iteration: iteration.map(|k| usize::try_from(k).unwrap_or(usize::MAX)),
        }));
    }
    let plane = match projection {
        pb::Projection::Unspecified if values.is_empty() => {
            let detail = "scattered points need parameters, a projection, or foot points";
            return Err(Mistake::at_text("surface.scattered", detail));
        }
        pb::Projection::Unspecified if !values.len().is_multiple_of(2) => {
            let count = values.len();
            let detail = format!("{count} numbers are no pairs u, v");
            return Err(Mistake::at_text(field, detail));
        }
        pb::Projection::Unspecified => {
            let pairs = Arc::new(Points::from_flat(2, &values));
            return Ok(ScatteredSpec::Own(Scattered::Given(pairs)));
        }
        pb::Projection::Nearest => Scattered::Plane,
        pb::Projection::Xy => Scattered::Coordinates,
    };
    match values.is_empty() {
        true => Ok(ScatteredSpec::Own(plane)),
        false => {
            let detail = "numbers are given, but there is a projection";
            Err(Mistake::at_text(field, detail))
        }
    }
}

fn scattered_message(scattered: &Scattered) -> pb::ScatteredParameters {
    let (projection, values) = match scattered {
        Scattered::Given(pairs) => (pb::Projection::Unspecified, flat(pairs)),
        Scattered::Plane => (pb::Projection::Nearest, Vec::new()),
        Scattered::Coordinates => (pb::Projection::Xy, Vec::new()),
    };
    pb::ScatteredParameters {
        projection: projection.into(),
        values,
        foot_points: None,
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
pub fn surface_weights(
    weights: pb::Weights,
    grid: Grid,
    field: &str,
) -> Result<Option<WeightSpec>, Mistake> {
    let pb::Weights { values, u, v } = weights;
    let Grid { rows, columns } = grid;
    let wrong = |detail: String| Err(Mistake::at_text(field, detail));
    match (values.is_empty(), u.is_empty() && v.is_empty()) {
        (true, true) => Ok(None),
        (false, false) => wrong("weights of points and of directions exclude each other".into()),
        (true, false) => Ok(Some(WeightSpec::Axes { u, v })),
        (false, true) if values.len() != rows * columns => {
            let given = values.len();
            wrong(format!(
                "{given} weights for {rows} rows of {columns} points"
            ))
        }
        (false, true) => Ok(Some(WeightSpec::Grid { values, columns })),
    }
}

/// How weights are used.
pub fn rational(value: i32) -> Result<Option<Rational>, Mistake> {
    Ok(match known(value, "rational")? {
        pb::Rational::Unspecified => None,
        pb::Rational::Homogeneous => Some(Rational::Homogeneous),
        pb::Rational::Fixed => Some(Rational::Fixed),
    })
}

/// When the iteration ends.
pub fn stop(stop: Option<pb::StopRules>) -> Option<StopSpec> {
    let stop = stop?;
    let tolerance = stop.rule.map(|rule| match rule {
        Rule::Tolerance(value) => Tolerance::Absolute(value),
        Rule::RelativeTolerance(value) => Tolerance::Relative(value),
    });
    // Too many for this machine are too many for any limit.
    let count = |count| usize::try_from(count).unwrap_or(usize::MAX);
    Some(StopSpec {
        tolerance: Ok(tolerance),
        max_iterations: stop.max_iterations.map(count),
    })
}

/// The message that would ask for the same problem again. The start of an edit is not a part of it: that
/// is its iteration 0.
pub fn message(
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
        points: flat(&request.points),
        basis: Some(basis::message(&request.u.basis)),
        parameters: Some(basis::parameters_message(&request.u.parameters)),
        weights: grid_weights(&request.weights).or(fixed).unwrap_or_default(),
        closed: request.u.closed,
        ends: request.u.ends.as_ref().map(ends::message),
    }
}

fn surface_message(request: &Request, v: &DirectionChoice) -> pb::Surface {
    let scattered = request.scattered.is_some();
    pb::Surface {
        dimension: count(request.points.dimension()),
        rows: count(request.grid.rows),
        columns: count(request.grid.columns),
        points: flat(&request.points),
        missing: request.missing.iter().map(|&index| count(index)).collect(),
        scattered: request.scattered.as_ref().map(scattered_message),
        u: Some(direction(&request.u, scattered)),
        v: Some(direction(v, scattered)),
        weights: grid_weights(&request.weights).unwrap_or_default(),
    }
}

fn direction(choice: &DirectionChoice, scattered: bool) -> pb::SurfaceDirection {
    pb::SurfaceDirection {
        basis: Some(basis::message(&choice.basis)),
        parameters: (!scattered).then(|| basis::parameters_message(&choice.parameters)),
        closed: choice.closed,
        weights: choice.weights.clone().unwrap_or_default(),
        ends: choice.ends.as_ref().map(ends::message),
    }
}

fn rational_message(request: &Request) -> pb::Rational {
    match Rational::of(request) {
        None => pb::Rational::Unspecified,
        Some(Rational::Homogeneous) => pb::Rational::Homogeneous,
        Some(Rational::Fixed) => pb::Rational::Fixed,
    }
}

fn grid_weights(weights: &Weights) -> Option<Vec<f64>> {
    match weights {
        Weights::None => None,
        Weights::Homogeneous(weights) | Weights::FixedGrid(weights) => Some(weights.clone()),
    }
}
