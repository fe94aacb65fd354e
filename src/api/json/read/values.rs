//! Numbers, counts, names, texts, and lists of such.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::SeqAccess;

use super::reader::{Numeral, Of, Read, Reader};
use super::reading::{ListLimits, Most, Reading};

/// The most characters of a text. Whatever is longer is no name of anything.
pub const LONGEST_TEXT: usize = 200;

impl Reader for Of<usize> {
    type Value = usize;

    fn expected(&self) -> String {
        "a whole number, zero or greater".to_owned()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<usize> {
        let count = value.whole().and_then(|count| usize::try_from(count).ok());
        if count.is_none() {
            at.mismatch(&self.expected(), &value.to_string());
        }
        count
    }
}

/// The schema of a whole number, zero or greater, where a name is needed for it.
pub enum Count {}

impl JsonSchema for Count {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "integer", "minimum": 0})
    }
}

/// Finite numbers: JSON has no others.
impl Reader for Of<f64> {
    type Value = f64;

    fn expected(&self) -> String {
        "a number".to_owned()
    }

    fn null(self, at: &mut Reading) -> Option<f64> {
        let found = "null (what many writers make of NaN and Infinity)";
        at.mismatch(&self.expected(), found);
        None
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<f64> {
        Some(value.real())
    }
}

impl Reader for Of<bool> {
    type Value = bool;

    fn expected(&self) -> String {
        "true or false".to_owned()
    }

    fn boolean(self, value: bool, _: &mut Reading) -> Option<bool> {
        Some(value)
    }
}

impl Reader for Of<String> {
    type Value = String;

    fn expected(&self) -> String {
        "a string".to_owned()
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<String> {
        if value.chars().nth(LONGEST_TEXT).is_some() {
            at.wrong(format!("it is longer than {LONGEST_TEXT} characters"));
            return None;
        }
        Some(value.to_owned())
    }
}

/// What lists have as elements.
pub trait Element {
    /// What they are called.
    const MANY: &'static str;

    /// How many of them a list has at most.
    fn most(limits: ListLimits) -> usize;
}

impl<T: Element> Reader for Of<Vec<T>>
where
    T: Read,
{
    type Value = Vec<T>;

    fn expected(&self) -> String {
        format!("a list of {}", T::MANY)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Vec<T>>, A::Error> {
        let mut elements = Vec::new();
        let most = Most::of(T::most(at.limits()), T::MANY);
        let whole = at.elements(list, most, T::reader, |element, _| {
            elements.push(element);
            Some(())
        })?;
        Ok(whole.then_some(elements))
    }
}

/// Makes enumerations of the model readable from their names.
macro_rules! choices {
    ($($type:ty),+) => {$(
        impl $crate::api::json::read::reader::Reader for $crate::api::json::read::reader::Of<$type> {
            type Value = $type;

            fn expected(&self) -> String {
                "a string".to_owned()
            }

            fn text(
                self,
                name: &str,
                at: &mut $crate::api::json::read::reading::Reading,
            ) -> Option<$type> {
                use $crate::model::named::Named;
                let value = <$type>::of_name(name);
                if value.is_none() {
                    at.wrong(format!(
                        "{} is no choice; there are {}",
                        $crate::model::short::quoted(name),
                        <$type>::names().join(", ")
                    ));
                }
                value
            }
        }
    )+};
}
pub(in crate::api) use choices;

/// Makes an enumeration readable from names.
macro_rules! names {
    ($type:ty, $what:literal, [$($name:literal => $variant:ident),+ $(,)?]) => {
        impl $type {
            /// How clients write them.
            pub(in crate::api) const NAMES: &[&'static str] = &[$($name),+];

            /// How clients write it.
            #[allow(dead_code, reason = "not all enumerations are written")]
            pub(in crate::api) fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl $crate::api::json::read::reader::Reader for $crate::api::json::read::reader::Of<$type> {
            type Value = $type;

            fn expected(&self) -> String {
                format!("the name of a {}: {}", $what, Self::Value::NAMES.join(", "))
            }

            fn text(
                self,
                name: &str,
                at: &mut $crate::api::json::read::reading::Reading,
            ) -> Option<$type> {
                match name {
                    $($name => return Some(Self::Value::$variant),)+
                    _ => at.wrong(format!(
                        "{} is no {}; there are {}",
                        $crate::model::short::quoted(name),
                        $what,
                        Self::Value::NAMES.join(", ")
                    )),
                }
                None
            }
        }
    };
}
pub(in crate::api) use names;
