//! Points of B-splines by their control points.

use super::entity::Entity;
use crate::import::curves::Point;
use crate::import::error::FileError;
use crate::import::sampled::{PIECES_OF_SPAN, along};

/// The largest degree: evaluation takes its square.
const MOST_DEGREE: usize = 25;

/// A B-spline, which is rational if it has weights.
struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// In homogeneous coordinates.
    control: Vec<[f64; 4]>,
}

/// The points of a spline at 16 parameters of each piece between its knots, at most `most` and one
/// more.
///
/// # Errors
///
/// If its control points, knots and degree do not fit.
pub(super) fn points(entity: &Entity<'_>, most: usize) -> Result<Vec<Point>, FileError> {
    let spline = Spline::of(entity)?;
    let domain = spline.degree..spline.control.len();
    let mut points = Vec::new();
    for span in domain {
        let (Some(start), Some(end)) = (spline.knots.get(span), spline.knots.get(span + 1)) else {
            break;
        };
        if end <= start {
            continue;
        }
        let first = usize::from(!points.is_empty());
        for i in first..=PIECES_OF_SPAN {
            let part = i as f64 / PIECES_OF_SPAN as f64;
            points.push(spline.at(span, start + part * (end - start)));
        }
        if points.len() > most {
            break;
        }
    }
    Ok(points)
}

impl Spline {
    fn of(entity: &Entity<'_>) -> Result<Self, FileError> {
        let wrong = |detail: String| Err(FileError::at(entity.line as usize, detail));
        let degree = entity.flags(71)? as usize;
        let knots = entity.numbers(40)?;
        let weights = entity.numbers(41)?;
        let points = entity.points(10)?;
        if degree == 0 || degree > MOST_DEGREE {
            return wrong(format!(
                "this SPLINE is of degree {degree}, and 1 to {MOST_DEGREE} are read"
            ));
        }
        if points.len() <= degree || knots.len() != points.len() + degree + 1 {
            return wrong(format!(
                "this SPLINE of degree {degree} has {} control points and {} knots, which do not fit",
                points.len(),
                knots.len()
            ));
        }
        if knots.windows(2).any(|pair| pair[1] < pair[0]) {
            return wrong("the knots of this SPLINE decrease".to_owned());
        }
        let weighted = weights.len() == points.len() && weights.iter().all(|it| *it > 0.0);
        if !weights.is_empty() && !weighted {
            return wrong("this SPLINE needs a positive weight for each control point".to_owned());
        }
        let weight = |index: usize| weights.get(index).copied().unwrap_or(1.0);
        let control = points.iter().enumerate().map(|(index, ([x, y, z], _))| {
            let weight = weight(index);
            [x * weight, y * weight, z * weight, weight]
        });
        Ok(Self {
            degree,
            control: control.collect(),
            knots,
        })
    }

    /// The point at a parameter of a span, by de Boor's algorithm.
    fn at(&self, span: usize, parameter: f64) -> Point {
        let first = span - self.degree;
        let mut local = [[0.0; 4]; MOST_DEGREE + 1];
        for (local, control) in local.iter_mut().zip(self.control.iter().skip(first)) {
            *local = *control;
        }
        let knot = |index: usize| self.knots.get(index).copied().unwrap_or_default();
        for level in 1..=self.degree {
            for i in (level..=self.degree).rev() {
                let (start, end) = (knot(first + i), knot(first + i + self.degree + 1 - level));
                let part = (parameter - start) / (end - start);
                let before = local[i - 1];
                for (x, before) in local[i].iter_mut().zip(before) {
                    *x = before + part * (*x - before);
                }
            }
        }
        let [x, y, z, weight] = local[self.degree];
        along([0.0; 3], [x, y, z], 1.0 / weight)
    }
}
