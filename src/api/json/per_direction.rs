//! One value for both directions of a surface, or one for each: `X` or `{"u": X, "v": X}`.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde::de::{MapAccess, SeqAccess};
use serde_json::{Value, json};

use crate::fit::invalid::Axis;

use super::read::{Field, Members, Numeral, Of, Read, Reader, Reading};

/// A value for both directions, or one for each.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub enum PerDirection<T> {
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
    pub fn split(self) -> (T, T)
    where
        T: Clone,
    {
        match self {
            Self::Both(value) => (value.clone(), value),
            Self::Each { u, v } => (u, v),
        }
    }

    /// What is made of each of the values.
    pub fn map<U>(self, make: impl Fn(T) -> U) -> PerDirection<U> {
        match self {
            Self::Both(value) => PerDirection::Both(make(value)),
            Self::Each { u, v } => PerDirection::Each {
                u: make(u),
                v: make(v),
            },
        }
    }

    /// Whether each direction has a value of its own.
    pub fn is_each(&self) -> bool {
        matches!(self, Self::Each { .. })
    }
}

/// What a JSON pointer has for a direction, if there is one value for each.
pub fn direction(each: bool, axis: Axis) -> &'static str {
    match (each, axis) {
        (false, _) => "",
        (true, Axis::U) => "/u",
        (true, Axis::V) => "/v",
    }
}

impl<T> Reader for Of<PerDirection<T>>
where
    T: Read,
{
    type Value = PerDirection<T>;

    fn expected(&self) -> String {
        let one = T::reader().expected();
        format!("{one}; or one for each direction, {{\"u\": …, \"v\": …}}")
    }

    fn boolean(self, value: bool, at: &mut Reading) -> Option<PerDirection<T>> {
        T::reader().boolean(value, at).map(PerDirection::Both)
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<PerDirection<T>> {
        T::reader().number(value, at).map(PerDirection::Both)
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<PerDirection<T>> {
        T::reader().text(value, at).map(PerDirection::Both)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<PerDirection<T>>, A::Error> {
        Ok(T::reader().list(list, at)?.map(PerDirection::Both))
    }

    /// The first name decides: u or v start a pair, anything else is a value for both.
    fn object<'de, A: MapAccess<'de>>(
        self,
        mut members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<PerDirection<T>>, A::Error> {
        if !matches!(members.peek()?, Some("u" | "v")) {
            let both = T::reader().object(members, at)?;
            return Ok(both.map(PerDirection::Both));
        }
        let (mut u, mut v) = (Field::Absent, Field::Absent);
        while let Some(name) = members.next(&["u", "v"], at)? {
            let place = if name == "u" { &mut u } else { &mut v };
            members.field(name, place, at)?;
        }
        let (u, v) = (u.value("u", at), v.value("v", at));
        Ok(u.zip(v).map(|(u, v)| PerDirection::Each { u, v }))
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

/// The choices of a schema. Generators of clients understand a reference to an object among the choices
/// of another schema, but no reference to what is a choice itself, a list or a name.
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

/// The schema of a value for each direction, under a name of its own: generated clients have a type
/// for it.
pub struct Pair<T>(PhantomData<T>);

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
