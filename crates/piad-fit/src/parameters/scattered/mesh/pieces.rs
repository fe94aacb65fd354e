//! The pieces of a mesh: triangles that are connected by edges.

use super::edges::Edges;

/// The piece of each triangle. The largest piece is the first one; of equal ones that of the first triangle.
#[must_use]
pub fn pieces(triangles: &[[u32; 3]]) -> Vec<u32> {
    connected(triangles, &Edges::new(triangles))
}

/// The same, of edges that are known.
pub(super) fn connected(triangles: &[[u32; 3]], edges: &Edges) -> Vec<u32> {
    let mut roots: Vec<u32> = (0..triangles.len() as u32).collect();
    for group in edges.groups() {
        let first = root(&mut roots, group[0].1 / 3);
        for (_, half_edge) in &group[1..] {
            let other = root(&mut roots, half_edge / 3);
            let first = root(&mut roots, first);
            roots[first.max(other) as usize] = first.min(other);
        }
    }
    let of: Vec<u32> = (0..triangles.len() as u32)
        .map(|t| root(&mut roots, t))
        .collect();
    let mut sizes = vec![0_u32; triangles.len()];
    of.iter().for_each(|&root| sizes[root as usize] += 1);
    let mut order: Vec<u32> = (0..triangles.len() as u32)
        .filter(|&t| sizes[t as usize] > 0)
        .collect();
    order.sort_by_key(|&t| (u32::MAX - sizes[t as usize], t));
    let mut numbers = sizes;
    for (number, &root) in order.iter().enumerate() {
        numbers[root as usize] = number as u32;
    }
    of.into_iter().map(|root| numbers[root as usize]).collect()
}

/// The first triangle of those that are known to be connected with one.
fn root(roots: &mut [u32], mut of: u32) -> u32 {
    while roots[of as usize] != of {
        let above = roots[roots[of as usize] as usize];
        roots[of as usize] = above;
        of = above;
    }
    of
}
