//! What can be read, and from which kinds of values.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::members::Members;
use super::reading::Reading;
use crate::model::short::quoted;

/// Values may stand within one another so deeply. No part of a job needs more than eight.
const DEEPEST: usize = 64;

/// Reads a value. Whatever a reader does not say it takes is noted as a mistake; without a value
/// there is one.
pub trait Reader: Sized {
    /// What is read.
    type Value;

    /// What a value should be: "a number".
    fn expected(&self) -> String;

    /// The value of a field that is not there; none if it must be.
    fn absent(self) -> Option<Self::Value> {
        None
    }

    /// Reads `null`.
    fn null(self, at: &mut Reading) -> Option<Self::Value> {
        at.mismatch(&self.expected(), "null");
        None
    }

    /// Reads `true` or `false`.
    fn boolean(self, value: bool, at: &mut Reading) -> Option<Self::Value> {
        at.mismatch(&self.expected(), &value.to_string());
        None
    }

    /// Reads a number.
    fn number(self, value: Numeral, at: &mut Reading) -> Option<Self::Value> {
        at.mismatch(&self.expected(), &value.to_string());
        None
    }

    /// Reads a text.
    fn text(self, value: &str, at: &mut Reading) -> Option<Self::Value> {
        at.mismatch(&self.expected(), &quoted(value));
        None
    }

    /// Reads a list, to its end.
    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Self::Value>, A::Error> {
        at.mismatch(&self.expected(), "a list");
        at.check()?;
        Anything.list(list, at)?;
        Ok(None)
    }

    /// Reads an object, to its end.
    fn object<'de, A: MapAccess<'de>>(
        self,
        members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<Self::Value>, A::Error> {
        at.mismatch(&self.expected(), "an object");
        at.check()?;
        Anything.object(members, at)?;
        Ok(None)
    }
}

/// A number, as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numeral {
    /// A whole number, zero or greater.
    Whole(u64),
    /// A whole number below zero.
    Negative(i64),
    /// Any other.
    Real(f64),
}

impl Numeral {
    /// The nearest number of 64 bits.
    pub fn real(self) -> f64 {
        match self {
            Self::Whole(value) => value as f64,
            Self::Negative(value) => value as f64,
            Self::Real(value) => value,
        }
    }

    /// The whole number that it is: 3.0 and 3e0 are 3, as in JSON schemas.
    pub fn whole(self) -> Option<u64> {
        /// Up to here every whole number is a number of its own.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        match self {
            Self::Whole(value) => Some(value),
            Self::Negative(_) => None,
            Self::Real(value) => {
                let is_whole = (0.0..=EXACT).contains(&value) && value.fract() == 0.0;
                is_whole.then_some(value as u64)
            }
        }
    }
}

impl fmt::Display for Numeral {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(value) => write!(f, "{value}"),
            Self::Negative(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value:?}"),
        }
    }
}

/// Reads a value of this type.
#[derive(Clone, Copy, Debug)]
pub struct Of<T>(PhantomData<T>);

/// What can be read. All that [`Of`] reads can be.
pub trait Read: Sized {
    /// What reads it.
    type By: Reader<Value = Self>;

    /// The reader.
    fn reader() -> Self::By;
}

impl<T> Read for T
where
    Of<T>: Reader<Value = T>,
{
    type By = Of<T>;

    fn reader() -> Of<T> {
        Of(PhantomData)
    }
}

/// A value that may be left out, or null.
impl<T> Reader for Of<Option<T>>
where
    T: Read,
{
    type Value = Option<T>;

    fn expected(&self) -> String {
        T::reader().expected()
    }

    fn absent(self) -> Option<Option<T>> {
        Some(None)
    }

    fn null(self, _: &mut Reading) -> Option<Option<T>> {
        Some(None)
    }

    fn boolean(self, value: bool, at: &mut Reading) -> Option<Option<T>> {
        T::reader().boolean(value, at).map(Some)
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<Option<T>> {
        T::reader().number(value, at).map(Some)
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<Option<T>> {
        T::reader().text(value, at).map(Some)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Option<T>>, A::Error> {
        Ok(T::reader().list(list, at)?.map(Some))
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<Option<T>>, A::Error> {
        Ok(T::reader().object(members, at)?.map(Some))
    }
}

/// Passes over a value.
#[derive(Clone, Copy, Debug)]
pub struct Anything;

impl Reader for Anything {
    type Value = ();

    fn expected(&self) -> String {
        "anything".to_owned()
    }

    fn null(self, _: &mut Reading) -> Option<()> {
        Some(())
    }

    fn boolean(self, _: bool, _: &mut Reading) -> Option<()> {
        Some(())
    }

    fn number(self, _: Numeral, _: &mut Reading) -> Option<()> {
        Some(())
    }

    fn text(self, _: &str, _: &mut Reading) -> Option<()> {
        Some(())
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        mut list: A,
        at: &mut Reading,
    ) -> Result<Option<()>, A::Error> {
        while list.next_element_seed(Seed(self, at))?.is_some() {}
        Ok(Some(()))
    }

    fn object<'de, A: MapAccess<'de>>(
        self,
        mut members: Members<A>,
        at: &mut Reading,
    ) -> Result<Option<()>, A::Error> {
        while members.next_name()? {
            members.value(self, at)?;
        }
        Ok(Some(()))
    }
}

impl<'de, A: MapAccess<'de>> Members<A> {
    /// Reads the value of the member.
    pub(super) fn value<R: Reader>(
        &mut self,
        reader: R,
        at: &mut Reading,
    ) -> Result<Option<R::Value>, A::Error> {
        self.map.next_value_seed(Seed(reader, at))
    }
}

/// Reads a value, and notes what is wrong with it.
pub(super) struct Seed<'a, R>(pub(super) R, pub(super) &'a mut Reading);

impl<'de, R: Reader> DeserializeSeed<'de> for Seed<'_, R> {
    type Value = Option<R::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, R: Reader> Visitor<'de> for Seed<'_, R> {
    type Value = Option<R::Value>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.expected())
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        Ok(self.0.null(self.1))
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        Ok(self.0.boolean(value, self.1))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        Ok(self.0.number(Numeral::Whole(value), self.1))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        Ok(self.0.number(Numeral::Negative(value), self.1))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        Ok(self.0.number(Numeral::Real(value), self.1))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Self::Value, E> {
        Ok(self.0.text(value, self.1))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        let Self(reader, at) = self;
        at.deeper(DEEPEST, |at| reader.list(list, at))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        let Self(reader, at) = self;
        at.deeper(DEEPEST, |at| reader.object(Members::new(map), at))
    }
}
