//! A job that a message asks for: it becomes what its JSON would have become, so that both are
//! validated by the same code.

use bytes::Bytes;
use prost::DecodeError;

use super::bounds::{self, Bounded, check_count};
use super::fields::Layout;
use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method;
use super::names::{known, some};
use super::stream;
use crate::api::json::numbers::{MAX_DIMENSION, PointGrid, PointList, RuleOrNumbers, WeightList};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::values::{Count, Number};
use crate::api::json::request::basis::{BasisKind, BasisRequest, KnotRule, ParameterRule};
use crate::api::json::request::job::{JobRequest, ValidJob};
use crate::api::json::request::mistakes::Mistakes;
use crate::api::json::request::shape::{CurveRequest, SurfaceRequest};
use crate::api::json::request::stop::StopRequest;
use crate::api::json::request::weights::RationalRequest;
use crate::api::problem::{Kind, Problem};
use crate::api::text;
use crate::config::Config;
use crate::fit::lane::Lane;
use crate::fit::points::Points;

/// Reads a message from the body of a request.
pub fn decode<M: Bounded>(body: Bytes, most_points: usize) -> Result<M, Problem> {
    text::check_compression(&body, true)?;
    bounds::check::<M>(&body, most_points)?;
    M::decode(body).map_err(|error| Problem::new(Kind::NotProtobuf, unreadable(&error)))
}

/// How the texts of decoding errors end, and what they mean. The texts are all that prost tells about an error:
/// its kind is private. Where a later version says something else, the reason is given in general words.
const BROKEN: [(&str, &str); 6] = [
    ("buffer underflow", "it ends too soon"),
    (
        "delimited length exceeded",
        "a field is longer than what it is in",
    ),
    (
        "recursion limit reached",
        "messages stand within one another too often",
    ),
    ("data is not UTF-8 encoded", "a text is not UTF-8"),
    ("invalid tag value: 0", "a field has the number 0"),
    ("invalid varint", "a number is malformed"),
];

/// Why bytes are no message, in plain words.
fn unreadable(error: &DecodeError) -> String {
    let text = error.to_string();
    let text = text
        .strip_prefix("failed to decode Protobuf message: ")
        .unwrap_or(&text);
    let known = BROKEN.iter().find(|(end, _)| text.ends_with(end));
    let reason = known.map_or("a field has another type", |(_, plain)| plain);
    // Fields that are known stand before the reason: "JobInput.geometry: ".
    match text.split_once(": ") {
        Some((place, _)) if place.contains('.') => format!("{place} cannot be read: {reason}"),
        _ => format!("the message cannot be read: {reason}"),
    }
}

/// The job, if it can be computed. Fields of errors are relative to the message.
pub fn validate(input: pb::JobInput, config: &Config) -> Result<ValidJob, Problem> {
    let layout = Layout::of(&input);
    let request = job(input, config.max_points)?;
    let valid = request.validate(config);
    valid.map_err(|problem| layout.name(problem))
}

fn job(input: pb::JobInput, most_points: usize) -> Result<JobRequest, Problem> {
    let mut mistakes = Mistakes::default();
    let (curve, surface) = match input.geometry {
        None => (None, None),
        Some(Geometry::Curve(it)) => (mistakes.keep(curve(it, most_points)), None),
        Some(Geometry::Surface(it)) => (None, mistakes.keep(surface(it, most_points))),
    };
    let stream = input.stream.map(stream::spec).transpose();
    let stream = mistakes.keep(stream.map_err(|problem| problem.within("stream")));
    let rational = mistakes.keep(rational(input.rational));
    let method = mistakes.keep(method::request(input.method, most_points));
    if !mistakes.none() {
        return Err(mistakes.problem());
    }
    Ok(JobRequest {
        name: input.name,
        curve,
        surface,
        rational: rational.flatten(),
        method: method.flatten(),
        stop: stop(input.stop),
        stream: stream.flatten(),
    })
}

fn curve(curve: pb::Curve, most: usize) -> Result<CurveRequest, Problem> {
    let points = points(curve.dimension, &curve.points, most, "curve")?;
    Ok(CurveRequest {
        points: PointList(points),
        basis: basis(curve.basis, "curve.basis")?,
        degree: None,
        parameters: parameters(curve.parameters, "curve.parameters")?,
        weights: some(curve.weights).map(WeightList::Line),
        closed: Some(curve.closed),
    })
}

fn surface(surface: pb::Surface, most: usize) -> Result<SurfaceRequest, Problem> {
    let (rows, columns) = (surface.rows as usize, surface.columns as usize);
    let points = points(surface.dimension, &surface.points, most, "surface")?;
    let count = rows.checked_mul(columns);
    if count != Some(points.len()) {
        let given = points.len();
        let detail = format!("{given} points for {rows} rows of {columns} points");
        return Err(Problem::at_field("surface.points", detail));
    }
    let missing = missing(&surface.missing, points.len())?;
    let (u, v) = (surface.u.unwrap_or_default(), surface.v.unwrap_or_default());
    let weights = Weights {
        values: surface.weights,
        u: u.weights,
        v: v.weights,
    };
    let basis = |it, field| {
        Ok::<_, Problem>(basis(it, field)?.unwrap_or(BasisRequest::of(BasisKind::Bspline)))
    };
    let parameters = |it, field| {
        let usual = RuleOrNumbers::Rule(ParameterRule::ChordLength);
        Ok::<_, Problem>(parameters(it, field)?.unwrap_or(usual))
    };
    Ok(SurfaceRequest {
        points: PointGrid {
            points,
            missing,
            rows,
            columns,
        },
        basis: Some(PerDirection::Each {
            u: basis(u.basis, "surface.u.basis")?,
            v: basis(v.basis, "surface.v.basis")?,
        }),
        degree: None,
        parameters: Some(PerDirection::Each {
            u: parameters(u.parameters, "surface.u.parameters")?,
            v: parameters(v.parameters, "surface.v.parameters")?,
        }),
        weights: weights.of_surface(rows, columns, "surface.weights")?,
        closed: Some(PerDirection::Each {
            u: u.closed,
            v: v.closed,
        }),
    })
}

/// Flat coordinates as points.
fn points(dimension: u32, flat: &[f64], most: usize, root: &str) -> Result<Points, Problem> {
    let dimension = dimension as usize;
    if !(1..=MAX_DIMENSION).contains(&dimension) {
        let detail = format!("points have 1 to {MAX_DIMENSION} coordinates, not {dimension}");
        return Err(Problem::at_field(format!("{root}.dimension"), detail));
    }
    if !flat.len().is_multiple_of(dimension) {
        let count = flat.len();
        let detail = format!("{count} numbers are no points of {dimension} coordinates");
        return Err(Problem::at_field(format!("{root}.points"), detail));
    }
    let count = flat.len() / dimension;
    check_count(count, most, "points", &format!("{root}.points"))?;
    let lane = |c| -> Lane { flat.iter().skip(c).step_by(dimension).copied().collect() };
    Ok(Points::from_lanes((0..dimension).map(lane)))
}

fn missing(indices: &[u32], count: usize) -> Result<Vec<usize>, Problem> {
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
        return Err(Problem::at_field(format!("surface.missing[{k}]"), wrong));
    }
    Ok(missing)
}

/// Weights of a surface: for each point, or factors of the directions.
pub(in crate::api) struct Weights {
    pub(in crate::api) values: Vec<f64>,
    pub(in crate::api) u: Vec<f64>,
    pub(in crate::api) v: Vec<f64>,
}

impl Weights {
    /// `field` is that of the weights for each point.
    pub(in crate::api) fn of_surface(
        self,
        rows: usize,
        columns: usize,
        field: &str,
    ) -> Result<Option<PerDirection<WeightList>>, Problem> {
        let Self { values, u, v } = self;
        let wrong = |detail: String| Err(Problem::at_field(field, detail));
        match (values.is_empty(), u.is_empty() && v.is_empty()) {
            (true, true) => Ok(None),
            (false, false) => {
                wrong("weights of points and of directions exclude each other".into())
            }
            (true, false) => Ok(Some(PerDirection::Each {
                u: WeightList::Line(u),
                v: WeightList::Line(v),
            })),
            (false, true) if values.len() != rows * columns => {
                let given = values.len();
                wrong(format!(
                    "{given} weights for {rows} rows of {columns} points"
                ))
            }
            (false, true) => Ok(Some(PerDirection::Both(WeightList::Grid {
                values,
                columns,
            }))),
        }
    }
}

fn basis(basis: Option<pb::Basis>, field: &str) -> Result<Option<BasisRequest>, Problem> {
    let Some(basis) = basis else { return Ok(None) };
    let kind = match known(basis.kind, &format!("{field}.kind"))? {
        pb::BasisKind::Unspecified | pb::BasisKind::Bspline => BasisKind::Bspline,
        pb::BasisKind::Bernstein => BasisKind::Bernstein,
        pb::BasisKind::SaidBall => BasisKind::SaidBall,
        pb::BasisKind::WangBall => BasisKind::WangBall,
    };
    let rule = match known(basis.knot_rule, &format!("{field}.knot_rule"))? {
        pb::KnotRule::Unspecified => Chosen::Any,
        pb::KnotRule::Explicit => Chosen::Explicit,
        pb::KnotRule::Data => Chosen::Rule(KnotRule::Data, "data"),
        pb::KnotRule::Averaged => Chosen::Rule(KnotRule::Averaged, "averaged"),
    };
    Ok(Some(BasisRequest {
        kind,
        degree: basis.degree.map(|degree| Count(degree as usize)),
        knots: rule.of(basis.knots, &format!("{field}.knots"))?,
    }))
}

fn parameters(
    parameters: Option<pb::Parameters>,
    field: &str,
) -> Result<Option<RuleOrNumbers<ParameterRule>>, Problem> {
    let Some(parameters) = parameters else {
        return Ok(None);
    };
    let rule = match known(parameters.rule, &format!("{field}.rule"))? {
        pb::ParameterRule::Unspecified => Chosen::Any,
        pb::ParameterRule::Explicit => Chosen::Explicit,
        pb::ParameterRule::ChordLength => Chosen::Rule(ParameterRule::ChordLength, "chord_length"),
        pb::ParameterRule::Centripetal => Chosen::Rule(ParameterRule::Centripetal, "centripetal"),
        pb::ParameterRule::Uniform => Chosen::Rule(ParameterRule::Uniform, "uniform"),
    };
    rule.of(parameters.values, &format!("{field}.values"))
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
    fn of(self, numbers: Vec<f64>, field: &str) -> Result<Option<RuleOrNumbers<R>>, Problem> {
        match (self, numbers.is_empty()) {
            (Self::Any, true) => Ok(None),
            (Self::Any, false) | (Self::Explicit, _) => Ok(Some(RuleOrNumbers::Numbers(numbers))),
            (Self::Rule(rule, _), true) => Ok(Some(RuleOrNumbers::Rule(rule))),
            (Self::Rule(_, name), false) => {
                let detail = format!("numbers are given, but the rule is {name:?}");
                Err(Problem::at_field(field, detail))
            }
        }
    }
}

pub(in crate::api) fn rational(value: i32) -> Result<Option<RationalRequest>, Problem> {
    Ok(match known(value, "rational")? {
        pb::Rational::Unspecified => None,
        pb::Rational::Homogeneous => Some(RationalRequest::Homogeneous),
        pb::Rational::Fixed => Some(RationalRequest::Fixed),
    })
}

pub(in crate::api) fn stop(stop: Option<pb::StopRules>) -> Option<StopRequest> {
    let stop = stop?;
    let (tolerance, relative_tolerance) = match stop.rule {
        None => (None, None),
        Some(Rule::Tolerance(value)) => (Some(Number(value)), None),
        Some(Rule::RelativeTolerance(value)) => (None, Some(Number(value))),
    };
    // Too many for this machine are too many for any limit.
    let count = |count| Count(usize::try_from(count).unwrap_or(usize::MAX));
    Some(StopRequest {
        tolerance,
        relative_tolerance,
        max_iterations: stop.max_iterations.map(count),
    })
}
