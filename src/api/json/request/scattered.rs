//! The JSON of the parameters of a surface: of points in a grid, or of scattered ones.

use std::fmt;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, json_schema};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Value, json};

use super::basis::{ParameterRule, Parameters};
use super::iteration::IterationRequest;
use crate::api::json::schema::schema_of;
use crate::fit::points::Points;
use crate::fit::scattered::Scattered;
use crate::model::either::{PerDirection, RuleOrNumbers, object};
use crate::model::named::{Named, names};
use crate::model::scattered::{BaseSpec, ScatteredSpec};

/// The parameters of the data points of a surface.
#[derive(Clone, Debug)]
pub(in crate::api) enum SurfaceParameters {
    /// Those of the rows and columns of a grid.
    Grid(PerDirection<RuleOrNumbers<ParameterRule>>),
    /// Those of scattered points.
    Scattered(ScatteredSpec),
}

/// The plane in which scattered points have their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum ProjectionPlane {
    Nearest,
    Xy,
}

names!(ProjectionPlane, "plane", [
    "nearest" => Nearest,
    "xy" => Xy,
]);

impl From<ProjectionPlane> for Scattered {
    fn from(plane: ProjectionPlane) -> Self {
        match plane {
            ProjectionPlane::Nearest => Self::Plane,
            ProjectionPlane::Xy => Self::Coordinates,
        }
    }
}

impl<'de> Deserialize<'de> for SurfaceParameters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParametersVisitor)
    }
}

struct ParametersVisitor;

impl<'de> Visitor<'de> for ParametersVisitor {
    type Value = SurfaceParameters;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rule = ParameterRule::expected();
        write!(
            f,
            "{rule}; or a list of numbers; or one for each direction, {{\"u\": …, \"v\": …}}; of scattered points pairs, [[u, v], …], \"project\" or foot_points"
        )
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<SurfaceParameters, E> {
        match name {
            "project" => Ok(own(Scattered::Plane)),
            rule => ParameterRule::read(rule).map(both),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<SurfaceParameters, A::Error> {
        let (mut numbers, mut pairs) = (Vec::new(), Points::new(2));
        while let Some(parameter) = list.next_element_seed(Next(&numbers, &pairs))? {
            match parameter {
                Parameter::Number(t) => numbers.push(t),
                Parameter::Pair(pair) => pairs.push(&pair),
            }
        }
        Ok(if pairs.is_empty() {
            let numbers = RuleOrNumbers::Numbers(numbers);
            SurfaceParameters::Grid(PerDirection::Both(numbers))
        } else {
            pairs.shrink_to_fit();
            own(Scattered::Given(Arc::new(pairs)))
        })
    }

    /// A projection, another surface, or a value for each direction.
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SurfaceParameters, A::Error> {
        let Each {
            u,
            v,
            project,
            foot_points,
        } = Each::deserialize(MapAccessDeserializer::new(map))?;
        let missing = |name| Err(A::Error::missing_field(name));
        match (project, foot_points, u, v) {
            (Some(plane), None, None, None) => Ok(own(plane.into())),
            (None, Some(base), None, None) => Ok(base.parameters()),
            (None, None, Some(u), Some(v)) => {
                Ok(SurfaceParameters::Grid(PerDirection::Each { u, v }))
            }
            (None, None, None, _) => missing("u"),
            (None, None, _, None) => missing("v"),
            _ => Err(A::Error::custom(
                "parameters are u and v, or project, or foot_points",
            )),
        }
    }
}

/// What parameters may have as an object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Each {
    u: Option<RuleOrNumbers<ParameterRule>>,
    v: Option<RuleOrNumbers<ParameterRule>>,
    project: Option<ProjectionPlane>,
    foot_points: Option<FootPointsRequest>,
}

fn both(rule: ParameterRule) -> SurfaceParameters {
    SurfaceParameters::Grid(PerDirection::Both(RuleOrNumbers::Rule(rule)))
}

fn own(scattered: Scattered) -> SurfaceParameters {
    SurfaceParameters::Scattered(ScatteredSpec::Own(scattered))
}

/// The surface of another job, for foot points: the nearest points of it. They are found once, when the
/// new job is made.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = json!({"job": "01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a", "iteration": 12}))]
pub(in crate::api) struct FootPointsRequest {
    /// The id of the job whose surface it is, with as many coordinates as the points.
    job: String,
    /// An iteration that the job has reached; without it, the last one of a job that has ended.
    iteration: Option<IterationRequest>,
}

object!(FootPointsRequest, "an object with a job");

impl FootPointsRequest {
    fn parameters(self) -> SurfaceParameters {
        SurfaceParameters::Scattered(ScatteredSpec::FootPoints(BaseSpec {
            job: self.job,
            iteration: self.iteration.and_then(IterationRequest::number),
        }))
    }
}

/// A parameter of a line of points, or both of a scattered point.
enum Parameter {
    Number(f64),
    Pair([f64; 2]),
}

/// Reads the parameter after these.
struct Next<'a>(&'a [f64], &'a Points);

impl<'de> DeserializeSeed<'de> for Next<'_> {
    type Value = Parameter;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Parameter, D::Error> {
        match (
            deserializer.deserialize_any(PairVisitor)?,
            self.0,
            self.1.is_empty(),
        ) {
            (Parameter::Pair(_), [_, ..], _) | (Parameter::Number(_), _, false) => Err(
                D::Error::custom("expected numbers only, or pairs [u, v] only"),
            ),
            (parameter, ..) => Ok(parameter),
        }
    }
}

struct PairVisitor;

impl<'de> Visitor<'de> for PairVisitor {
    type Value = Parameter;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, or of scattered points a pair [u, v]")
    }

    fn visit_f64<E: Error>(self, t: f64) -> Result<Parameter, E> {
        Ok(Parameter::Number(t))
    }

    fn visit_u64<E: Error>(self, t: u64) -> Result<Parameter, E> {
        self.visit_f64(t as f64)
    }

    fn visit_i64<E: Error>(self, t: i64) -> Result<Parameter, E> {
        self.visit_f64(t as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Parameter, A::Error> {
        let (mut pair, mut count) = ([0.0; 2], 0);
        while let Some(t) = list.next_element()? {
            if let Some(place) = pair.get_mut(count) {
                *place = t;
            }
            count += 1;
        }
        match count {
            2 => Ok(Parameter::Pair(pair)),
            _ => Err(A::Error::custom(format_args!(
                "expected a pair [u, v], found {count} numbers"
            ))),
        }
    }
}

/// The parameters of a surface.
pub(super) enum SurfaceParameterChoice {}

schema_of!(SurfaceParameterChoice, "SurfaceParameters", generator => {
    let of_grid: Schema = PerDirection::<Parameters>::json_schema(generator);
    let mut choices = match of_grid.get("oneOf") {
        Some(Value::Array(choices)) => choices.clone(),
        _ => vec![of_grid.to_value()],
    };
    let mut base = generator.subschema_for::<FootPointsRequest>();
    base.insert("description".to_owned(), "The other job.".into());
    let scattered = [
        json_schema!({
            "title": "Pairs",
            "description": "Of scattered points: u and v of each.",
            "type": "array",
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "minItems": 2,
        }),
        json_schema!({
            "description": "Of scattered points: their coordinates in the plane that lies nearest to them, along their principal axes.",
            "type": "string",
            "const": "project",
        }),
        json_schema!({
            "title": "Projection",
            "description": "Of scattered points: `nearest` is the same, `xy` their x and y.",
            "type": "object",
            "properties": {
                "project": {"type": "string", "enum": ProjectionPlane::names(), "description": "The plane.", "examples": ["xy"]},
            },
            "required": ["project"],
            "additionalProperties": false,
            "examples": [{"project": "xy"}],
        }),
        json_schema!({
            "title": "FootPointParameters",
            "description": "Of scattered points: the parameters of the nearest points of the surface of another job.",
            "type": "object",
            "properties": {
                "foot_points": base,
            },
            "required": ["foot_points"],
            "additionalProperties": false,
        }),
    ];
    choices.extend(scattered.into_iter().map(Schema::to_value));
    json_schema!({
        "description": "How the data points get their parameters: rows and columns by a rule or by numbers, for both directions or for each; scattered points by pairs, by a projection or by their foot points on another surface.",
        "oneOf": choices,
        "examples": ["centripetal", [[0, 0], [0.3, 1.2], [1, 0.7]], {"project": "xy"}],
    })
});
