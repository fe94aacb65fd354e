//! A level of a curve with corners: each piece between two of them is a fit by itself, and a level of the curve has a
//! level of each of them, the last one of those that have ended.

use std::sync::Arc;

use super::schedules::Fit;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::knot_selection::clamped_breaks;
use crate::problem::Problem;

/// The curve of all pieces.
pub(super) fn joined(whole: &Problem, pieces: &[&Fit]) -> Option<Fit> {
    let breaks = pieces.iter().map(|it| clamped_breaks::of(it.problem.u()));
    let breaks: Vec<Vec<f64>> = breaks.collect::<Option<_>>()?;
    let degree = whole.u().basis.degree();
    let breaks = clamped_breaks::joined(degree, breaks.iter().map(Vec::as_slice));
    let u = whole.with_breaks(whole.u(), &breaks, parameters(whole, pieces)?)?;
    Some(Fit {
        control_points: Arc::new(control_points(&u, pieces)),
        problem: Arc::new(whole.with_directions([u])),
        error: error(whole, pieces)?,
    })
}

/// The control points of all pieces, in the order of those of a direction.
fn control_points(u: &Direction, pieces: &[&Fit]) -> Points {
    let mut all = Points::zeros(pieces[0].control_points.dimension(), u.free());
    let mut function = 0;
    for piece in pieces {
        let points = &piece.control_points;
        for i in 0..points.len() {
            all.set(u.free_index(function + i), points.point(i));
        }
        function += points.len() - 1;
    }
    all
}

/// The parameters of the data, which pieces may have moved.
fn parameters(whole: &Problem, pieces: &[&Fit]) -> Option<Arc<Vec<f64>>> {
    let mut parameters = Arc::clone(&whole.u().parameters);
    let (_, settings) = whole.method().automatic()?;
    if !settings.correct_parameters {
        return Some(parameters);
    }
    let all = Arc::make_mut(&mut parameters);
    let (count, period) = (all.len(), whole.u().period().unwrap_or(0.0));
    for (piece, data) in pieces.iter().zip(whole.data_of_pieces()?) {
        for (index, t) in data.zip(piece.problem.u().parameters.iter()) {
            all[index % count] = t - (index / count) as f64 * period;
        }
    }
    Some(parameters)
}

/// The distances of all data; corners, which two pieces have, are at none.
fn error(whole: &Problem, pieces: &[&Fit]) -> Option<FitError> {
    let count = whole.grid().count();
    let mut all = pieces[0].error;
    (all.max, all.sum) = (-1.0, 0.0);
    let errors = || pieces.iter().map(|it| it.error);
    let largest = errors().fold(0.0, |most: f64, error| most.max(error.rms));
    let mut squares = 0.0;
    for (error, data) in errors().zip(whole.data_of_pieces()?) {
        if error.max > all.max || error.max.is_nan() {
            (all.max, all.at) = (error.max, (data.start + error.at) % count);
        }
        all.sum += error.sum;
        // Squares of distances in any unit stay within the range of numbers.
        let share = if largest > 0.0 {
            error.rms / largest
        } else {
            0.0
        };
        squares += share * share * data.len() as f64;
    }
    all.rms = largest * (squares / count as f64).sqrt();
    Some(all)
}
