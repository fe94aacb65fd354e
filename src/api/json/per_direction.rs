//! One value for both directions of a surface, or one for each: `X` or `{"u": X, "v": X}`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{MapAccess, SeqAccess};

use super::read::{Field, Members, Numeral, Of, Read, Reader, Reading};
use super::schema::each;

/// A value for both directions, or one for each.
#[derive(Clone, Copy, Debug)]
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
        let one = generator.subschema_for::<T>();
        json_schema!({"anyOf": [one.clone(), each(&one)]})
    }
}
