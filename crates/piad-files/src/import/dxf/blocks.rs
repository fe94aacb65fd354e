//! Blocks of DXF: entities with a name, and the places that references (`INSERT`) give them.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::entity::Entity;
use crate::import::curves::Point;
use crate::import::error::FileError;
use crate::import::sampled::along;

/// The deepest nesting of references.
pub(super) const MOST_NESTED: usize = 16;

/// The most groups of the entities of all references: a few of them can place very many.
pub(super) const MOST_PLACED: usize = 1_000_000;

/// An entity, and the vertices of a `POLYLINE`.
pub(super) type Whole<'a> = (Entity<'a>, Vec<Entity<'a>>);

/// The entities of a block.
#[derive(Debug)]
pub(super) struct Block<'a> {
    /// The point that references place.
    pub(super) base: Point,
    pub(super) entities: Vec<Whole<'a>>,
    /// The total number of groups.
    pub(super) groups: usize,
}

/// The blocks of a file by their names.
#[derive(Debug, Default)]
pub(super) struct Blocks<'a> {
    ended: BTreeMap<&'a str, Rc<Block<'a>>>,
    /// The block whose entities are read.
    open: Option<(&'a str, Block<'a>)>,
}

impl<'a> Blocks<'a> {
    /// Adds an entity of the section of blocks.
    ///
    /// # Errors
    ///
    /// If the base of a block is no point.
    pub(super) fn add(
        &mut self,
        entity: Entity<'a>,
        vertices: Vec<Entity<'a>>,
    ) -> Result<(), FileError> {
        match (entity.name, &mut self.open) {
            ("BLOCK", _) => {
                let base = [entity.number(10)?, entity.number(20)?, entity.number(30)?];
                let entities = Vec::new();
                self.open = Some((
                    entity.text(2),
                    Block {
                        base,
                        entities,
                        groups: 0,
                    },
                ));
            }
            ("ENDBLK", _) => {
                let ended = self.open.take();
                self.ended
                    .extend(ended.map(|(name, block)| (name, Rc::new(block))));
            }
            (_, Some((_, block))) => {
                let all = vertices.iter().chain([&entity]);
                let groups: usize = all.map(|entity| entity.groups.len() + 1).sum();
                block.groups += groups;
                block.entities.push((entity, vertices));
            }
            (_, None) => {}
        }
        Ok(())
    }

    /// The block of a name, unless it has no entities, as those in other files.
    pub(super) fn get(&self, name: &str) -> Option<Rc<Block<'a>>> {
        let found = self.ended.get(name);
        found.filter(|block| !block.entities.is_empty()).cloned()
    }
}

/// Where the entities of a block are: their axes and their origin in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    axes: [Point; 3],
    origin: Point,
}

impl Placement {
    pub(super) fn apply(&self, point: Point) -> Point {
        let axes = self.axes.iter().zip(point);
        axes.fold(self.origin, |sum, (axis, x)| along(sum, *axis, x))
    }

    /// First the other one, then this one.
    pub(super) fn after(&self, first: &Self) -> Self {
        let turned = Self {
            origin: [0.0; 3],
            ..*self
        };
        Self {
            axes: first.axes.map(|axis| turned.apply(axis)),
            origin: self.apply(first.origin),
        }
    }
}

/// The placements of a block with this base by a reference: one, or those of its rows and columns.
///
/// # Errors
///
/// If a number is invalid.
pub(super) fn placements(
    insert: &Entity<'_>,
    base: Point,
) -> Result<impl Iterator<Item = Placement>, FileError> {
    let system = insert.system()?;
    let place = insert.point(10)?;
    let (sine, cosine) = insert.number(50)?.to_radians().sin_cos();
    let turned = move |[x, y, z]: Point| [cosine * x - sine * y, sine * x + cosine * y, z];
    let mut scales = [1.0; 3];
    for (scale, code) in scales.iter_mut().zip(41..) {
        *scale = insert.optional(code)?.unwrap_or(1.0);
    }
    let [x, y, z] = scales;
    let axes = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
    let axes = axes.map(|axis| system.in_world(turned(axis)));
    let [columns, rows] = [insert.flags(70)?.max(1), insert.flags(71)?.max(1)];
    let [dx, dy] = [insert.number(44)?, insert.number(45)?];
    let all = (0..rows).flat_map(move |row| (0..columns).map(move |column| (row, column)));
    Ok(all.map(move |(row, column)| {
        let step = turned([f64::from(column) * dx, f64::from(row) * dy, 0.0]);
        let origin = system.in_world(along(place, step, 1.0));
        let with_base = axes.iter().zip(base);
        let origin = with_base.fold(origin, |sum, (axis, x)| along(sum, *axis, -x));
        Placement { axes, origin }
    }))
}

/// The error of references that place too many entities.
pub(super) fn too_many(insert: &Entity<'_>) -> FileError {
    let detail = format!(
        "the INSERTs of blocks up to this one place more than {MOST_PLACED} groups of DXF, the limit"
    );
    FileError::at(insert.line as usize, detail)
}

/// The error of references that are nested too deep.
pub(super) fn too_deep(insert: &Entity<'_>) -> FileError {
    let detail = format!(
        "the blocks are nested more than {MOST_NESTED} deep here, or one has itself inside"
    );
    FileError::at(insert.line as usize, detail)
}
