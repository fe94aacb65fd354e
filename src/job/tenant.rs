//! Tenants: the owners of jobs.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use parking_lot::Mutex;
use serde::{Deserialize, Deserializer, Serialize, de};

/// The most bytes of a name.
const LONGEST: usize = 64;

/// All names so far. They are kept forever, as their number is bounded by tokens and jobs.
static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// A tenant, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub(crate) struct Tenant(&'static str);

impl Tenant {
    /// The owner of jobs that were made without a token.
    pub(crate) const DEFAULT: Self = Self("default");

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        self.0
    }
}

impl FromStr for Tenant {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-._".contains(c);
        if name.is_empty() || name.len() > LONGEST || !name.chars().all(plain) {
            return Err(format!(
                "the name of a tenant has 1 to {LONGEST} letters, digits, -, . and _"
            ));
        }
        let mut names = NAMES.lock();
        if let Some(known) = names.get(name) {
            return Ok(Self(known));
        }
        let name = Box::leak(Box::from(name));
        names.insert(name);
        Ok(Self(name))
    }
}

impl fmt::Display for Tenant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl<'de> Deserialize<'de> for Tenant {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        String::deserialize(input)?
            .parse()
            .map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_tenants_are_those_of_their_names() {
        let cad: Tenant = "cad.example".parse().unwrap();
        assert_eq!(cad, "cad.example".parse().unwrap());
        assert_ne!(cad, Tenant::DEFAULT);
        assert_eq!("default".parse(), Ok(Tenant::DEFAULT));
        for name in ["", "a b", "a\nb", "ä", &"a".repeat(65)] {
            assert!(name.parse::<Tenant>().is_err(), "{name:?}");
        }
    }
}
