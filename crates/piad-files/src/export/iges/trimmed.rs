//! Trimmed surfaces (entity 144): a surface with curves on it (entity 142), each in its parameters and in space, as composite
//! curves (entity 102) if there are several edges.

use super::entities::{Entities, Label};
use super::sections::Status;
use super::splines::geometry;
use crate::export::error::ExportError;
use crate::export::format::Format;
use crate::export::nurbs::Nurbs;
use crate::export::trim::edges::{self, Edge};
use piad_fit::geometry::Outline;

const COMPOSITE: usize = 102;
const CURVE: usize = 126;
const SURFACE: usize = 128;
const ON_SURFACE: usize = 142;
const TRIMMED: usize = 144;

/// The curve was projected on the surface, and the curve in the parameters is preferred (section 4.34).
const PROJECTED: usize = 1;
const PREFERS_PARAMETERS: usize = 1;

/// Adds a trimmed surface for each piece.
pub(super) fn write(
    entities: &mut Entities,
    nurbs: &Nurbs,
    outline: &Outline,
    label: &Label,
) -> Result<(), ExportError> {
    let loops = edges::of_loops(nurbs, outline);
    let counts = edges::counts(outline);
    let is_at_pole = |(edges, all): (&Vec<Edge>, usize)| edges.len() < all;
    if loops.iter().zip(counts).any(is_at_pole) {
        let format = Format::Iges;
        return Err(ExportError::TrimmedAtPole { format });
    }
    let surface = entities.add(SURFACE, Status::Dependent, label, |data| {
        geometry(data, nurbs)
    });
    let loops = loops.iter().map(|edges| {
        let in_plane = |edge: &Edge| edge.in_plane.clone();
        let in_plane = path(entities, edges, Status::InParameters, label, in_plane);
        let in_space = path(entities, edges, Status::Dependent, label, |it| {
            it.in_space.clone()
        });
        entities.add(ON_SURFACE, Status::Dependent, label, |data| {
            for number in [PROJECTED, surface, in_plane, in_space, PREFERS_PARAMETERS] {
                data.integer(number);
            }
        })
    });
    let loops: Vec<usize> = loops.collect();
    for face in &outline.faces {
        entities.add(TRIMMED, Status::Independent, label, |data| {
            data.integer(surface);
            // The outer boundary is not that of the rectangle.
            data.integer(1);
            data.integer(face.holes.len());
            face.loops().for_each(|index| data.integer(loops[index]));
        });
    }
    Ok(())
}

/// The curves of edges, as one entity.
fn path(
    entities: &mut Entities,
    edges: &[Edge],
    status: Status,
    label: &Label,
    curve: impl Fn(&Edge) -> Nurbs,
) -> usize {
    let curves = edges.iter().map(|edge| {
        let curve = curve(edge);
        entities.add(CURVE, status, label, |data| geometry(data, &curve))
    });
    let curves: Vec<usize> = curves.collect();
    match curves[..] {
        [only] => only,
        _ => entities.add(COMPOSITE, status, label, |data| {
            data.integer(curves.len());
            curves.iter().for_each(|&number| data.integer(number));
        }),
    }
}
