//! Objects with their fields.

use serde::de::MapAccess;

use super::members::Members;
use super::reader::{Anything, Read, Reader};
use super::reading::{PathStep, Reading};

impl<'de, A: MapAccess<'de>> Members<A> {
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
            at.unknown_field(&self.name, names);
            at.check()?;
            self.value(Anything, at)?;
        }
        Ok(None)
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

/// Makes a type readable from objects with these fields; an object with a kind also from its name
/// alone, with a function that makes the object of it. Where the value of a field says which others
/// there are, a function of it names those.
macro_rules! object {
    ($type:ty, $expected:literal, [$($field:ident),+ $(,)?] $(, of_name: $short:expr)? $(, fields_by $by:ident: $fields:expr)?) => {
        impl $crate::api::json::read::reader::Reader for $crate::api::json::read::reader::Of<$type> {
            type Value = $type;

            fn expected(&self) -> String {
                $expected.to_owned()
            }

            $(fn text(
                self,
                name: &str,
                at: &mut $crate::api::json::read::reading::Reading,
            ) -> Option<$type> {
                $short(name, at)
            })?

            fn object<'de, A: serde::de::MapAccess<'de>>(
                self,
                mut members: $crate::api::json::read::members::Members<A>,
                at: &mut $crate::api::json::read::reading::Reading,
            ) -> Result<Option<$type>, A::Error> {
                use $crate::api::json::read::object::Field;
                $(let mut $field = Field::Absent;)+
                while let Some(name) = members.next(&[$(stringify!($field)),+], at)? {
                    match name {
                        $(stringify!($field) => members.field(name, &mut $field, at)?,)+
                        _ => {}
                    }
                }
                // Of all fields, before it is looked at whether one is missing.
                $(let $field = $field.value(stringify!($field), at);)+
                $(if let Some(by) = &$by {
                    at.there_are(&$fields(by));
                })?
                Ok((|| Some(Self::Value { $($field: $field?),+ }))())
            }
        }
    };
}
pub(in crate::api) use object;
