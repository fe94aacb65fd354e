//! The edges of triangles, each with the half-edges on it.
//!
//! Half-edge `3 t + k` goes from corner k of triangle t to the next one.

use crate::interrupt;

/// Half-edges in the order of their edges.
pub(super) struct Edges {
    sorted: Vec<(u64, u32)>,
}

impl Edges {
    pub(super) fn new(triangles: &[[u32; 3]]) -> Self {
        let mut sorted = Vec::with_capacity(3 * triangles.len());
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
                let key = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                sorted.push((key, (3 * t + k) as u32));
            }
        }
        interrupt::check();
        sorted.sort_unstable();
        interrupt::check();
        Self { sorted }
    }

    /// The half-edges of each edge.
    pub(super) fn groups(&self) -> impl Iterator<Item = &[(u64, u32)]> {
        self.sorted.chunk_by(|a, b| a.0 == b.0)
    }
}

/// The half-edge before one in its triangle.
pub(super) fn before(half_edge: u32) -> u32 {
    match half_edge % 3 {
        0 => half_edge + 2,
        _ => half_edge - 1,
    }
}

/// The vertices from and to which a half-edge goes.
pub(super) fn ends(triangles: &[[u32; 3]], half_edge: u32) -> [u32; 2] {
    let triangle = triangles[half_edge as usize / 3];
    let k = half_edge as usize % 3;
    [triangle[k], triangle[(k + 1) % 3]]
}
