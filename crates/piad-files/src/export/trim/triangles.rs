//! The triangles of a trimmed surface: a constrained Delaunay triangulation of the samples of the surface and of points along
//! its loops.

use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use piad_fit::engine::nurbs::{Jet, SpanParameter};
use piad_fit::geometry::{Nurbs, Outline};

/// The least distance of samples from loops, in steps between samples: nearer ones would give narrow triangles.
const APART: f64 = 0.35;

/// The longest steps along loops, in the same unit.
const STEP: f64 = 0.5;

/// Places in the parameters of a surface, and triangles between them, counter-clockwise.
#[derive(Debug, Default)]
pub(in super::super) struct Triangles {
    /// u and v of each vertex.
    pub places: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

/// A vertex, at a place that is counted in samples.
struct Vertex {
    at: [f64; 2],
    place: [f64; 2],
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.at[0], self.at[1])
    }
}

/// The triangles of a surface inside of an outline, with vertices at these sites and along the loops.
pub(in super::super) fn triangles(
    surface: &Nurbs,
    outline: &Outline,
    sites: [&[SpanParameter]; 2],
) -> Option<Triangles> {
    let lines = sites.map(|sites| sites.iter().map(|site| site.t).collect::<Vec<f64>>());
    let steps = [STEP, 0.5 * STEP, 0.1 * STEP];
    let mut meshes = steps.iter().map(|&step| {
        let (vertices, edges) = vertices(surface, outline, &lines, step);
        triangulated(vertices, edges)
    });
    meshes.find_map(|mesh| mesh).map(|mesh| inside(&mesh))
}

/// The vertices, and those of them between which there are loops.
fn vertices(
    surface: &Nurbs,
    outline: &Outline,
    lines: &[Vec<f64>; 2],
    step: f64,
) -> (Vec<Vertex>, Vec<[usize; 2]>) {
    let most = lines.iter().map(Vec::len).max().unwrap_or(1);
    let vertex = |place: [f64; 2]| Vertex {
        at: [0, 1].map(|axis| counted(&lines[axis], place[axis])),
        place,
    };
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    for polygon in outline.polygons(surface, step / most as f64) {
        let (first, count) = (vertices.len(), polygon.len() - 1);
        vertices.extend(polygon[..count].iter().map(|it| vertex(*it)));
        edges.extend((0..count).map(|k| [first + k, first + (k + 1) % count]));
    }
    let is_near = near(&vertices, lines[0].len(), lines[1].len());
    for (i, &u) in lines[0].iter().enumerate() {
        for (j, &v) in lines[1].iter().enumerate() {
            if !is_near[i * lines[1].len() + j] {
                vertices.push(vertex([u, v]));
            }
        }
    }
    (vertices, edges)
}

/// A parameter as a number of samples.
fn counted(line: &[f64], t: f64) -> f64 {
    let after = line.partition_point(|it| *it <= t).clamp(1, line.len() - 1);
    let (low, high) = (line[after - 1], line[after]);
    (after - 1) as f64 + (t - low) / (high - low)
}

/// The samples near these vertices.
fn near(vertices: &[Vertex], rows: usize, columns: usize) -> Vec<bool> {
    let mut near = vec![false; rows * columns];
    for Vertex { at: [x, y], .. } in vertices {
        let (i, j) = (x.round(), y.round());
        if (i - x).hypot(j - y) < APART + 0.5 * STEP {
            let (i, j) = (i as usize, j as usize);
            near[i.min(rows - 1) * columns + j.min(columns - 1)] = true;
        }
    }
    near
}

type Mesh = ConstrainedDelaunayTriangulation<Vertex>;

/// The triangulation, unless edges of loops cross.
fn triangulated(vertices: Vec<Vertex>, edges: Vec<[usize; 2]>) -> Option<Mesh> {
    let mut crossing = 0;
    let mesh = Mesh::try_bulk_load_cdt(vertices, edges, |_| crossing += 1);
    mesh.ok().filter(|_| crossing == 0)
}

/// The triangles between loops, which are found from outside: each loop leads in or out.
fn inside(mesh: &Mesh) -> Triangles {
    let mut is_inside: Vec<Option<bool>> = vec![None; mesh.num_all_faces()];
    let mut next = vec![(mesh.outer_face(), false)];
    let hull: Vec<_> = mesh.convex_hull().collect();
    let mut triangles = Vec::new();
    while let Some((face, is_in)) = next.pop() {
        if is_inside[face.index()].replace(is_in).is_some() {
            continue;
        }
        let inner = face.as_inner();
        let edges = match &inner {
            Some(inner) => inner.adjacent_edges().to_vec(),
            None => hull.clone(),
        };
        for edge in edges {
            let beyond = edge.rev().face();
            let is_loop = edge.as_undirected().is_constraint_edge();
            next.push((beyond, is_in != is_loop));
        }
        if let Some(inner) = inner.filter(|_| is_in) {
            triangles.push(inner.vertices().map(|it| it.index() as u32));
        }
    }
    triangles.sort_unstable();
    used(mesh, triangles)
}

/// The triangles with those vertices that they have.
fn used(mesh: &Mesh, mut triangles: Vec<[u32; 3]>) -> Triangles {
    let mut numbers = vec![u32::MAX; mesh.num_vertices()];
    for &index in triangles.as_flattened() {
        numbers[index as usize] = 0;
    }
    let mut places = Vec::new();
    for (vertex, number) in mesh.vertices().zip(&mut numbers) {
        if *number == 0 {
            *number = places.len() as u32;
            places.push(vertex.data().place);
        }
    }
    for index in triangles.as_flattened_mut() {
        *index = numbers[*index as usize];
    }
    Triangles { places, triangles }
}

/// The points of a surface at scattered sites.
pub(in super::super) fn evaluate(
    surface: &Nurbs,
    sites: &[(SpanParameter, Option<SpanParameter>)],
) -> Vec<Jet> {
    let mut jets = vec![Jet::default(); sites.len()];
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|&a, &b| sites[a].0.t.total_cmp(&sites[b].0.t));
    // Samples lie in rows, which are evaluated together.
    for row in order.chunk_by(|&a, &b| sites[a].0 == sites[b].0) {
        let across: Vec<SpanParameter> = row.iter().filter_map(|&index| sites[index].1).collect();
        let some = surface.evaluate(&[sites[row[0]].0], &across);
        row.iter()
            .zip(some)
            .for_each(|(&index, jet)| jets[index] = jet);
    }
    jets
}
