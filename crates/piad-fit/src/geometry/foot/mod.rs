//! Foot points: the points of a curve or surface that are nearest to others.
//!
//! ```text
//! (u, v)(P) = argmin ‖S(u, v) − P‖
//! ```
//!
//! The surface is divided into *cells*, pieces of its knot spans. As a Bézier patch a cell lies in the convex hull of
//! its control points (weights are positive), so that the box around them bounds its distance from below. A search tree
//! yields the cells by the distances of their boxes; in each of them Newton's method finds the nearest point, until
//! boxes are farther away than the nearest point so far. A cell that bends has several points that are nearer than
//! those beside them: so Newton's method starts in its quarters again, and theirs, where the control points allow a
//! point that is nearer. Where several points are equally near, the least u counts, then the least v.
//!
//! A point costs some patches of O((p + 1)(q + 1)(p + q)) and some steps of O((p + 1)(q + 1)), and the
//! tree O(log n) for n cells.

mod cells;
pub(crate) mod deviation;
mod parts;
mod patch;

use std::sync::Arc;

use rayon::prelude::*;
use thiserror::Error;

use super::nurbs::{KnotVector, Nurbs};
use crate::data::points::{Points, normalizing_scale};
use crate::interrupt;
use crate::parameters::{Domain, Pairs};
use crate::setup::Setup;
use cells::{Cells, MAX_DEGREE};

/// The highest degree of a curve with foot points: the time to divide it grows with the fifth power.
const MAX_DEGREE_OF_CURVES: usize = 64;

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
    #[error("the fit of the job has degree {degree}: nearest points are found up to degree {most}")]
    Degree {
        /// Of the fit.
        degree: usize,
        /// The highest with foot points.
        most: usize,
    },
    /// A pole is possible.
    #[error("the fit of the job has a weight that is not positive, so that it can have poles")]
    Weight,
    /// Infinite or NaN.
    #[error("a control point of the job's fit is infinite or NaN")]
    NotFinite,
    /// Values of a function.
    #[error("points with one coordinate are values of a function: they have no nearest point")]
    OneCoordinate,
}

/// The nearest points of a curve or surface.
#[derive(Clone, Debug)]
pub(crate) struct FootPoints {
    /// Their parameters (u, v); v of a curve is zero.
    pairs: Vec<[f64; 2]>,
    /// How far they are.
    distances: Vec<f64>,
}

/// The parameters (u, v) of the foot points of all points, and the periods of closed directions. Points that are infinite
/// or NaN have NaN.
///
/// # Errors
///
/// The fit is no surface that has foot points.
pub fn foot_points(surface: &Nurbs, points: &Points) -> Result<Pairs, NoFootPoints> {
    let Some(v) = &surface.v else {
        return Err(NoFootPoints::Curve);
    };
    let found = nearest(surface, points, |_| None)?;
    let knots = [&surface.u, v];
    let lanes = [0, 1].map(|axis| {
        let (low, high) = knots[axis].domain();
        // The end of a closed direction is its start.
        let inside = |t: f64| match knots[axis].closed && t >= high {
            true => low,
            false => t,
        };
        let lane = found.pairs.iter().map(|pair| inside(pair[axis]));
        lane.collect::<Vec<_>>()
    });
    let domains = knots.map(|knots| {
        let (low, high) = knots.domain();
        match knots.closed {
            true => Domain::Closed(high - low),
            false => Domain::Data,
        }
    });
    Ok(Pairs {
        values: Arc::new(Points::from_lanes(lanes)),
        domains,
    })
}

/// The nearest points of a curve or surface to all points. Points that are infinite or NaN have NaN. None
/// is farther than the point at the parameters that are `known`.
fn nearest(
    fit: &Nurbs,
    points: &Points,
    known: impl Fn(usize) -> Option<[f64; 2]> + Sync,
) -> Result<FootPoints, NoFootPoints> {
    // A curve is a surface that does not depend on v.
    let constant = KnotVector::constant();
    let v = fit.v.as_ref().unwrap_or(&constant);
    check(fit, v, points)?;
    // Near the origin, and of the order of one: neither sums nor squares leave the range of numbers.
    let scale = normalizing_scale(fit.points.magnitude().max(points.magnitude()));
    let origin: Vec<f64> = fit.points.point(0).map(|x| x * scale).collect();
    let place = |points: &Points, index: usize| {
        let mut place = [0.0; 3];
        let coordinates = points.point(index).zip(&origin);
        for (x, (coordinate, origin)) in place.iter_mut().zip(coordinates) {
            *x = coordinate * scale - origin;
        }
        place
    };
    let cells = Cells::new(fit, v, |index| place(&fit.points, index));
    let mut found = FootPoints {
        pairs: vec![[f64::NAN; 2]; points.len()],
        distances: vec![f64::NAN; points.len()],
    };
    let rule = interrupt::rule();
    let pairs = found.pairs.par_chunks_mut(CHUNK);
    pairs
        .zip(found.distances.par_chunks_mut(CHUNK))
        .enumerate()
        .take_any_while(|_| rule.as_ref().is_none_or(|is_over| !is_over()))
        .for_each(|(chunk, (pairs, distances))| {
            let mut search = cells.search();
            for (i, (pair, distance)) in pairs.iter_mut().zip(distances).enumerate() {
                let index = chunk * CHUNK + i;
                let point = place(points, index);
                if point.iter().all(|x| x.is_finite()) {
                    let (foot, square) = search.foot_point(point, known(index));
                    (*pair, *distance) = (foot, square.sqrt() / scale);
                }
            }
        });
    interrupt::check();
    Ok(found)
}

/// Returns true if a fit has foot points.
fn check(fit: &Nurbs, v: &KnotVector, points: &Points) -> Result<(), NoFootPoints> {
    let (of_fit, of_points) = (fit.points.dimension(), points.dimension());
    if of_fit != of_points {
        return Err(NoFootPoints::Dimension {
            surface: of_fit,
            points: of_points,
        });
    }
    let (degree, most) = match fit.v {
        None => (fit.u.degree, MAX_DEGREE_OF_CURVES),
        Some(_) => (fit.u.degree.max(v.degree), MAX_DEGREE),
    };
    if degree > most {
        return Err(NoFootPoints::Degree { degree, most });
    }
    if fit.bad_weight().is_some() {
        return Err(NoFootPoints::Weight);
    }
    if fit.bad_coordinate().is_some() {
        return Err(NoFootPoints::NotFinite);
    }
    Ok(())
}

/// The approximate number of bytes that the search on a fit takes: its control net in three forms, the pieces of its
/// knot spans with their matrices, and its cells in the tree.
pub fn memory(setup: &Setup) -> usize {
    let counts = setup.directions().map(|direction| {
        let (functions, degree) = (direction.basis.functions(), direction.basis.degree());
        let pieces = functions * cells::pieces(degree);
        (functions, pieces, pieces * (56 + 8 * (degree + 1).pow(2)))
    });
    let (points, cells, pieces) = counts.fold((1, 1, 0), |sums, (points, cells, bytes)| {
        (sums.0 * points, sums.1 * cells, sums.2 + bytes)
    });
    96 * points + 128 * cells + pieces
}

#[cfg(test)]
mod tests;
