//! Drawings in DXF: the entities of the model, and those of blocks where references place them.

mod blocks;
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
use crate::text::{plain, quoted};
use blocks::{Blocks, MOST_NESTED, MOST_PLACED, Placement, placements, too_deep, too_many};
use entity::Entity;
use pairs::{Pair, Pairs};
use shapes::Shape;

/// What binary files begin with.
const BINARY: &str = "AutoCAD Binary DXF";

/// A drawing is flat if no point is higher than this part of its size.
const FLAT: f64 = 1e-9;

/// The most kinds of skipped entities that are named.
const MOST_NAMES: usize = 10;

/// The named units of the header.
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

/// Each curve is a part, with the name of its layer; lines and arcs whose ends meet are joined, and the points of a
/// layer form one part.
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

/// A reference to a block, whose entities are added.
struct Reference<'a> {
    placement: Placement,
    layer: &'a str,
    /// The nesting depth of references, including this one.
    depth: usize,
}

struct Drawing<'a> {
    most: usize,
    /// The curves with their places in the file.
    curves: Vec<(usize, Curve)>,
    /// The lines and arcs of each layer.
    pieces: BTreeMap<&'a str, Vec<(usize, Curve)>>,
    /// The points of each layer.
    points: BTreeMap<&'a str, (usize, Curve)>,
    /// The number of entities, and of their points.
    entities: usize,
    count: usize,
    blocks: Blocks<'a>,
    /// The number of references that were read, and of the groups that they have placed.
    references: usize,
    placed: usize,
    /// The number of skipped entities of each kind.
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
            blocks: Blocks::default(),
            references: 0,
            placed: 0,
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
                (0, _) if name == "BLOCKS" => {
                    return read_entities(name, pair, pairs, |entity, vertices| {
                        self.blocks.add(entity, vertices)
                    });
                }
                (0, _) if name == "ENTITIES" => {
                    return read_entities(name, pair, pairs, |entity, vertices| {
                        self.entity(&entity, &vertices)
                    });
                }
                _ => {}
            }
        }
        Err(cut_off(name))
    }

    fn entity(&mut self, entity: &Entity<'a>, vertices: &[Entity<'a>]) -> Result<(), FileError> {
        if entity.flags(67)? == 1 {
            self.entities += 1;
            self.paper += 1;
            return Ok(());
        }
        self.add(entity, vertices, None)
    }

    /// Adds an entity of the drawing, or of a block within a reference.
    fn add(
        &mut self,
        entity: &Entity<'a>,
        vertices: &[Entity<'a>],
        around: Option<&Reference<'a>>,
    ) -> Result<(), FileError> {
        self.entities += 1;
        let layer = match (entity.layer(), around) {
            // Such entities of blocks are in the layer of the reference.
            ("0", Some(reference)) => reference.layer,
            (layer, _) => layer,
        };
        if entity.name == "INSERT" {
            return self.insert(entity, layer, around);
        }
        let index = self.entities;
        let named = |curve: Curve| Curve {
            name: Some(layer.to_owned()),
            ..curve
        };
        let placed = |point| around.map_or(point, |it| it.placement.apply(point));
        let mut shape = shapes::shape(entity, vertices, self.most)?;
        if let Shape::Piece(curve) | Shape::Whole(curve) = &mut shape {
            self.count += curve.points.len();
            for point in &mut curve.points {
                *point = placed(*point);
            }
        }
        match shape {
            Shape::Whole(curve) => self.curves.push((index, named(curve))),
            Shape::Piece(curve) => self.pieces.entry(layer).or_default().push((index, curve)),
            Shape::Point(point, line) => {
                self.count += 1;
                let cloud = || (index, named(Curve::cloud(None)));
                let (_, cloud) = self.points.entry(layer).or_insert_with(cloud);
                cloud.push(placed(point), line);
            }
            Shape::Mesh => *self.unread.entry("POLYLINE that is a mesh").or_default() += 1,
            Shape::Unknown => *self.unread.entry(entity.name).or_default() += 1,
        }
        // Lines share their ends: there are at least half as many points at the end.
        if self.count / 2 > self.most {
            let detail = format!("there are more than {} points, the limit", self.most);
            return Err(FileError::at(entity.line as usize, detail));
        }
        Ok(())
    }

    /// Adds the entities of a block where a reference places them.
    fn insert(
        &mut self,
        insert: &Entity<'a>,
        layer: &'a str,
        around: Option<&Reference<'a>>,
    ) -> Result<(), FileError> {
        let depth = around.map_or(0, |it| it.depth) + 1;
        if depth > MOST_NESTED {
            return Err(too_deep(insert));
        }
        let Some(block) = self.blocks.get(insert.text(2)) else {
            let name = "INSERT of a block without entities in the file";
            *self.unread.entry(name).or_default() += 1;
            return Ok(());
        };
        self.references += usize::from(around.is_none());
        for own in placements(insert, block.base)? {
            self.placed += block.groups;
            if self.placed > MOST_PLACED {
                return Err(too_many(insert));
            }
            let reference = Reference {
                placement: around.map_or(own, |it| it.placement.after(&own)),
                layer,
                depth,
            };
            for (entity, vertices) in &block.entities {
                self.add(entity, vertices, Some(&reference))?;
            }
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

    /// The notice about the drawing.
    fn notices(&self) -> Vec<String> {
        let mut notices = Vec::new();
        if let Some(units) = self.units {
            notices.push(format!("The drawing is in {units}."));
        }
        if self.references > 0 {
            notices.push(format!(
                "{} INSERTs are read as the entities of their blocks.",
                self.references
            ));
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

/// Reads entities up to the end of this section, from the first one on, each with its vertices.
fn read_entities<'a>(
    section: &str,
    first: Pair<'a>,
    pairs: &mut Pairs<'a>,
    mut take: impl FnMut(Entity<'a>, Vec<Entity<'a>>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let mut entity = Entity::new(first);
    // The polyline whose vertices are read, and these.
    let mut polyline: Option<(Entity<'a>, Vec<Entity<'a>>)> = None;
    while entity.name != "ENDSEC" {
        let Some(pair) = pairs.next()? else {
            return Err(cut_off(section));
        };
        if pair.code != 0 {
            entity.groups.push(pair);
            continue;
        }
        let ended = std::mem::replace(&mut entity, Entity::new(pair));
        polyline = match (ended.name, polyline) {
            ("VERTEX", Some((polyline, mut vertices))) => {
                vertices.push(ended);
                Some((polyline, vertices))
            }
            (name, open) => {
                if let Some((polyline, vertices)) = open {
                    take(polyline, vertices)?;
                }
                match name {
                    "POLYLINE" => Some((ended, Vec::new())),
                    "SEQEND" => None,
                    _ => {
                        take(ended, Vec::new())?;
                        None
                    }
                }
            }
        };
    }
    if let Some((polyline, vertices)) = polyline {
        take(polyline, vertices)?;
    }
    Ok(())
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
