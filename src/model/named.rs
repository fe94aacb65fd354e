//! Enumerations whose values have names, which are the same in JSON, in queries and in stores; and rules with names,
//! which may be replaced by numbers.

use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

use serde::Deserializer;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, SeqAccess, Visitor};

use super::list_limits;
use piad_files::text::quoted;

/// A value with a name.
pub(crate) trait Named: Copy + PartialEq + 'static {
    /// What a value is, for errors: "kind of basis".
    const WHAT: &'static str = "choice";

    /// All values with their names; the first is the default.
    const ALL: &'static [(Self, &'static str)];

    /// The names.
    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|(_, name)| *name).collect()
    }

    /// Its name.
    fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(value, _)| *value == self);
        entry.map_or("", |(_, name)| name)
    }

    /// The value of a name.
    fn of_name(name: &str) -> Option<Self> {
        let entry = Self::ALL.iter().find(|(_, known)| *known == name);
        entry.map(|(value, _)| *value)
    }

    /// The expected form, for errors.
    fn expected() -> String {
        let names = Self::names().join(", ");
        format!("the name of a {}: {names}", Self::WHAT)
    }

    /// The value of a name, or the error.
    fn read<E: Error>(name: &str) -> Result<Self, E> {
        Self::of_name(name).ok_or_else(|| unknown(name, Self::WHAT, &Self::names()))
    }
}

/// The error for an unknown name.
fn unknown<E: Error>(name: &str, what: &str, names: &[&str]) -> E {
    let (name, names) = (quoted(name), names.join(", "));
    E::custom(format_args!(
        "unknown {what} {name}; expected one of {names}"
    ))
}

/// Reads a value by its name.
pub(crate) fn deserialize<'de, T: Named, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
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

        $crate::model::named::by_name!($type);
    };
}
pub(crate) use names;

/// Writes and reads a value by its name.
macro_rules! by_name {
    ($type:ty) => {
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
pub(crate) use by_name;

/// Declares the JSON of a setting of a fit: the names of its values.
macro_rules! setting {
    ($(#[$about:meta])* $written:ident($type:ident), $what:literal, [$($name:literal => $value:ident),+ $(,)?]) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) struct $written(pub $type);

        impl $crate::model::named::Named for $written {
            const WHAT: &'static str = $what;
            const ALL: &'static [(Self, &'static str)] = &[$((Self($type::$value), $name),)+];
        }

        $crate::model::named::by_name!($written);
    };
}
pub(crate) use setting;

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

/// A rule that has a name, or explicit numbers.
pub(crate) trait Rule: Clone + PartialEq + 'static {
    /// What a rule is, for errors: "rule for knots".
    const WHAT: &'static str;

    /// All rules with their names.
    const RULES: &'static [(Self, &'static str)];

    /// The choice of these numbers.
    fn explicit(numbers: Arc<Vec<f64>>) -> Self;

    /// The names of the rules.
    fn names() -> Vec<&'static str> {
        Self::RULES.iter().map(|(_, name)| *name).collect()
    }

    /// The name of a rule.
    fn name(&self) -> Option<&'static str> {
        let entry = Self::RULES.iter().find(|(rule, _)| rule == self);
        entry.map(|(_, name)| *name)
    }
}

/// Reads a rule by its name, or explicit numbers.
pub(crate) fn read_rule<'de, T: Rule, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    struct RuleVisitor<T>(PhantomData<T>);

    impl<'de, T: Rule> Visitor<'de> for RuleVisitor<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            let names = T::names().join(", ");
            write!(
                f,
                "the name of a {}: {names}; or a list of numbers",
                T::WHAT
            )
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
            let entry = T::RULES.iter().find(|(_, known)| *known == name);
            let rule = entry.map(|(rule, _)| rule.clone());
            rule.ok_or_else(|| unknown(name, T::WHAT, &T::names()))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T, A::Error> {
            let numbers = list_limits::numbers(SeqAccessDeserializer::new(list))?;
            Ok(T::explicit(Arc::new(numbers)))
        }
    }

    deserializer.deserialize_any(RuleVisitor(PhantomData))
}

/// Declares the JSON of a rule of a fit: its name; numbers are its variant `Explicit`.
macro_rules! rules {
    ($(#[$about:meta])* $written:ident($type:ident), $what:literal, [$($name:literal => $rule:ident),+ $(,)?]) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $written(pub $type);

        impl $crate::model::named::Rule for $written {
            const WHAT: &'static str = $what;
            const RULES: &'static [(Self, &'static str)] = &[$((Self($type::$rule), $name),)+];

            fn explicit(numbers: std::sync::Arc<Vec<f64>>) -> Self {
                Self($type::Explicit(numbers))
            }
        }

        impl serde::Serialize for $written {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                match &self.0 {
                    $type::Explicit(numbers) => serializer.collect_seq(numbers.iter()),
                    _ => $crate::model::named::Rule::name(self).serialize(serializer),
                }
            }
        }

        impl<'de> serde::Deserialize<'de> for $written {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                $crate::model::named::read_rule(d)
            }
        }
    };
}
pub(crate) use rules;
