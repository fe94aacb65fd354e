//! The requested corners of a curve, and creases of a surface.

use std::fmt;

use schemars::{JsonSchema, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::{Serialize, Serializer};

use super::list_limits::{for_all_points, for_points};
use super::schema::schema_of;
use super::serde_helpers::{Whole, object};
use piad_fit::basis::Corners;
use piad_fit::engine::DirectionChoice;

/// The corners of a curve: `"auto"`, an angle, or indices of points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CornersInput(pub Corners);

/// The lines of a grid of points across which a surface may turn, between the first and the last.
#[derive(Clone, Debug, Default, serde::Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = serde_json::json!({"u": [12], "v": [3, 9]}))]
pub(crate) struct Creases {
    /// Indices of rows.
    #[serde(
        default,
        deserialize_with = "for_points",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<Vec<usize>>")]
    pub u: Option<Vec<Whole>>,
    /// Indices of columns.
    #[serde(
        default,
        deserialize_with = "for_points",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<Vec<usize>>")]
    pub v: Option<Vec<Whole>>,
}

object!(Creases, "an object with rows u or columns v");

impl Creases {
    /// The creases of the choices of both directions, if there are any.
    pub(crate) fn of(u: &DirectionChoice, v: &DirectionChoice) -> Option<Self> {
        let lines = |choice: &DirectionChoice| {
            let indices = choice.corners.as_ref()?.indices().iter();
            Some(indices.map(|&index| Whole(index)).collect())
        };
        let creases = Self {
            u: lines(u),
            v: lines(v),
        };
        (creases.u.is_some() || creases.v.is_some()).then_some(creases)
    }

    /// The corners of the directions.
    pub(super) fn corners(self) -> [Option<Corners>; 2] {
        [self.u, self.v].map(|lines| {
            let indices = lines?.into_iter().map(|Whole(index)| index);
            Some(Corners::At(indices.collect()))
        })
    }
}

/// Corners at which the points turn by more than this angle, in degrees.
#[derive(serde::Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Angle {
    angle: f64,
}

impl<'de> Deserialize<'de> for CornersInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CornersVisitor;

        impl<'de> Visitor<'de> for CornersVisitor {
            type Value = Corners;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"auto\", {\"angle\": degrees} or a list of indices of points")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Corners, E> {
                match name {
                    "auto" => Ok(Corners::USUAL),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(name), &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Corners, A::Error> {
                let Angle { angle } = Angle::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Corners::Found(angle))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Corners, A::Error> {
                let indices: Vec<Whole> = for_all_points(SeqAccessDeserializer::new(list))?;
                let indices = indices.into_iter().map(|Whole(index)| index);
                Ok(Corners::At(indices.collect()))
            }
        }

        deserializer.deserialize_any(CornersVisitor).map(Self)
    }
}

impl Serialize for CornersInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Corners::At(indices) => serializer.collect_seq(indices.iter()),
            Corners::Found(angle) => Angle { angle: *angle }.serialize(serializer),
        }
    }
}

schema_of!(
    CornersInput,
    "Corners",
    json_schema!({
        "description": "The points at which a curve may turn, and through which it passes: by their indices, or those at which the points turn by more than an angle in degrees (\"auto\": 30) and by more than three times what those around them turn. The pieces between them are fitted by themselves. Open B-splines with knots as usual have them.",
        "oneOf": [
            {"type": "string", "enum": ["auto"]},
            {"type": "object", "properties": {"angle": {"description": "In degrees.", "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 180}}, "required": ["angle"], "additionalProperties": false},
            {"type": "array", "items": {"type": "integer", "minimum": 1}},
        ],
        "examples": ["auto", {"angle": 45}, [12, 40]],
    })
);
