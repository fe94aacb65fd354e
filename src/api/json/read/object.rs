//! Objects with their fields.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};

use super::reader::Seed;
use super::{Anything, PathStep, Read, Reader, Reading};
use crate::model::short::{cut, quoted};

/// The most characters of a name that are kept. No field has a longer one.
const LONGEST_NAME: usize = 100;

/// The members of an object, one after the other.
#[derive(Debug)]
pub struct Members<A> {
    map: A,
    /// The name of the last member that was seen.
    name: String,
    /// It was seen, but not taken.
    waiting: bool,
}

impl<'de, A: MapAccess<'de>> Members<A> {
    pub(super) fn new(map: A) -> Self {
        Self {
            map,
            name: String::new(),
            waiting: false,
        }
    }

    /// The name of the next member, which stays there.
    pub fn peek(&mut self) -> Result<Option<&str>, A::Error> {
        self.waiting = self.waiting || self.next_name()?;
        Ok(self.waiting.then_some(self.name.as_str()))
    }

    /// Goes to the next member, if there is one.
    pub(super) fn next_name(&mut self) -> Result<bool, A::Error> {
        if std::mem::take(&mut self.waiting) {
            return Ok(true);
        }
        let name = self.map.next_key_seed(NameSeed(&mut self.name))?;
        Ok(name.is_some())
    }

    /// Goes to the next member with one of these names; others are mistakes.
    pub fn next(
        &mut self,
        names: &[&'static str],
        at: &mut Reading,
    ) -> Result<Option<&'static str>, A::Error> {
        while self.next_name()? {
            if let Some(name) = names.iter().find(|name| **name == self.name) {
                return Ok(Some(name));
            }
            let detail = format!(
                "unknown field {}; there are {}",
                quoted(&self.name),
                names.join(", ")
            );
            at.wrong_field(&self.name, detail);
            at.check()?;
            self.value(Anything, at)?;
        }
        Ok(None)
    }

    /// Reads the value of the member.
    pub(super) fn value<R: Reader>(
        &mut self,
        reader: R,
        at: &mut Reading,
    ) -> Result<Option<R::Value>, A::Error> {
        self.map.next_value_seed(Seed(reader, at))
    }

    /// Reads a field into its place; the field is given once.
    pub fn field<T>(
        &mut self,
        name: &'static str,
        place: &mut Field<T>,
        at: &mut Reading,
    ) -> Result<(), A::Error>
    where
        T: Read,
    {
        if !matches!(place, Field::Absent) {
            at.wrong_field(name, "this field is given twice");
            self.value(Anything, at)?;
            return at.check();
        }
        let value = at.within(PathStep::Field(name), |at| self.value(T::reader(), at))?;
        *place = value.map_or(Field::Wrong, Field::Given);
        at.check()
    }
}

/// What was read of a field.
#[derive(Debug)]
pub enum Field<T> {
    /// It is not there.
    Absent,
    /// It is wrong, which has been noted.
    Wrong,
    /// It is there.
    Given(T),
}

impl<T> Field<T>
where
    T: Read,
{
    /// The value; without one there is a mistake.
    pub fn value(self, name: &str, at: &mut Reading) -> Option<T> {
        match self {
            Self::Given(value) => Some(value),
            Self::Wrong => None,
            Self::Absent => {
                let value = T::reader().absent();
                if value.is_none() {
                    at.wrong(format!("the field {name:?} is missing"));
                }
                value
            }
        }
    }
}

/// Reads the name of a member into a text, which is cut if no field has so long a name.
struct NameSeed<'a>(&'a mut String);

impl<'de> DeserializeSeed<'de> for NameSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for NameSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<(), E> {
        self.0.clear();
        self.0.push_str(&cut(name, LONGEST_NAME));
        Ok(())
    }
}

/// Makes a type readable from objects with these fields; an object with a kind also from its name
/// alone, with a function that makes the object of it.
macro_rules! object {
    ($type:ty, $expected:literal, [$($field:ident),+ $(,)?] $(, of_name: $short:expr)?) => {
        impl $crate::api::json::read::Reader for $crate::api::json::read::Of<$type> {
            type Value = $type;

            fn expected(&self) -> String {
                $expected.to_owned()
            }

            $(fn text(
                self,
                name: &str,
                at: &mut $crate::api::json::read::Reading,
            ) -> Option<$type> {
                $short(name, at)
            })?

            fn object<'de, A: serde::de::MapAccess<'de>>(
                self,
                mut members: $crate::api::json::read::Members<A>,
                at: &mut $crate::api::json::read::Reading,
            ) -> Result<Option<$type>, A::Error> {
                use $crate::api::json::read::Field;
                $(let mut $field = Field::Absent;)+
                while let Some(name) = members.next(&[$(stringify!($field)),+], at)? {
                    match name {
                        $(stringify!($field) => members.field(name, &mut $field, at)?,)+
                        _ => {}
                    }
                }
                // Of all fields, before it is looked at whether one is missing.
                $(let $field = $field.value(stringify!($field), at);)+
                Ok((|| Some(Self::Value { $($field: $field?),+ }))())
            }
        }
    };
}
pub(in crate::api) use object;
