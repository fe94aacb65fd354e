//! Places at which constraints hold.

use schemars::json_schema;
use serde::de::{Deserializer, Error, Unexpected};
use serde::{Deserialize, Serialize, Serializer};

use crate::model::lists::Lists;
use crate::model::named::{Named, names};
use crate::model::schema::schema_of;
use crate::model::serde_helpers::{Object, below, read_object, some};
use crate::model::settings::Index;
use piad_fit::data::Grid;
use piad_fit::invalid::{Axis, Side};
use piad_fit::method::At;

/// The location of a constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PlaceInput {
    Side(Side),
    Index(Index),
    Parameter(Parameter),
    Boundary(Boundary),
}

/// A parameter of a curve, or both of a surface.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Parameter {
    One(f64),
    Two(f64, f64),
}

/// A boundary of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Boundary(pub(crate) Axis, pub(crate) Side);

impl Boundary {
    const U_START: Self = Self(Axis::U, Side::Start);
    const U_END: Self = Self(Axis::U, Side::End);
    const V_START: Self = Self(Axis::V, Side::Start);
    const V_END: Self = Self(Axis::V, Side::End);
}

names!(Boundary, "boundary", [
    "u_start" => U_START,
    "u_end" => U_END,
    "v_start" => V_START,
    "v_end" => V_END,
]);

/// A place as an object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    #[serde(default, deserialize_with = "some")]
    index: Option<Index>,
    #[serde(default, deserialize_with = "some")]
    parameter: Option<Parameter>,
    #[serde(default, deserialize_with = "some")]
    boundary: Option<Boundary>,
}

impl<'de> Object<'de> for PlaceInput {
    const EXPECTED: &'static str =
        "\"start\", \"end\", {\"index\": …}, {\"parameter\": …} or {\"boundary\": …}";

    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
        let place = Fields::deserialize(fields)?;
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

impl<'de> Deserialize<'de> for PlaceInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer)
    }
}

impl Serialize for PlaceInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Side(side) => side.name().serialize(serializer),
            Self::Index(index) => serializer.collect_map([("index", index)]),
            Self::Parameter(parameter) => serializer.collect_map([("parameter", parameter)]),
            Self::Boundary(boundary) => serializer.collect_map([("boundary", boundary)]),
        }
    }
}

impl<'de> Deserialize<'de> for Parameter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const TWO: &str = "a surface has two parameters, [u, v]";
        let Lists { values, lengths } =
            Lists::read(deserializer, "a parameter, or [u, v]", true, 1)?;
        match (&values[..], &lengths[..]) {
            ([t], []) => Ok(Self::One(*t)),
            ([u, v], [_]) => Ok(Self::Two(*u, *v)),
            (_, [count]) if *count > 2 => Err(below("/2", TWO)),
            _ => Err(D::Error::custom(TWO)),
        }
    }
}

schema_of!(PlaceInput, "ConstraintPlace", generator => {
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

impl PlaceInput {
    /// The place among data points that are arranged in a grid.
    pub(super) fn at(self, grid: Grid, surface: bool) -> Result<At, String> {
        Ok(match self {
            Self::Side(side) => At::Side(side),
            Self::Index(index) => At::Index(index.of_point(grid, surface)?),
            Self::Parameter(Parameter::One(t)) => At::Parameter(t),
            Self::Parameter(Parameter::Two(u, v)) => At::Parameters(u, v),
            Self::Boundary(Boundary(axis, side)) => At::Boundary(axis, side),
        })
    }

    /// A location in the form of a request; points of surfaces are in rows of `columns` points.
    pub(super) fn of(at: At, columns: Option<usize>) -> Self {
        match at {
            At::Side(side) => Self::Side(side),
            At::Index(point) => Self::Index(Index::new(point, columns)),
            At::Parameter(t) => Self::Parameter(Parameter::One(t)),
            At::Parameters(u, v) => Self::Parameter(Parameter::Two(u, v)),
            At::Boundary(axis, side) => Self::Boundary(Boundary(axis, side)),
        }
    }
}
