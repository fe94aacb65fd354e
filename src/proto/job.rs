//! A job and its message, both ways.

use std::sync::Arc;

use super::ends::{self, flat};
use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method::{self, MethodTarget};
use super::stream;
use super::values::{check_count, count, known, some};
use crate::fit::basis::{Polynomial, knots::Knots};
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::method::Method;
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{Request, Tolerance, Weights};
use crate::fit::scattered::Scattered;
use crate::model::job::JobSpec;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::shape::{AxisSpec, BasisKind, BasisSpec, MAX_DIMENSION, ShapeSpec};
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
            ..axis(curve.basis, curve.parameters, curve.closed, "curve")?
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
    Ok(ShapeSpec {
        points,
        grid,
        missing,
        scattered,
        u: AxisSpec {
            ends: Ok(ends::spec(u.ends, (columns, dimension), "surface.u.ends")?),
            ..axis(u.basis, u.parameters, u.closed, "surface.u")?
        },
        v: Some(AxisSpec {
            ends: Ok(ends::spec(v.ends, (rows, dimension), "surface.v.ends")?),
            ..axis(v.basis, v.parameters, v.closed, "surface.v")?
        }),
        weights: Ok(surface_weights(weights, grid, "surface.weights")?),
    })
}

/// The parameters of scattered points.
fn scattered(parameters: pb::ScatteredParameters, grid: Grid) -> Result<Scattered, Mistake> {
    let pb::ScatteredParameters { projection, values } = parameters;
    if grid.is_rows() {
        let detail = "scattered points have one column, or neither rows nor columns";
        return Err(Mistake::at_text("surface.columns", detail));
    }
    let field = "surface.scattered.values";
    let plane = match known(projection, "surface.scattered.projection")? {
        pb::Projection::Unspecified if values.is_empty() => {
            let detail = "scattered points need parameters, or a projection";
            return Err(Mistake::at_text("surface.scattered", detail));
        }
        pb::Projection::Unspecified if !values.len().is_multiple_of(2) => {
            let count = values.len();
            let detail = format!("{count} numbers are no pairs u, v");
            return Err(Mistake::at_text(field, detail));
        }
        pb::Projection::Unspecified => {
            return Ok(Scattered::Given(Arc::new(Points::from_flat(2, &values))));
        }
        pb::Projection::Nearest => Scattered::Plane,
        pb::Projection::Xy => Scattered::Coordinates,
    };
    match values.is_empty() {
        true => Ok(plane),
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
    }
}

fn axis(
    basis: Option<pb::Basis>,
    parameters: Option<pb::Parameters>,
    closed: bool,
    root: &str,
) -> Result<AxisSpec, Mistake> {
    Ok(AxisSpec {
        basis: Ok(self::basis(
            basis.unwrap_or_default(),
            &format!("{root}.basis"),
        )?),
        parameters: self::parameters(
            parameters.unwrap_or_default(),
            &format!("{root}.parameters"),
        )?,
        closed,
        ends: Ok(None),
    })
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

fn basis(basis: pb::Basis, field: &str) -> Result<BasisSpec, Mistake> {
    let kind = match known(basis.kind, &format!("{field}.kind"))? {
        pb::BasisKind::Unspecified | pb::BasisKind::Bspline => BasisKind::Bspline,
        pb::BasisKind::Bernstein => BasisKind::Bernstein,
        pb::BasisKind::SaidBall => BasisKind::SaidBall,
        pb::BasisKind::WangBall => BasisKind::WangBall,
    };
    let rule = match known(basis.knot_rule, &format!("{field}.knot_rule"))? {
        pb::KnotRule::Unspecified => Chosen::Any,
        pb::KnotRule::Explicit => Chosen::Explicit,
        pb::KnotRule::Data => Chosen::Rule(Knots::Data, "data"),
        pb::KnotRule::Averaged => Chosen::Rule(Knots::Averaged, "averaged"),
        pb::KnotRule::Spread => Chosen::Rule(Knots::Spread, "spread"),
        pb::KnotRule::PieglTiller => Chosen::Rule(Knots::PieglTiller, "piegl_tiller"),
    };
    Ok(BasisSpec {
        kind,
        degree: basis.degree.map(|degree| degree as usize),
        knots: rule.of(basis.knots, Knots::Explicit, &format!("{field}.knots"))?,
    })
}

fn parameters(parameters: pb::Parameters, field: &str) -> Result<Parametrization, Mistake> {
    let rule = match known(parameters.rule, &format!("{field}.rule"))? {
        pb::ParameterRule::Unspecified => Chosen::Any,
        pb::ParameterRule::Explicit => Chosen::Explicit,
        pb::ParameterRule::ChordLength => {
            Chosen::Rule(Parametrization::ChordLength, "chord_length")
        }
        pb::ParameterRule::Centripetal => Chosen::Rule(Parametrization::Centripetal, "centripetal"),
        pb::ParameterRule::Uniform => Chosen::Rule(Parametrization::Uniform, "uniform"),
    };
    let field = format!("{field}.values");
    let chosen = rule.of(parameters.values, Parametrization::Explicit, &field)?;
    Ok(chosen.unwrap_or(Parametrization::ChordLength))
}

/// The rule by which numbers are chosen.
enum Chosen<R> {
    /// As the numbers say, if there are any.
    Any,
    Explicit,
    /// A rule, and its name.
    Rule(R, &'static str),
}

impl<R> Chosen<R> {
    fn of(
        self,
        numbers: Vec<f64>,
        explicit: impl Fn(Arc<Vec<f64>>) -> R,
        field: &str,
    ) -> Result<Option<R>, Mistake> {
        match (self, numbers.is_empty()) {
            (Self::Any, true) => Ok(None),
            (Self::Any, false) | (Self::Explicit, _) => Ok(Some(explicit(Arc::new(numbers)))),
            (Self::Rule(rule, _), true) => Ok(Some(rule)),
            (Self::Rule(_, name), false) => {
                let detail = format!("numbers are given, but the rule is {name:?}");
                Err(Mistake::at_text(field, detail))
            }
        }
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
            rule: Some(match request.tolerance {
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
        basis: Some(basis_message(&request.u.basis)),
        parameters: Some(parameters_message(&request.u.parameters)),
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
        basis: Some(basis_message(&choice.basis)),
        parameters: (!scattered).then(|| parameters_message(&choice.parameters)),
        closed: choice.closed,
        weights: choice.weights.clone().unwrap_or_default(),
        ends: choice.ends.as_ref().map(ends::message),
    }
}

fn basis_message(choice: &BasisChoice) -> pb::Basis {
    let kind = basis_kind(choice).into();
    let BasisChoice::BSpline { degree, knots } = choice else {
        return pb::Basis {
            kind,
            ..pb::Basis::default()
        };
    };
    let (rule, knots) = match knots {
        Knots::Usual => (pb::KnotRule::Unspecified, Vec::new()),
        Knots::Data => (pb::KnotRule::Data, Vec::new()),
        Knots::Averaged => (pb::KnotRule::Averaged, Vec::new()),
        Knots::Spread => (pb::KnotRule::Spread, Vec::new()),
        Knots::PieglTiller => (pb::KnotRule::PieglTiller, Vec::new()),
        Knots::Explicit(knots) => (pb::KnotRule::Explicit, knots.to_vec()),
    };
    pb::Basis {
        kind,
        degree: Some(count(*degree)),
        knot_rule: rule.into(),
        knots,
    }
}

fn parameters_message(choice: &Parametrization) -> pb::Parameters {
    let (rule, values) = match choice {
        Parametrization::ChordLength => (pb::ParameterRule::ChordLength, Vec::new()),
        Parametrization::Centripetal => (pb::ParameterRule::Centripetal, Vec::new()),
        Parametrization::Uniform => (pb::ParameterRule::Uniform, Vec::new()),
        Parametrization::Explicit(values) => (pb::ParameterRule::Explicit, values.to_vec()),
    };
    pb::Parameters {
        rule: rule.into(),
        values,
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

/// The kind of a basis that was asked for.
fn basis_kind(choice: &BasisChoice) -> pb::BasisKind {
    match choice {
        BasisChoice::BSpline { .. } => pb::BasisKind::Bspline,
        BasisChoice::Polynomial(Polynomial::Bernstein) => pb::BasisKind::Bernstein,
        BasisChoice::Polynomial(Polynomial::SaidBall) => pb::BasisKind::SaidBall,
        BasisChoice::Polynomial(Polynomial::WangBall) => pb::BasisKind::WangBall,
    }
}
