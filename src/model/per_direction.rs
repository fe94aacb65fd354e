//! A value for both directions of a surface, or one for each.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde::de::value::{
    BoolDeserializer, F64Deserializer, I64Deserializer, MapAccessDeserializer,
    SeqAccessDeserializer, StrDeserializer, U64Deserializer, UnitDeserializer,
};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Value, json};

use super::serde_helpers::{Peeked, below, step};
use piad_fit::invalid::Axis;

/// A value for both directions, or one for each: `X` or `{"u": X, "v": X}`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum PerDirection<T> {
    /// The same for u and v.
    Both(T),
    /// One for u and one for v.
    Each {
        /// For u.
        u: T,
        /// For v.
        v: T,
    },
}

impl<T> PerDirection<T> {
    /// The values for u and v.
    pub(crate) fn split(self) -> (T, T)
    where
        T: Clone,
    {
        match self {
            Self::Both(value) => (value.clone(), value),
            Self::Each { u, v } => (u, v),
        }
    }

    /// The result for each of the values.
    pub(crate) fn map<U>(self, make: impl Fn(T) -> U) -> PerDirection<U> {
        match self {
            Self::Both(value) => PerDirection::Both(make(value)),
            Self::Each { u, v } => PerDirection::Each {
                u: make(u),
                v: make(v),
            },
        }
    }

    /// The value for both directions if they have the same, or there is only one.
    pub(crate) fn of(u: T, v: Option<T>) -> Self
    where
        T: PartialEq,
    {
        match v {
            Some(v) if v != u => Self::Each { u, v },
            _ => Self::Both(u),
        }
    }

    /// Returns true if each direction has a value of its own.
    pub(crate) fn is_each(&self) -> bool {
        matches!(self, Self::Each { .. })
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PerDirection<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PerDirectionVisitor(PhantomData))
    }
}

struct PerDirectionVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for PerDirectionVisitor<T> {
    type Value = PerDirection<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value for both directions, or {\"u\": …, \"v\": …}")
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        T::deserialize(UnitDeserializer::new()).map(PerDirection::Both)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        T::deserialize(BoolDeserializer::new(value)).map(PerDirection::Both)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        T::deserialize(U64Deserializer::new(value)).map(PerDirection::Both)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        T::deserialize(I64Deserializer::new(value)).map(PerDirection::Both)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        T::deserialize(F64Deserializer::new(value)).map(PerDirection::Both)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Self::Value, E> {
        T::deserialize(StrDeserializer::new(value)).map(PerDirection::Both)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(list)).map(PerDirection::Both)
    }

    /// The first name decides: u or v start a pair, anything else is a value for both.
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut name = map.next_key::<String>()?;
        if !matches!(name.as_deref(), Some("u" | "v")) {
            let map = MapAccessDeserializer::new(Peeked { name, map });
            return T::deserialize(map).map(PerDirection::Both);
        }
        let (mut u, mut v) = (None, None);
        while let Some(known) = name {
            let place = match known.as_str() {
                "u" => &mut u,
                "v" => &mut v,
                _ => return Err(below(&step(&known), unknown_field::<A::Error>(&known))),
            };
            if place.is_some() {
                return Err(below(&step(&known), "this field is given twice"));
            }
            *place = Some(map.next_value()?);
            name = map.next_key()?;
        }
        Ok(PerDirection::Each {
            u: given(u, "u")?,
            v: given(v, "v")?,
        })
    }
}

fn unknown_field<E: Error>(name: &str) -> E {
    E::unknown_field(name, &["u", "v"])
}

/// The value of a field, or the default for a missing one.
fn given<'de, T: Deserialize<'de>, E: Error>(value: Option<T>, name: &'static str) -> Result<T, E> {
    let absent = || T::deserialize(UnitDeserializer::<E>::new());
    value.map_or_else(|| absent().map_err(|_| E::missing_field(name)), Ok)
}

/// The schema of a whole number, zero or greater, where a name is needed for it.
pub(crate) enum Count {}

impl JsonSchema for Count {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "integer", "minimum": 0})
    }
}

/// The step of a JSON pointer to a direction, if there is one value for each.
pub(crate) fn direction(each: bool, axis: Axis) -> &'static str {
    match (each, axis) {
        (false, _) => "",
        (true, Axis::U) => "/u",
        (true, Axis::V) => "/v",
    }
}

impl<T: JsonSchema> JsonSchema for PerDirection<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("PerDirectionOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut choices = one_of(T::json_schema(generator), generator.subschema_for::<T>());
        choices.push(generator.subschema_for::<Pair<T>>().to_value());
        json_schema!({"oneOf": choices})
    }
}

/// The choices of a schema. Client generators understand a reference to an object among the choices of another schema,
/// but no reference to a choice, a list or a name.
fn one_of(mut schema: Schema, reference: Schema) -> Vec<Value> {
    if let Some(Value::Array(choices)) = schema.get("oneOf") {
        return choices.clone();
    }
    if schema.get("properties").is_some() {
        return vec![reference.to_value()];
    }
    for about in ["description", "examples"] {
        schema.remove(about);
    }
    vec![schema.to_value()]
}

/// The schema of a value for each direction, under a name of its own, so that generated clients have a type for it.
pub(crate) struct Pair<T>(PhantomData<T>);

impl<T: JsonSchema> JsonSchema for Pair<T> {
    fn schema_name() -> Cow<'static, str> {
        let name = T::schema_name();
        let (first, rest) = name.split_at(1);
        format!("{}{rest}Pair", first.to_uppercase()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = T::json_schema(generator);
        let is_boolean = one.get("type").is_some_and(|it| it == "boolean");
        let example = match one.get("examples") {
            Some(examples) => examples[0].clone(),
            None if is_boolean => Value::Bool(true),
            None => Value::from(8),
        };
        let value = |description: &str, generator: &mut SchemaGenerator| {
            let mut schema = generator.subschema_for::<T>();
            schema.insert("description".to_owned(), json!(description));
            schema
        };
        json_schema!({
            "description": "A value for each direction of a surface.",
            "type": "object",
            "properties": {
                "u": value("For u, from row to row.", generator),
                "v": value("For v, from column to column.", generator),
            },
            "required": ["u", "v"],
            "additionalProperties": false,
            "examples": [{"u": example, "v": example}],
        })
    }
}
