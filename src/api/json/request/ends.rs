//! The JSON of how a curve or a surface ends: a word, or an end for each side, which is a word or has
//! vectors.

use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{MapAccess, SeqAccess};

use crate::api::json::read::{
    Field, Members, Most, Numeral, Of, Read, Reader, Reading, names, object,
};
use crate::fit::ends::{End, Ends};
use crate::fit::invalid::{Axis, Place, Side};
use crate::fit::lane::Lane;
use crate::fit::points::Points;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::shape::MAX_DIMENSION;

/// An end without vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum EndWord {
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

/// Numbers in lists within lists, all of a level of the same length.
#[derive(Clone, Debug, Default)]
struct Vectors {
    values: Vec<f64>,
    /// The lengths of the lists, from the outermost to those of numbers.
    lengths: Vec<usize>,
}

/// The most levels of lists: orders of derivatives, data points of a boundary, coordinates.
const DEEPEST: usize = 3;

impl Reader for Of<Vectors> {
    type Value = Vectors;

    fn expected(&self) -> String {
        "a list of numbers, or of lists of them".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Vectors>, A::Error> {
        let vectors = RefCell::new(Vectors::default());
        let whole = LevelReader(&vectors, 0).list(list, at)?;
        Ok(whole.map(|_| vectors.into_inner()))
    }
}

/// Reads a list of a level, or a number, into vectors; gives whether it was a list.
struct LevelReader<'a>(&'a RefCell<Vectors>, usize);

impl Reader for LevelReader<'_> {
    type Value = bool;

    fn expected(&self) -> String {
        Of::<Vectors>::expected(&Vectors::reader())
    }

    fn null(self, at: &mut Reading) -> Option<bool> {
        f64::reader().null(at).map(|_| false)
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<bool> {
        let Self(vectors, level) = self;
        let mut vectors = vectors.borrow_mut();
        // Numbers stand in lists of one level, which is known once a list has ended.
        if !vectors.lengths.is_empty() && vectors.lengths.len() != level {
            at.wrong("a number stands here where others have lists");
            return None;
        }
        vectors.values.push(value.real());
        Some(false)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<bool>, A::Error> {
        let Self(vectors, level) = self;
        if level == DEEPEST {
            at.wrong(format!(
                "there are at most {DEEPEST} lists within each other"
            ));
            return Ok(None);
        }
        let before = vectors.borrow().values.len();
        let most = at.limits().points.saturating_mul(DEEPEST);
        let most = Most::of(most, "numbers").after(before);
        let (mut length, mut of_lists) = (0, None);
        let whole = at.elements(
            list,
            most,
            || LevelReader(vectors, level + 1),
            |is_list, at| {
                length += 1;
                if *of_lists.get_or_insert(is_list) != is_list {
                    at.wrong("numbers stand here beside lists of numbers");
                    return None;
                }
                Some(())
            },
        )?;
        if !whole {
            return Ok(None);
        }
        let end = vectors.borrow_mut().end(level, length, before, at);
        Ok(end.map(|()| true))
    }
}

impl Vectors {
    /// Notes that a list of a level has ended, which has so many entries.
    fn end(&mut self, level: usize, length: usize, before: usize, at: &mut Reading) -> Option<()> {
        let has_numbers = self.values.len() == before + length;
        if self.lengths.is_empty() && has_numbers && length > 0 {
            self.lengths.resize(level + 1, 0);
        }
        let Some(own) = self.lengths.get_mut(level) else {
            at.wrong("a list is empty, or stands where others have numbers");
            return None;
        };
        if *own == 0 {
            *own = length;
        }
        if *own != length {
            at.wrong(format!(
                "this list has {length} entries, the first of its kind has {own}"
            ));
            return None;
        }
        Some(())
    }

    /// The vectors of each order, of a boundary of one data point or of many; none if these are other
    /// lists.
    fn orders(self, is_surface: bool, are_many: bool) -> Option<Vec<Arc<Points>>> {
        let mut lengths = self.lengths.into_iter().rev();
        let dimension = lengths.next()?;
        let boundary = if is_surface { lengths.next()? } else { 1 };
        if are_many {
            lengths.next()?;
        }
        if lengths.next().is_some() || dimension == 0 || dimension > MAX_DIMENSION {
            return None;
        }
        let order = |flat: &[f64]| {
            let lane = |c| -> Lane { flat.iter().skip(c).step_by(dimension).copied().collect() };
            Arc::new(Points::from_lanes((0..dimension).map(lane)))
        };
        let orders = self.values.chunks_exact(boundary * dimension);
        Some(orders.map(order).collect())
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

/// The schema of the ends of a curve: a word, or an end for each side.
pub(super) enum CurveEnds {}

/// The schema of the ends of a direction of a surface.
enum DirectionEnds {}

/// The schema of the ends of a surface: those of both directions, or of each that is not closed.
pub(super) enum SurfaceEnds {}

/// What the schemas of curves and of surfaces differ in.
trait Boundary {
    const NAME: &'static str;
    const ONE: &'static str;

    /// The schema of the vectors of one order.
    fn vectors() -> Schema;
    fn example() -> serde_json::Value;
}

/// The schema of a vector.
fn vector() -> Schema {
    json_schema!({
        "type": "array",
        "items": {"type": "number"},
        "minItems": 1,
        "maxItems": MAX_DIMENSION,
    })
}

impl Boundary for CurveEnds {
    const NAME: &'static str = "Curve";
    const ONE: &'static str = "a vector";

    fn vectors() -> Schema {
        vector()
    }

    fn example() -> serde_json::Value {
        serde_json::json!([0.0, 1.0])
    }
}

impl Boundary for DirectionEnds {
    const NAME: &'static str = "Surface";
    const ONE: &'static str = "a vector for each data point of the boundary";

    fn vectors() -> Schema {
        json_schema!({"type": "array", "items": vector(), "minItems": 2})
    }

    fn example() -> serde_json::Value {
        serde_json::json!([[0.0, 1.0, 0.0], [0.0, 1.0, 0.5]])
    }
}

/// An end with vectors.
struct GivenEnd<B>(std::marker::PhantomData<B>);

/// An end for each side.
struct EndPair<B>(std::marker::PhantomData<B>);

impl<B: Boundary> JsonSchema for GivenEnd<B> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}End", B::NAME).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let field = |schema: Schema, what: String| {
            let mut schema = schema;
            schema.insert("description".to_owned(), what.into());
            schema
        };
        let one = B::ONE;
        json_schema!({
            "description": "An end with derivatives with respect to the parameter: one of the fields is given.",
            "type": "object",
            "properties": {
                "derivative": field(B::vectors(), format!("The first derivative: {one}.")),
                "derivatives": field(
                    json_schema!({"type": "array", "items": B::vectors(), "minItems": 1}),
                    format!("Derivatives of the first order and further ones, for each {one}; those that are missing are estimated."),
                ),
                "tangent": field(B::vectors(), format!("The direction of the first derivative, {one}. Its length is that of the polygon through the points over the range of the parameters.")),
            },
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": false,
            "examples": [{"tangent": B::example()}],
        })
    }
}

impl<B: Boundary> JsonSchema for EndPair<B> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}EndPair", B::NAME).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let given = generator.subschema_for::<GivenEnd<B>>();
        let side = |which: &str| {
            json_schema!({
                "description": format!("How it ends at its {which} parameter."),
                "oneOf": [{"type": "string", "enum": EndWord::NAMES}, given],
                "default": "estimated",
            })
        };
        json_schema!({
            "description": "How both sides end.",
            "type": "object",
            "properties": {"start": side("first"), "end": side("last")},
            "minProperties": 1,
            "additionalProperties": false,
            "examples": [{"start": {"tangent": B::example()}, "end": "natural"}],
        })
    }
}

/// The schema of ends: a word or an object.
fn ends<B: Boundary>(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "description": "How a B-spline with knots at the data ends: with estimated derivatives, with copies of its end points (repeated), without second derivative (natural), or with derivatives that are given.",
        "oneOf": [
            {"type": "string", "enum": EndWord::NAMES},
            generator.subschema_for::<EndPair<B>>(),
        ],
        "default": "estimated",
        "examples": ["natural"],
    })
}

impl JsonSchema for CurveEnds {
    fn schema_name() -> Cow<'static, str> {
        "CurveEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        ends::<Self>(generator)
    }
}

impl JsonSchema for DirectionEnds {
    fn schema_name() -> Cow<'static, str> {
        "DirectionEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        ends::<Self>(generator)
    }
}

/// Ends for each direction that has some.
enum EachEnds {}

impl JsonSchema for EachEnds {
    fn schema_name() -> Cow<'static, str> {
        "SurfaceEndsPair".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut of = |which: &str| {
            let mut schema = DirectionEnds::json_schema(generator);
            schema.insert("description".to_owned(), which.into());
            schema
        };
        json_schema!({
            "description": "How each direction ends; closed ones are left out.",
            "type": "object",
            "properties": {
                "u": of("How u ends, from row to row: at the first and the last row."),
                "v": of("How v ends, from column to column: at the first and the last column."),
            },
            "minProperties": 1,
            "additionalProperties": false,
            "examples": [{"v": "natural"}],
        })
    }
}

impl JsonSchema for SurfaceEnds {
    fn schema_name() -> Cow<'static, str> {
        "SurfaceEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = ends::<DirectionEnds>(generator);
        let each = generator.subschema_for::<EachEnds>().to_value();
        if let Some(serde_json::Value::Array(choices)) = schema.get_mut("oneOf") {
            choices.push(each);
        }
        schema
    }
}
