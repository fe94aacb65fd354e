//! Enumerations whose values have names, which are the same in JSON, in queries and in stores.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserializer;
use serde::de::{Error, Visitor};

use super::short::quoted;

/// A value with a name.
pub trait Named: Copy + PartialEq + 'static {
    /// What a value is: "kind of basis".
    const WHAT: &'static str = "choice";

    /// All values with their names; the first is the one that is meant if none is chosen.
    const ALL: &'static [(Self, &'static str)];

    /// The names.
    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|(_, name)| *name).collect()
    }

    /// What it is called.
    fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(value, _)| *value == self);
        entry.map_or("", |(_, name)| name)
    }

    /// The value of a name.
    fn of_name(name: &str) -> Option<Self> {
        let entry = Self::ALL.iter().find(|(_, known)| *known == name);
        entry.map(|(value, _)| *value)
    }

    /// What a reader of it expects.
    fn expected() -> String {
        let names = Self::names().join(", ");
        format!("the name of a {}: {names}", Self::WHAT)
    }

    /// The value of a name, or what is wrong with it.
    fn read<E: Error>(name: &str) -> Result<Self, E> {
        Self::of_name(name).ok_or_else(|| {
            let (name, names) = (quoted(name), Self::names().join(", "));
            E::custom(format_args!(
                "{name} is no {}; there are {names}",
                Self::WHAT
            ))
        })
    }
}

/// Reads a value by its name.
pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    struct NameVisitor<T>(PhantomData<T>);

    impl<T: Named> Visitor<'_> for NameVisitor<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(&T::expected())
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
            T::read(name)
        }
    }

    deserializer.deserialize_str(NameVisitor(PhantomData))
}

/// Gives the values of an enumeration their names, in JSON, too.
macro_rules! names {
    ($type:ty, $what:literal, [$($name:literal => $value:ident),+ $(,)?]) => {
        impl $crate::model::named::Named for $type {
            const WHAT: &'static str = $what;
            const ALL: &'static [(Self, &'static str)] = &[$((Self::$value, $name),)+];
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::model::named::Named::name(*self))
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                $crate::model::named::deserialize(d)
            }
        }
    };
}
pub(crate) use names;

/// Declares an enumeration with the names of its values.
macro_rules! named {
    ($(#[$about:meta])* $type:ident, $what:literal { $($(#[$meaning:meta])* $value:ident = $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type {
            $($(#[$meaning])* $value,)+
        }

        $crate::model::named::names!($type, $what, [$($name => $value),+]);
    };
}
pub(crate) use named;
