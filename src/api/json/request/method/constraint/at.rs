//! The JSON of places at which constraints hold.

use std::fmt;

use schemars::json_schema;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};

use crate::api::json::request::settings::Index;
use crate::api::json::schema::schema_of;
use crate::fit::invalid::{Axis, Side};
use crate::fit::method::At;
use crate::fit::points::Grid;
use crate::model::either::{Object, read_at_most, read_object, some};
use crate::model::named::{Named, names};

/// Where a constraint holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum AtRequest {
    Side(Side),
    Index(Index),
    Parameter(ParameterRequest),
    Boundary(Boundary),
}

/// A parameter of a curve, or both of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum ParameterRequest {
    One(f64),
    Two(f64, f64),
}

/// A boundary of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Boundary {
    UStart,
    UEnd,
    VStart,
    VEnd,
}

names!(Boundary, "boundary", [
    "u_start" => UStart,
    "u_end" => UEnd,
    "v_start" => VStart,
    "v_end" => VEnd,
]);

/// A place as an object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    #[serde(default, deserialize_with = "some")]
    index: Option<Index>,
    #[serde(default, deserialize_with = "some")]
    parameter: Option<ParameterRequest>,
    #[serde(default, deserialize_with = "some")]
    boundary: Option<Boundary>,
}

impl<'de> Object<'de> for AtRequest {
    const EXPECTED: &'static str =
        "\"start\", \"end\", {\"index\": …}, {\"parameter\": …} or {\"boundary\": …}";

    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
        let place = Place::deserialize(fields)?;
        match (place.index, place.parameter, place.boundary) {
            (Some(index), None, None) => Ok(Self::Index(index)),
            (None, Some(parameter), None) => Ok(Self::Parameter(parameter)),
            (None, None, Some(boundary)) => Ok(Self::Boundary(boundary)),
            _ => Err(D::Error::custom(
                "a place has one of index, parameter and boundary",
            )),
        }
    }

    fn of_name<E: Error>(name: &str) -> Result<Self, E> {
        let mut sides = [Side::Start, Side::End].into_iter();
        let side = sides.find(|side| side.name() == name);
        side.map(Self::Side)
            .ok_or_else(|| E::invalid_type(Unexpected::Str(name), &Self::EXPECTED))
    }
}

impl<'de> Deserialize<'de> for AtRequest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer)
    }
}

impl<'de> Deserialize<'de> for ParameterRequest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ParameterVisitor;

        impl<'de> Visitor<'de> for ParameterVisitor {
            type Value = ParameterRequest;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a parameter, or [u, v]")
            }

            fn visit_f64<E: Error>(self, t: f64) -> Result<ParameterRequest, E> {
                Ok(ParameterRequest::One(t))
            }

            fn visit_u64<E: Error>(self, t: u64) -> Result<ParameterRequest, E> {
                self.visit_f64(t as f64)
            }

            fn visit_i64<E: Error>(self, t: i64) -> Result<ParameterRequest, E> {
                self.visit_f64(t as f64)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
                let both: Vec<f64> =
                    read_at_most(SeqAccessDeserializer::new(list), 2, "parameters")?;
                match both[..] {
                    [u, v] => Ok(ParameterRequest::Two(u, v)),
                    _ => Err(A::Error::custom("a surface has two parameters, [u, v]")),
                }
            }
        }

        deserializer.deserialize_any(ParameterVisitor)
    }
}

schema_of!(AtRequest, "ConstraintPlace", generator => {
    let index = generator.subschema_for::<Index>();
    let place = |name: &str, what: &str, mut schema: schemars::Schema| {
        schema.insert("description".to_owned(), what.into());
        json_schema!({
            "type": "object",
            "properties": {name: schema},
            "required": [name],
            "additionalProperties": false,
        })
    };
    let number = json_schema!({"type": "number"});
    let parameter = json_schema!({
        "oneOf": [number, {"type": "array", "items": number, "minItems": 2, "maxItems": 2}],
    });
    let boundary = json_schema!({"type": "string", "enum": Boundary::names()});
    json_schema!({
        "description": "An end of a curve, the parameters of a data point, a parameter ([u, v] of a surface), or a boundary of a surface.",
        "oneOf": [
            {"type": "string", "enum": ["start", "end"]},
            place("index", "The data point at whose parameters it holds.", index),
            place("parameter", "The parameter of a curve, or [u, v] of a surface.", parameter),
            place("boundary", "The boundary of a surface at the first or the last parameter of u or of v.", boundary),
        ],
        "examples": ["start", {"index": 17}, {"parameter": [0.5, 0.25]}, {"boundary": "u_end"}],
    })
});

impl AtRequest {
    pub(super) fn of(self, grid: Grid, surface: bool) -> Result<At, String> {
        Ok(match self {
            Self::Side(side) => At::Side(side),
            Self::Index(index) => At::Index(index.of_point(grid, surface)?),
            Self::Parameter(ParameterRequest::One(t)) => At::Parameter(t),
            Self::Parameter(ParameterRequest::Two(u, v)) => At::Parameters(u, v),
            Self::Boundary(boundary) => {
                let (axis, side) = boundary.of();
                At::Boundary(axis, side)
            }
        })
    }
}

impl Boundary {
    fn of(self) -> (Axis, Side) {
        match self {
            Self::UStart => (Axis::U, Side::Start),
            Self::UEnd => (Axis::U, Side::End),
            Self::VStart => (Axis::V, Side::Start),
            Self::VEnd => (Axis::V, Side::End),
        }
    }
}
