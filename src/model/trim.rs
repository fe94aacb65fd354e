//! The requested trimming of a surface.

use std::fmt;

use schemars::json_schema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::schema::schema_of;
use piad_fit::engine::Trim;

/// The trimming of a surface to the outline of its data: true, false, or a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TrimInput(pub Option<Trim>);

/// A distance that is given.
#[derive(serde::Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Within {
    distance: f64,
}

impl<'de> Deserialize<'de> for TrimInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TrimVisitor;

        impl<'de> Visitor<'de> for TrimVisitor {
            type Value = Option<Trim>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("true, false or an object with a distance")
            }

            fn visit_bool<E>(self, is_trimmed: bool) -> Result<Option<Trim>, E> {
                Ok(is_trimmed.then(Trim::default))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Option<Trim>, A::Error> {
                let Within { distance } = Within::deserialize(MapAccessDeserializer::new(map))?;
                let distance = Some(distance);
                Ok(Some(Trim { distance }))
            }
        }

        deserializer.deserialize_any(TrimVisitor).map(Self)
    }
}

impl Serialize for TrimInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.map(|trim| trim.distance) {
            None => serializer.serialize_bool(false),
            Some(None) => serializer.serialize_bool(true),
            Some(Some(distance)) => Within { distance }.serialize(serializer),
        }
    }
}

schema_of!(
    TrimInput,
    "Trim",
    json_schema!({
        "description": "True if the surface is trimmed to the outline of its data, which is at most a distance from them, in the unit of the points: with `true` about the distance of the points from each other. Holes and gaps of up to two or three times the distance are filled; data in several islands give several loops. The result and files have the outline; the fit is the same without it.",
        "oneOf": [
            {"type": "boolean"},
            {
                "type": "object",
                "properties": {"distance": {"description": "The largest distance of the data from the surface that is left.", "type": "number", "exclusiveMinimum": 0, "examples": [0.5]}},
                "required": ["distance"],
                "additionalProperties": false,
            },
        ],
        "default": false,
        "examples": [true, {"distance": 0.5}],
    })
);
