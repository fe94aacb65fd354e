//! Knots of curves with corners, as [`Breaks`](super::breaks::Breaks) of others: both ends and the knots between, of
//! which those at corners occur p times.
//!
//! ```text
//! knots, p = 3      0 0 0 0  1  2 2 2  3  4 4 4 4
//! breaks                  0  1  2 2 2  3  4
//! ```

use std::sync::Arc;

use crate::basis::Basis;
use crate::basis::direction::Direction;
use crate::basis::pieces::{self, Pieces};

/// The breaks of pieces without knots between their ends.
pub(crate) fn at_ends(degree: usize, ends: impl Iterator<Item = f64>) -> Vec<f64> {
    let pieces: Vec<f64> = ends.collect();
    joined(degree, pieces.windows(2))
}

/// The breaks of pieces that meet.
pub(crate) fn joined<'a>(degree: usize, pieces: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut breaks: Vec<f64> = Vec::new();
    for piece in pieces {
        match breaks.last() {
            None => breaks.extend(piece),
            Some(&corner) => {
                breaks.resize(breaks.len() + degree - 1, corner);
                breaks.extend(&piece[1..]);
            }
        }
    }
    breaks
}

/// The breaks of a direction with clamped knots, if each function has its own control point.
pub(crate) fn of(direction: &Direction) -> Option<Vec<f64>> {
    let (degree, knots) = (direction.basis.degree(), direction.basis.knots()?);
    let functions = direction.basis.functions();
    let own = direction.free() + usize::from(direction.is_closed()) == functions;
    let is_clamped = knots[0] == knots[degree] && knots[functions] == knots[functions + degree];
    (own && is_clamped).then(|| knots[degree..=functions].to_vec())
}

/// A direction with clamped knots, of data at some parameters; `None` if the breaks decrease, or come too often. A closed
/// one begins at its first corner, which is this data point, and has a period.
pub(crate) fn direction(
    degree: usize,
    breaks: &[f64],
    parameters: Arc<Vec<f64>>,
    around: Option<(usize, f64)>,
) -> Option<Direction> {
    let [first, .., last] = *breaks else {
        return None;
    };
    let inner = &breaks[1..breaks.len() - 1];
    let increase = breaks.windows(2).all(|pair| pair[0] <= pair[1]);
    let continuous = inner
        .chunk_by(|a, b| a == b)
        .all(|knots| knots.len() <= degree);
    let inside = inner.iter().all(|knot| first < *knot && *knot < last);
    if !(first < last && increase && continuous && inside) {
        return None;
    }
    let mut knots = vec![first; degree];
    knots.extend(breaks);
    knots.resize(knots.len() + degree, last);
    let functions = knots.len() - degree - 1;
    let basis = Basis::BSpline {
        degree,
        knots: Arc::new(knots),
    };
    Some(match around {
        None => Direction::open(basis, parameters, functions, 0),
        Some((corner, period)) => {
            let number = pieces::first_number(corner, functions - 1, parameters.len());
            let pieces = Pieces::new(degree, &[functions], Some(number));
            Direction::in_pieces(basis, parameters, pieces, Some(period))
        }
    })
}
