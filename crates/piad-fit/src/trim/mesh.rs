//! The outline of a mesh: its boundary loops, with half of the mean length of their edges as unit.

use super::boundary::{Piece, Vertex};
use super::cells::Side;

/// The unit, as a part of the mean length of edges.
const UNIT: f64 = 0.5;

/// Holes of up to this number of units along both directions are filled: three edges.
const SMALL: f64 = 6.0;

/// A vertex is a corner where the boundary turns by more than the angle with this cosine, over this number of edges on either side.
const COSINE: f64 = 0.5;
const EDGES: usize = 3;

/// A boundary around more than this part of the rectangle leaves all of it.
const WHOLE: f64 = 0.999;

/// The boundary of a mesh in units from the lower ends of its parameters.
pub(super) struct Boundary {
    /// The loop around the mesh, counter-clockwise, and those of its holes; `None` where nothing is left out.
    pub piece: Option<Piece>,
    /// The unit.
    pub unit: f64,
    sides: [Side; 2],
}

impl Boundary {
    /// The loops of vertices with these parameters, which go along no closed direction.
    pub(super) fn new(loops: &[Vec<u32>], parameters: &[[f64; 2]], sides: [Side; 2]) -> Self {
        let edge = |[a, b]: [usize; 2]| {
            let [from, to] = [parameters[a], parameters[b]];
            (to[0] - from[0]).hypot(to[1] - from[1])
        };
        let unit = UNIT * mean_edge(loops, edge);
        let place = |vertex: &u32| {
            let pair = parameters[*vertex as usize];
            [0, 1].map(|axis| (pair[axis] - sides[axis].low) / unit)
        };
        let polygons = loops
            .iter()
            .map(|line| line.iter().map(place).collect::<Vec<_>>());
        let mut polygons: Vec<(f64, Vec<[f64; 2]>)> = polygons.map(|it| (area(&it), it)).collect();
        polygons.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        let holes = polygons
            .iter()
            .skip(1)
            .filter(|(_, polygon)| !is_small(polygon));
        let kept: Vec<_> = polygons.iter().take(1).chain(holes).collect();
        let whole: f64 = sides.iter().map(|side| side.length() / unit).product();
        let is_whole = kept.len() < 2 && kept.iter().all(|(area, _)| area.abs() > WHOLE * whole);
        let polygons = kept.iter().enumerate().map(|(k, (area, polygon))| {
            let is_turned = (*area > 0.0) != (k == 0);
            vertices(polygon, is_turned)
        });
        Self {
            piece: (!is_whole).then(|| Piece {
                polygons: polygons.collect(),
            }),
            unit,
            sides,
        }
    }

    /// Where the parameters begin and end, in units.
    pub(super) fn range(&self) -> [[f64; 2]; 2] {
        self.sides.map(|side| [0.0, side.length() / self.unit])
    }

    /// The parameter of a place in units.
    pub(super) fn parameter(&self, axis: usize, place: f64) -> f64 {
        let side = self.sides[axis];
        (side.low + place * self.unit).clamp(side.low, side.high)
    }
}

/// The mean length of the edges of some loops.
pub(super) fn mean_edge(loops: &[Vec<u32>], length: impl Fn([usize; 2]) -> f64) -> f64 {
    let edges = loops.iter().flat_map(|line| {
        let next = line.iter().cycle().skip(1);
        line.iter()
            .zip(next)
            .map(|(a, b)| [*a as usize, *b as usize])
    });
    let (sum, count) = edges.fold((0.0, 0_usize), |(sum, count), edge| {
        (sum + length(edge), count + 1)
    });
    sum / count.max(1) as f64
}

/// The area in a polygon, positive if it goes around counter-clockwise.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let cross = |(a, b): (&[f64; 2], &[f64; 2])| a[0] * b[1] - a[1] * b[0];
    0.5 * polygon.iter().zip(next).map(cross).sum::<f64>()
}

fn is_small(polygon: &[[f64; 2]]) -> bool {
    (0..2).all(|axis| {
        let (low, high) = polygon
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |it, at| {
                (it.0.min(at[axis]), it.1.max(at[axis]))
            });
        high - low <= SMALL
    })
}

/// The corners of a polygon and the middles of its edges, from one of the corners on, if it has one.
fn vertices(polygon: &[[f64; 2]], is_turned: bool) -> Vec<Vertex> {
    let mut places = polygon.to_vec();
    if is_turned {
        places.reverse();
    }
    let count = places.len();
    let cosine = |k: usize| {
        let reach = EDGES.min(count / 4).max(1);
        let [before, at, after] = [k + count - reach, k, k + reach].map(|k| places[k % count]);
        let [a, b] =
            [[at, before], [after, at]].map(|[to, from]| [to[0] - from[0], to[1] - from[1]]);
        let lengths = a[0].hypot(a[1]) * b[0].hypot(b[1]);
        (a[0] * b[0] + a[1] * b[1]) / lengths
    };
    let cosines: Vec<f64> = (0..count).map(cosine).collect();
    let is_corner = |k: usize| {
        let near = (1..=EDGES).flat_map(|step| [k + count - step % count, k + step]);
        let is_sharpest = near.map(|other| other % count).all(|other| {
            cosines[k] < cosines[other] || (cosines[k] == cosines[other] && k <= other)
        });
        cosines[k] < COSINE && is_sharpest
    };
    // Through the middles of edges, so that steps go inside as far as outside.
    let vertices = (0..count).flat_map(|k| {
        let (at, next) = (places[k], places[(k + 1) % count]);
        let corner = is_corner(k).then_some(Vertex {
            at,
            is_corner: true,
        });
        let middle = Vertex {
            at: [0, 1].map(|axis| 0.5 * (at[axis] + next[axis])),
            is_corner: false,
        };
        corner.into_iter().chain([middle])
    });
    let mut vertices: Vec<Vertex> = vertices.collect();
    let first = vertices.iter().position(|it| it.is_corner).unwrap_or(0);
    vertices.rotate_left(first);
    vertices
}
