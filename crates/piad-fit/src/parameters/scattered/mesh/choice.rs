//! The choice of the rule for the parameters of a mesh.

use std::sync::Arc;

use super::super::cylinder::Cylinder;
use super::super::pairs::{Domain, Pairs};
use super::super::plane::Plane;
use super::super::sphere::Sphere;
use super::overlap::overlaps;
use super::stretch::Stretch;
use super::topology::Topology;
use crate::data::points::Points;
use crate::interrupt;

/// The part of the area of a mesh that may be turned over: noise turns thin triangles of scans.
const SLIVERS: f64 = 1e-3;

/// A simpler surface is taken if it stretches the mesh by this much more.
const SIMPLER: f64 = 0.1;

/// A surface that stretches the mesh more than this is compared with mean value coordinates.
const MUCH: f64 = 0.5;

/// A surface that has less of its rectangle on the mesh is compared with mean value coordinates if these fill theirs.
const FILLED: f64 = 0.95;

/// The rule for the parameters of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Choice {
    Plane,
    Cylinder(Cylinder),
    Sphere(Sphere),
    MeanValue,
}

/// A surface that unfolds a mesh.
pub(super) struct Simple {
    choice: Choice,
    pairs: Pairs,
    stretch: Stretch,
}

impl Simple {
    /// True if it stretches the mesh so much that another parametrization may be better.
    pub(super) fn stretches_much(&self) -> bool {
        self.stretch.energy > MUCH
    }

    /// True if a good part of the rectangle of its parameters is beside the mesh.
    pub(super) fn leaves_corners(&self, topology: &Topology) -> bool {
        let [u, v] = [0, 1].map(|axis| self.pairs.values.lane(axis));
        let extent = |values: &[f64]| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low
        };
        let area = |&triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| [u, v].map(|lane| lane[vertex as usize]));
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let is_open = self.pairs.domains == [Domain::Data; 2];
        let filled = || topology.triangles.iter().map(area).sum::<f64>().abs() / 2.0;
        is_open && filled() < FILLED * extent(u) * extent(v)
    }

    /// True if other parameters turn no more than slivers over and stretch the mesh less; or also if they fill a rectangle, as these
    /// do not, and stretch it little.
    pub(super) fn is_worse(&self, other: &Stretch, is_patch: bool) -> bool {
        let is_little = other.energy < self.stretch.energy || is_patch && other.energy <= MUCH;
        other.share <= SLIVERS && is_little
    }

    pub(super) fn parts(self) -> (Choice, Stretch, Pairs) {
        (self.choice, self.stretch, self.pairs)
    }
}

/// The simplest surface among those that turn no more than slivers over and stretch the mesh least.
pub(super) fn simplest(
    points: &Points,
    topology: &Topology,
    is_closed: bool,
    stretch: impl Fn(&Pairs) -> Stretch,
) -> Option<Simple> {
    let mut kept: Vec<Simple> = Vec::new();
    if topology.genus == 0 {
        for (choice, pairs) in surfaces(points, topology, is_closed) {
            interrupt::check();
            let stretch = stretch(&pairs);
            if stretch.share <= SLIVERS && !overlaps(&topology.triangles, &pairs) {
                kept.push(Simple {
                    choice,
                    pairs,
                    stretch,
                });
            }
        }
    }
    let energies = kept.iter().map(|it| it.stretch.energy);
    let least = energies.fold(f64::INFINITY, f64::min);
    let is_enough = |it: &Simple| it.stretch.energy <= least + SIMPLER;
    kept.into_iter().find(is_enough)
}

/// The surfaces near the points that may unfold the mesh, with the parameters on them.
fn surfaces(points: &Points, topology: &Topology, is_closed: bool) -> Vec<(Choice, Pairs)> {
    let mut found = Vec::new();
    let has_boundary = !topology.loops.is_empty();
    if has_boundary {
        let all: Vec<usize> = (0..points.len()).collect();
        if let Ok(plane) = Plane::of(points, &all) {
            let pairs = Pairs::open(Arc::new(Points::from_lanes(plane.parameters())));
            found.push((Choice::Plane, pairs));
        }
        let cylinder = Cylinder::default().known(points);
        let pairs = cylinder.and_then(|it| Ok((it, it.parameters(points, is_closed)?)));
        // One loop does not go around.
        let goes = |pairs: &Pairs| {
            is_closed || pairs.domains[0] == Domain::Data || topology.loops.len() > 1
        };
        if let Some((cylinder, pairs)) = pairs.ok().filter(|(_, pairs)| goes(pairs)) {
            found.push((Choice::Cylinder(cylinder), pairs));
        }
    }
    let sphere = Sphere::default().known(points);
    let pairs = sphere.and_then(|it| Ok((it, it.parameters(points, is_closed)?)));
    let has_poles = |pairs: &Pairs| pairs.domains[1].poles() == [true; 2];
    if let Some((sphere, pairs)) = pairs
        .ok()
        .filter(|(_, pairs)| has_boundary || has_poles(pairs))
    {
        found.push((Choice::Sphere(sphere), pairs));
    }
    found
}
