//! DXF of AutoCAD R12, which everything reads that reads DXF: a polyline through samples of a curve, a
//! polygon mesh through samples of a surface.
//!
//! This version has neither units nor names of entities, and numbers are text. Splines came later and
//! with much that few readers need; the exact ones are in STEP and IGES.

use super::error::{ExportError, NetIndex};
use super::fitted::{Fitted, GENERATOR};
use super::format::Format;
use super::nurbs::{KnotVector, Nurbs};
use super::text::Text;
use piad_fit::engine::nurbs::{Jet, SpanParameter, steps_between};

/// The most samples of a polygon mesh in each direction, as AutoCAD has it.
const MOST_IN_MESH: usize = 256;

/// The most steps along a curve, and along each direction of a surface, unless more are asked for.
const MOST_ALONG_CURVE: usize = 1 << 12;
const MOST_ALONG_SURFACE: usize = 96;

/// Flags of polylines: closed, in space, a mesh, a mesh that is closed in its second direction.
const CLOSED: u32 = 1;
const SPATIAL: u32 = 8;
const MESH: u32 = 16;
const CLOSED_ACROSS: u32 = 32;
/// The flag of a vertex of a mesh.
const MESH_VERTEX: u32 = 64;

/// The polyline or the mesh as a DXF file.
pub(super) fn write(nurbs: &Nurbs, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let samples = fitted.options.samples;
    let mut text = Text::default();
    pair(
        &mut text,
        999,
        format_args!("{GENERATOR}: {}", fitted.description()),
    );
    pair(&mut text, 0, format_args!("SECTION"));
    pair(&mut text, 2, format_args!("HEADER"));
    pair(&mut text, 9, format_args!("$ACADVER"));
    pair(&mut text, 1, format_args!("AC1009"));
    pair(&mut text, 0, format_args!("ENDSEC"));
    pair(&mut text, 0, format_args!("SECTION"));
    pair(&mut text, 2, format_args!("ENTITIES"));
    match &nurbs.v {
        None => curve(&mut text, nurbs, samples.map(|grid| grid.rows))?,
        Some(v) => surface(
            &mut text,
            nurbs,
            v,
            samples.map(|grid| [grid.rows, grid.columns]),
        )?,
    }
    pair(&mut text, 0, format_args!("ENDSEC"));
    pair(&mut text, 0, format_args!("EOF"));
    Ok(text.into_bytes())
}

/// A polyline of the plane or of space. A closed one ends before its first vertex.
fn curve(text: &mut Text, nurbs: &Nurbs, samples: Option<usize>) -> Result<(), ExportError> {
    let steps = samples.map_or_else(|| nurbs.u.steps(MOST_ALONG_CURVE), steps_between);
    let sites = open_sites(&nurbs.u, steps);
    let jets = finite(nurbs.evaluate(&sites, &[]), None)?;
    let planar = nurbs.points.dimension() == 2;
    let closed = if nurbs.u.closed { CLOSED } else { 0 };
    let kind = if planar { 0 } else { SPATIAL };
    polyline(text, kind | closed);
    for jet in &jets {
        vertex(text, jet.point, (!planar).then_some(4 * SPATIAL));
    }
    end(text);
    Ok(())
}

/// A polygon mesh: M rows of N vertices.
fn surface(
    text: &mut Text,
    nurbs: &Nurbs,
    v: &KnotVector,
    samples: Option<[usize; 2]>,
) -> Result<(), ExportError> {
    let most = MOST_IN_MESH;
    if samples.is_some_and(|counts| counts.iter().any(|count| *count > most)) {
        return Err(ExportError::MeshSize {
            format: Format::Dxf,
            most,
        });
    }
    let steps = |knots: &KnotVector, axis: usize| match samples {
        Some(counts) => steps_between(counts[axis]),
        None => knots.steps(MOST_ALONG_SURFACE),
    };
    let sites = |knots: &KnotVector, axis| open_sites(knots, steps(knots, axis));
    let (rows, columns) = (sites(&nurbs.u, 0), sites(v, 1));
    let jets = finite(nurbs.evaluate(&rows, &columns), Some(columns.len()))?;
    let closed = if nurbs.u.closed { CLOSED } else { 0 };
    let across = if v.closed { CLOSED_ACROSS } else { 0 };
    polyline(text, MESH | closed | across);
    pair(text, 71, format_args!("{}", rows.len()));
    pair(text, 72, format_args!("{}", columns.len()));
    for jet in &jets {
        vertex(text, jet.point, Some(MESH_VERTEX));
    }
    end(text);
    Ok(())
}

/// Refuses samples that are not finite: sums can overflow although the control points do not.
fn finite(jets: Vec<Jet>, columns: Option<usize>) -> Result<Vec<Jet>, ExportError> {
    for (index, jet) in jets.iter().enumerate() {
        let coordinates = jet.point.iter().enumerate();
        if let Some((coordinate, &value)) = coordinates.into_iter().find(|(_, x)| !x.is_finite()) {
            return Err(ExportError::NotFinite {
                what: "sample",
                place: NetIndex::new(index, columns),
                coordinate,
                value,
            });
        }
    }
    Ok(jets)
}

/// The sites of samples, on closed directions without the last, which is the first.
fn open_sites(knots: &KnotVector, steps: usize) -> Vec<SpanParameter> {
    if !knots.closed {
        return knots.sites(steps);
    }
    // It takes three to go around.
    let mut sites = knots.sites(steps.max(3));
    sites.pop();
    sites
}

fn polyline(text: &mut Text, flags: u32) {
    entity(text, "POLYLINE");
    // Vertices follow; the place of the polyline itself is not used.
    pair(text, 66, format_args!("1"));
    place(text, [0.0; 3]);
    pair(text, 70, format_args!("{flags}"));
}

fn vertex(text: &mut Text, point: [f64; 3], flags: Option<u32>) {
    entity(text, "VERTEX");
    place(text, point);
    if let Some(flags) = flags {
        pair(text, 70, format_args!("{flags}"));
    }
}

fn end(text: &mut Text) {
    entity(text, "SEQEND");
}

fn entity(text: &mut Text, kind: &str) {
    pair(text, 0, format_args!("{kind}"));
    // The layer that is always there.
    pair(text, 8, format_args!("0"));
}

fn place(text: &mut Text, point: [f64; 3]) {
    for (code, x) in [10, 20, 30].into_iter().zip(point) {
        text.put(format_args!("{code:3}\n"));
        text.real(x, 'E');
        text.push("\n");
    }
}

/// A group: its code and its value, each on a line.
fn pair(text: &mut Text, code: u32, value: std::fmt::Arguments<'_>) {
    text.put(format_args!("{code:3}\n"));
    text.put(value);
    text.push("\n");
}
