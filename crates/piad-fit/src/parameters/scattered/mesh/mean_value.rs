//! Mean value coordinates (Floater 2003): each vertex inside is a weighted mean of its neighbours, with weights that are
//! positive whatever the triangles are.
//!
//! ```text
//! w = (tan α/2 + tan β/2) / |edge|        α, β: the angles at the vertex on both sides of the edge
//! ```

use std::collections::VecDeque;

use super::sheet::Sheet;
use super::topology::{wrong, wrong_at};
use crate::interrupt;
use crate::invalid::Invalid;
use crate::linear::sparse_rows::SparseRows;

/// The largest tangent of half an angle: a vertex on the edge across is held by the ends of this edge.
const LARGEST_TANGENT: f64 = 1e4;

/// What a vertex is a mean of.
#[derive(Clone, Copy)]
struct Share {
    of: u32,
    weight: f64,
    /// By how many periods u of the other vertex is larger than it is there.
    jump: f64,
}

/// u and v of all vertices, from those on the loops. Where a corner of a triangle is `left` of a cut, its u is larger by 1.
///
/// # Errors
///
/// Two corners of a triangle are at one place; or the system cannot be solved.
pub(super) fn solved(
    sheet: &Sheet,
    fixed: &[[f64; 2]],
    left: Option<&[[bool; 3]]>,
) -> Result<Vec<[f64; 2]>, Invalid> {
    let (starts, shares) = shares(sheet, left)?;
    let shares_of = |vertex: u32| {
        let [start, end] = [0, 1].map(|k| starts[vertex as usize + k] as usize);
        &shares[start..end]
    };
    let order = order(sheet, shares_of);
    let mut number = vec![u32::MAX; sheet.places.len()];
    for (k, &vertex) in order.iter().enumerate() {
        number[vertex as usize] = k as u32;
    }
    let mut rows = SparseRows::with_room(order.len(), 6 * order.len());
    let mut right = vec![vec![0.0; order.len()]; 2];
    let mut entries: Vec<(u32, f64)> = Vec::new();
    for (k, &vertex) in order.iter().enumerate() {
        let shares = shares_of(vertex);
        let all: f64 = shares.iter().map(|it| it.weight).sum();
        if !(all > 0.0 && all.is_finite()) {
            let detail = format!("the triangles around point {vertex} have no area");
            return Err(wrong(detail));
        }
        entries.clear();
        for Share { of, weight, jump } in shares {
            let weight = weight / all;
            right[0][k] += weight * jump;
            match number[*of as usize] {
                u32::MAX => (0..2).for_each(|c| right[c][k] += weight * fixed[*of as usize][c]),
                other => entries.push((other, -weight)),
            }
        }
        entries.sort_by_key(|(other, _)| *other);
        // Each neighbour has a share in two triangles.
        let merged = entries.chunk_by(|a, b| a.0 == b.0);
        rows.push(merged.map(|same| (same[0].0, same.iter().map(|(_, weight)| weight).sum())));
    }
    let solutions = rows.solve(right).ok_or_else(|| {
        wrong(
            "the parameters of the mesh cannot be computed: its triangles differ too much in size",
        )
    })?;
    let mut places = fixed.to_vec();
    for (c, solution) in solutions.iter().enumerate() {
        for (value, &vertex) in solution.iter().zip(&order) {
            places[vertex as usize][c] = *value;
        }
    }
    Ok(places)
}

/// The shares of each vertex inside, one after the other, and where those of each start.
fn shares(sheet: &Sheet, left: Option<&[[bool; 3]]>) -> Result<(Vec<u32>, Vec<Share>), Invalid> {
    let count = sheet.places.len();
    let is_inside = |vertex: u32| sheet.on_loop[vertex as usize].is_none();
    let mut starts = vec![0_u32; count + 1];
    for &vertex in sheet
        .triangles
        .iter()
        .flatten()
        .filter(|it| is_inside(**it))
    {
        starts[vertex as usize + 1] += 2;
    }
    for k in 0..count {
        starts[k + 1] += starts[k];
    }
    let none = Share {
        of: 0,
        weight: 0.0,
        jump: 0.0,
    };
    let mut shares = vec![none; starts[count] as usize];
    let mut places = starts.clone();
    for (t, triangle) in sheet.triangles.iter().enumerate() {
        if t % (1 << 14) == 0 {
            interrupt::check();
        }
        for k in 0..3 {
            let vertex = triangle[k];
            if !is_inside(vertex) {
                continue;
            }
            let next = (k + 1) % 3;
            let after = (k + 2) % 3;
            let at = |corner: usize| sheet.places[triangle[corner] as usize];
            let [a, b] = [next, after].map(|corner| at(corner) - at(k));
            let [of_a, of_b] = [a.norm(), b.norm()];
            if of_a <= 0.0 || of_b <= 0.0 {
                let other = triangle[if of_a <= 0.0 { next } else { after }];
                return Err(wrong_at(
                    t,
                    format!(
                        "points {vertex} and {other} of triangle {t} are at the same place: merge them"
                    ),
                ));
            }
            let (sine, cosine) = (a.cross(&b).norm(), a.dot(&b));
            // tan(α/2) = (1 − cos α) / sin α = sin α / (1 + cos α).
            let tangent = match cosine > 0.0 {
                true => sine / (of_a * of_b + cosine),
                false => (of_a * of_b - cosine) / sine,
            };
            let tangent = tangent.clamp(1.0 / LARGEST_TANGENT, LARGEST_TANGENT);
            let is_left = |corner: usize| left.is_some_and(|left| left[t][corner]);
            let period = |corner: usize| f64::from(u8::from(is_left(corner)));
            for (corner, length) in [(next, of_a), (after, of_b)] {
                shares[places[vertex as usize] as usize] = Share {
                    of: triangle[corner],
                    weight: tangent / length,
                    jump: period(corner) - period(k),
                };
                places[vertex as usize] += 1;
            }
        }
    }
    Ok((starts, shares))
}

/// The vertices inside, from the loops inwards, so that neighbours are near each other.
fn order<'a>(sheet: &Sheet, shares_of: impl Fn(u32) -> &'a [Share]) -> Vec<u32> {
    let mut is_known: Vec<bool> = sheet.on_loop.iter().map(Option::is_some).collect();
    let mut order = Vec::new();
    let mut queue = VecDeque::new();
    // A vertex beside the boundary is the first one; all others are reached from it, or from others there.
    for triangle in &sheet.triangles {
        if triangle
            .iter()
            .all(|&it| sheet.on_loop[it as usize].is_none())
        {
            continue;
        }
        for &start in triangle {
            if is_known[start as usize] {
                continue;
            }
            is_known[start as usize] = true;
            queue.push_back(start);
            while let Some(vertex) = queue.pop_front() {
                order.push(vertex);
                for Share { of, .. } in shares_of(vertex) {
                    if !is_known[*of as usize] {
                        is_known[*of as usize] = true;
                        queue.push_back(*of);
                    }
                }
            }
        }
    }
    order
}
