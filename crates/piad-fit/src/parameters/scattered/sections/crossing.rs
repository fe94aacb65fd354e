//! Sections that cross the one before them: there is no surface through both.

use super::polyline::Polyline;
use crate::data::vectors::{self, dot, length, minus, unit};

/// The number of edges with which sections are compared.
const EDGES: usize = 64;

/// Sections cross where the edges of one go through another's this much nearer than these are long.
const RELATIVE_DISTANCE: f64 = 1e-6;

/// Edges cross if the sine of the angle between them is greater than this; others touch.
const ANGLE: f64 = 0.1;

/// A section is in a plane if no place is farther from it than this part of the section's size, and it is on both sides of
/// another one's plane if it is farther from it than that on both.
const FLAT: f64 = 0.02;

/// Returns true if two sections cross: as curves do, or as rings of a chain.
pub(super) fn cross(one: &Polyline, other: &Polyline) -> bool {
    let (one, other) = (sampled(one), sampled(other));
    meet(&one, &other) || are_linked(&one, &other)
}

fn sampled(section: &Polyline) -> Vec<[f64; 3]> {
    section.at((0..=EDGES).map(|k| k as f64 / EDGES as f64))
}

/// Returns true if edges of two curves go through each other.
fn meet(some: &[[f64; 3]], others: &[[f64; 3]]) -> bool {
    let edges = |it: &[[f64; 3]]| {
        it.windows(2)
            .map(|edge| [edge[0], edge[1]])
            .collect::<Vec<_>>()
    };
    let others = edges(others);
    let inside = |k: usize| (1..EDGES - 1).contains(&k);
    let some = edges(some);
    let mut pairs = some.iter().enumerate().filter(|(k, _)| inside(*k));
    pairs.any(|(_, one)| {
        let mut others = others.iter().enumerate().filter(|(k, _)| inside(*k));
        others.any(|(_, other)| go_through(*one, *other))
    })
}

/// Returns true if two edges have a point in common, and not their direction.
fn go_through([a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]) -> bool {
    let (one, other, between) = (minus(b, a), minus(d, c), minus(c, a));
    let normal = vectors::cross(one, other);
    let (square, size) = (dot(normal, normal), length(one) * length(other));
    if square <= (ANGLE * size).powi(2) {
        return false;
    }
    let s = dot(vectors::cross(between, other), normal) / square;
    let t = dot(vectors::cross(between, one), normal) / square;
    let apart = dot(between, normal).abs() / square.sqrt();
    let range = 0.0..=1.0;
    range.contains(&s)
        && range.contains(&t)
        && apart <= RELATIVE_DISTANCE * length(one).min(length(other))
}

/// Returns true if each of two curves that are in planes is on both sides of the other one's plane.
fn are_linked(some: &[[f64; 3]], others: &[[f64; 3]]) -> bool {
    let planes = [plane(some), plane(others)];
    let [Some(one), Some(other)] = planes else {
        return false;
    };
    is_on_both_sides(some, other) && is_on_both_sides(others, one)
}

fn is_on_both_sides(places: &[[f64; 3]], (origin, normal): ([f64; 3], [f64; 3])) -> bool {
    let least = FLAT * size(places);
    let heights = || {
        places
            .iter()
            .map(|place| dot(minus(*place, origin), normal))
    };
    heights().any(|height| height > least) && heights().any(|height| height < -least)
}

/// The plane of a curve that is in one: a place and the normal, by the area that it goes around.
fn plane(places: &[[f64; 3]]) -> Option<([f64; 3], [f64; 3])> {
    let origin = places[0];
    let areas = places
        .windows(2)
        .map(|edge| vectors::cross(minus(edge[0], origin), minus(edge[1], origin)));
    let area = areas.fold([0.0; 3], |sum, it| [0, 1, 2].map(|k| sum[k] + it[k]));
    let normal = unit(area)?;
    let most = FLAT * size(places);
    let mut heights = places
        .iter()
        .map(|place| dot(minus(*place, origin), normal).abs());
    heights
        .all(|height| height <= most)
        .then_some((origin, normal))
}

/// The largest distance from the first place.
fn size(places: &[[f64; 3]]) -> f64 {
    let distances = places.iter().map(|place| length(minus(*place, places[0])));
    distances.fold(0.0, f64::max)
}
