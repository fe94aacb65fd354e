//! Defaults of the items of a batch, and their merging with an item.
//!
//! The fields of an item replace those of the defaults; objects are merged field by field (RFC 7396), except those with
//! another `kind`, such as another method, which are replaced as a whole. `null` removes a default. A curve has only
//! the defaults of curves, and a surface those of surfaces.

use std::fmt;

use bytes::Bytes;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use crate::api::json::request;
use crate::api::problem::{Kind, Location, Problem};

/// The default fields of items.
pub(super) enum Defaults {
    /// As JSON.
    Json(Fields),
    /// As the bytes of a message: two messages are merged by reading one after the other.
    Message(Bytes),
}

/// The fields of an object.
pub(super) struct Fields(Vec<(String, Field)>);

/// The value of a field.
enum Field {
    Object(Fields),
    /// Anything else, as JSON.
    Value(Box<str>),
}

impl Defaults {
    /// Reads the defaults of a batch in JSON: fields of a job without points, which are checked.
    pub(super) fn json(text: &Bytes, most_points: usize) -> Result<Self, Problem> {
        request::job::check_defaults(text, most_points).map_err(|problem| {
            problem.relocated(|place| match place {
                Location::Pointer(pointer) => Location::Pointer(format!("/defaults{pointer}")),
                place => place,
            })
        })?;
        let raw: &RawValue = serde_json::from_slice(text).map_err(|_| unreadable())?;
        match Field::of(raw) {
            Field::Object(fields) => Ok(Self::Json(fields)),
            Field::Value(_) => Err(unreadable()),
        }
    }

    /// An item with the defaults filled in. A value that is not an object is unchanged.
    pub(super) fn merge(&self, item: &Bytes) -> Bytes {
        match self {
            Self::Message(defaults) => [&defaults[..], &item[..]].concat().into(),
            Self::Json(defaults) => match serde_json::from_slice(item) {
                Ok(raw) => {
                    let mut merged = String::with_capacity(item.len() + defaults.size());
                    defaults.merge(&raw, true, &mut merged);
                    Bytes::from(merged)
                }
                Err(_) => item.clone(),
            },
        }
    }

    /// Returns true if a JSON pointer into a merged item leads to a part of the defaults.
    pub(super) fn has(&self, pointer: &str, item: &[u8]) -> bool {
        let Self::Json(defaults) = self else {
            return false;
        };
        let names = || pointer.split('/').skip(1);
        let of_item = serde_json::from_slice(item).map_or(0, |item| depth(&item, names()));
        defaults.depth(names()) > of_item
    }

    /// The approximate number of bytes it adds to an item.
    pub(super) fn size(&self) -> usize {
        match self {
            Self::Json(fields) => fields.size(),
            Self::Message(bytes) => bytes.len(),
        }
    }
}

fn unreadable() -> Problem {
    let detail = "expected an object with fields of a job";
    Problem::at_pointer(Kind::InvalidFit, "/defaults".to_owned(), detail)
}

/// The fields of an object, unparsed.
struct Raw<'a>(Vec<(String, &'a RawValue)>);

impl<'de> Deserialize<'de> for Raw<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FieldsOf;
        impl<'de> Visitor<'de> for FieldsOf {
            type Value = Raw<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(Raw(fields))
            }
        }
        deserializer.deserialize_map(FieldsOf)
    }
}

impl<'a> Raw<'a> {
    /// The fields of a value that is an object.
    fn of(value: &'a RawValue) -> Option<Self> {
        let is_object = value.get().starts_with('{');
        is_object.then(|| serde_json::from_str(value.get()).ok())?
    }

    fn get(&self, name: &str) -> Option<&'a RawValue> {
        let mut fields = self.0.iter();
        fields.find(|(it, _)| it == name).map(|(_, value)| *value)
    }
}

impl Field {
    fn of(value: &RawValue) -> Self {
        match Raw::of(value) {
            Some(Raw(fields)) => {
                let field = |(name, value): (String, &RawValue)| (name, Self::of(value));
                Self::Object(Fields(fields.into_iter().map(field).collect()))
            }
            None => Self::Value(value.get().into()),
        }
    }

    fn write(&self, out: &mut String) {
        match self {
            Self::Value(text) => out.push_str(text),
            Self::Object(Fields(fields)) => {
                let mut object = Object::begin(out);
                for (name, field) in fields {
                    field.write(object.field(name));
                }
                object.end();
            }
        }
    }
}

impl Fields {
    fn get(&self, name: &str) -> Option<&Field> {
        let mut fields = self.0.iter();
        fields.find(|(it, _)| it == name).map(|(_, field)| field)
    }

    /// Writes an object with these fields in the place of those that it does not have.
    fn merge(&self, object: &Raw<'_>, is_job: bool, out: &mut String) {
        let mut merged = Object::begin(out);
        for (name, value) in &object.0 {
            let default = self.get(name);
            if value.get() == "null" && default.is_some() {
                continue;
            }
            let out = merged.field(name);
            match (default, Raw::of(value)) {
                (Some(Field::Object(fields)), Some(inner)) if !fields.differs_in_kind(&inner) => {
                    fields.merge(&inner, false, out);
                }
                _ => out.push_str(value.get()),
            }
        }
        for (name, field) in &self.0 {
            let other = match name.as_str() {
                "curve" if is_job => "surface",
                "surface" if is_job => "curve",
                _ => name,
            };
            if object.get(name).is_none() && object.get(other).is_none() {
                field.write(merged.field(name));
            }
        }
        merged.end();
    }

    /// Returns true if both have a kind and the kinds differ.
    fn differs_in_kind(&self, object: &Raw<'_>) -> bool {
        match (self.get("kind"), object.get("kind")) {
            (Some(Field::Value(own)), Some(other)) => **own != *other.get(),
            _ => false,
        }
    }

    /// The number of these names that lead from field to field.
    fn depth<'a>(&self, mut names: impl Iterator<Item = &'a str>) -> usize {
        match names.next().and_then(|name| self.get(name)) {
            None => 0,
            Some(Field::Object(fields)) => 1 + fields.depth(names),
            // Elements of a list are where the list is.
            Some(Field::Value(_)) => 1 + names.count(),
        }
    }

    fn size(&self) -> usize {
        let sizes = self.0.iter().map(|(name, field)| match field {
            Field::Value(text) => name.len() + text.len() + 4,
            Field::Object(fields) => name.len() + fields.size() + 6,
        });
        sizes.sum()
    }
}

/// The number of these names that lead from field to field of an object.
fn depth<'a>(object: &Raw<'_>, mut names: impl Iterator<Item = &'a str>) -> usize {
    match names.next().and_then(|name| object.get(name)) {
        None => 0,
        Some(value) => match Raw::of(value) {
            Some(inner) => 1 + depth(&inner, names),
            None => 1 + names.count(),
        },
    }
}

/// An object that is being written.
struct Object<'a> {
    out: &'a mut String,
    has_fields: bool,
}

impl<'a> Object<'a> {
    fn begin(out: &'a mut String) -> Self {
        out.push('{');
        Self {
            out,
            has_fields: false,
        }
    }

    /// Returns the text to which the value of a field is written.
    fn field(&mut self, name: &str) -> &mut String {
        if std::mem::replace(&mut self.has_fields, true) {
            self.out.push(',');
        }
        self.out
            .push_str(&serde_json::Value::from(name).to_string());
        self.out.push(':');
        self.out
    }

    fn end(self) {
        self.out.push('}');
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn defaults() -> Defaults {
        let text = json!({
            "curve": {"degree": 3, "closed": true},
            "surface": {"degree": 2},
            "method": {"kind": "weighted", "omega": 0.9},
            "stop": {"tolerance": 0.01, "max_iterations": 5},
        });
        Defaults::json(&Bytes::from(text.to_string()), 100).unwrap_or_else(|_| panic!("{text}"))
    }

    fn merged(item: &Value) -> Value {
        serde_json::from_slice(&defaults().merge(&item.to_string().into())).unwrap()
    }

    #[test]
    fn items_come_before_defaults() {
        let curve = json!({"name": "a", "curve": {"points": [[0, 1]], "degree": 5}});
        assert_eq!(
            merged(&curve),
            json!({
                "name": "a",
                "curve": {"points": [[0, 1]], "degree": 5, "closed": true},
                "method": {"kind": "weighted", "omega": 0.9},
                "stop": {"tolerance": 0.01, "max_iterations": 5},
            })
        );
        let surface = json!({
            "surface": {"points": []}, "method": {"kind": "global"}, "stop": {"max_iterations": null}
        });
        assert_eq!(
            merged(&surface),
            json!({
                "surface": {"points": [], "degree": 2}, "method": {"kind": "global"}, "stop": {"tolerance": 0.01},
            })
        );
        let short = json!({"curve": 7, "method": "direct", "stop": null, "more": null});
        assert_eq!(
            merged(&short),
            json!({"curve": 7, "method": "direct", "more": null})
        );
        assert_eq!(merged(&json!([1])), json!([1]));
    }

    #[test]
    fn errors_have_locations() {
        let item = br#"{"curve": {"points": [[0, 0]], "degree": 1}, "stop": {}}"#;
        for (pointer, expected) in [
            ("", false),
            ("/curve/points/0", false),
            ("/curve/degree", false),
            ("/curve/closed", true),
            ("/curve/ends", false),
            ("/stop/tolerance", true),
            ("/method/omega", true),
            ("/rational", false),
        ] {
            assert_eq!(defaults().has(pointer, item), expected, "{pointer}");
        }
    }

    #[test]
    fn defaults_are_fields_of_jobs() {
        for (text, reason) in [
            (r#"{"tolerance": 1}"#, "/defaults/tolerance: unknown field"),
            (r#"{"curve": {"degree": "x"}}"#, "/defaults/curve/degree: "),
            ("[]", "/defaults: expected an object"),
            (r#"{"stop": }"#, "/defaults"),
        ] {
            let problem = Defaults::json(&Bytes::from(text), 100).err().unwrap();
            assert!(problem.detail().contains(reason), "{text}: {problem:?}");
        }
        for text in [
            "{}",
            r#"{"surface": {"closed": {"u": true, "v": false}}, "curve": {}}"#,
        ] {
            assert!(Defaults::json(&Bytes::from(text), 100).is_ok(), "{text}");
        }
    }
}
