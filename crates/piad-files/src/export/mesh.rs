//! Vertices, normals and triangles of a surface; vertices of a curve.

use crate::export::error::ExportError;
use crate::export::format::Format;
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::options::Options;
use crate::export::sampling::along_curve;
use crate::export::trim::triangles::{self as trim, Triangles};
use piad_fit::engine::nurbs::{Jet, SpanParameter, steps_between};
use piad_fit::engine::vectors::{cross, length, minus, unit};
use piad_fit::geometry::Outline;

/// The most steps along a curve and along each direction of a surface: some 10⁵ vertices, which
/// every viewer can show.
const MOST_ALONG_CURVE: usize = 1 << 16;
pub(super) const MOST_ALONG_SURFACE: usize = 384;

/// Single precision suffices while the distance from the origin is at most this multiple of the extent.
const MAX_ORIGIN_DISTANCE_EXTENTS: f64 = 16.0;

/// A tessellated surface, or the points along a curve.
#[derive(Clone, Debug, Default)]
pub(super) struct Mesh {
    /// The offset of all positions.
    pub(super) origin: [f64; 3],
    /// The vertices, row by row.
    pub(super) positions: Vec<[f32; 3]>,
    /// Unit normals, on the side from which u × v turns counterclockwise.
    pub(super) normals: Vec<[f32; 3]>,
    /// Counterclockwise seen from that side.
    pub(super) triangles: Vec<[u32; 3]>,
    /// From each vertex of a curve to the next.
    pub(super) lines: Vec<[u32; 2]>,
}

impl Mesh {
    /// Samples a curve or surface, with the requested or a suitable density.
    pub(super) fn new(
        nurbs: &Nurbs,
        outline: Option<&Outline>,
        options: &Options,
        format: Format,
    ) -> Result<Self, ExportError> {
        let grid = SampledGrid::new(nurbs, outline, options)?;
        let origin = origin(&grid.jets);
        let mut mesh = Self {
            origin,
            ..Self::default()
        };
        for jet in &grid.jets {
            let [x, y, z] = minus(jet.point, origin);
            mesh.positions
                .push([single(x, format)?, single(y, format)?, single(z, format)?]);
        }
        if nurbs.v.is_some() {
            mesh.normals = grid.normals(nurbs);
            mesh.triangles = grid.triangles;
        } else {
            let count = grid.jets.len() as u32;
            mesh.lines = (1..count).map(|end| [end - 1, end]).collect();
        }
        Ok(mesh)
    }
}

/// Samples of a curve or surface in double precision.
#[derive(Clone, Debug)]
pub(super) struct SampledGrid {
    /// The parameters of each sample; `v` is empty for curves.
    sites: Vec<(SpanParameter, Option<SpanParameter>)>,
    /// The number of samples in a row of a surface that is not trimmed.
    columns: Option<usize>,
    /// The samples; of a surface that is not trimmed row by row.
    pub(super) jets: Vec<Jet>,
    /// The triangles of a surface, counterclockwise seen from the side of its normals.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl SampledGrid {
    /// Samples a curve or surface inside an outline, with the requested or a suitable density.
    pub(super) fn new(
        nurbs: &Nurbs,
        outline: Option<&Outline>,
        options: &Options,
    ) -> Result<Self, ExportError> {
        let across = |knots: &KnotVector, requested: Option<usize>| {
            let steps = requested.map_or_else(|| knots.steps(MOST_ALONG_SURFACE), steps_between);
            knots.sites(steps)
        };
        let Some(v) = &nurbs.v else {
            let u = along_curve(nurbs, options, MOST_ALONG_CURVE)?;
            let jets = nurbs.evaluate(&u, &[]);
            return Ok(Self::of_grid(nurbs, &u, &[], jets));
        };
        let samples = options.samples;
        let u = across(&nurbs.u, samples.map(|grid| grid.rows));
        let v = across(v, samples.map(|grid| grid.columns));
        match outline {
            None => Ok(Self::of_grid(nurbs, &u, &v, nurbs.evaluate(&u, &v))),
            Some(outline) => Self::trimmed(nurbs, outline, [&u, &v]),
        }
    }

    fn of_grid(
        nurbs: &Nurbs,
        u: &[SpanParameter],
        v: &[SpanParameter],
        mut jets: Vec<Jet>,
    ) -> Self {
        close(nurbs, v.len().max(1), &mut jets);
        let surface = |u| v.iter().map(move |&v| (u, Some(v)));
        let sites = match v {
            [] => u.iter().map(|&u| (u, None)).collect(),
            _ => u.iter().flat_map(|&u| surface(u)).collect(),
        };
        Self {
            sites,
            columns: Some(v.len().max(1)),
            jets,
            triangles: match v {
                [] => Vec::new(),
                _ => triangles(u.len(), v.len()),
            },
        }
    }

    fn trimmed(
        nurbs: &Nurbs,
        outline: &Outline,
        sites: [&[SpanParameter]; 2],
    ) -> Result<Self, ExportError> {
        let triangulation = trim::triangles(nurbs, outline, sites);
        let Triangles { places, triangles } = triangulation.ok_or(ExportError::NoTriangulation)?;
        let site =
            |[u, v]: [f64; 2]| (nurbs.u.site_at(u), nurbs.v.as_ref().map(|it| it.site_at(v)));
        let sites: Vec<_> = places.into_iter().map(site).collect();
        let jets = trim::evaluate(nurbs, &sites);
        Ok(Self {
            sites,
            columns: None,
            jets,
            triangles,
        })
    }

    /// The number of samples in a row of a surface that is not trimmed; one for a curve.
    pub(super) fn columns(&self) -> Option<usize> {
        self.columns
    }

    /// The unit normals of a surface.
    pub(super) fn normals(&self, nurbs: &Nurbs) -> Vec<[f32; 3]> {
        normals(nurbs, self)
    }
}

/// Closed directions end at the same points from which they start, so that a mesh has no gap there.
fn close(nurbs: &Nurbs, columns: usize, jets: &mut [Jet]) {
    let last = jets.len() - columns;
    if nurbs.u.closed {
        for j in 0..columns {
            jets[last + j].point = jets[j].point;
        }
    }
    if nurbs.v.as_ref().is_some_and(|v| v.closed) {
        for row in jets.chunks_exact_mut(columns) {
            row[columns - 1].point = row[0].point;
        }
    }
}

/// Points far from the origin, as those of maps are, lose their shape in single precision: they are
/// stored relative to the middle of their bounding box.
fn origin(jets: &[Jet]) -> [f64; 3] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for jet in jets {
        for c in 0..3 {
            low[c] = low[c].min(jet.point[c]);
            high[c] = high[c].max(jet.point[c]);
        }
    }
    let middle = [0, 1, 2].map(|c| low[c] / 2.0 + high[c] / 2.0);
    let near = length(middle) <= MAX_ORIGIN_DISTANCE_EXTENTS * length(minus(high, low));
    if near { [0.0; 3] } else { middle }
}

/// Two triangles for each cell of the grid of vertices.
fn triangles(rows: usize, columns: usize) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * rows * columns);
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let vertex = |di: usize, dj: usize| ((i + di) * columns + j + dj) as u32;
            triangles.push([vertex(0, 0), vertex(1, 0), vertex(1, 1)]);
            triangles.push([vertex(0, 0), vertex(1, 1), vertex(0, 1)]);
        }
    }
    triangles
}

/// The direction of ∂S/∂u × ∂S/∂v. Where control points coincide, as they do at the ends with knots
/// at the data, a derivative can vanish: there the normal is that of a point a little inside, or if
/// that has none either, of the triangles around.
fn normals(nurbs: &Nurbs, grid: &SampledGrid) -> Vec<[f32; 3]> {
    let normal = |jet: &Jet| cross(jet.du, jet.dv);
    let largest = grid.jets.iter().map(normal).map(length).fold(0.0, f64::max);
    let mut around = None;
    let mut normals = Vec::with_capacity(grid.jets.len());
    for (index, jet) in grid.jets.iter().enumerate() {
        let (u, v) = grid.sites[index];
        let regular = |jet: &Jet| Some(normal(jet)).filter(|n| length(*n) > 1e-8 * largest);
        let direction = regular(jet).and_then(unit).or_else(|| {
            let inside = nurbs.v.as_ref()?.inside(v?);
            let near = nurbs.evaluate(&[nurbs.u.inside(u)], &[inside]);
            near.first().map(normal).and_then(unit)
        });
        let direction = direction.or_else(|| {
            let areas = around.get_or_insert_with(|| areas(grid));
            unit(areas[index])
        });
        normals.push(direction.unwrap_or([0.0, 0.0, 1.0]).map(|x| x as f32));
    }
    normals
}

/// The vector areas of the triangles around each vertex.
fn areas(grid: &SampledGrid) -> Vec<[f64; 3]> {
    let mut areas = vec![[0.0; 3]; grid.jets.len()];
    for triangle in &grid.triangles {
        let [a, b, c] = triangle.map(|index| grid.jets[index as usize].point);
        let area = cross(minus(b, a), minus(c, a));
        for index in triangle {
            let sum = &mut areas[*index as usize];
            *sum = [0, 1, 2].map(|c| sum[c] + area[c]);
        }
    }
    areas
}

/// A coordinate in single precision.
pub(super) fn single(value: f64, format: Format) -> Result<f32, ExportError> {
    let rounded = value as f32;
    if rounded.is_finite() {
        Ok(rounded)
    } else {
        Err(ExportError::SinglePrecision { format, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::cylinder::cylinder;
    use piad_fit::data::Grid;
    use piad_fit::engine::vectors::dot;

    fn wide(vector: [f32; 3]) -> [f64; 3] {
        vector.map(f64::from)
    }

    #[test]
    fn normals_of_a_cylinder_point_away_from_its_axis() {
        let mesh = Mesh::new(&cylinder(), None, &Options::default(), Format::Gltf).unwrap();
        assert_eq!(mesh.origin, [0.0; 3]);
        assert_eq!(mesh.positions.len(), mesh.normals.len());
        for (&position, &normal) in mesh.positions.iter().zip(&mesh.normals) {
            let [x, y, _] = wide(position);
            assert!(length(minus(wide(normal), [x / 2.0, y / 2.0, 0.0])) < 1e-6);
        }
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|index| wide(mesh.positions[index as usize]));
            let area = cross(minus(b, a), minus(c, a));
            assert!(dot(area, wide(mesh.normals[triangle[0] as usize])) > 0.0);
        }
    }

    /// With the first row of control points twice, ∂S/∂u is zero there; with it in one place, as at
    /// a pole, ∂S/∂v is.
    #[test]
    fn vanishing_derivatives_leave_normals() {
        let mut doubled = cylinder();
        let mut pole = cylinder();
        for lane in 0..3 {
            let values = &mut doubled.points.lanes_mut()[lane];
            values[2] = values[0];
            values[3] = values[1];
            let values = &mut pole.points.lanes_mut()[lane];
            values[1] = values[0];
        }
        doubled.weights = None;
        pole.weights = None;
        for nurbs in [doubled, pole] {
            let mesh = Mesh::new(&nurbs, None, &Options::default(), Format::Gltf).unwrap();
            for &normal in &mesh.normals {
                assert!((length(wide(normal)) - 1.0).abs() < 1e-6);
            }
            // The first vertex of the second row is the second one of the first triangle.
            let columns = mesh.triangles[0][1] as usize;
            for column in 0..columns {
                let first = wide(mesh.normals[column]);
                let second = wide(mesh.normals[columns + column]);
                assert!(dot(first, second) > 0.99, "{first:?} {second:?}");
            }
        }
    }

    /// Where single precision would lose the shape.
    #[test]
    fn points_far_away_are_stored_around_their_middle() {
        let mut nurbs = cylinder();
        nurbs.points.lanes_mut()[0]
            .iter_mut()
            .for_each(|x| *x += 5e6);
        let mesh = Mesh::new(&nurbs, None, &Options::default(), Format::Gltf).unwrap();
        for &position in &mesh.positions {
            let [x, y, _] = wide(position);
            let (x, y) = (x + mesh.origin[0] - 5e6, y + mesh.origin[1]);
            assert!((x.hypot(y) - 2.0).abs() < 1e-6);
        }
    }

    #[test]
    fn requested_numbers_of_samples() {
        let options = Options {
            samples: Some(Grid {
                rows: 3,
                columns: 4,
            }),
            ..Options::default()
        };
        let mesh = Mesh::new(&cylinder(), None, &options, Format::Gltf).unwrap();
        assert_eq!(mesh.positions.len(), 12);
        assert_eq!(mesh.triangles.len(), 2 * 2 * 3);
    }
}
