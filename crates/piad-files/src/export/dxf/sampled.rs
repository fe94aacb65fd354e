//! Samples as polylines and polygon meshes.

use crate::export::error::ExportError;
use crate::export::format::Format;
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::options::Options;
use crate::export::sampling::{along_curve, finite};
use piad_fit::engine::nurbs::{SpanParameter, steps_between};

/// The most samples of a polygon mesh in each direction, the limit of AutoCAD.
const MOST_IN_MESH: usize = 256;

/// The most steps along a curve, and along each direction of a surface, unless more are requested.
const MOST_ALONG_CURVE: usize = 1 << 12;
const MOST_ALONG_SURFACE: usize = 96;

/// Flags of polylines: closed, in space, a mesh, a mesh that is closed in its second direction.
const CLOSED: u32 = 1;
pub(super) const SPATIAL: u32 = 8;
const MESH: u32 = 16;
const CLOSED_ACROSS: u32 = 32;

/// A polyline through samples of a curve. A closed one ends before its first vertex.
#[derive(Debug)]
pub(super) struct Polyline {
    pub(super) flags: u32,
    /// True if all vertices are in the xy plane.
    pub(super) is_planar: bool,
    pub(super) vertices: Vec<[f64; 3]>,
}

impl Polyline {
    pub(super) fn new(nurbs: &Nurbs, options: &Options) -> Result<Self, ExportError> {
        let mut sites = along_curve(nurbs, options, MOST_ALONG_CURVE)?;
        if nurbs.u.closed {
            sites = open(&nurbs.u, sites);
        }
        let is_planar = nurbs.points.dimension() == 2;
        let closed = if nurbs.u.closed { CLOSED } else { 0 };
        let kind = if is_planar { 0 } else { SPATIAL };
        Ok(Self {
            flags: kind | closed,
            is_planar,
            vertices: finite(&nurbs.evaluate(&sites, &[]), None)?,
        })
    }
}

/// A polygon mesh through samples of a surface: M rows of N vertices.
#[derive(Debug)]
pub(super) struct PolygonMesh {
    pub(super) flags: u32,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) vertices: Vec<[f64; 3]>,
}

impl PolygonMesh {
    pub(super) fn new(
        nurbs: &Nurbs,
        v: &KnotVector,
        options: &Options,
    ) -> Result<Self, ExportError> {
        let counts = options.samples.map(|grid| [grid.rows, grid.columns]);
        let most = MOST_IN_MESH;
        if counts.is_some_and(|counts| counts.iter().any(|count| *count > most)) {
            return Err(ExportError::MeshSize {
                format: Format::Dxf,
                most,
            });
        }
        let sites = |knots: &KnotVector, axis: usize| {
            let steps = match counts {
                Some(counts) => steps_between(counts[axis]),
                None => knots.steps(MOST_ALONG_SURFACE),
            };
            match knots.closed {
                true => open(knots, knots.sites(steps)),
                false => knots.sites(steps),
            }
        };
        let (rows, columns) = (sites(&nurbs.u, 0), sites(v, 1));
        let closed = if nurbs.u.closed { CLOSED } else { 0 };
        let across = if v.closed { CLOSED_ACROSS } else { 0 };
        Ok(Self {
            flags: MESH | closed | across,
            rows: rows.len(),
            columns: columns.len(),
            vertices: finite(&nurbs.evaluate(&rows, &columns), Some(columns.len()))?,
        })
    }
}

/// The sites of a closed direction without the last, which is the first again. It takes three to go around.
fn open(knots: &KnotVector, mut sites: Vec<SpanParameter>) -> Vec<SpanParameter> {
    if sites.len() < 4 {
        sites = knots.sites(3);
    }
    sites.pop();
    sites
}
