//! The JSON of a job, and its way to a fitting problem.

use serde::Deserialize;

use super::numbers::{NameOrNumbers, Number, PointGrid, PointList};
use super::per_direction::PerDirection;
use super::problem::{Kind, Problem};
use crate::config::Config;
use crate::fit::basis::knots::Knots;
use crate::fit::invalid::{Axis, Invalid, Place};
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{self as fit, BasisChoice, DirectionChoice, Tolerance};
use crate::fit::transform::Method;

const DEFAULT_DEGREE: usize = 3;
const DEFAULT_TOLERANCE: Tolerance = Tolerance::Relative(1e-6);
const DEFAULT_ITERATIONS: usize = 1000;
const LONGEST_NAME: usize = 200;

/// A job as clients write it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobRequest {
    name: Option<String>,
    curve: Option<CurveRequest>,
    surface: Option<SurfaceRequest>,
    method: Option<MethodRequest>,
    #[serde(default)]
    stop: StopRequest,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveRequest {
    points: PointList,
    basis: Option<BasisRequest>,
    parameters: Option<NameOrNumbers>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceRequest {
    points: PointGrid,
    basis: Option<PerDirection<BasisRequest>>,
    parameters: Option<PerDirection<NameOrNumbers>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BasisRequest {
    kind: BasisKind,
    degree: Option<usize>,
    knots: Option<NameOrNumbers>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum BasisKind {
    Bspline,
    Bernstein,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MethodRequest {
    kind: MethodKind,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum MethodKind {
    Global,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct StopRequest {
    tolerance: Option<Number>,
    relative_tolerance: Option<Number>,
    max_iterations: Option<usize>,
}

/// A job that can be computed.
#[derive(Debug)]
pub struct ValidJob {
    /// The client's name for it.
    pub name: Option<String>,
    /// The problem.
    pub problem: fit::Problem,
}

impl JobRequest {
    /// Checks the request against the limits and the mathematics.
    pub fn validate(self, config: &Config) -> Result<ValidJob, Problem> {
        if let Some(name) = &self.name
            && name.chars().count() > LONGEST_NAME
        {
            let detail = format!("the name is longer than {LONGEST_NAME} characters");
            return Err(invalid("/name", detail));
        }
        let shape = match (self.curve, self.surface) {
            (Some(curve), None) => curve.shape()?,
            (None, Some(surface)) => surface.shape()?,
            (None, None) => return Err(invalid("", "a curve or a surface is needed")),
            (Some(_), Some(_)) => {
                let detail = "the job has a curve, so it cannot have a surface as well";
                return Err(invalid("/surface", detail));
            }
        };
        check_count(&shape, config.max_points)?;
        let (tolerance, max_iterations) = self.stop.rules(config.max_iterations)?;
        let method = match self.method.map(|method| method.kind) {
            None | Some(MethodKind::Global) => Method::Global,
        };
        let places = shape.places;
        let request = fit::Request {
            points: shape.points,
            grid: shape.grid,
            u: shape.u,
            v: shape.v,
            method,
            tolerance,
            max_iterations,
        };
        let problem = fit::Problem::new(request)
            .map_err(|error| invalid(&places.pointer(&error), error.to_string()))?;
        Ok(ValidJob {
            name: self.name,
            problem,
        })
    }
}

/// What curves and surfaces have in common.
struct Shape {
    points: Points,
    grid: Grid,
    u: DirectionChoice,
    v: Option<DirectionChoice>,
    places: Places,
}

impl CurveRequest {
    fn shape(self) -> Result<Shape, Problem> {
        let PointList(points) = self.points;
        let grid = Grid {
            rows: points.len(),
            columns: 1,
        };
        Ok(Shape {
            points,
            grid,
            u: DirectionChoice {
                basis: basis(self.basis, "/curve/basis")?,
                parameters: parametrization(self.parameters, "/curve/parameters")?,
            },
            v: None,
            places: Places {
                surface_columns: None,
                basis_each: false,
                parameters_each: false,
            },
        })
    }
}

impl SurfaceRequest {
    fn shape(self) -> Result<Shape, Problem> {
        let PointGrid {
            points,
            rows,
            columns,
        } = self.points;
        let places = Places {
            surface_columns: Some(columns),
            basis_each: self.basis.as_ref().is_some_and(PerDirection::is_each),
            parameters_each: self.parameters.as_ref().is_some_and(PerDirection::is_each),
        };
        let (basis_u, basis_v) = self.basis.map(PerDirection::split).unzip();
        let (parameters_u, parameters_v) = self.parameters.map(PerDirection::split).unzip();
        let direction = |axis, basis_request, parameters| {
            Ok::<_, Problem>(DirectionChoice {
                basis: basis(basis_request, &places.basis(axis))?,
                parameters: parametrization(parameters, &places.parameters(axis))?,
            })
        };
        Ok(Shape {
            points,
            grid: Grid { rows, columns },
            u: direction(Axis::U, basis_u, parameters_u)?,
            v: Some(direction(Axis::V, basis_v, parameters_v)?),
            places,
        })
    }
}

fn basis(request: Option<BasisRequest>, pointer: &str) -> Result<BasisChoice, Problem> {
    let Some(request) = request else {
        return Ok(BasisChoice::BSpline {
            degree: DEFAULT_DEGREE,
            knots: Knots::Data,
        });
    };
    match request.kind {
        BasisKind::Bspline => Ok(BasisChoice::BSpline {
            degree: request.degree.unwrap_or(DEFAULT_DEGREE),
            knots: knots(request.knots, pointer)?,
        }),
        BasisKind::Bernstein => {
            let given = request.degree.map(|_| "degree");
            match given.or(request.knots.map(|_| "knots")) {
                None => Ok(BasisChoice::Bernstein),
                Some(field) => Err(invalid(
                    &format!("{pointer}/{field}"),
                    format!("a bernstein basis has no {field} to choose: its degree is points − 1"),
                )),
            }
        }
    }
}

fn knots(request: Option<NameOrNumbers>, basis: &str) -> Result<Knots, Problem> {
    match request {
        None => Ok(Knots::Data),
        Some(NameOrNumbers::Numbers(knots)) => Ok(Knots::Explicit(knots)),
        Some(NameOrNumbers::Name(name)) => match name.as_str() {
            "data" => Ok(Knots::Data),
            "averaged" => Ok(Knots::Averaged),
            _ => Err(invalid(
                &format!("{basis}/knots"),
                format!("knots are \"data\", \"averaged\" or a list of numbers, not {name:?}"),
            )),
        },
    }
}

fn parametrization(
    request: Option<NameOrNumbers>,
    pointer: &str,
) -> Result<Parametrization, Problem> {
    match request {
        None => Ok(Parametrization::ChordLength),
        Some(NameOrNumbers::Numbers(values)) => Ok(Parametrization::Explicit(values)),
        Some(NameOrNumbers::Name(name)) => match name.as_str() {
            "chord_length" => Ok(Parametrization::ChordLength),
            "centripetal" => Ok(Parametrization::Centripetal),
            "uniform" => Ok(Parametrization::Uniform),
            _ => Err(invalid(
                pointer,
                format!(
                    "parameters are \"chord_length\", \"centripetal\", \"uniform\" or a list of numbers, not {name:?}"
                ),
            )),
        },
    }
}

impl StopRequest {
    fn rules(&self, most_iterations: usize) -> Result<(Tolerance, usize), Problem> {
        let tolerance = match (self.tolerance, self.relative_tolerance) {
            (None, None) => DEFAULT_TOLERANCE,
            (Some(Number(value)), None) => Tolerance::Absolute(value),
            (None, Some(Number(value))) => Tolerance::Relative(value),
            (Some(_), Some(_)) => {
                let detail = "tolerance is given, so relative_tolerance cannot be";
                return Err(invalid("/stop/relative_tolerance", detail));
            }
        };
        let max_iterations = self
            .max_iterations
            .unwrap_or(DEFAULT_ITERATIONS.min(most_iterations));
        if max_iterations > most_iterations {
            let detail = format!(
                "{max_iterations} iterations are more than {most_iterations}, the limit of this server"
            );
            return Err(invalid("/stop/max_iterations", detail));
        }
        Ok((tolerance, max_iterations))
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

/// Where in the request the parts of a problem stand.
#[derive(Clone, Copy)]
struct Places {
    /// The number of columns of a surface; `None` for a curve.
    surface_columns: Option<usize>,
    basis_each: bool,
    parameters_each: bool,
}

impl Places {
    fn root(&self) -> &'static str {
        match self.surface_columns {
            None => "/curve",
            Some(_) => "/surface",
        }
    }

    fn part(&self, name: &str, each: bool, axis: Axis) -> String {
        let direction = match (each, axis) {
            (false, _) => "",
            (true, Axis::U) => "/u",
            (true, Axis::V) => "/v",
        };
        format!("{}/{name}{direction}", self.root())
    }

    fn basis(&self, axis: Axis) -> String {
        self.part("basis", self.basis_each, axis)
    }

    fn parameters(&self, axis: Axis) -> String {
        self.part("parameters", self.parameters_each, axis)
    }

    /// The JSON pointer to what is wrong.
    fn pointer(&self, error: &Invalid) -> String {
        let points = format!("{}/points", self.root());
        match error.place() {
            Place::Points => points,
            Place::Point(index) => match self.surface_columns {
                None => format!("{points}/{index}"),
                Some(columns) => format!("{points}/{}/{}", index / columns, index % columns),
            },
            Place::Line(Axis::U, index) => format!("{points}/{index}"),
            Place::Line(Axis::V, index) => format!("{points}/0/{index}"),
            Place::Basis(axis) => self.basis(axis),
            Place::Degree(axis) => format!("{}/degree", self.basis(axis)),
            Place::Knots(axis) => format!("{}/knots", self.basis(axis)),
            Place::Knot(axis, index) => format!("{}/knots/{index}", self.basis(axis)),
            Place::Parameters(axis) => self.parameters(axis),
            Place::Parameter(axis, index) => format!("{}/{index}", self.parameters(axis)),
            Place::Tolerance => "/stop/tolerance".to_owned(),
            Place::RelativeTolerance => "/stop/relative_tolerance".to_owned(),
        }
    }
}
