//! The cut between the two loops of a mesh, along a shortest path.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::edges::{Edges, ends};
use super::sheet::Sheet;
use crate::interrupt;

/// A shortest path from the first loop to the second one.
pub(super) struct Cut {
    /// Its vertices.
    pub path: Vec<u32>,
    pub length: f64,
}

/// The neighbours of each vertex.
pub(super) struct Neighbours {
    starts: Vec<u32>,
    others: Vec<u32>,
}

impl Neighbours {
    pub(super) fn new(triangles: &[[u32; 3]], count: usize) -> Self {
        let edges = Edges::new(triangles);
        let mut starts = vec![0_u32; count + 1];
        let pairs = || edges.groups().map(|group| ends(triangles, group[0].1));
        for [a, b] in pairs() {
            starts[a as usize + 1] += 1;
            starts[b as usize + 1] += 1;
        }
        for k in 0..count {
            starts[k + 1] += starts[k];
        }
        let mut places = starts.clone();
        let mut others = vec![0; starts[count] as usize];
        for [a, b] in pairs() {
            for (from, to) in [(a, b), (b, a)] {
                others[places[from as usize] as usize] = to;
                places[from as usize] += 1;
            }
        }
        Self { starts, others }
    }

    pub(super) fn of(&self, vertex: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|k| self.starts[vertex as usize + k] as usize);
        &self.others[start..end]
    }
}

impl Cut {
    /// The shortest one along edges (Dijkstra); `None` if there is none.
    pub(super) fn new(sheet: &Sheet) -> Option<Self> {
        let neighbours = Neighbours::new(&sheet.triangles, sheet.places.len());
        let mut distances = vec![f64::INFINITY; sheet.places.len()];
        let mut parents = vec![u32::MAX; sheet.places.len()];
        let mut heap = BinaryHeap::new();
        for &vertex in &sheet.loops[0] {
            distances[vertex as usize] = 0.0;
            heap.push(Reverse((0.0_f64.to_bits(), vertex)));
        }
        let mut steps = 0_u32;
        while let Some(Reverse((bits, vertex))) = heap.pop() {
            steps = steps.wrapping_add(1);
            if steps.is_multiple_of(1 << 12) {
                interrupt::check();
            }
            let length = f64::from_bits(bits);
            if length > distances[vertex as usize] {
                continue;
            }
            if sheet.on_loop[vertex as usize] == Some(1) {
                return Some(Self {
                    path: path(&parents, vertex),
                    length,
                });
            }
            for &other in neighbours.of(vertex) {
                let step = (sheet.places[other as usize] - sheet.places[vertex as usize]).norm();
                if length + step < distances[other as usize] {
                    distances[other as usize] = length + step;
                    parents[other as usize] = vertex;
                    // Lengths are not negative, so that their bits are in their order.
                    heap.push(Reverse(((length + step).to_bits(), other)));
                }
            }
        }
        None
    }

    /// For each corner of each triangle true if it is a vertex of the cut seen from its left.
    pub(super) fn left(&self, sheet: &Sheet) -> Vec<[bool; 3]> {
        let triangles = &sheet.triangles;
        let mut place = vec![usize::MAX; sheet.places.len()];
        self.path
            .iter()
            .enumerate()
            .for_each(|(k, &vertex)| place[vertex as usize] = k);
        let mut left = vec![[false; 3]; triangles.len()];
        let mut twins = vec![u32::MAX; 3 * triangles.len()];
        for group in Edges::new(triangles).groups() {
            if let [(_, one), (_, other)] = *group {
                twins[one as usize] = other;
                twins[other as usize] = one;
            }
        }
        // The triangles on the left of an edge of the path, and from there around its ends up to the next one.
        for half_edge in 0..twins.len() as u32 {
            let [from, to] = ends(triangles, half_edge).map(|vertex| place[vertex as usize]);
            if from == usize::MAX || to == usize::MAX || to != from + 1 {
                continue;
            }
            let is_path = |half_edge: u32| {
                let [a, b] = ends(triangles, half_edge).map(|vertex| place[vertex as usize]);
                a != usize::MAX && b != usize::MAX && a.abs_diff(b) == 1
            };
            for (vertex, steps) in [(from, true), (to, false)] {
                let vertex = self.path[vertex];
                // The half-edge of the triangle over which the walk continues.
                let mut at = half_edge;
                loop {
                    let t = at as usize / 3;
                    if let Some(k) = triangles[t].iter().position(|it| *it == vertex) {
                        left[t][k] = true;
                    }
                    let k = at % 3;
                    // From an edge out of the vertex to the one into it, or the other way around.
                    let crossed = 3 * (at / 3) + if steps { (k + 2) % 3 } else { (k + 1) % 3 };
                    let twin = twins[crossed as usize];
                    if twin == u32::MAX || is_path(crossed) {
                        break;
                    }
                    at = twin;
                }
            }
        }
        left
    }
}

/// The vertices on the way to one.
fn path(parents: &[u32], end: u32) -> Vec<u32> {
    let mut path = vec![end];
    let mut at = end;
    while parents[at as usize] != u32::MAX {
        at = parents[at as usize];
        path.push(at);
    }
    path.reverse();
    path
}
