//! The shape of a fit: curvature at samples, extremes, length or area, continuity.

use thiserror::Error;

use super::csv::{grid, sites};
use super::error::{ExportError, NetIndex};
use super::options::Options;
use piad_fit::data::{Grid, Points};
use piad_fit::engine::curvature::{CurveShape, SurfaceShape};
use piad_fit::engine::{Problem, samples};
use piad_fit::geometry::{KnotVector, Nurbs};

/// The cost of a sample with curvature, as a multiple of one without: two more derivatives, and the curvature.
const CURVATURE_COST: usize = 4;

/// The cost of samples at equal distances, as a multiple of samples at equal steps.
const LENGTH_COST: usize = 20;

/// The evaluations of a curve for each of its control points, for extremes, length and continuity.
const FOR_EACH: usize = 40;

/// The evaluations of a surface in each direction, in all and for each control point.
const IN_EACH: usize = 512;
const FOR_EACH_LINE: usize = 6;

/// The shape of a curve or surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Of a curve.
    Curve(Box<CurveShape>),
    /// Of a surface.
    Surface(Box<SurfaceShape>),
}

/// Why a curve or surface has no measurable shape.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoShape {
    /// Values of a function have no place in the plane or in space.
    #[error(
        "the points have one coordinate, and curvature, length and area are those of curves and surfaces of the plane \
         or of space: fit points that have their argument as a coordinate; give heights a spacing"
    )]
    OneCoordinate,
    /// Weights of rational curves and surfaces are positive, or they may have poles.
    #[error(
        "the weight of control point {place} is {weight}, and curvature needs positive weights: choose another iteration"
    )]
    Weight {
        /// The control point, in the complete net.
        place: NetIndex,
        /// Its weight.
        weight: f64,
    },
    /// A control point is infinite or NaN.
    #[error(
        "coordinate {coordinate} of control point {place} is {value}, and curvature needs finite numbers"
    )]
    NotFinite {
        /// The control point, in the complete net.
        place: NetIndex,
        /// The coordinate, counted from 0.
        coordinate: usize,
        /// Its value.
        value: f64,
    },
    /// Samples with invalid options.
    #[error(transparent)]
    Samples(#[from] ExportError),
}

/// The approximate number of multiplications that it takes to measure a shape with these samples.
pub fn cost(problem: &Problem, options: &Options) -> usize {
    let surface = problem.v().is_some();
    let chosen = grid(options, surface);
    let functions = problem.directions().map(|it| it.basis.functions());
    let mut counts = [chosen.rows, chosen.columns];
    for (count, functions) in counts.iter_mut().zip(functions) {
        *count += match surface {
            false => FOR_EACH * functions,
            true => IN_EACH + FOR_EACH_LINE * functions,
        };
    }
    let [rows, columns] = counts;
    let times = match options.is_by_length() {
        true => CURVATURE_COST + LENGTH_COST,
        false => CURVATURE_COST,
    };
    samples::multiplications(problem, Grid { rows, columns }).saturating_mul(times)
}

/// The number of samples, if it does not depend on the length of a curve.
pub fn sample_count(surface: bool, options: &Options) -> usize {
    let most = options.spacing.map(|_| super::SPACED);
    grid(options, surface).count().max(most.unwrap_or_default())
}

/// The shape of a level of a fit, with samples as in a table; of the options those about samples count, and were
/// checked by [`check_options`] as those of a table.
///
/// # Errors
///
/// If the points have one coordinate, a weight is not positive or a number not finite, or if there would be too many
/// samples.
///
/// [`check_options`]: super::check_options
pub fn measure(
    problem: &Problem,
    control_points: &Points,
    options: &Options,
) -> Result<Shape, NoShape> {
    if problem.dimension() < 2 {
        return Err(NoShape::OneCoordinate);
    }
    let nurbs = Nurbs::of(problem, control_points);
    check(&nurbs)?;
    let (u, v) = sites(&nurbs, options)?;
    Ok(match SurfaceShape::new(&nurbs, &u, &v) {
        Some(surface) => Shape::Surface(Box::new(surface)),
        None => Shape::Curve(Box::new(CurveShape::new(&nurbs, &u))),
    })
}

fn check(nurbs: &Nurbs) -> Result<(), NoShape> {
    let place = |index| NetIndex::new(index, nurbs.v.as_ref().map(KnotVector::count));
    if let Some(index) = nurbs.bad_weight() {
        return Err(NoShape::Weight {
            place: place(index),
            weight: nurbs.weight(index),
        });
    }
    match nurbs.bad_coordinate() {
        None => Ok(()),
        Some((coordinate, index)) => Err(NoShape::NotFinite {
            place: place(index),
            coordinate,
            value: nurbs.points.lane(coordinate)[index],
        }),
    }
}
