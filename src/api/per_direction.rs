//! One value for both directions of a surface, or one for each: `X` or `{"u": X, "v": X}`.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};

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

impl<T: Clone> PerDirection<T> {
    /// The values for u and v.
    pub fn split(self) -> (T, T) {
        match self {
            Self::Both(value) => (value.clone(), value),
            Self::Each { u, v } => (u, v),
        }
    }

    /// Whether each direction has a value of its own.
    pub fn is_each(&self) -> bool {
        matches!(self, Self::Each { .. })
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PerDirection<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DirectionVisitor(PhantomData))
    }
}

struct DirectionVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for DirectionVisitor<T> {
    type Value = PerDirection<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value for both directions, or {\"u\": …, \"v\": …}")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        T::deserialize(text.into_deserializer()).map(PerDirection::Both)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Self::Value, E> {
        T::deserialize(number.into_deserializer()).map(PerDirection::Both)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
        T::deserialize(number.into_deserializer()).map(PerDirection::Both)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(PerDirection::Both)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(list)).map(PerDirection::Both)
    }

    /// The first key decides: u or v start a pair, anything else is a value for both.
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let first: Option<String> = map.next_key()?;
        match first.as_deref() {
            Some("u") => pair(Direction::U, map),
            Some("v") => pair(Direction::V, map),
            _ => T::deserialize(MapAccessDeserializer::new(Unread { first, map }))
                .map(PerDirection::Both),
        }
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(field_identifier, rename_all = "lowercase")]
enum Direction {
    U,
    V,
}

fn pair<'de, T: Deserialize<'de>, A: MapAccess<'de>>(
    first: Direction,
    mut map: A,
) -> Result<PerDirection<T>, A::Error> {
    let (mut u, mut v) = (None, None);
    let mut key = Some(first);
    while let Some(direction) = key {
        let (slot, name) = match direction {
            Direction::U => (&mut u, "u"),
            Direction::V => (&mut v, "v"),
        };
        if slot.replace(map.next_value()?).is_some() {
            return Err(A::Error::duplicate_field(name));
        }
        key = map.next_key()?;
    }
    Ok(PerDirection::Each {
        u: u.ok_or_else(|| A::Error::missing_field("u"))?,
        v: v.ok_or_else(|| A::Error::missing_field("v"))?,
    })
}

/// A map whose first key was looked at and put back.
struct Unread<A> {
    first: Option<String>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Unread<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        match self.first.take() {
            Some(first) => seed
                .deserialize(StrDeserializer::<A::Error>::new(&first))
                .map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
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
