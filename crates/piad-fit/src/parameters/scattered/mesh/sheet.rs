//! A mesh made ready for mean value coordinates: small holes are filled, and edges across are split.
//!
//! A hole is filled by a fan of triangles around its middle. An edge between two vertices of one loop that is not on the
//! boundary would pull what is behind it to a side of the rectangle: it gets a vertex in its middle. Around a ragged loop
//! there is a smooth ring, so that its vertices are free.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::topology::Topology;

/// A mesh with one or two loops, in whose interior there may be vertices that are no points.
pub(super) struct Sheet {
    /// The points, and the vertices that are added.
    pub places: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    /// The loops that are left.
    pub loops: Vec<Vec<u32>>,
    /// For each vertex the number of its loop.
    pub on_loop: Vec<Option<u8>>,
}

impl Sheet {
    /// The sheet with these of the loops of a mesh.
    pub(super) fn new(topology: &Topology, places: &[Vector3<f64>], kept: &[usize]) -> Self {
        let mut sheet = Self {
            places: places.to_vec(),
            triangles: topology.triangles.clone(),
            loops: Vec::new(),
            on_loop: Vec::new(),
        };
        for (index, line) in topology.loops.iter().enumerate() {
            match kept.contains(&index) {
                true => sheet.loops.push(line.clone()),
                false => sheet.fill(line),
            }
        }
        sheet.number();
        sheet
    }

    /// Adds a ring of vertices around a loop, which takes its place.
    pub(super) fn surround(&mut self, number: usize, places: Vec<Vector3<f64>>) {
        let line = self.loops[number].clone();
        let ring: Vec<u32> = places.into_iter().map(|place| self.add(place)).collect();
        for (k, &from) in line.iter().enumerate() {
            let next = (k + 1) % line.len();
            self.triangles.push([ring[k], ring[next], line[next]]);
            self.triangles.push([ring[k], line[next], from]);
        }
        self.loops[number] = ring;
        self.number();
    }

    /// Notes on which loop each vertex is.
    fn number(&mut self) {
        self.on_loop = vec![None; self.places.len()];
        for (number, line) in self.loops.iter().enumerate() {
            for &vertex in line {
                self.on_loop[vertex as usize] = Some(number as u8);
            }
        }
    }

    /// Fills a hole.
    fn fill(&mut self, line: &[u32]) {
        let sum: Vector3<f64> = line.iter().map(|&v| self.places[v as usize]).sum();
        let middle = self.add(sum / line.len() as f64);
        for (k, &from) in line.iter().enumerate() {
            let to = line[(k + 1) % line.len()];
            self.triangles.push([to, from, middle]);
        }
    }

    fn add(&mut self, place: Vector3<f64>) -> u32 {
        self.places.push(place);
        (self.places.len() - 1) as u32
    }

    /// The same with vertices on the edges across.
    pub(super) fn split(mut self) -> Self {
        // The number of the loop of a vertex, its place in it, and the length of it.
        let mut on_loop = vec![None; self.places.len()];
        for (number, line) in self.loops.iter().enumerate() {
            for (k, &v) in line.iter().enumerate() {
                on_loop[v as usize] = Some((number as u8, k, line.len()));
            }
        }
        let is_across = |a: u32, b: u32| match (on_loop[a as usize], on_loop[b as usize]) {
            (Some((first, i, count)), Some((second, j, _))) => {
                let apart = i.abs_diff(j);
                first == second && apart != 1 && apart + 1 != count
            }
            _ => false,
        };
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        for t in 0..self.triangles.len() {
            let corners = self.triangles[t];
            let mut of_edges = [None; 3];
            for (k, of_edge) in of_edges.iter_mut().enumerate() {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if is_across(a, b) {
                    let key = [a.min(b), a.max(b)];
                    let known = middles.get(&key).copied();
                    let middle = known.unwrap_or_else(|| {
                        self.add((self.places[a as usize] + self.places[b as usize]) * 0.5)
                    });
                    middles.insert(key, middle);
                    *of_edge = Some(middle);
                }
            }
            self.divide(t, of_edges);
        }
        self.number();
        self
    }

    /// Divides a triangle, some edges of which have a vertex in their middle.
    fn divide(&mut self, t: usize, middles: [Option<u32>; 3]) {
        let turned = |k: usize| {
            let corners = self.triangles[t];
            [corners[k % 3], corners[(k + 1) % 3], corners[(k + 2) % 3]]
        };
        let mut parts = match middles {
            [None, None, None] => return,
            [Some(m), Some(n), Some(o)] => {
                let [a, b, c] = turned(0);
                vec![[m, n, o], [a, m, o], [m, b, n], [o, n, c]]
            }
            [Some(m), Some(n), None] => two(turned(0), m, n),
            [None, Some(m), Some(n)] => two(turned(1), m, n),
            [Some(n), None, Some(m)] => two(turned(2), m, n),
            [Some(m), None, None] => one(turned(0), m),
            [None, Some(m), None] => one(turned(1), m),
            [None, None, Some(m)] => one(turned(2), m),
        };
        if let Some(first) = parts.pop() {
            self.triangles[t] = first;
        }
        self.triangles.append(&mut parts);
    }
}

/// The parts of a triangle with a vertex on its first edge.
fn one([a, b, c]: [u32; 3], middle: u32) -> Vec<[u32; 3]> {
    vec![[a, middle, c], [middle, b, c]]
}

/// The parts of a triangle with vertices on its first and its second edge.
fn two([a, b, c]: [u32; 3], first: u32, second: u32) -> Vec<[u32; 3]> {
    vec![[first, b, second], [a, first, second], [a, second, c]]
}
