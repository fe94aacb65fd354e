//! Requested ends of a curve or a surface: a word, or an end for each side, which is a word or has vectors.

mod schema;

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

use super::errors::{SpecPart, ValidationError};
use super::lists::Vectors;
use super::named::{Named, names};
use super::serde_helpers::{Object, read_object, some};
use piad_fit::basis::{End, Ends, MAX_DEGREE};
use piad_fit::invalid::{Axis, Place, Side};

pub(super) use schema::{CurveEnds, SurfaceEnds};

/// An end without vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EndWord {
    Estimated,
    Repeated,
    Natural,
}

names!(EndWord, "rule for ends", [
    "estimated" => Estimated,
    "repeated" => Repeated,
    "natural" => Natural,
]);

/// How a direction ends.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub(crate) struct EndsInput {
    start: Option<EndInput>,
    end: Option<EndInput>,
}

impl<'de> Object<'de> for EndsInput {
    const EXPECTED: &'static str =
        "\"estimated\", \"repeated\" or \"natural\", or {\"start\": …, \"end\": …}";

    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
        Self::deserialize(fields)
    }

    fn of_name<E: Error>(name: &str) -> Result<Self, E> {
        EndWord::read(name).map(Self::of_word)
    }
}

impl<'de> Deserialize<'de> for EndsInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer)
    }
}

/// The end conditions of a direction of a surface; closed directions are left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct DirectionEnds(pub Option<EndsInput>);

impl<'de> Object<'de> for DirectionEnds {
    const EXPECTED: &'static str = EndsInput::EXPECTED;

    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
        EndsInput::of_fields(fields).map(|ends| Self(Some(ends)))
    }

    fn of_name<E: Error>(name: &str) -> Result<Self, E> {
        EndsInput::of_name(name).map(|ends| Self(Some(ends)))
    }

    fn of_nothing<E: Error>() -> Result<Self, E> {
        Ok(Self(None))
    }
}

impl<'de> Deserialize<'de> for DirectionEnds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer)
    }
}

/// The end of a direction on one side.
#[derive(Clone, Debug, PartialEq)]
enum EndInput {
    Word(EndWord),
    /// The name of the field that has them, and the vectors.
    Vectors(&'static str, Vectors),
}

/// An end with vectors.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenEnd {
    #[serde(default, deserialize_with = "some")]
    derivative: Option<Vectors>,
    #[serde(default, deserialize_with = "some")]
    derivatives: Option<Vectors>,
    #[serde(default, deserialize_with = "some")]
    tangent: Option<Vectors>,
}

impl<'de> Object<'de> for EndInput {
    const EXPECTED: &'static str = "one of estimated, repeated, natural, or an object with a derivative, derivatives or a tangent";

    fn of_fields<D: Deserializer<'de>>(fields: D) -> Result<Self, D::Error> {
        let given = GivenEnd::deserialize(fields)?;
        match (given.derivative, given.derivatives, given.tangent) {
            (Some(vectors), None, None) => Ok(Self::Vectors("derivative", vectors)),
            (None, Some(vectors), None) => Ok(Self::Vectors("derivatives", vectors)),
            (None, None, Some(vectors)) => Ok(Self::Vectors("tangent", vectors)),
            _ => Err(D::Error::custom(
                "an end has one of derivative, derivatives and tangent",
            )),
        }
    }

    fn of_name<E: Error>(name: &str) -> Result<Self, E> {
        EndWord::read(name).map(Self::Word)
    }
}

impl<'de> Deserialize<'de> for EndInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer)
    }
}

impl Serialize for EndInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Word(word) => word.serialize(serializer),
            Self::Vectors(name, vectors) => serializer.collect_map([(name, vectors)]),
        }
    }
}

impl Serialize for EndsInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.word() {
            Some(word) => word.serialize(serializer),
            None => serializer.collect_map([("start", &self.start), ("end", &self.end)]),
        }
    }
}

/// The form of ends, for the locations of errors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EndsForm {
    /// One word for both sides.
    one_word: bool,
    /// The fields of the vectors at the start and at the end.
    fields: [&'static str; 2],
    /// There are vectors for each data point of the boundary of a surface.
    surface: bool,
}

impl EndsForm {
    /// The pointer to a part of ends, below that of the ends.
    pub(crate) fn pointer(&self, place: Place) -> String {
        let number = |side| usize::from(side == Side::End);
        match place {
            Place::End(_, side) if !self.one_word => format!("/{}", side.name()),
            Place::EndOrder(_, side, order) => {
                let field = self.fields[number(side)];
                let order = match field {
                    "derivatives" => format!("/{order}"),
                    _ => String::new(),
                };
                format!("/{}/{field}{order}", side.name())
            }
            Place::EndVector(axis, side, order, index) => {
                let order = self.pointer(Place::EndOrder(axis, side, order));
                match self.surface {
                    true => format!("{order}/{index}"),
                    false => order,
                }
            }
            _ => String::new(),
        }
    }
}

impl EndsInput {
    /// The same word on both sides.
    fn of_word(word: EndWord) -> Self {
        let end = || Some(EndInput::Word(word));
        Self {
            start: end(),
            end: end(),
        }
    }

    /// The ends of a direction in the form of a request.
    pub(crate) fn of(ends: &Ends, is_surface: bool) -> Self {
        let side = |end: &End| {
            Some(match end {
                End::Estimated => EndInput::Word(EndWord::Estimated),
                End::Repeated => EndInput::Word(EndWord::Repeated),
                End::Natural => EndInput::Word(EndWord::Natural),
                End::Derivatives(orders) => {
                    EndInput::Vectors("derivatives", Vectors::of(orders, is_surface, true))
                }
                End::Tangent(vectors) => {
                    let vectors = std::slice::from_ref(vectors);
                    EndInput::Vectors("tangent", Vectors::of(vectors, is_surface, false))
                }
            })
        };
        Self {
            start: side(&ends.start),
            end: side(&ends.end),
        }
    }

    /// The word that both sides have.
    fn word(&self) -> Option<EndWord> {
        match (&self.start, &self.end) {
            (Some(EndInput::Word(start)), Some(EndInput::Word(end))) => {
                (start == end).then_some(*start)
            }
            _ => None,
        }
    }

    /// Its JSON.
    pub(crate) fn form(&self, surface: bool) -> EndsForm {
        let field = |end: &Option<EndInput>| match end {
            Some(EndInput::Vectors(name, _)) => *name,
            _ => "derivative",
        };
        EndsForm {
            one_word: self.word().is_some(),
            fields: [field(&self.start), field(&self.end)],
            surface,
        }
    }

    /// The ends that it requests.
    pub(super) fn ends(self, axis: Axis, is_surface: bool) -> Result<Ends, ValidationError> {
        let side = |end: Option<EndInput>, side| {
            end.map_or(Ok(End::Estimated), |end| end.end((axis, side), is_surface))
        };
        Ok(Ends {
            start: side(self.start, Side::Start)?,
            end: side(self.end, Side::End)?,
        })
    }
}

/// Refuses more orders of derivatives than a fit of any degree has, before each is processed.
pub(crate) fn check_orders(count: usize) -> Result<(), String> {
    match count > MAX_DEGREE {
        true => Err(format!(
            "{count} orders of derivatives, but there are at most {MAX_DEGREE}, the largest degree"
        )),
        false => Ok(()),
    }
}

impl EndInput {
    fn end(self, (axis, side): (Axis, Side), is_surface: bool) -> Result<End, ValidationError> {
        let (name, vectors) = match self {
            Self::Word(EndWord::Estimated) => return Ok(End::Estimated),
            Self::Word(EndWord::Repeated) => return Ok(End::Repeated),
            Self::Word(EndWord::Natural) => return Ok(End::Natural),
            Self::Vectors(name, vectors) => (name, vectors),
        };
        let place = SpecPart::Fit(Place::End(axis, side));
        let are_many = name == "derivatives";
        if are_many {
            check_orders(vectors.count()).map_err(|detail| ValidationError::at(place, detail))?;
        }
        let vectors = vectors.orders(is_surface, are_many);
        match (name, vectors) {
            ("tangent", Some(mut vectors)) if vectors.len() == 1 => {
                Ok(vectors.pop().map_or(End::Estimated, End::Tangent))
            }
            ("derivative" | "derivatives", Some(vectors)) => Ok(End::Derivatives(vectors)),
            _ => {
                let one = if is_surface {
                    "[[x, y, z], …], one for each data point of the boundary"
                } else {
                    "[x, y, z]"
                };
                let detail = match name {
                    "derivatives" => format!("expected a list of {one}, one for each order"),
                    _ => format!("expected {one}"),
                };
                Err(ValidationError::at(place, detail))
            }
        }
    }
}
