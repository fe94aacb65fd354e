//! Foot points: the points of a surface that are nearest to others.
//!
//! ```text
//! (u, v)(P) = argmin ‖S(u, v) − P‖
//! ```
//!
//! The surface is divided into *cells*, pieces of its knot spans. As a Bézier patch a cell lies in
//! the convex hull of its control points (weights are positive), so that the box around them tells
//! how near it can be at most. A search tree yields the cells by the distances of their boxes; in
//! each of them Newton's method finds the nearest point, until boxes are farther away than the
//! nearest point so far. Where several points are equally near, the least u counts, then the least v.
//!
//! A point costs some patches of O((p + 1)(q + 1)(p + q)) and some steps of O((p + 1)(q + 1)), and the
//! tree O(log n) for n cells.

mod cells;
mod patch;

use rayon::prelude::*;
use thiserror::Error;

use super::interrupt;
use super::nurbs::Nurbs;
use super::points::Points;
use super::problem::Problem;
use super::scaling::normalizing_scale;
use cells::Cells;

/// The highest degree of a surface with foot points: the time of a step grows with its square.
pub const MAX_DEGREE: usize = 32;

/// The number of points that a thread does at a time.
const CHUNK: usize = 256;

/// Why a fit has no foot points.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NoFootPoints {
    /// It is a curve.
    #[error("the job fits a curve: foot points lie on surfaces")]
    Curve,
    /// Other dimensions.
    #[error("the surface of the job has {surface} coordinates, and these points have {points}")]
    Dimension {
        /// Coordinates of the surface.
        surface: usize,
        /// Coordinates of the points.
        points: usize,
    },
    /// Polynomials of a high degree.
    #[error(
        "the surface of the job has degree {0}: foot points are found on surfaces of degree up to {MAX_DEGREE}"
    )]
    Degree(usize),
    /// A pole is possible.
    #[error("the surface of the job has a weight that is not positive, so that it can have poles")]
    Weight,
    /// Infinite or NaN.
    #[error("a control point of the job's surface is infinite or NaN")]
    NotFinite,
}

/// The parameters (u, v) of the foot points of all points. Points that are infinite or NaN have NaN.
///
/// # Errors
///
/// The fit is no surface that has foot points.
pub fn foot_points(surface: &Nurbs, points: &Points) -> Result<Points, NoFootPoints> {
    let Some(v) = &surface.v else {
        return Err(NoFootPoints::Curve);
    };
    let (of_surface, of_points) = (surface.points.dimension(), points.dimension());
    if of_surface != of_points {
        return Err(NoFootPoints::Dimension {
            surface: of_surface,
            points: of_points,
        });
    }
    let degree = surface.u.degree.max(v.degree);
    if degree > MAX_DEGREE {
        return Err(NoFootPoints::Degree(degree));
    }
    if surface.bad_weight().is_some() {
        return Err(NoFootPoints::Weight);
    }
    if surface.bad_coordinate().is_some() {
        return Err(NoFootPoints::NotFinite);
    }
    // Near the origin, and of the order of one: neither sums nor squares leave the range of numbers.
    let scale = normalizing_scale(surface.points.magnitude().max(points.magnitude()));
    let origin: Vec<f64> = surface.points.point(0).map(|x| x * scale).collect();
    let place = |points: &Points, index: usize| {
        let mut place = [0.0; 3];
        let coordinates = points.point(index).zip(&origin);
        for (x, (coordinate, origin)) in place.iter_mut().zip(coordinates) {
            *x = coordinate * scale - origin;
        }
        place
    };
    let cells = Cells::new(surface, v, |index| place(&surface.points, index));
    let mut pairs = vec![[f64::NAN; 2]; points.len()];
    let rule = interrupt::rule();
    pairs
        .par_chunks_mut(CHUNK)
        .enumerate()
        .take_any_while(|_| rule.as_ref().is_none_or(|is_over| !is_over()))
        .for_each(|(chunk, pairs)| {
            let mut search = cells.search();
            for (i, pair) in pairs.iter_mut().enumerate() {
                let point = place(points, chunk * CHUNK + i);
                if point.iter().all(|x| x.is_finite()) {
                    *pair = search.foot_point(point);
                }
            }
        });
    interrupt::check();
    let lane = |k: usize| pairs.iter().map(|pair| pair[k]).collect::<Vec<_>>();
    Ok(Points::from_lanes([lane(0), lane(1)]))
}

/// About how many bytes the search on a surface takes: its control net in three forms, and its cells in
/// the tree.
pub fn memory(problem: &Problem) -> usize {
    let counts = problem.directions().map(|direction| {
        let functions = direction.basis.functions();
        (
            functions,
            functions * cells::pieces(direction.basis.degree()),
        )
    });
    let (points, cells) = counts.fold((1, 1), |(points, cells), (p, c)| (points * p, cells * c));
    96 * points + 128 * cells
}

#[cfg(test)]
mod tests;
