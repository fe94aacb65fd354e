//! The members of an object, one after the other.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};

use crate::model::short::cut;

/// The most characters of a name that are kept. No field has a longer one.
const LONGEST_NAME: usize = 100;

/// The members of an object, one after the other.
#[derive(Debug)]
pub struct Members<A> {
    /// What they are taken from.
    pub(super) map: A,
    /// The name of the last member that was seen.
    pub(super) name: String,
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
