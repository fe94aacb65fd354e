//! Which rule a mesh gets its parameters by.

use std::sync::Arc;

use super::super::cylinder::Cylinder;
use super::super::normals::Cloud;
use super::super::pairs::{Domain, Pairs};
use super::super::plane::Plane;
use super::super::sphere::Sphere;
use super::overlap::overlaps;
use super::stretch::Stretch;
use super::topology::Topology;
use crate::data::points::Points;
use crate::interrupt;
use crate::invalid::Invalid;

/// A simpler surface is taken if it stretches the mesh by this much more.
const SIMPLER: f64 = 0.1;

/// A surface that stretches the mesh more than this is compared with mean value coordinates.
const MUCH: f64 = 0.5;

/// The rule by which a mesh gets its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Choice {
    Plane,
    Cylinder(Cylinder),
    Sphere(Sphere),
    MeanValue,
}

/// The simplest surface among those that turn no triangle over and stretch the mesh least; else mean value coordinates.
///
/// # Errors
///
/// Why there are no mean value coordinates, if no surface unfolds the mesh.
pub(super) fn best(
    points: &Points,
    cloud: &Cloud,
    topology: &Topology,
    mean_values: impl FnOnce() -> Result<Pairs, Invalid>,
) -> Result<Choice, Invalid> {
    let energy = |pairs: &Pairs| {
        interrupt::check();
        let stretch = Stretch::new(cloud, &topology.triangles, pairs);
        let is_whole = stretch.folded == 0 && !overlaps(&topology.triangles, pairs);
        is_whole.then_some(stretch.energy)
    };
    let mut kept = Vec::new();
    if topology.genus == 0 {
        for (choice, pairs) in surfaces(points, topology) {
            kept.extend(energy(&pairs).map(|energy| (energy, choice)));
        }
    }
    let least = kept
        .iter()
        .map(|(energy, _)| *energy)
        .fold(f64::INFINITY, f64::min);
    let simplest = kept
        .into_iter()
        .find(|(energy, _)| *energy <= least + SIMPLER);
    let Some((_, simplest)) = simplest else {
        return mean_values().map(|_| Choice::MeanValue);
    };
    if least <= MUCH || topology.loops.is_empty() {
        return Ok(simplest);
    }
    let other = mean_values().ok().and_then(|pairs| energy(&pairs));
    Ok(match other {
        Some(other) if other < least => Choice::MeanValue,
        _ => simplest,
    })
}

/// The surfaces near the points that may unfold the mesh, with the parameters on them.
fn surfaces(points: &Points, topology: &Topology) -> Vec<(Choice, Pairs)> {
    let mut found = Vec::new();
    let is_closed = topology.loops.is_empty();
    if !is_closed {
        let all: Vec<usize> = (0..points.len()).collect();
        if let Ok(plane) = Plane::of(points, &all) {
            let pairs = Pairs::open(Arc::new(Points::from_lanes(plane.parameters())));
            found.push((Choice::Plane, pairs));
        }
        let cylinder = Cylinder::default().known(points);
        let pairs = cylinder.and_then(|it| Ok((it, it.parameters(points, false)?)));
        // One loop does not go around.
        let goes = |pairs: &Pairs| pairs.domains[0] == Domain::Data || topology.loops.len() > 1;
        if let Some((cylinder, pairs)) = pairs.ok().filter(|(_, pairs)| goes(pairs)) {
            found.push((Choice::Cylinder(cylinder), pairs));
        }
    }
    let sphere = Sphere::default().known(points);
    let pairs = sphere.and_then(|it| Ok((it, it.parameters(points, false)?)));
    let has_poles = |pairs: &Pairs| pairs.domains[1].poles() == [true; 2];
    if let Some((sphere, pairs)) = pairs
        .ok()
        .filter(|(_, pairs)| !is_closed || has_poles(pairs))
    {
        found.push((Choice::Sphere(sphere), pairs));
    }
    found
}
