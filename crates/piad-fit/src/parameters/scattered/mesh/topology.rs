//! The topology of a mesh: a connected, oriented surface, and the loops of its boundary.

use std::collections::VecDeque;

use super::edges::{Edges, before, ends};
use super::pieces::connected;
use crate::interrupt;
use crate::invalid::{Axis, Invalid, Place};

/// There is no half-edge in the other sense: the edge is on the boundary.
const NONE: u32 = u32::MAX;

/// The most sizes of pieces that are named.
const MOST_NAMED: usize = 5;

/// A mesh that is one orientable surface.
#[derive(Debug)]
pub(super) struct Topology {
    /// The triangles in one sense, that of most of them.
    pub triangles: Vec<[u32; 3]>,
    /// The vertices of each loop of the boundary, in the sense of the triangles.
    pub loops: Vec<Vec<u32>>,
    /// The number of handles.
    pub genus: usize,
}

impl Topology {
    /// That of triangles over `count` vertices, which are all in one of them.
    ///
    /// # Errors
    ///
    /// The first triangle, edge or vertex where it is no surface; that it has several pieces, or one side only.
    pub(super) fn new(triangles: &[[u32; 3]], count: usize) -> Result<Self, Invalid> {
        check(triangles, count)?;
        let edges = Edges::new(triangles);
        check_pieces(&connected(triangles, &edges))?;
        let twins = twins(triangles, &edges)?;
        let edge_count = edges.groups().count();
        drop(edges);
        let flips = flips(triangles, &twins)?;
        let (triangles, twins) = oriented(triangles, &twins, &flips);
        let next = boundary(&triangles, &twins, count)?;
        let loops = loops(&next);
        let characteristic = count as i64 - edge_count as i64 + triangles.len() as i64;
        let genus = (2 - loops.len() as i64 - characteristic) / 2;
        Ok(Self {
            triangles,
            loops,
            genus: usize::try_from(genus).unwrap_or(0),
        })
    }
}

/// A validation error of a mesh.
pub(super) fn wrong(detail: impl Into<String>) -> Invalid {
    Invalid::at(Place::Parameters(Axis::U), detail)
}

/// A validation error of a mesh, at a triangle.
pub(super) fn wrong_at(triangle: usize, detail: impl Into<String>) -> Invalid {
    Invalid::at(Place::Triangle(triangle), detail)
}

/// Refuses indices that are out of range or the same, and points that are in no triangle.
fn check(triangles: &[[u32; 3]], count: usize) -> Result<(), Invalid> {
    let mut is_used = vec![false; count];
    for (t, triangle) in triangles.iter().enumerate() {
        for &index in triangle {
            let Some(used) = is_used.get_mut(index as usize) else {
                let detail = format!(
                    "triangle {t} has point {index}, and there are {count}, from 0 to {}",
                    count.saturating_sub(1)
                );
                return Err(wrong_at(t, detail));
            };
            *used = true;
        }
        let [a, b, c] = triangle;
        if a == b || b == c || c == a {
            let detail = format!("triangle {t} has a point twice: {a}, {b}, {c}");
            return Err(wrong_at(t, detail));
        }
    }
    match is_used.iter().position(|is_used| !is_used) {
        None => Ok(()),
        Some(index) => Err(Invalid::at(
            Place::Point(index),
            format!("point {index} is in no triangle, so that it has no parameters"),
        )),
    }
}

/// Refuses several pieces.
fn check_pieces(pieces: &[u32]) -> Result<(), Invalid> {
    let mut sizes: Vec<usize> = Vec::new();
    for &piece in pieces {
        let piece = piece as usize;
        if sizes.len() <= piece {
            sizes.resize(piece + 1, 0);
        }
        sizes[piece] += 1;
    }
    let count = sizes.len();
    if count < 2 {
        return Ok(());
    }
    let more = if count > MOST_NAMED { ", …" } else { "" };
    let sizes = sizes.iter().take(MOST_NAMED).map(usize::to_string);
    let sizes = sizes.collect::<Vec<_>>().join(", ");
    Err(wrong(format!(
        "the mesh has {count} pieces of {sizes}{more} triangles, and a surface is fitted to one: leave the others out"
    )))
}

/// The half-edge on the other side of each.
fn twins(triangles: &[[u32; 3]], edges: &Edges) -> Result<Vec<u32>, Invalid> {
    let mut twins = vec![NONE; 3 * triangles.len()];
    // The first triangle where it happens, whatever the order of edges.
    let mut branching: Option<u32> = None;
    for group in edges.groups() {
        match *group {
            [_] => {}
            [(_, one), (_, other)] => {
                twins[one as usize] = other;
                twins[other as usize] = one;
            }
            _ => {
                let third = group[2].1;
                branching = Some(branching.map_or(third, |it| it.min(third)));
            }
        }
    }
    let Some(third) = branching else {
        return Ok(twins);
    };
    let t = third as usize / 3;
    let [from, to] = ends(triangles, third);
    Err(wrong_at(
        t,
        format!(
            "triangle {t} is the third one on the edge of points {from} and {to}: an edge of a surface has one or two"
        ),
    ))
}

/// Which triangles are turned over so that all are in the sense of most.
fn flips(triangles: &[[u32; 3]], twins: &[u32]) -> Result<Vec<bool>, Invalid> {
    let mut flips: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut queue = VecDeque::new();
    if let Some(first) = flips.first_mut() {
        *first = Some(false);
        queue.push_back(0_u32);
    }
    while let Some(t) = queue.pop_front() {
        let flip = flips[t as usize] == Some(true);
        for half_edge in 3 * t..3 * t + 3 {
            let twin = twins[half_edge as usize];
            if twin == NONE {
                continue;
            }
            let other = twin / 3;
            let is_same_way = ends(triangles, half_edge)[0] == ends(triangles, twin)[0];
            let wanted = flip != is_same_way;
            match flips[other as usize] {
                None => {
                    flips[other as usize] = Some(wanted);
                    queue.push_back(other);
                }
                Some(found) if found != wanted => {
                    return Err(wrong(format!(
                        "the mesh has one side only, as a Möbius strip has: triangles {t} and {other} cannot be turned the same way"
                    )));
                }
                Some(_) => {}
            }
        }
    }
    let turned = flips.iter().filter(|it| **it == Some(true)).count();
    let is_most = 2 * turned > triangles.len();
    Ok(flips
        .into_iter()
        .map(|it| (it == Some(true)) != is_most)
        .collect())
}

/// The triangles in one sense, with the half-edges on the other side.
fn oriented(triangles: &[[u32; 3]], twins: &[u32], flips: &[bool]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let place = |half_edge: u32| match flips[half_edge as usize / 3] {
        true => 3 * (half_edge / 3) + 2 - half_edge % 3,
        false => half_edge,
    };
    let mut moved = vec![NONE; twins.len()];
    for (half_edge, &twin) in twins.iter().enumerate() {
        if twin != NONE {
            moved[place(half_edge as u32) as usize] = place(twin);
        }
    }
    let turned = triangles.iter().zip(flips);
    let turned = turned.map(|(&[a, b, c], &flip)| if flip { [a, c, b] } else { [a, b, c] });
    (turned.collect(), moved)
}

/// The next vertex on the boundary of each vertex on it.
///
/// # Errors
///
/// The triangles around a vertex are not one fan.
fn boundary(triangles: &[[u32; 3]], twins: &[u32], count: usize) -> Result<Vec<u32>, Invalid> {
    interrupt::check();
    let mut next = vec![NONE; count];
    // A half-edge from each vertex, of the boundary if there is one; and the triangles around it.
    let mut starts = vec![NONE; count];
    let mut around = vec![0_u32; count];
    for half_edge in 0..twins.len() as u32 {
        let [from, to] = ends(triangles, half_edge);
        around[from as usize] += 1;
        let is_boundary = twins[half_edge as usize] == NONE;
        if is_boundary && next[from as usize] != NONE {
            return Err(bow_tie(from));
        }
        if is_boundary {
            next[from as usize] = to;
        }
        if is_boundary || starts[from as usize] == NONE {
            starts[from as usize] = half_edge;
        }
    }
    for (vertex, &start) in starts.iter().enumerate() {
        let (mut at, mut found) = (start, 0);
        while at != NONE {
            found += 1;
            at = twins[before(at) as usize];
            if at == start {
                break;
            }
        }
        if found != around[vertex] {
            return Err(bow_tie(vertex as u32));
        }
    }
    Ok(next)
}

fn bow_tie(vertex: u32) -> Invalid {
    Invalid::at(
        Place::Point(vertex as usize),
        format!(
            "the triangles around point {vertex} are not one fan: parts of the mesh touch at this point only"
        ),
    )
}

/// The loops of the boundary.
fn loops(next: &[u32]) -> Vec<Vec<u32>> {
    let mut is_passed = vec![false; next.len()];
    let mut loops = Vec::new();
    for start in 0..next.len() {
        let mut line = Vec::new();
        let mut at = start as u32;
        while next[at as usize] != NONE && !is_passed[at as usize] {
            is_passed[at as usize] = true;
            line.push(at);
            at = next[at as usize];
        }
        if !line.is_empty() {
            loops.push(line);
        }
    }
    loops
}
