//! Parameters of the vertices of a triangle mesh.
//!
//! Where a plane, a cylinder or a sphere unfolds all triangles well they are the places on it ([`choice`]). Else they are
//! mean value coordinates: a mesh with one loop of boundary fills a rectangle ([`rectangle`]), and one with two goes around
//! ([`tube`]). Small holes are closed before ([`sheet`]).
//!
//! - `edges`, `pieces`, `topology`: connectivity, and the test for a surface;
//! - `boundary`: a loop as a line; `corners`: the corners of the rectangle; `cut`: a path between two loops;
//! - `mean_value`: the system; `gradient`: how long u and v are on the mesh; `stretch` and `overlap`: what comes
//!   of the triangles.

mod boundary;
mod choice;
mod corners;
mod cut;
mod edges;
mod gradient;
mod mean_value;
mod overlap;
mod pieces;
mod rectangle;
mod sheet;
mod stretch;
mod topology;
mod tube;

use std::sync::Arc;

use super::normals::Cloud;
use super::pairs::Pairs;
use crate::data::points::Points;
use crate::interrupt;
use crate::invalid::Invalid;
use cut::Cut;
use sheet::Sheet;
use stretch::Stretch;
use topology::{Topology, wrong};

pub(super) use choice::Choice;
pub use pieces::pieces;

/// The most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 4_000_000;

/// Bytes that a triangle takes while parameters are computed.
const BYTES: usize = 500;

/// The cost, in multiplications, of the parameters of a triangle.
const MULTIPLICATIONS: usize = 8_000;

/// Loops that are shorter than this part of the longest one are holes.
const HOLE: f64 = 0.25;

/// A shorter loop is one end of a tube if it is farther from the longest one than this part of its length.
const TUBE: f64 = 0.25;

/// Triangles whose corners are the points.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mesh {
    /// The indices of the corners of each triangle.
    pub triangles: Arc<Vec<[u32; 3]>>,
    /// How its vertices get their parameters.
    pub unfolding: MeshUnfolding,
}

/// How the vertices of a mesh get their parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum MeshUnfolding {
    /// From a plane, a cylinder or a sphere that unfolds all triangles, else by mean value coordinates.
    #[default]
    Auto,
    /// By mean value coordinates.
    MeanValue,
}

/// Measures of a mesh with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoldedTriangles {
    /// The number of triangles that are turned over by their parameters, or have no area there.
    pub count: usize,
    /// The first of them.
    pub triangle: usize,
    /// The part of the area of the mesh that they have.
    pub share: f64,
}

/// The parameters of a mesh, and how they were found.
pub(super) struct Solved {
    pub choice: Choice,
    pub pairs: Pairs,
    pub folded: Option<FoldedTriangles>,
}

impl Mesh {
    /// Bytes, and about how many multiplications, that parameters take.
    pub(crate) fn cost(&self) -> (usize, usize) {
        let count = self.triangles.len();
        let [bytes, multiplications] = [BYTES, MULTIPLICATIONS].map(|it| count.saturating_mul(it));
        (bytes, multiplications)
    }

    /// The parameters of points; u is closed where they go around, or where requested.
    ///
    /// # Errors
    ///
    /// Why the triangles are no surface, or one that cannot be unfolded.
    pub(super) fn solved(&self, points: &Points, is_closed: bool) -> Result<Solved, Invalid> {
        let count = self.triangles.len();
        if count == 0 {
            return Err(wrong("the mesh has no triangles"));
        }
        self.check_count()?;
        let cloud = Cloud::new(points, "mesh")?;
        let topology = Topology::new(&self.triangles, points.len())?;
        interrupt::check();
        let mean_values = || {
            let pairs = mean_values(&cloud, &topology)?;
            Ok((Stretch::new(&cloud, &topology.triangles, &pairs), pairs))
        };
        let stretch = |pairs: &Pairs| Stretch::new(&cloud, &topology.triangles, pairs);
        let simple = match self.unfolding {
            MeshUnfolding::MeanValue => None,
            MeshUnfolding::Auto => choice::simplest(points, &topology, is_closed, stretch),
        };
        let (choice, stretch, pairs) = match simple {
            Some(simple) => {
                let is_patch = simple.leaves_corners(&topology) && is_patch(&cloud, &topology);
                let others = (is_patch || simple.stretches_much()) && !topology.loops.is_empty();
                match others.then(mean_values) {
                    Some(Ok((stretch, pairs))) if simple.is_worse(&stretch, is_patch) => {
                        (Choice::MeanValue, stretch, pairs)
                    }
                    _ => simple.parts(),
                }
            }
            None => {
                let (stretch, pairs) = mean_values()?;
                (Choice::MeanValue, stretch, pairs)
            }
        };
        let Stretch {
            folded,
            first,
            share,
            ..
        } = stretch;
        let folded = (folded > 0).then_some(FoldedTriangles {
            count: folded,
            triangle: first,
            share,
        });
        Ok(Solved {
            choice,
            pairs,
            folded,
        })
    }

    /// The loops of its boundary, of a mesh whose vertices are this number of points.
    pub(crate) fn loops(&self, points: usize) -> Result<Vec<Vec<u32>>, Invalid> {
        Ok(Topology::new(&self.triangles, points)?.loops)
    }

    /// Refuses more triangles than the limit.
    pub(crate) fn check_count(&self) -> Result<(), Invalid> {
        let count = self.triangles.len();
        if count <= MAX_TRIANGLES {
            return Ok(());
        }
        let detail = format!("the mesh has {count} triangles, and the limit is {MAX_TRIANGLES}");
        Err(wrong(detail))
    }
}

/// Mean value coordinates of a mesh with one loop of boundary or two.
fn mean_values(cloud: &Cloud, topology: &Topology) -> Result<Pairs, Invalid> {
    let sheet = |kept: &[usize]| Sheet::new(topology, &cloud.points, kept);
    let loops = by_length(cloud, topology);
    let is_large = |&&(_, length): &&(usize, f64)| length >= HOLE * loops[0].1;
    let large = loops.iter().filter(is_large).count();
    if topology.genus > 0 || !(1..=2).contains(&large) {
        return Err(not_unfolded(topology, large));
    }
    if let [(first, length), (second, _), ..] = loops[..] {
        let sheet = sheet(&[first, second]);
        let is_tube = |cut: Cut| large == 2 || cut.length > TUBE * length;
        if Cut::new(&sheet).is_some_and(is_tube) {
            return tube::parameters(cloud, sheet);
        }
    }
    rectangle::parameters(cloud, sheet(&[loops[0].0]))
}

/// True if a mesh has one large loop, with four sharp corners.
fn is_patch(cloud: &Cloud, topology: &Topology) -> bool {
    match by_length(cloud, topology)[..] {
        [(_, first), (_, second), ..] if second >= HOLE * first => false,
        [(index, _), ..] => {
            let sheet = Sheet::new(topology, &cloud.points, &[index]);
            topology.genus == 0 && rectangle::is_patch(&sheet)
        }
        [] => false,
    }
}

/// The loops with their lengths, the longest first.
fn by_length(cloud: &Cloud, topology: &Topology) -> Vec<(usize, f64)> {
    let length = |line: &Vec<u32>| -> f64 {
        let next = line.iter().cycle().skip(1);
        let place = |vertex: &u32| cloud.points[*vertex as usize];
        line.iter()
            .zip(next)
            .map(|(a, b)| (place(b) - place(a)).norm())
            .sum()
    };
    let mut loops: Vec<(usize, f64)> = topology.loops.iter().map(length).enumerate().collect();
    loops.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    loops
}

/// A mesh that is neither a disc nor a tube.
fn not_unfolded(topology: &Topology, large: usize) -> Invalid {
    let Topology { loops, genus, .. } = topology;
    let holes = match loops.len() - large {
        0 => String::new(),
        count => format!(" and {count} small holes"),
    };
    if loops.is_empty() && *genus == 0 {
        return wrong(
            "the mesh is closed (no boundary, genus 0), and some of its triangles fold on the sphere nearest to it: cut it into parts with a boundary",
        );
    }
    let loops = match large {
        0 => "no boundary".to_owned(),
        1 => format!("one boundary loop{holes}"),
        count => format!("{count} boundary loops{holes}"),
    };
    wrong(format!(
        "the mesh has {loops}, and genus {genus}: a mesh of genus 0 with one or two loops, or a closed one like a sphere, has parameters; cut it into such parts"
    ))
}

#[cfg(test)]
mod tests;
