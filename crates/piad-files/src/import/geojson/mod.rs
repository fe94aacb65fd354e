//! Lines, polygons and points of GeoJSON.

mod object;
mod positions;

use super::curves::{Curve, Curves};
use super::degrees;
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Parts;
use crate::text::{quoted, without_mark};
use object::{Geometry, Object, ObjectType, top_level_type};
use positions::Positions;

/// Returns true if bytes are a GeoJSON object, with or without a byte-order mark; the bytes after its type may be
/// damaged.
#[must_use]
pub fn is_geojson(bytes: &[u8]) -> bool {
    let bytes = without_mark(bytes).trim_ascii_start();
    bytes.starts_with(b"{")
        && top_level_type(bytes).is_some_and(|name| ObjectType::of(&name) != ObjectType::Other)
}

/// Each line and each ring of a polygon is a part; all points together are one part.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let file: Object = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let detail = message.split(" at line ").next().unwrap_or(&message);
        FileError::at(error.line().max(1), format!("this is no GeoJSON: {detail}"))
    })?;
    let mut reader = Reader {
        curves: Curves::new(hints.most),
        points: Curve::cloud(None),
        least: usize::MAX,
        largest: 0,
        other: 0,
    };
    reader.read(&file)?;
    reader.finish(file.reference.as_deref())
}

struct Reader {
    curves: Curves,
    points: Curve,
    /// The least and the largest number of numbers of a position.
    least: usize,
    largest: usize,
    /// The number of objects of unknown type.
    other: usize,
}

/// Where an object stands, for errors.
#[derive(Clone, Copy)]
struct Place<'a> {
    /// The index of the feature, from 0.
    feature: Option<usize>,
    name: Option<&'a str>,
}

impl Reader {
    fn read(&mut self, file: &Object) -> Result<(), FileError> {
        if file.kind != ObjectType::FeatureCollection {
            return self.object(file, None);
        }
        let features = file.members.iter().enumerate();
        for (index, feature) in features {
            self.object(feature, Some(index))?;
        }
        Ok(())
    }

    fn object(&mut self, object: &Object, feature: Option<usize>) -> Result<(), FileError> {
        let name = object.name.as_deref();
        // Nesting is limited by the JSON reader.
        let mut left = vec![object];
        while let Some(object) = left.pop() {
            match object.kind {
                ObjectType::Other => self.other += 1,
                ObjectType::Feature
                | ObjectType::GeometryCollection
                | ObjectType::FeatureCollection => {
                    left.extend(object.members.iter().rev());
                }
                ObjectType::Geometry(depth, what) => {
                    if let Some(positions) = &object.positions {
                        positions
                            .check(depth)
                            .map_err(|detail| wrong(feature, &detail))?;
                        self.geometry(positions, what, Place { feature, name })?;
                    }
                }
            }
        }
        Ok(())
    }

    fn geometry(
        &mut self,
        positions: &Positions,
        what: Geometry,
        place: Place<'_>,
    ) -> Result<(), FileError> {
        self.least = self.least.min(positions.least);
        self.largest = self.largest.max(positions.largest);
        if what == Geometry::Points {
            self.points.points.extend(&positions.points);
            return self.curves.check_room(&self.points);
        }
        for line in positions.lists() {
            let mut curve = Curve::new(place.name.map(str::to_owned));
            curve.points = line.to_vec();
            curve.closed = what == Geometry::Rings;
            let pushed = self.curves.push(curve);
            pushed.map_err(|error| match place.feature {
                Some(feature) => FileError::of_file(format!("feature {feature}: {error}")),
                None => error,
            })?;
        }
        Ok(())
    }

    fn finish(mut self, reference: Option<&str>) -> Result<Parts, FileErrors> {
        if !self.points.points.is_empty() {
            self.curves.push(self.points)?;
        }
        let mut notices = match planar(&self.curves, reference) {
            Some(notice) => vec![notice],
            None => degrees::to_metres(&mut self.curves),
        };
        let heights = self.least >= 3;
        if self.largest >= 3 && !heights {
            let notice = "Some positions have no height, which is left out of the others.";
            notices.push(notice.to_owned());
        }
        if self.largest > 3 {
            let notice = "Positions have more than 3 numbers: the first 3 are read.";
            notices.push(notice.to_owned());
        }
        if self.other > 0 {
            notices.push(format!(
                "{} objects have no geometry of GeoJSON, and are left out.",
                self.other
            ));
        }
        self.curves.finish(if heights { 3 } else { 2 }, notices)
    }
}

/// The notice about coordinates that are not degrees, if there are any.
fn planar(curves: &Curves, reference: Option<&str>) -> Option<String> {
    let degrees = |name: &&str| {
        let name = name.to_ascii_uppercase();
        name.ends_with("CRS84") || name.ends_with(":4326")
    };
    if let Some(name) = reference.filter(|name| !degrees(name)) {
        return Some(format!(
            "The coordinates are taken as they are, in the units of {}.",
            quoted(name)
        ));
    }
    let is_place = |[x, y, _]: &[f64; 3]| x.abs() <= 180.0 && y.abs() <= 90.0;
    let notice = "The coordinates are taken as they are: they are no longitudes and latitudes.";
    (!curves.points().all(is_place)).then(|| notice.to_owned())
}

/// An error in the geometry of a feature.
fn wrong(feature: Option<usize>, detail: &str) -> FileError {
    FileError::of_file(match feature {
        Some(feature) => format!("feature {feature}: {detail}"),
        None => detail.to_owned(),
    })
}

#[cfg(test)]
mod tests;
