//! The boundary of filled cells, as closed polygons.
//!
//! A polygon goes through the middles of the edges between filled and empty cells, so that cells that share no more than a
//! corner stay apart, and along the sides of the rectangle. Filled cells are on its left. It turns freely where it comes to
//! a side, leaves it, or passes a corner of the rectangle.

use std::collections::BTreeMap;

use super::cells::{Cell, Cells};
use crate::interrupt::Meter;

/// A vertex of a polygon, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub at: [f64; 2],
    /// True if the outline turns there as the polygon does.
    pub is_corner: bool,
}

/// A piece of the filled cells: the polygon around it and those of its holes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Piece {
    /// The polygons, of which the first goes around, counter-clockwise.
    pub polygons: Vec<Vec<Vertex>>,
}

/// The directions of the edges of a cell, from the lower one on, counter-clockwise.
const ALONG: [Cell; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
/// Where the neighbour beyond such an edge is.
const BEYOND: [Cell; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];
/// The corner of a cell from which such an edge goes.
const FROM: [Cell; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];

/// An edge between a filled cell and an empty one, or a side of the rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edge {
    cell: Cell,
    side: usize,
}

fn plus(a: Cell, b: Cell) -> Cell {
    [a[0] + b[0], a[1] + b[1]]
}

impl Edge {
    fn beyond(self) -> Cell {
        plus(self.cell, BEYOND[self.side])
    }

    /// The next edge around the same cells. Cells that share a corner are not connected.
    fn next(self, cells: &Cells) -> Self {
        let Self { cell, side } = self;
        let ahead = plus(cell, ALONG[side]);
        let across = plus(ahead, BEYOND[side]);
        if !cells.is_filled(ahead) {
            let side = (side + 1) % 4;
            Self { cell, side }
        } else if !cells.is_filled(across) {
            Self { cell: ahead, side }
        } else {
            let side = (side + 3) % 4;
            Self { cell: across, side }
        }
    }

    /// The end of the edge, in cells.
    fn end(self) -> [f64; 2] {
        plus(plus(self.cell, FROM[self.side]), ALONG[self.side]).map(|x| x as f64)
    }

    /// The middle of the edge, moved into its cell by a part of that.
    fn middle(self, inside: f64) -> [f64; 2] {
        let (end, along, beyond) = (self.end(), ALONG[self.side], BEYOND[self.side]);
        [0, 1].map(|axis| end[axis] - 0.5 * along[axis] as f64 - inside * beyond[axis] as f64)
    }
}

/// The pieces of filled cells, in the order of their first cells. Polygons are this much further inside than the edges of
/// cells, in cells.
pub(super) fn pieces(cells: &Cells, inside: f64, meter: &mut Meter) -> Vec<Piece> {
    let columns = cells.steps[0].count;
    let index = |[i, j]: Cell| j as usize * columns + i as usize;
    let count = columns * cells.steps[1].count;
    let labels = labels(cells, index, meter);
    let mut seen = vec![0_u8; count];
    let mut pieces: BTreeMap<u32, Piece> = BTreeMap::new();
    for cell in cells.each() {
        meter.add(4);
        for side in 0..4 {
            let edge = Edge { cell, side };
            let is_edge = cells.is_filled(cell) && !cells.is_filled(edge.beyond());
            if !is_edge || seen[index(cell)] & (1 << side) != 0 {
                continue;
            }
            let edges = around(edge, cells, meter);
            for it in &edges {
                seen[index(it.cell)] |= 1 << it.side;
            }
            let piece = pieces.entry(labels[index(cell)]).or_default();
            let polygon = polygon(&edges, inside, cells);
            // The first cell of a piece has its outer boundary below it.
            piece.polygons.push(polygon);
        }
    }
    pieces.into_values().collect()
}

fn around(first: Edge, cells: &Cells, meter: &mut Meter) -> Vec<Edge> {
    let mut edges = vec![first];
    let mut edge = first.next(cells);
    while edge != first {
        meter.add(8);
        edges.push(edge);
        edge = edge.next(cells);
    }
    edges
}

/// The number of the piece of each filled cell, from 1 on.
fn labels(cells: &Cells, index: impl Fn(Cell) -> usize, meter: &mut Meter) -> Vec<u32> {
    let mut labels = vec![0; cells.steps[0].count * cells.steps[1].count];
    let mut last = 0;
    for start in cells.each() {
        if !cells.is_filled(start) || labels[index(start)] != 0 {
            continue;
        }
        last += 1;
        labels[index(start)] = last;
        let mut next = vec![start];
        while let Some(cell) = next.pop() {
            meter.add(8);
            for near in ALONG.map(|step| plus(cell, step)) {
                if cells.is_filled(near) && labels[index(near)] == 0 {
                    labels[index(near)] = last;
                    next.push(near);
                }
            }
        }
    }
    labels
}

/// The polygon along these edges.
fn polygon(edges: &[Edge], inside: f64, cells: &Cells) -> Vec<Vertex> {
    let range = cells.steps.map(|it| it.range());
    // Cells around lines of points reach beyond the rectangle.
    let within = |at: [f64; 2]| [0, 1].map(|axis| at[axis].clamp(range[axis][0], range[axis][1]));
    let mut vertices: Vec<Vertex> = Vec::with_capacity(edges.len());
    let mut push = |at: [f64; 2], is_corner: bool| {
        let at = within(at);
        match vertices.last_mut() {
            Some(last) if last.at == at => last.is_corner |= is_corner,
            _ => vertices.push(Vertex { at, is_corner }),
        }
    };
    let sides = sides(edges, cells);
    for (k, edge) in edges.iter().enumerate() {
        if sides[k].is_none() {
            push(edge.middle(inside), false);
        }
        if sides[k] != sides[(k + 1) % edges.len()] {
            push(edge.end(), true);
        }
    }
    if let [first, .., last] = &mut vertices[..]
        && first.at == last.at
    {
        first.is_corner |= last.is_corner;
        vertices.pop();
    }
    from_corner(vertices)
}

/// The side of the rectangle along which each edge goes. Where a polygon only touches a side it goes along none, nor where it
/// is about to leave it at a small angle.
fn sides(edges: &[Edge], cells: &Cells) -> Vec<Option<usize>> {
    let side = |edge: &Edge| (!cells.contains(edge.beyond())).then_some(edge.side);
    let sides: Vec<Option<usize>> = edges.iter().map(side).collect();
    let count = sides.len();
    let is_start = |k: &usize| sides[*k] != sides[(k + count - 1) % count];
    let starts: Vec<usize> = (0..count).filter(is_start).collect();
    let mut kept = sides.clone();
    for (&start, &end) in starts.iter().zip(starts.iter().cycle().skip(1)) {
        if sides[start].is_none() {
            continue;
        }
        let length = (end + count - start - 1) % count + 1;
        let (before, after) = (start + count - 1, start + length);
        // A corner of the rectangle, or a steep way off the side.
        let is_held = |k: usize, step: usize| {
            sides[k % count].is_some() || is_steep(edges, k, step, sides[start])
        };
        let [first, last] = [is_held(before, count - 1), is_held(after, 1)]
            .map(|is_held| if is_held { 0 } else { AHEAD });
        let straight = length.saturating_sub(first + last);
        let least = if first + last == 0 {
            ALONG_SIDE
        } else {
            2 * AHEAD
        };
        let dropped = match straight < least {
            true => [start..start + length, 0..0],
            false => [start..start + first, start + length - last..start + length],
        };
        dropped
            .into_iter()
            .flatten()
            .for_each(|k| kept[k % count] = None);
    }
    kept
}

/// The fewest cells for which a polygon goes along a side.
const ALONG_SIDE: usize = 4;

/// After how many edges it is seen in which direction a polygon leaves a side.
const AHEAD: usize = 5;

/// Returns true if a polygon leaves a side at more than 45 degrees at an edge, in the direction of `step`.
fn is_steep(edges: &[Edge], from: usize, step: usize, side: Option<usize>) -> bool {
    let count = edges.len();
    let [first, last] = [from, from + AHEAD * step].map(|k| edges[k % count].middle(0.0));
    let [dx, dy] = [last[0] - first[0], last[1] - first[1]].map(f64::abs);
    match side {
        Some(0 | 2) => dy >= dx,
        _ => dx >= dy,
    }
}

/// The same polygon from its first corner on, if it has one.
fn from_corner(mut vertices: Vec<Vertex>) -> Vec<Vertex> {
    let first = vertices.iter().position(|it| it.is_corner).unwrap_or(0);
    vertices.rotate_left(first);
    vertices
}
