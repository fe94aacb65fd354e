//! Which four vertices of a loop become the corners of a rectangle.
//!
//! They are four of the sharpest turns of the loop that are well apart and leave opposite sides of like lengths. A loop with
//! fewer sharp turns is divided between them; one without gets those vertices that lie farthest towards the corners of the
//! least rectangle around it.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::super::normals::across;
use super::super::rectangle;
use super::boundary::Boundary;

/// The parts of a loop on both sides of a vertex by which its turn is measured: the first one at which the loop does not
/// turn to and fro. Corners are at least twice as far apart.
const WINDOWS: [f64; 3] = [0.01, 0.02, 0.04];

/// A loop that turns by no more than this in all does not go to and fro; a convex one turns by 2 π.
const CALM: f64 = 2.6 * PI;

/// The least turn that is a corner.
const LEAST_TURN: f64 = 50.0 * PI / 180.0;

/// The most turns among which the corners are chosen.
const MAX_TURNS: usize = 12;

/// The corners of a rectangle.
pub(super) struct Corners {
    /// Their indices, increasing.
    pub at: [usize; 4],
    /// True if the loop has a sharp turn at each of them.
    pub are_sharp: bool,
}

/// The four corners; `None` of a loop with fewer vertices.
pub(super) fn corners(line: &Boundary) -> Option<Corners> {
    let count = line.len();
    if count < 4 {
        return None;
    }
    let is_calm = |window: &&f64| total_turn(line, **window) <= CALM;
    let window = WINDOWS.iter().find(is_calm).unwrap_or(&WINDOWS[2]);
    let turns = sharpest(line, *window);
    let chosen = match turns.len() {
        0 => of_rectangle(line),
        1..=3 => None,
        _ => best_of(&turns, line),
    };
    let at = chosen.or_else(|| divided(&turns, line));
    Some(Corners {
        at: at.unwrap_or([0, 1, 2, 3].map(|k| k * count / 4)),
        are_sharp: turns.len() >= 4,
    })
}

/// The sharpest turns that are well apart, with their angles; in the order of the loop.
fn sharpest(line: &Boundary, window: f64) -> Vec<(usize, f64)> {
    let whole = line.whole();
    let at = |k: usize| turn(line, k, line.lengths[k], window * whole);
    let turns: Vec<f64> = (0..line.len()).map(at).collect();
    let mut order: Vec<usize> = (0..line.len()).filter(|&k| turns[k] > LEAST_TURN).collect();
    order.sort_by(|&a, &b| turns[b].total_cmp(&turns[a]).then(a.cmp(&b)));
    let mut kept: Vec<(usize, f64)> = Vec::new();
    for k in order {
        let is_apart = |&(other, _): &(usize, f64)| line.apart(k, other) >= 2.0 * window * whole;
        if kept.len() < MAX_TURNS && kept.iter().all(is_apart) {
            kept.push((k, turns[k]));
        }
    }
    kept.sort_by_key(|(k, _)| *k);
    kept
}

/// By what angle the loop turns towards its inside at a length, on the mesh at a vertex, between chords of the window.
fn turn(line: &Boundary, vertex: usize, length: f64, window: f64) -> f64 {
    let [behind, here, ahead] = [-window, 0.0, window].map(|along| line.at(length + along));
    let normal = line.normals[vertex];
    let flat = |along: Vector3<f64>| along - normal * along.dot(&normal);
    let (from, to) = (flat(here - behind), flat(ahead - here));
    normal.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// The sum of all turns, whatever their sense, of a line with chords of the window.
fn total_turn(line: &Boundary, window: f64) -> f64 {
    let window = window * line.whole();
    let steps = (line.whole() / window).round() as usize;
    let lengths = (0..steps).map(|k| k as f64 * window);
    let turn_at = |length: f64| {
        let vertex = line.lengths.partition_point(|it| *it <= length);
        turn(line, vertex.clamp(1, line.len()) - 1, length, window)
    };
    lengths.map(|length| turn_at(length).abs()).sum()
}

/// The vertices that lie farthest towards the corners of the least rectangle around the loop, seen along its normal.
fn of_rectangle(line: &Boundary) -> Option<[usize; 4]> {
    let sum: Vector3<f64> = line.normals.iter().sum();
    let [first, second] = across(sum.try_normalize(1e-12)?);
    let flat = line.places.iter();
    let places: Vec<[f64; 2]> = flat.map(|it| [it.dot(&first), it.dot(&second)]).collect();
    let [x, y] = rectangle::longer_side(&places, &[])?;
    let turned = |&[a, b]: &[f64; 2]| [a * x + b * y, b * x - a * y];
    let places: Vec<[f64; 2]> = places.iter().map(turned).collect();
    let range = |axis: usize| {
        let values = places.iter().map(move |place| place[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let [(left, right), (low, high)] = [range(0), range(1)];
    let towards = |[x, y]: [f64; 2]| {
        let score = |place: &[f64; 2]| {
            let u = (2.0 * place[0] - left - right) / (right - left);
            x * u + y * (2.0 * place[1] - low - high) / (high - low)
        };
        let most = places.iter().map(score).fold(f64::NEG_INFINITY, f64::max);
        // Of equal ones the first, whatever rounding does.
        places
            .iter()
            .map(score)
            .position(|it| it >= most - 1e-9)
            .unwrap_or(0)
    };
    let mut found = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(towards);
    found.sort_unstable();
    let is_apart = |k: usize| line.apart(found[k], found[(k + 1) % 4]) >= 0.08 * line.whole();
    (0..4).all(is_apart).then_some(found)
}

/// How unlike opposite sides are: the sum of the logarithms of their ratios.
fn unlike(line: &Boundary, corners: [usize; 4]) -> f64 {
    let side = |k: usize| match corners.get(k + 1) {
        Some(&end) => line.lengths[end] - line.lengths[corners[k]],
        None => line.whole() - line.lengths[corners[k]] + line.lengths[corners[0]],
    };
    let [a, b, c, d] = [0, 1, 2, 3].map(side);
    (a / c).ln().abs() + (b / d).ln().abs()
}

/// The four of several turns that are sharp and leave like sides.
fn best_of(turns: &[(usize, f64)], line: &Boundary) -> Option<[usize; 4]> {
    let count = turns.len();
    let mut best: Option<(f64, [usize; 4])> = None;
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                for d in c + 1..count {
                    let four = [turns[a], turns[b], turns[c], turns[d]];
                    let corners = four.map(|(k, _)| k);
                    let sharp: f64 = four.iter().map(|(_, turn)| turn.min(0.5 * PI)).sum();
                    let score = sharp - unlike(line, corners);
                    if best.is_none_or(|(most, _)| score > most + 1e-9) {
                        best = Some((score, corners));
                    }
                }
            }
        }
    }
    best.map(|(_, corners)| corners)
}

/// Up to three turns, with others that divide the loop between them so that opposite sides are alike.
fn divided(turns: &[(usize, f64)], line: &Boundary) -> Option<[usize; 4]> {
    let given: Vec<usize> = turns.iter().take(3).map(|(k, _)| *k).collect();
    let given = if given.is_empty() { vec![0] } else { given };
    let missing = 4 - given.len();
    let mut best: Option<(f64, [usize; 4])> = None;
    // All ways to spread the missing ones over the sides.
    for code in 0..(missing + 1).pow(given.len() as u32) {
        let spread = |k: usize| code / (missing + 1).pow(k as u32) % (missing + 1);
        if (0..given.len()).map(spread).sum::<usize>() != missing {
            continue;
        }
        let mut corners = given.clone();
        for (k, &from) in given.iter().enumerate() {
            let start = line.lengths[from];
            let end = given
                .get(k + 1)
                .map_or(line.whole() + line.lengths[given[0]], |&next| {
                    line.lengths[next]
                });
            for part in 1..=spread(k) {
                let wanted = start + (end - start) * part as f64 / (spread(k) + 1) as f64;
                corners.push(nearest(line, wanted.rem_euclid(line.whole())));
            }
        }
        corners.sort_unstable();
        corners.dedup();
        let Ok(corners) = <[usize; 4]>::try_from(corners) else {
            continue;
        };
        let score = unlike(line, corners);
        if best.is_none_or(|(least, _)| score < least - 1e-9) {
            best = Some((score, corners));
        }
    }
    best.map(|(_, corners)| corners)
}

/// The vertex nearest to a length along the loop.
fn nearest(line: &Boundary, wanted: f64) -> usize {
    let after = line
        .lengths
        .partition_point(|it| *it < wanted)
        .min(line.len());
    let nearest = match after.checked_sub(1) {
        Some(before) if wanted - line.lengths[before] < line.lengths[after] - wanted => before,
        _ => after,
    };
    nearest % line.len()
}
