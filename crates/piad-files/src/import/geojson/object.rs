//! The supported objects of GeoJSON.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use serde_json::Value;

use super::positions::Positions;

/// The type of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ObjectType {
    FeatureCollection,
    Feature,
    GeometryCollection,
    /// The nesting depth of its positions, and their kind.
    Geometry(usize, Geometry),
    /// An unknown type.
    Other,
}

/// The kind of the positions of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Geometry {
    Points,
    Lines,
    Rings,
}

/// An object.
#[derive(Debug)]
pub(super) struct Object {
    pub(super) kind: ObjectType,
    /// The name in its properties.
    pub(super) name: Option<Box<str>>,
    /// Its features, its geometry or its geometries.
    pub(super) members: Vec<Object>,
    pub(super) positions: Option<Box<Positions>>,
    /// The coordinate reference system that it names.
    pub(super) reference: Option<Box<str>>,
}

impl ObjectType {
    pub(super) fn of(name: &str) -> Self {
        match name {
            "FeatureCollection" => Self::FeatureCollection,
            "Feature" => Self::Feature,
            "GeometryCollection" => Self::GeometryCollection,
            "Point" => Self::Geometry(1, Geometry::Points),
            "MultiPoint" => Self::Geometry(2, Geometry::Points),
            "LineString" => Self::Geometry(2, Geometry::Lines),
            "MultiLineString" => Self::Geometry(3, Geometry::Lines),
            "Polygon" => Self::Geometry(3, Geometry::Rings),
            "MultiPolygon" => Self::Geometry(4, Geometry::Rings),
            _ => Self::Other,
        }
    }
}

impl<'de> Deserialize<'de> for Object {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Members)
    }
}

/// Reads the members of an object.
struct Members;

impl<'de> Visitor<'de> for Members {
    type Value = Object;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of GeoJSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Object, A::Error> {
        let mut object = Object {
            kind: ObjectType::Other,
            name: None,
            members: Vec::new(),
            positions: None,
            reference: None,
        };
        let mut id = None;
        while let Some(key) = map.next_key::<String>()? {
            match &*key {
                "type" => object.kind = ObjectType::of(&map.next_value::<String>()?),
                "features" | "geometries" => object.members = map.next_value()?,
                "geometry" => {
                    object.members = map.next_value::<Option<Object>>()?.into_iter().collect();
                }
                "coordinates" => object.positions = Some(map.next_value()?),
                "properties" => {
                    object.name = map.next_value::<Properties>()?.name.map(String::into);
                }
                "id" => id = text(&map.next_value()?),
                "crs" => object.reference = reference(&map.next_value()?),
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        object.members.shrink_to_fit();
        object.name = object.name.or(id.map(String::into));
        Ok(object)
    }
}

/// The name of a coordinate reference system.
fn reference(value: &Value) -> Option<Box<str>> {
    let named = value.pointer("/properties/name").and_then(text);
    let code = || value.pointer("/properties/code").and_then(text);
    let name = named.or_else(|| code().map(|code| format!("EPSG:{code}")));
    name.map(String::into)
}

/// A text or a number that is not blank.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) if !text.trim().is_empty() => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// The name of a feature in its properties.
struct Properties {
    name: Option<String>,
}

impl<'de> Deserialize<'de> for Properties {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values: Option<serde_json::Map<String, Value>> = Option::deserialize(deserializer)?;
        let values = values.unwrap_or_default();
        let of = |names: &[&str]| {
            let known = |key: &str| names.iter().any(|name| key.eq_ignore_ascii_case(name));
            let mut values = values.iter().filter(|(key, _)| known(key));
            values.find_map(|(key, value)| Some((key.as_str(), text(value)?)))
        };
        let named = of(&["name"]).map(|(_, name)| name);
        // Contours have no names, but heights.
        let height = || of(&["elev", "elevation", "ele", "height", "contour"]);
        let height = || height().map(|(key, height)| format!("{key} {height}"));
        let id = || of(&["id", "fid"]).map(|(_, id)| id);
        Ok(Self {
            name: named.or_else(height).or_else(id),
        })
    }
}

/// The type of an object in JSON, as far as its first member of this name: what follows is ignored.
pub(super) fn top_level_type(json: &[u8]) -> Option<String> {
    let mut found = None;
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    // Stops with an error, which has no meaning.
    let _stopped = deserializer.deserialize_map(TypeOnly(&mut found));
    found
}

/// Reads members until the type.
struct TypeOnly<'a>(&'a mut Option<String>);

impl<'de> Visitor<'de> for TypeOnly<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if key == "type" {
                *self.0 = Some(map.next_value()?);
                return Err(A::Error::custom("found"));
            }
            map.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
}
