//! The JSON of a job, and its way to a fitting problem.

pub mod edit;
pub(in crate::api) mod method;
pub(in crate::api) mod mistakes;
pub(in crate::api) mod places;
mod schema;

use std::sync::Arc;

use schemars::JsonSchema;

use super::numbers::{PointGrid, PointList, RuleOrNumbers, WeightList};
use super::per_direction::PerDirection;
use super::read::values::{Count, LONGEST_TEXT, Number};
use super::read::{Read, names, object};
use super::schema::numbers::{SurfaceWeights, Weights as CurveWeights};
use crate::api::problem::{Kind, Problem};
use crate::api::stream::options;
use crate::config::Config;
use crate::fit::basis::{MAX_DEGREE, Polynomial, knots::Knots};
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::invalid::Axis;
use crate::fit::method::Method;
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{self as fit, Tolerance, Weights};
use crate::model::stream::StreamSpec;
use method::MethodRequest;
use mistakes::Mistakes;
use places::Places;

const DEFAULT_DEGREE: usize = 3;
const DEFAULT_TOLERANCE: Tolerance = Tolerance::Relative(1e-6);
const DEFAULT_ITERATIONS: usize = 1000;
const LONGEST_NAME: usize = LONGEST_TEXT;

/// A fit of a curve or of a surface. Fields that are not known are refused.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(transform = schema::job, example = schema::example_job())]
pub struct JobRequest {
    /// A name for people. Answers and files repeat it.
    #[schemars(length(max = LONGEST_NAME), example = &"wing section")]
    pub(in crate::api) name: Option<String>,
    /// The curve to fit.
    pub(in crate::api) curve: Option<CurveRequest>,
    /// The surface to fit.
    pub(in crate::api) surface: Option<SurfaceRequest>,
    /// How weights are used; only with weights.
    pub(in crate::api) rational: Option<RationalRequest>,
    /// The method; without one `global`.
    pub(in crate::api) method: Option<MethodRequest>,
    /// When the iteration ends.
    pub(in crate::api) stop: Option<StopRequest>,
    /// What the event streams of the job are like if they do not say it themselves.
    pub(in crate::api) stream: Option<StreamSpec>,
}

/// A curve through data points.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "CurveInput", example = schema::example_curve())]
pub(in crate::api) struct CurveRequest {
    /// The data points, in their order.
    pub(in crate::api) points: PointList,
    /// The basis; without one a cubic B-spline.
    pub(in crate::api) basis: Option<BasisRequest>,
    /// Short for a B-spline of this degree, instead of `basis`.
    #[schemars(range(min = 1, max = MAX_DEGREE))]
    pub(in crate::api) degree: Option<Count>,
    /// The parameters of the data points; without them `chord_length`.
    #[schemars(with = "Option<schema::Parameters>")]
    pub(in crate::api) parameters: Option<RuleOrNumbers<ParameterRule>>,
    /// Weights of the data points, for a rational curve.
    #[schemars(with = "Option<CurveWeights>")]
    pub(in crate::api) weights: Option<WeightList>,
    /// Whether the curve is a periodic B-spline, which returns to its first point.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<bool>,
}

/// A surface through a grid of data points. `basis`, `parameters` and `closed` are one value for
/// both directions, or one for each.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "SurfaceInput", example = schema::example_surface())]
pub(in crate::api) struct SurfaceRequest {
    /// Rows (u) of columns (v) of data points.
    pub(in crate::api) points: PointGrid,
    /// The bases; without them cubic B-splines.
    pub(in crate::api) basis: Option<PerDirection<BasisRequest>>,
    /// Short for B-splines of this degree, instead of `basis`.
    #[schemars(with = "Option<PerDirection<schema::Degree>>")]
    pub(in crate::api) degree: Option<PerDirection<Count>>,
    /// The parameters of the data points; without them `chord_length`.
    #[schemars(with = "Option<PerDirection<schema::Parameters>>")]
    pub(in crate::api) parameters: Option<PerDirection<RuleOrNumbers<ParameterRule>>>,
    /// Weights of the data points, for a rational surface.
    #[schemars(with = "Option<SurfaceWeights>")]
    pub(in crate::api) weights: Option<PerDirection<WeightList>>,
    /// Whether the directions are periodic.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<PerDirection<bool>>,
}

/// The functions that are blended with the control points.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "Basis", transform = schema::basis, example = schema::example_basis())]
pub(in crate::api) struct BasisRequest {
    /// The kind of the basis.
    pub(in crate::api) kind: BasisKind,
    /// The degree.
    #[schemars(range(min = 1, max = MAX_DEGREE), extend("default" = DEFAULT_DEGREE))]
    pub(in crate::api) degree: Option<Count>,
    /// Where the pieces meet.
    #[schemars(with = "Option<schema::KnotChoice>")]
    pub(in crate::api) knots: Option<RuleOrNumbers<KnotRule>>,
}

/// A kind of basis.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(example = &"bspline")]
pub(in crate::api) enum BasisKind {
    Bspline,
    Bernstein,
    SaidBall,
    WangBall,
}

/// How weights are used: in homogeneous coordinates, so that the weights of the control points
/// evolve with them, or as a part of the basis, so that they stay.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "Rational", example = &"homogeneous")]
pub(in crate::api) enum RationalRequest {
    Homogeneous,
    Fixed,
}

/// Where the knots of a B-spline are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum KnotRule {
    Data,
    Averaged,
}

/// How data points get their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum ParameterRule {
    ChordLength,
    Centripetal,
    Uniform,
}

/// When the iteration ends. There is one of the tolerances, or none.
#[derive(Debug, Default, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "StopRules", example = schema::example_stop())]
pub(in crate::api) struct StopRequest {
    /// The largest allowed distance from a data point, in data units.
    #[schemars(range(min = 0))]
    pub(in crate::api) tolerance: Option<Number>,
    /// The same as a part of the diagonal of the bounding box of the data.
    #[schemars(range(min = 0), extend("default" = 1e-6))]
    pub(in crate::api) relative_tolerance: Option<Number>,
    /// The last iteration that is computed. Servers have a limit, which /v1/capabilities tells.
    #[schemars(extend("default" = DEFAULT_ITERATIONS))]
    pub(in crate::api) max_iterations: Option<Count>,
}

object!(
    JobRequest,
    "an object",
    [name, curve, surface, rational, method, stop, stream]
);
object!(
    CurveRequest,
    "an object with points",
    [points, basis, degree, parameters, weights, closed]
);
object!(
    SurfaceRequest,
    "an object with points",
    [points, basis, degree, parameters, weights, closed]
);
object!(
    BasisRequest,
    "an object with a kind, or the name of a kind",
    [kind, degree, knots],
    of_name: |name, at| BasisKind::reader().text(name, at).map(BasisRequest::of)
);
object!(
    StopRequest,
    "an object",
    [tolerance, relative_tolerance, max_iterations]
);
names!(BasisKind, "kind of basis", [
    "bspline" => Bspline,
    "bernstein" => Bernstein,
    "said_ball" => SaidBall,
    "wang_ball" => WangBall,
]);
names!(RationalRequest, "use of weights", [
    "homogeneous" => Homogeneous,
    "fixed" => Fixed,
]);
names!(KnotRule, "rule for knots", ["data" => Data, "averaged" => Averaged]);
names!(ParameterRule, "rule for parameters", [
    "chord_length" => ChordLength,
    "centripetal" => Centripetal,
    "uniform" => Uniform,
]);

/// A job that can be computed.
#[derive(Debug)]
pub struct ValidJob {
    /// The client's name for it.
    pub name: Option<String>,
    /// How its streams go if they do not say it themselves.
    pub stream: Option<Arc<StreamSpec>>,
    /// The problem.
    pub problem: fit::Problem,
}

impl JobRequest {
    /// Checks the request against the limits and the mathematics.
    pub fn validate(self, config: &Config) -> Result<ValidJob, Problem> {
        let mut mistakes = Mistakes::default();
        mistakes.keep(check_name(self.name.as_deref()));
        let rational = self.rational;
        let surface = self.surface.is_some();
        let shape = match (self.curve, self.surface) {
            (Some(curve), None) => curve.shape(rational, &mut mistakes),
            (None, Some(surface)) => surface.shape(rational, &mut mistakes),
            (None, None) => mistakes.keep(Err(invalid("", "a curve or a surface is needed"))),
            (Some(_), Some(_)) => {
                let detail = "the job has a curve, so it cannot have a surface as well";
                mistakes.keep(Err(invalid("/surface", detail)))
            }
        };
        let shape = shape.and_then(|shape| {
            let count = check_count(&shape, config.max_points);
            mistakes.keep(count).map(|()| shape)
        });
        let stop = self.stop.unwrap_or_default();
        let stop = mistakes.keep(stop.rules(config.max_iterations));
        let stream = self.stream.as_ref();
        let stream = stream.map(|stream| options::check(stream, surface));
        mistakes.keep(stream.transpose().map_err(Problem::from));
        let Some(mut shape) = shape else {
            let settings = self.method.map(|method| method.check_settings());
            mistakes.keep(settings.transpose());
            return Err(mistakes.problem());
        };
        let method = match self.method {
            None => Some((Method::Global, None)),
            Some(method) => {
                shape.places.control_points_each = method.has_control_points_each();
                mistakes.keep(method.method(shape.grid, shape.v.is_some()))
            }
        };
        let Some((method, selected)) = method else {
            return Err(mistakes.problem());
        };
        // The points and the basis may be wrong beside what was found so far.
        let (tolerance, max_iterations) = stop.unwrap_or((DEFAULT_TOLERANCE, 0));
        let places = shape.places;
        let request = fit::Request {
            points: Arc::new(shape.points),
            grid: shape.grid,
            missing: shape.missing,
            u: shape.u,
            v: shape.v,
            weights: shape.weights,
            method,
            selected,
            start: None,
            lambda_min: None,
            tolerance,
            max_iterations,
        };
        let problem = mistakes.fit(request, |error| places.pointer(error));
        let problem = problem.filter(|_| mistakes.none());
        let Some(problem) = problem else {
            return Err(mistakes.problem());
        };
        Ok(ValidJob {
            name: self.name,
            stream: fitting_stream(self.stream, &problem)?,
            problem,
        })
    }
}

/// How the streams of a job go, if its data can be sent like that.
fn fitting_stream(
    stream: Option<StreamSpec>,
    problem: &fit::Problem,
) -> Result<Option<Arc<StreamSpec>>, Problem> {
    let request = StreamSpec::default();
    options::check_range(&request, stream.as_ref(), problem)?;
    Ok(stream.map(Arc::new))
}

fn check_name(name: Option<&str>) -> Result<(), Problem> {
    match name {
        Some(name) if name.chars().count() > LONGEST_NAME => {
            let detail = format!("the name is longer than {LONGEST_NAME} characters");
            Err(invalid("/name", detail))
        }
        _ => Ok(()),
    }
}

impl BasisRequest {
    /// A basis of this kind, with its usual degree and knots.
    pub(in crate::api) fn of(kind: BasisKind) -> Self {
        Self {
            kind,
            degree: None,
            knots: None,
        }
    }

    /// A B-spline of this degree.
    fn of_degree(degree: Count) -> Self {
        Self {
            degree: Some(degree),
            ..Self::of(BasisKind::Bspline)
        }
    }
}

/// A degree that stands instead of a basis does not stand beside one.
fn check_degree(degree: bool, basis: bool, root: &str) -> Result<(), Problem> {
    if degree && basis {
        let detail = "a basis is given, which has its degree itself";
        return Err(invalid(&format!("{root}/degree"), detail));
    }
    Ok(())
}

/// What curves and surfaces have in common.
struct Shape {
    points: Points,
    grid: Grid,
    u: DirectionChoice,
    v: Option<DirectionChoice>,
    missing: Vec<usize>,
    weights: Weights,
    places: Places,
}

impl CurveRequest {
    /// What there is of it, also if there are mistakes beside the points.
    fn shape(self, rational: Option<RationalRequest>, mistakes: &mut Mistakes) -> Option<Shape> {
        let degree = check_degree(self.degree.is_some(), self.basis.is_some(), "/curve");
        mistakes.keep(degree);
        let short = self.degree.is_some();
        let of_degree = self.degree.map(BasisRequest::of_degree);
        let PointList(points) = self.points;
        let grid = Grid {
            rows: points.len(),
            columns: 1,
        };
        let weights = mistakes.keep(curve_weights(self.weights, rational));
        let (weights, fixed) = weights.unwrap_or((Weights::None, None));
        let basis = mistakes.keep(basis(self.basis.or(of_degree), "/curve/basis"));
        Some(Shape {
            points,
            grid,
            u: DirectionChoice {
                basis: basis?,
                parameters: parametrization(self.parameters),
                closed: self.closed.unwrap_or(false),
                control_points: None,
                weights: fixed,
            },
            v: None,
            missing: Vec::new(),
            weights,
            places: Places {
                degree_alone: short,
                ..Places::default()
            },
        })
    }
}

impl SurfaceRequest {
    /// What there is of it, also if there are mistakes beside the points.
    fn shape(self, rational: Option<RationalRequest>, mistakes: &mut Mistakes) -> Option<Shape> {
        let degree = check_degree(self.degree.is_some(), self.basis.is_some(), "/surface");
        mistakes.keep(degree);
        let degree_alone = self.degree.is_some();
        let of_degree = self
            .degree
            .map(|degree| degree.map(BasisRequest::of_degree));
        let bases = self.basis.or(of_degree);
        let PointGrid {
            points,
            missing,
            rows,
            columns,
        } = self.points;
        let grid = Grid { rows, columns };
        let places = Places {
            surface_columns: Some(columns),
            degree_alone,
            basis_each: bases.as_ref().is_some_and(PerDirection::is_each),
            parameters_each: self.parameters.as_ref().is_some_and(PerDirection::is_each),
            closed_each: self.closed.is_some_and(|closed| closed.is_each()),
            weights_each: self.weights.as_ref().is_some_and(PerDirection::is_each),
            control_points_each: false,
        };
        let weights = surface_weights(self.weights, rational, grid, "/surface/weights");
        let weights = mistakes.keep(weights);
        let (weights, fixed) = weights.unwrap_or((Weights::None, None));
        let (basis_u, basis_v) = bases.map(PerDirection::split).unzip();
        let (parameters_u, parameters_v) = self.parameters.map(PerDirection::split).unzip();
        let (closed_u, closed_v) = self.closed.map(PerDirection::split).unzip();
        let (fixed_u, fixed_v) = fixed.unzip();
        let mut direction = |axis, request, parameters, closed: Option<bool>, weights| {
            let basis = mistakes.keep(basis(request, &places.basis(axis)));
            Some(DirectionChoice {
                basis: basis?,
                parameters: parametrization(parameters),
                closed: closed.unwrap_or(false),
                control_points: None,
                weights,
            })
        };
        let u = direction(Axis::U, basis_u, parameters_u, closed_u, fixed_u);
        let v = direction(Axis::V, basis_v, parameters_v, closed_v, fixed_v);
        Some(Shape {
            points,
            grid,
            u: u?,
            v: Some(v?),
            missing,
            weights,
            places,
        })
    }
}

/// Weights of a curve: of the data points, or fixed ones.
fn curve_weights(
    weights: Option<WeightList>,
    rational: Option<RationalRequest>,
) -> Result<(Weights, Option<Vec<f64>>), Problem> {
    let weights = match weights {
        None => None,
        Some(WeightList::Line(weights)) => Some(weights),
        Some(WeightList::Grid { .. }) => {
            let detail = "the weights of a curve are a list of numbers";
            return Err(invalid("/curve/weights", detail));
        }
    };
    match (rational, weights) {
        (None, None) => Ok((Weights::None, None)),
        (Some(_), None) => Err(no_weights()),
        (Some(RationalRequest::Fixed), Some(weights)) => Ok((Weights::None, Some(weights))),
        (_, Some(weights)) => Ok((Weights::Homogeneous(weights), None)),
    }
}

/// Fixed weights of both directions.
type FixedWeights = Option<(Vec<f64>, Vec<f64>)>;

/// Weights of a surface: a grid, or one list for each direction whose products they are.
fn surface_weights(
    weights: Option<PerDirection<WeightList>>,
    rational: Option<RationalRequest>,
    grid: Grid,
    pointer: &str,
) -> Result<(Weights, FixedWeights), Problem> {
    let Some(weights) = weights else {
        return match rational {
            None => Ok((Weights::None, None)),
            Some(_) => Err(no_weights()),
        };
    };
    let fixed = rational == Some(RationalRequest::Fixed);
    match weights {
        PerDirection::Both(WeightList::Grid { values, columns }) => {
            let rows = values.len() / columns.max(1);
            if (rows, columns) != (grid.rows, grid.columns) {
                let detail = format!(
                    "{rows} rows of {columns} weights for {} rows of {} points",
                    grid.rows, grid.columns
                );
                return Err(invalid(pointer, detail));
            }
            let weights = if fixed {
                Weights::FixedGrid(values)
            } else {
                Weights::Homogeneous(values)
            };
            Ok((weights, None))
        }
        PerDirection::Each {
            u: WeightList::Line(u),
            v: WeightList::Line(v),
        } => {
            if fixed {
                return Ok((Weights::None, Some((u, v))));
            }
            for (name, given, expected) in [("u", u.len(), grid.rows), ("v", v.len(), grid.columns)]
            {
                if given != expected {
                    let detail = format!("{given} weights for {expected} points");
                    return Err(invalid(&format!("{pointer}/{name}"), detail));
                }
            }
            for (name, weights) in [("u", &u), ("v", &v)] {
                let wrong = |w: &f64| !(*w > 0.0 && w.is_finite());
                if let Some(index) = weights.iter().position(wrong) {
                    let value = weights[index];
                    let detail =
                        format!("weight {index} is {value}; weights are finite and greater than 0");
                    return Err(invalid(&format!("{pointer}/{name}/{index}"), detail));
                }
            }
            let products = u.iter().flat_map(|u| v.iter().map(move |v| u * v));
            Ok((Weights::Homogeneous(products.collect()), None))
        }
        _ => {
            let detail =
                "the weights of a surface are rows of numbers, or {\"u\": […], \"v\": […]}";
            Err(invalid(pointer, detail))
        }
    }
}

fn no_weights() -> Problem {
    invalid(
        "/rational",
        "rational says how weights are used, but there are no weights",
    )
}

fn basis(request: Option<BasisRequest>, pointer: &str) -> Result<BasisChoice, Problem> {
    let Some(request) = request else {
        return Ok(BasisChoice::BSpline {
            degree: DEFAULT_DEGREE,
            knots: Knots::Usual,
        });
    };
    let kind = match request.kind {
        BasisKind::Bspline => {
            return Ok(BasisChoice::BSpline {
                degree: request
                    .degree
                    .map_or(DEFAULT_DEGREE, |Count(degree)| degree),
                knots: knots(request.knots),
            });
        }
        BasisKind::Bernstein => Polynomial::Bernstein,
        BasisKind::SaidBall => Polynomial::SaidBall,
        BasisKind::WangBall => Polynomial::WangBall,
    };
    let degree = request.degree.map(|_| "degree");
    let given = degree.into_iter().chain(request.knots.map(|_| "knots"));
    let wrong = given.map(|field| {
        let detail = format!(
            "a {} basis has no {field} to choose: its degree is control points − 1",
            kind.name()
        );
        invalid(&format!("{pointer}/{field}"), detail)
    });
    Problem::of_all(wrong).map_or(Ok(BasisChoice::Polynomial(kind)), Err)
}

fn knots(request: Option<RuleOrNumbers<KnotRule>>) -> Knots {
    match request {
        None => Knots::Usual,
        Some(RuleOrNumbers::Numbers(knots)) => Knots::Explicit(Arc::new(knots)),
        Some(RuleOrNumbers::Rule(KnotRule::Data)) => Knots::Data,
        Some(RuleOrNumbers::Rule(KnotRule::Averaged)) => Knots::Averaged,
    }
}

fn parametrization(request: Option<RuleOrNumbers<ParameterRule>>) -> Parametrization {
    match request {
        None => Parametrization::ChordLength,
        Some(RuleOrNumbers::Numbers(values)) => Parametrization::Explicit(Arc::new(values)),
        Some(RuleOrNumbers::Rule(rule)) => match rule {
            ParameterRule::ChordLength => Parametrization::ChordLength,
            ParameterRule::Centripetal => Parametrization::Centripetal,
            ParameterRule::Uniform => Parametrization::Uniform,
        },
    }
}

impl StopRequest {
    fn rules(&self, most_iterations: usize) -> Result<(Tolerance, usize), Problem> {
        let mut mistakes = Mistakes::default();
        let tolerance = match (self.tolerance, self.relative_tolerance) {
            (None, None) => Ok(DEFAULT_TOLERANCE),
            (Some(Number(value)), None) => Ok(Tolerance::Absolute(value)),
            (None, Some(Number(value))) => Ok(Tolerance::Relative(value)),
            (Some(_), Some(_)) => {
                let detail = "tolerance is given, so relative_tolerance cannot be";
                Err(invalid("/stop/relative_tolerance", detail))
            }
        };
        let tolerance = mistakes.keep(tolerance);
        let usual = DEFAULT_ITERATIONS.min(most_iterations);
        let max_iterations = self.max_iterations.map_or(usual, |Count(count)| count);
        if max_iterations > most_iterations {
            let detail = format!(
                "{max_iterations} iterations are more than {most_iterations}, the limit of this server"
            );
            mistakes.keep::<()>(Err(invalid("/stop/max_iterations", detail)));
        }
        match tolerance.filter(|_| mistakes.none()) {
            Some(tolerance) => Ok((tolerance, max_iterations)),
            None => Err(mistakes.problem()),
        }
    }
}

fn check_count(shape: &Shape, limit: usize) -> Result<(), Problem> {
    let count = shape.grid.count();
    if count > limit {
        let detail = format!("{count} points are more than {limit}, the limit of this server");
        return Err(invalid(&format!("{}/points", shape.places.root()), detail));
    }
    Ok(())
}

fn invalid(pointer: &str, detail: impl Into<String>) -> Problem {
    Problem::at_pointer(Kind::InvalidFit, pointer.to_owned(), detail)
}
