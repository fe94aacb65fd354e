//! The points of each entity of DXF.

use std::f64::consts::PI;

use super::entity::{Entity, System, cross, number};
use super::spline;
use crate::import::curves::{Curve, Point};
use crate::import::error::FileError;
use crate::import::sampled::{Arc, SAMPLED, along, turn};

/// Arcs of ellipses whose angle differs from a full turn by up to this are whole ellipses.
const NEAR_FULL: f64 = 1e-9;

/// The flags of a `POLYLINE`.
const IS_CLOSED: u32 = 1;
const IS_SPATIAL: u32 = 8;
const IS_MESH: u32 = 16 | 64;

/// The flag of a vertex that is a control point of the smooth curve that the others are on.
const IS_CONTROL: u32 = 16;

/// The kind of an entity.
#[derive(Debug)]
pub(super) enum Shape {
    /// A curve that others may continue.
    Piece(Curve),
    /// A curve of its own.
    Whole(Curve),
    Point(Point, u32),
    /// A mesh, of which nothing is read.
    Mesh,
    /// A kind that is not read.
    Unknown,
}

/// A corner of a polyline.
#[derive(Clone, Copy)]
struct Corner {
    point: Point,
    /// The tangent of a quarter of the angle of the arc to the next corner.
    bulge: f64,
    line: u32,
}

/// The points of an entity; `vertices` are those of a `POLYLINE`. A spline has at most `most` of them and some more.
///
/// # Errors
///
/// If numbers are missing or invalid.
pub(super) fn shape(
    entity: &Entity<'_>,
    vertices: &[Entity<'_>],
    most: usize,
) -> Result<Shape, FileError> {
    Ok(match entity.name {
        "LINE" => Shape::Piece(line(entity)?),
        "ARC" => Shape::Piece(sampled(arc(entity, Some((50, 51)))?, false, entity)),
        "CIRCLE" => Shape::Whole(sampled(arc(entity, None)?, true, entity)),
        "ELLIPSE" => ellipse(entity)?,
        "POINT" => Shape::Point(entity.point(10)?, entity.line),
        "LWPOLYLINE" => Shape::Whole(light_polyline(entity)?),
        "POLYLINE" if entity.flags(70)? & IS_MESH != 0 => Shape::Mesh,
        "POLYLINE" => Shape::Whole(polyline(entity, vertices)?),
        "SPLINE" => Shape::Whole(spline(entity, most)?),
        _ => Shape::Unknown,
    })
}

fn line(entity: &Entity<'_>) -> Result<Curve, FileError> {
    let mut curve = Curve::new(None);
    curve.push(entity.point(10)?, entity.line);
    curve.push(entity.point(11)?, entity.line);
    Ok(curve)
}

/// The points of an arc as a curve.
fn sampled(arc: Arc, closed: bool, entity: &Entity<'_>) -> Curve {
    let mut curve = Curve::new(None);
    for point in arc.all_points() {
        curve.push(point, entity.line);
    }
    curve.closed = closed;
    curve.notices.push(SAMPLED.to_owned());
    curve
}

/// A circle, or the arc between the angles of two groups.
fn arc(entity: &Entity<'_>, angles: Option<(i32, i32)>) -> Result<Arc, FileError> {
    let system = entity.system()?;
    let radius = entity.number(40)?;
    if radius <= 0.0 {
        let detail = format!("the radius of this {} is {radius}", entity.name);
        return Err(FileError::at(entity.line as usize, detail));
    }
    let (start, end) = match angles {
        Some((start, end)) => (entity.number(start)?, entity.number(end)?),
        None => (0.0, 360.0),
    };
    let axes = [[radius, 0.0, 0.0], [0.0, radius, 0.0]];
    Ok(Arc {
        centre: system.in_world(entity.point(10)?),
        axes: axes.map(|axis| system.in_world(axis)),
        start: start.to_radians(),
        sweep: turn((end - start).to_radians()),
    })
}

/// An ellipse or an arc of one, in coordinates of the world.
fn ellipse(entity: &Entity<'_>) -> Result<Shape, FileError> {
    let major = entity.point(11)?;
    let ratio = entity.number(40)?;
    let minor = cross(entity.system()?.normal(), major).map(|x| ratio * x);
    let start = entity.number(41)?;
    let end = entity.optional(42)?.unwrap_or(2.0 * PI);
    let mut sweep = turn(end - start);
    let full = sweep < NEAR_FULL || 2.0 * PI - sweep < NEAR_FULL;
    if full {
        sweep = 2.0 * PI;
    }
    let arc = Arc {
        centre: entity.point(10)?,
        axes: [major, minor],
        start,
        sweep,
    };
    let curve = sampled(arc, full, entity);
    Ok(match full {
        true => Shape::Whole(curve),
        false => Shape::Piece(curve),
    })
}

/// A polyline in a plane, whose corners are groups.
fn light_polyline(entity: &Entity<'_>) -> Result<Curve, FileError> {
    let height = entity.number(38)?;
    let mut corners: Vec<Corner> = Vec::new();
    for pair in &entity.groups {
        match (pair.code, corners.last_mut()) {
            (10, _) => corners.push(Corner {
                point: [number(pair)?, 0.0, height],
                bulge: 0.0,
                line: pair.line,
            }),
            (20, Some(corner)) => corner.point[1] = number(pair)?,
            (42, Some(corner)) => corner.bulge = number(pair)?,
            _ => {}
        }
    }
    let closed = entity.flags(70)? & IS_CLOSED != 0;
    Ok(bulged(&corners, closed, entity.system()?))
}

/// A polyline whose corners are entities.
fn polyline(entity: &Entity<'_>, vertices: &[Entity<'_>]) -> Result<Curve, FileError> {
    let flags = entity.flags(70)?;
    let spatial = flags & IS_SPATIAL != 0;
    let mut corners = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        if vertex.flags(70)? & IS_CONTROL != 0 {
            continue;
        }
        let [x, y, z] = vertex.point(10)?;
        corners.push(Corner {
            point: [x, y, if spatial { z } else { entity.number(30)? }],
            bulge: if spatial { 0.0 } else { vertex.number(42)? },
            line: vertex.line,
        });
    }
    let system = match spatial {
        true => System::WORLD,
        false => entity.system()?,
    };
    Ok(bulged(&corners, flags & IS_CLOSED != 0, system))
}

/// A polyline with the points of its arcs.
fn bulged(corners: &[Corner], closed: bool, system: System) -> Curve {
    let mut curve = Curve::new(None);
    let next = corners.iter().skip(1).chain(corners.first());
    let last = corners.len().saturating_sub(usize::from(!closed));
    for (index, (corner, next)) in corners.iter().zip(next).enumerate() {
        curve.push(system.in_world(corner.point), corner.line);
        if index >= last {
            continue;
        }
        let Some(arc) = bulge_arc(corner, next) else {
            continue;
        };
        // The last one is the next corner.
        for part in arc.parts().filter(|part| *part < 1.0) {
            curve.push(system.in_world(arc.at(part)), corner.line);
        }
        if curve.notices.is_empty() {
            curve.notices.push(SAMPLED.to_owned());
        }
    }
    curve.closed = closed;
    curve
}

/// The arc from a corner to the next one.
fn bulge_arc(corner: &Corner, next: &Corner) -> Option<Arc> {
    let bulge = corner.bulge;
    let [dx, dy, _] = along(next.point, corner.point, -1.0);
    if bulge == 0.0 || (dx == 0.0 && dy == 0.0) {
        return None;
    }
    let middle = along(corner.point, [dx, dy, 0.0], 0.5);
    let centre = along(
        middle,
        [-dy, dx, 0.0],
        (1.0 - bulge * bulge) / (4.0 * bulge),
    );
    let [x, y, _] = along(corner.point, centre, -1.0);
    Some(Arc {
        centre,
        // From the corner itself, and a quarter of a turn on.
        axes: [[x, y, 0.0], [-y, x, 0.0]],
        start: 0.0,
        sweep: 4.0 * bulge.atan(),
    })
}

/// A spline through its fit points, or else sampled.
fn spline(entity: &Entity<'_>, most: usize) -> Result<Curve, FileError> {
    let mut curve = Curve::new(None);
    let closed = entity.flags(70)? & IS_CLOSED != 0;
    let fit = entity.points(11)?;
    if fit.len() > 1 {
        for (point, line) in fit {
            curve.push(point, line);
        }
        curve.closed = closed;
        let notice = "The points of a SPLINE are its fit points.";
        curve.notices.push(notice.to_owned());
        return Ok(curve);
    }
    for point in spline::points(entity, most)? {
        curve.push(point, entity.line);
    }
    curve.closed = closed && curve.ends_meet();
    curve.notices.push(SAMPLED.to_owned());
    Ok(curve)
}
