//! The JSON of places at which constraints hold.

use schemars::json_schema;
use serde::de::{MapAccess, SeqAccess};

use crate::api::json::read::{Field, Members, Most, Numeral, Of, Read, Reader, Reading, names};
use crate::api::json::request::settings::Index;
use crate::api::json::schema::schema_of;
use crate::fit::invalid::{Axis, Side};
use crate::fit::method::At;
use crate::fit::points::Grid;
use crate::model::short::quoted;

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

/// The fields of a place.
const PLACES: [&str; 3] = ["index", "parameter", "boundary"];

impl Reader for Of<AtRequest> {
    type Value = AtRequest;

    fn expected(&self) -> String {
        "\"start\", \"end\", {\"index\": …}, {\"parameter\": …} or {\"boundary\": …}".to_owned()
    }

    fn text(self, name: &str, at: &mut Reading) -> Option<AtRequest> {
        let side = [Side::Start, Side::End].into_iter();
        let side = side.into_iter().find(|side| side.name() == name);
        if side.is_none() {
            at.mismatch(&self.expected(), &quoted(name));
        }
        side.map(AtRequest::Side)
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        mut members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<AtRequest>, A::Error> {
        let (mut index, mut parameter, mut boundary) =
            (Field::Absent, Field::Absent, Field::Absent);
        while let Some(name) = members.next(&PLACES, at)? {
            match name {
                "index" => members.field(name, &mut index, at)?,
                "parameter" => members.field(name, &mut parameter, at)?,
                _ => members.field(name, &mut boundary, at)?,
            }
        }
        Ok(match (index, parameter, boundary) {
            (Field::Given(index), Field::Absent, Field::Absent) => Some(AtRequest::Index(index)),
            (Field::Absent, Field::Given(parameter), Field::Absent) => {
                Some(AtRequest::Parameter(parameter))
            }
            (Field::Absent, Field::Absent, Field::Given(boundary)) => {
                Some(AtRequest::Boundary(boundary))
            }
            (Field::Wrong, ..) | (_, Field::Wrong, _) | (.., Field::Wrong) => None,
            _ => {
                at.wrong("a place has one of index, parameter and boundary");
                None
            }
        })
    }
}

impl Reader for Of<ParameterRequest> {
    type Value = ParameterRequest;

    fn expected(&self) -> String {
        "a parameter, or [u, v]".to_owned()
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<ParameterRequest> {
        Some(ParameterRequest::One(value.real()))
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<ParameterRequest>, A::Error> {
        let mut both = Vec::new();
        let whole = at.elements(list, Most::of(2, "parameters"), f64::reader, |value, _| {
            both.push(value);
            Some(())
        })?;
        match both[..] {
            [u, v] if whole => Ok(Some(ParameterRequest::Two(u, v))),
            _ => {
                if whole {
                    at.wrong("a surface has two parameters, [u, v]");
                }
                Ok(None)
            }
        }
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
    let boundary = json_schema!({"type": "string", "enum": Boundary::NAMES});
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
