//! The parameters of a surface as they are asked for: of points in a grid, or of scattered ones.

use std::fmt;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value, json};

use super::basis::ParametersInput;
use super::either::{below, object};
use super::iteration::IterationChoice;
use super::lists::{LISTS, Lists};
use super::mistakes::{Mistake, SpecPart};
use super::named::{Named, Rule, names};
use super::per_direction::PerDirection;
use super::schema::schema_of;
use piad_fit::data::Points;
use piad_fit::geometry::{Nurbs, foot_points};
use piad_fit::parameters::{CoordinatePlane, Parametrization, Scattered};

/// The parameters of the data points of a surface.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceParameters {
    /// Those of the rows and columns of a grid.
    Grid(PerDirection<ParametersInput>),
    /// Those of scattered points, as they are given, or from a plane.
    Scattered(Scattered),
    /// Those of the foot points of scattered points on the surface of another job.
    FootPoints(FootPoints),
}

/// The plane in which scattered points have their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ProjectionPlane {
    Nearest,
    Xy,
    Xz,
    Yz,
}

names!(ProjectionPlane, "plane", [
    "nearest" => Nearest,
    "xy" => Xy,
    "xz" => Xz,
    "yz" => Yz,
]);

impl From<ProjectionPlane> for Scattered {
    fn from(plane: ProjectionPlane) -> Self {
        match plane {
            ProjectionPlane::Nearest => Self::Plane,
            ProjectionPlane::Xy => Self::Coordinates(CoordinatePlane::Xy),
            ProjectionPlane::Xz => Self::Coordinates(CoordinatePlane::Xz),
            ProjectionPlane::Yz => Self::Coordinates(CoordinatePlane::Yz),
        }
    }
}

impl From<CoordinatePlane> for ProjectionPlane {
    fn from(plane: CoordinatePlane) -> Self {
        match plane {
            CoordinatePlane::Xy => Self::Xy,
            CoordinatePlane::Xz => Self::Xz,
            CoordinatePlane::Yz => Self::Yz,
        }
    }
}

/// The surface of another job, for foot points: the nearest points of it. They are found once, when the
/// new job is made.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "FootPointsRequest")]
#[schemars(example = json!({"job": "01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a", "iteration": 12}))]
pub struct FootPoints {
    /// The id of the job whose surface it is, with as many coordinates as the points.
    pub job: String,
    /// An iteration that the job has reached; without it, the last one of a job that has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) iteration: Option<IterationChoice>,
}

object!(FootPoints, "an object with a job");

/// The parameters of the foot points of scattered points on a surface, or why there are none.
pub(super) fn on_surface(
    points: &Points,
    surface: Result<&Nurbs, Mistake>,
) -> Result<Scattered, Mistake> {
    match foot_points(surface?, points) {
        Ok(pairs) => Ok(Scattered::Given(Arc::new(pairs))),
        Err(reason) => Err(Mistake::at(SpecPart::FootPoints, reason.to_string())),
    }
}

/// What is said of a surface that nobody has looked for.
pub fn no_base() -> Mistake {
    Mistake::at(SpecPart::FootPoints, "other jobs are not known here")
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
        let (what, names) = (ParametersInput::WHAT, ParametersInput::names().join(", "));
        write!(
            f,
            "the name of a {what}: {names}; or a list of numbers; or one for each direction, {{\"u\": …, \"v\": …}}; of scattered points pairs, [[u, v], …], \"project\" or foot_points"
        )
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<SurfaceParameters, E> {
        if name == "project" {
            return Ok(SurfaceParameters::Scattered(Scattered::Plane));
        }
        let rule = ParametersInput::deserialize(StrDeserializer::new(name))?;
        Ok(SurfaceParameters::Grid(PerDirection::Both(rule)))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<SurfaceParameters, A::Error> {
        let Lists { values, lengths } =
            Lists::read(SeqAccessDeserializer::new(list), LISTS, false, 2)?;
        match lengths[..] {
            [_] => {
                let numbers = ParametersInput(Parametrization::Explicit(Arc::new(values)));
                Ok(SurfaceParameters::Grid(PerDirection::Both(numbers)))
            }
            [_, 2] => {
                let pairs = Arc::new(Points::from_flat(2, &values));
                Ok(SurfaceParameters::Scattered(Scattered::Given(pairs)))
            }
            // All have the same length.
            _ => Err(below(
                "/0",
                "expected a number, or of scattered points a pair [u, v]",
            )),
        }
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
            (Some(plane), None, None, None) => Ok(SurfaceParameters::Scattered(plane.into())),
            (None, Some(base), None, None) => Ok(SurfaceParameters::FootPoints(base)),
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
    u: Option<ParametersInput>,
    v: Option<ParametersInput>,
    project: Option<ProjectionPlane>,
    foot_points: Option<FootPoints>,
}

impl Serialize for SurfaceParameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Grid(parameters) => parameters.serialize(serializer),
            Self::Scattered(Scattered::Given(pairs)) => {
                serializer.collect_seq((0..pairs.len()).map(|k| pairs.point(k).collect::<Vec<_>>()))
            }
            Self::Scattered(Scattered::Plane) => serializer.serialize_str("project"),
            Self::Scattered(Scattered::Coordinates(plane)) => {
                serializer.collect_map([("project", ProjectionPlane::from(*plane))])
            }
            Self::FootPoints(base) => serializer.collect_map([("foot_points", base)]),
        }
    }
}

schema_of!(SurfaceParameters, "SurfaceParameters", generator => {
    let of_grid: Schema = PerDirection::<ParametersInput>::json_schema(generator);
    let mut choices = match of_grid.get("oneOf") {
        Some(Value::Array(choices)) => choices.clone(),
        _ => vec![of_grid.to_value()],
    };
    let mut base = generator.subschema_for::<FootPoints>();
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
            "description": "Of scattered points: `nearest` is the same, `xy`, `xz` and `yz` are two of their coordinates.",
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
