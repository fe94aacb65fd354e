//! Drawings in DXF: the entities of the model, without those of blocks.

mod chains;
mod entity;
mod pairs;
mod shapes;
mod spline;

use std::collections::BTreeMap;

use super::curves::{Curve, Curves, size};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Parts;
use crate::short::{plain, quoted};
use entity::Entity;
use pairs::{Pair, Pairs};
use shapes::Shape;

/// What binary files begin with.
const BINARY: &str = "AutoCAD Binary DXF";

/// A drawing is flat if no point is higher than this part of its size.
const FLAT: f64 = 1e-9;

/// The most kinds of entities that are not read that are named.
const MOST_NAMES: usize = 10;

/// The units of the header that are named.
const UNITS: [(&str, &str); 5] = [
    ("1", "inches"),
    ("2", "feet"),
    ("4", "millimetres"),
    ("5", "centimetres"),
    ("6", "metres"),
];

/// Returns true if a text is DXF, also a binary one.
pub(super) fn is_dxf(text: &str) -> bool {
    let text = text.trim_start();
    text.starts_with(BINARY)
        || Pairs::new(text)
            .next()
            .is_ok_and(|pair| pair.is_some_and(|pair| pair.code == 0 && pair.value == "SECTION"))
}

/// Each curve is a part, with the name of its layer; lines and arcs whose ends meet are one, and so are the points of a
/// layer.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    if text.trim_start().starts_with(BINARY) {
        let detail = "this is a binary DXF file, which is not supported: save it as ASCII DXF";
        return Err(FileError::of_file(detail).into());
    }
    let mut drawing = Drawing::new(hints.most);
    let mut pairs = Pairs::new(text);
    while let Some(pair) = pairs.next()? {
        if pair.code == 0 && pair.value == "SECTION" {
            drawing.section(&mut pairs)?;
        }
    }
    drawing.finish()
}

struct Drawing<'a> {
    most: usize,
    /// The curves with their places in the file.
    curves: Vec<(usize, Curve)>,
    /// The lines and arcs of each layer.
    pieces: BTreeMap<&'a str, Vec<(usize, Curve)>>,
    /// The points of each layer.
    points: BTreeMap<&'a str, (usize, Curve)>,
    /// How many entities there are, and how many points they have.
    entities: usize,
    count: usize,
    /// How many entities of a kind are not read.
    unread: BTreeMap<&'a str, usize>,
    paper: usize,
    units: Option<&'static str>,
}

impl<'a> Drawing<'a> {
    fn new(most: usize) -> Self {
        Self {
            most,
            curves: Vec::new(),
            pieces: BTreeMap::new(),
            points: BTreeMap::new(),
            entities: 0,
            count: 0,
            unread: BTreeMap::new(),
            paper: 0,
            units: None,
        }
    }

    /// Reads a section up to its end.
    fn section(&mut self, pairs: &mut Pairs<'a>) -> Result<(), FileError> {
        let mut name = "";
        let mut variable = "";
        while let Some(pair) = pairs.next()? {
            match (pair.code, pair.value) {
                (0, "ENDSEC") => return Ok(()),
                (2, value) if name.is_empty() => name = value,
                (9, value) => variable = value,
                (70, value) if name == "HEADER" && variable == "$INSUNITS" => {
                    let known = UNITS.iter().find(|(code, _)| *code == value);
                    self.units = known.map(|(_, unit)| *unit);
                }
                (0, _) if name == "ENTITIES" => return self.read_entities(pair, pairs),
                _ => {}
            }
        }
        Err(cut_off(name))
    }

    /// Reads entities up to the end of their section, from the first one on.
    fn read_entities(&mut self, first: Pair<'a>, pairs: &mut Pairs<'a>) -> Result<(), FileError> {
        let mut entity = Entity::new(first);
        // The polyline whose vertices are read, and these.
        let mut polyline: Option<(Entity<'a>, Vec<Entity<'a>>)> = None;
        while let Some(pair) = pairs.next()? {
            if pair.code != 0 {
                entity.groups.push(pair);
                continue;
            }
            let next = Entity::new(pair);
            let ended = std::mem::replace(&mut entity, next);
            polyline = match (ended.name, polyline) {
                ("VERTEX", Some((polyline, mut vertices))) => {
                    vertices.push(ended);
                    Some((polyline, vertices))
                }
                (name, open) => {
                    if let Some((polyline, vertices)) = open {
                        self.entity(&polyline, &vertices)?;
                    }
                    match name {
                        "POLYLINE" => Some((ended, Vec::new())),
                        "SEQEND" => None,
                        _ => {
                            self.entity(&ended, &[])?;
                            None
                        }
                    }
                }
            };
            if pair.value == "ENDSEC" {
                if let Some((polyline, vertices)) = polyline {
                    self.entity(&polyline, &vertices)?;
                }
                return Ok(());
            }
        }
        Err(cut_off("ENTITIES"))
    }

    fn entity(&mut self, entity: &Entity<'a>, vertices: &[Entity<'a>]) -> Result<(), FileError> {
        self.entities += 1;
        if entity.flags(67)? == 1 {
            self.paper += 1;
            return Ok(());
        }
        let (layer, index) = (entity.layer(), self.entities);
        let named = |curve: Curve| Curve {
            name: Some(layer.to_owned()),
            ..curve
        };
        let shape = shapes::shape(entity, vertices, self.most)?;
        if let Shape::Piece(curve) | Shape::Whole(curve) = &shape {
            self.count += curve.points.len();
        }
        match shape {
            Shape::Whole(curve) => self.curves.push((index, named(curve))),
            Shape::Piece(curve) => self.pieces.entry(layer).or_default().push((index, curve)),
            Shape::Point(point, line) => {
                let cloud = || (index, named(Curve::cloud(None)));
                let (_, cloud) = self.points.entry(layer).or_insert_with(cloud);
                cloud.push(point, line);
            }
            Shape::Mesh => *self.unread.entry("POLYLINE that is a mesh").or_default() += 1,
            Shape::Unknown => *self.unread.entry(entity.name).or_default() += 1,
        }
        // Lines share their ends: there are at least half as many points in the end.
        if self.count / 2 > self.most {
            let detail = format!("there are more than {} points, the limit", self.most);
            return Err(FileError::at(entity.line as usize, detail));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Parts, FileErrors> {
        let notices = self.notices();
        for (layer, pieces) in self.pieces {
            let (indices, pieces): (Vec<usize>, Vec<Curve>) = pieces.into_iter().unzip();
            for (first, mut curve) in chains::chains(pieces) {
                curve.name = Some(layer.to_owned());
                let index = indices.get(first).copied().unwrap_or_default();
                self.curves.push((index, curve));
            }
        }
        self.curves.extend(self.points.into_values());
        self.curves.sort_by_key(|(index, _)| *index);
        let mut curves = Curves::new(self.most);
        for (_, curve) in self.curves {
            curves.push(curve)?;
        }
        let highest = FLAT * size(curves.points());
        let flat = curves.points().all(|[_, _, z]| z.abs() <= highest);
        curves.finish(if flat { 2 } else { 3 }, notices)
    }

    /// What is said of the drawing.
    fn notices(&self) -> Vec<String> {
        let mut notices = Vec::new();
        if let Some(units) = self.units {
            notices.push(format!("The drawing is in {units}."));
        }
        let listed = self.unread.iter().take(MOST_NAMES);
        let listed = listed.map(|(name, count)| format!("{count} {}", plain(name)));
        let listed: Vec<String> = listed.collect();
        if !listed.is_empty() {
            let more = match self.unread.len() > MOST_NAMES {
                true => " and others",
                false => "",
            };
            notices.push(format!(
                "Entities that are not read: {}{more}.",
                listed.join(", ")
            ));
        }
        if self.paper > 0 {
            notices.push(format!(
                "{} entities of the paper space are not read.",
                self.paper
            ));
        }
        notices
    }
}

/// The error of a file that ends within a section.
fn cut_off(section: &str) -> FileError {
    FileError::of_file(format!(
        "the file ends within the section {}: it is cut off",
        quoted(section)
    ))
}

#[cfg(test)]
mod tests;
