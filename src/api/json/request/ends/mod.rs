//! The JSON of how a curve or a surface ends: a word, or an end for each side, which is a word or has
//! vectors.

mod schema;
mod vectors;
mod word;

use serde::de::MapAccess;

use crate::api::json::read::{Field, Members, Of, Read, Reader, Reading, object};
use crate::fit::ends::{End, Ends};
use crate::fit::invalid::{Axis, Place, Side};
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};

pub(super) use schema::{CurveEnds, SurfaceEnds};
pub(super) use vectors::Vectors;
use word::EndWord;

/// How a direction ends.
#[derive(Clone, Debug)]
pub(in crate::api) struct EndsRequest {
    start: Option<EndRequest>,
    end: Option<EndRequest>,
}

object!(
    EndsRequest,
    "\"estimated\", \"repeated\" or \"natural\", or {\"start\": …, \"end\": …}",
    [start, end],
    of_name: |name, at| EndWord::reader().text(name, at).map(EndsRequest::of)
);

/// How a direction ends on one side.
#[derive(Clone, Debug)]
enum EndRequest {
    Word(EndWord),
    /// The name of the field that has them, and the vectors.
    Vectors(&'static str, Vectors),
}

/// The fields of an end with vectors.
const FIELDS: [&str; 3] = ["derivative", "derivatives", "tangent"];

impl Reader for Of<EndRequest> {
    type Value = EndRequest;

    fn expected(&self) -> String {
        format!(
            "one of {}, or an object with a derivative, derivatives or a tangent",
            EndWord::NAMES.join(", ")
        )
    }

    fn text(self, name: &str, at: &mut Reading) -> Option<EndRequest> {
        EndWord::reader().text(name, at).map(EndRequest::Word)
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        mut members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<EndRequest>, A::Error> {
        let mut found: [Field<Vectors>; 3] = [Field::Absent, Field::Absent, Field::Absent];
        while let Some(name) = members.next(&FIELDS, at)? {
            for (field, place) in FIELDS.iter().zip(&mut found) {
                if name == *field {
                    members.field(name, place, at)?;
                    break;
                }
            }
        }
        let given = FIELDS.into_iter().zip(found);
        let given = given.filter(|(_, field)| !matches!(field, Field::Absent));
        let mut given: Vec<(&str, Field<Vectors>)> = given.collect();
        match (given.pop(), given.is_empty()) {
            (Some((name, Field::Given(vectors))), true) => {
                Ok(Some(EndRequest::Vectors(name, vectors)))
            }
            (Some((_, Field::Wrong)), true) => Ok(None),
            _ => {
                at.wrong("an end has one of derivative, derivatives and tangent");
                Ok(None)
            }
        }
    }
}

/// How ends are written, for the places of mistakes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EndsForm {
    /// One word for both sides.
    one_word: bool,
    /// The fields of the vectors at the start and at the end.
    fields: [&'static str; 2],
    /// There are vectors for each data point of the boundary of a surface.
    surface: bool,
}

impl EndsForm {
    /// The pointer to a part of ends, below that of the ends.
    pub(super) fn pointer(&self, place: Place) -> String {
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

impl EndsRequest {
    /// The same word on both sides.
    fn of(word: EndWord) -> Self {
        Self {
            start: Some(EndRequest::Word(word)),
            end: Some(EndRequest::Word(word)),
        }
    }

    /// How it is written.
    pub(super) fn form(&self, surface: bool) -> EndsForm {
        let field = |end: &Option<EndRequest>| match end {
            Some(EndRequest::Vectors(name, _)) => *name,
            _ => "derivative",
        };
        let word = |end: &Option<EndRequest>| match end {
            Some(EndRequest::Word(word)) => Some(*word),
            _ => None,
        };
        let words = word(&self.start).zip(word(&self.end));
        EndsForm {
            one_word: words.is_some_and(|(start, end)| start == end),
            fields: [field(&self.start), field(&self.end)],
            surface,
        }
    }

    /// The ends that it asks for.
    pub(super) fn spec(self, axis: Axis, is_surface: bool) -> OrMistakes<Ends> {
        let side = |end: Option<EndRequest>, side| {
            end.map_or(Ok(End::Estimated), |end| end.spec((axis, side), is_surface))
        };
        Ok(Ends {
            start: side(self.start, Side::Start)?,
            end: side(self.end, Side::End)?,
        })
    }
}

impl EndRequest {
    fn spec(self, (axis, side): (Axis, Side), is_surface: bool) -> Result<End, Mistake> {
        let (name, vectors) = match self {
            Self::Word(EndWord::Estimated) => return Ok(End::Estimated),
            Self::Word(EndWord::Repeated) => return Ok(End::Repeated),
            Self::Word(EndWord::Natural) => return Ok(End::Natural),
            Self::Vectors(name, vectors) => (name, vectors),
        };
        let vectors = vectors.orders(is_surface, name == "derivatives");
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
                let place = Place::End(axis, side);
                Err(Mistake::at(SpecPart::Fit(place), detail))
            }
        }
    }
}
