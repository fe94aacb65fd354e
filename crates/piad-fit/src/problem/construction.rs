//! From the requested settings of a direction to its parameters, knots and basis.
//!
//! | basis | control points | knots | source |
//! |---|---|---|---|
//! | polynomial | at most the number of data points | none | LBW05, section 2 |
//! | open B-spline | n, and p − 1 end copies | at the data | LBW05 (3.1)–(3.2) |
//! | open B-spline | n | averaged, or given | PT97 (9.8) |
//! | open B-spline | fewer than data points | spread, or given | |
//! | open B-spline | fewer than data points | as in earlier versions | PT97 (9.68)–(9.69) |
//! | curve | fewer than data points | spread, then adaptive ([`super::adaptive_knots`]) | |
//! | closed B-spline | n, or fewer | periodic | |
//! | B-spline with corners, or creases | n, or fewer | p at each corner, averaged or spread between | |
//!
//! Given values are checked against each other: parameters against knots, knots against the number of control points,
//! weights against that of functions.

use std::sync::Arc;

use super::corners::{ends_of_pieces, unrolled};
use crate::basis::choice::{BasisChoice, Corners, DirectionChoice};
use crate::basis::direction::Direction;
use crate::basis::knots::{self, Knots};
use crate::basis::pieces::{self, Pieces};
use crate::basis::{Basis, MAX_DEGREE, Polynomial, given_knots};
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::points::Points;
use crate::ends::chosen;
use crate::invalid::{Axis, Invalid, Place};
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::clamped_breaks;
use crate::parameters::{LARGEST, Parametrization, Parametrized, parameters, rescale};

impl Direction {
    /// Computes the parameters and knots of a direction and checks them.
    ///
    /// `points` are the data in the arrangement `grid`, some of which may be `missing`; `axis` says
    /// which direction it is. It takes O(n), and O(n m) where the parameters of a surface are means
    /// of distances.
    ///
    /// # Errors
    ///
    /// The first error of the number of control points, the parameters, the degree, the knots or the weights.
    pub(crate) fn new(
        choice: DirectionChoice,
        points: &Points,
        grid: Grid,
        missing: Option<&Missing>,
        axis: Axis,
    ) -> Result<Self, Invalid> {
        let count = grid.along(axis);
        let free = choice.control_points.unwrap_or(count);
        let fewer = choice.control_points.is_some();
        let given = matches!(choice.parameters, Parametrization::Explicit(_));
        let ended = chosen::are_chosen(&choice, axis)?;
        let placed = parameters(
            choice.parameters,
            points,
            grid,
            missing,
            axis,
            choice.closed,
        )?;
        check_range(&placed.values, axis)?;
        let direction = match choice.basis {
            BasisChoice::Polynomial(_) if choice.closed => {
                return Err(Invalid::at(
                    Place::Closed(axis),
                    "a closed curve is a periodic B-spline: polynomials cannot be closed",
                ));
            }
            BasisChoice::Polynomial(kind) => polynomial(kind, placed.values, free, axis)?,
            BasisChoice::BSpline { degree, knots } => {
                check_degree(degree, true, axis)?;
                if let Some(Corners::At(corners)) = &choice.corners {
                    with_corners(degree, corners, placed, (free, choice.closed), axis)?
                } else if choice.closed {
                    periodic(degree, &knots, placed, free, axis)?
                } else if fewer {
                    least_squares(degree, knots, placed.values, free, given, axis)?
                } else {
                    clamped(degree, knots, placed.values, given, axis)?
                }
            }
        };
        let direction = match choice.weights {
            None => direction,
            Some(weights) => direction.with_weights(weights, axis)?,
        };
        match ended {
            None => Ok(direction),
            Some(ends) => {
                let boundary = grid.count() / count;
                Ok(ends.apply(direction, axis, (boundary, points.dimension()))?)
            }
        }
    }
}

/// The initial direction of a fit that chooses its knots: with given breaks, or the fewest that there are for the
/// degree, between corners if it has some.
pub(crate) fn first_direction(
    choice: DirectionChoice,
    (points, grid, missing): (&Points, Grid, Option<&Missing>),
    breaks: Option<&[f64]>,
    most: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    chosen::are_chosen(&choice, axis)?;
    let BasisChoice::BSpline { degree, .. } = choice.basis else {
        return Err(Invalid::automatic_knots(axis));
    };
    check_degree(degree, true, axis)?;
    let free = most.min(grid.along(axis).max(degree + 1));
    if degree >= free {
        return Err(Invalid::too_few_control_points(axis, free, degree));
    }
    let Parametrized { values, period } = parameters(
        choice.parameters,
        points,
        grid,
        missing,
        axis,
        choice.closed,
    )?;
    check_range(&values, axis)?;
    let direction = if let Some(Corners::At(corners)) = &choice.corners {
        let period = choice.closed.then_some(period);
        let breaks = match breaks {
            Some(breaks) => breaks.to_vec(),
            None => {
                let t = unrolled(&values, corners, period);
                let ends = ends_of_pieces(corners, values.len(), choice.closed);
                clamped_breaks::at_ends(degree, ends.iter().map(|&end| t[end]))
            }
        };
        let around = period.map(|period| (corners[0], period));
        clamped_breaks::direction(degree, &breaks, values, around)
    } else {
        let (first, last) = (values[0], values[values.len() - 1]);
        let end = if choice.closed { first + period } else { last };
        let line = match breaks {
            Some(breaks) => Breaks::new(degree, choice.closed, breaks.to_vec()),
            None => Breaks::coarsest(degree, choice.closed, first, end),
        };
        line.map(|line| line.direction(values))
    };
    direction.ok_or(Invalid::parameter_range(axis))
}

/// A polynomial direction of degree control points − 1, with parameters scaled to [0, 1].
fn polynomial(
    kind: Polynomial,
    mut t: Arc<Vec<f64>>,
    free: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let degree = free - 1;
    check_degree(degree, false, axis)?;
    rescale(Arc::make_mut(&mut t).as_mut_slice(), 0.0, 1.0, axis)?;
    Ok(Direction::open(
        Basis::Polynomial { kind, degree },
        t,
        free,
        0,
    ))
}

/// An open B-spline with as many free control points as data points.
fn clamped(
    degree: usize,
    choice: Knots,
    mut t: Arc<Vec<f64>>,
    parameters_given: bool,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let free = t.len();
    let mut front_copies = 0;
    let knots = match choice {
        Knots::Usual | Knots::Data => {
            // ⌈(p−1)/2⌉ copies of the first control point in front, ⌊(p−1)/2⌋ of the last behind.
            front_copies = degree / 2;
            Arc::new(knots::at_data(&t, degree))
        }
        Knots::Averaged => {
            check_enough(degree, free, axis)?;
            Arc::new(knots::averaged(&t, degree))
        }
        Knots::Spread | Knots::Adaptive => {
            return Err(Invalid::at(
                Place::Knots(axis),
                "\"spread\" places knots for fewer control points than data: it is for least squares",
            ));
        }
        Knots::Explicit(knots) => {
            explicit(&knots, degree, &mut t, free, parameters_given, axis)?;
            given_knots::check_schoenberg_whitney(&knots, degree, &t, axis)?;
            knots
        }
    };
    let basis = Basis::BSpline { degree, knots };
    Ok(Direction::open(basis, t, free, front_copies))
}

/// An open B-spline with fewer control points than data points: its knots are spread, unless
/// they are given. All parameters must lie within the knots.
fn least_squares(
    degree: usize,
    choice: Knots,
    mut t: Arc<Vec<f64>>,
    free: usize,
    parameters_given: bool,
    axis: Axis,
) -> Result<Direction, Invalid> {
    if degree >= free {
        return Err(Invalid::too_few_control_points(axis, free, degree));
    }
    let spread = matches!(choice, Knots::Usual | Knots::Spread);
    let knots = match choice {
        Knots::Usual | Knots::Spread | Knots::Adaptive => Arc::new(knots::spread(&t, degree, free)),
        Knots::Data | Knots::Averaged => return Err(least_squares_knots(axis)),
        Knots::Explicit(knots) => {
            explicit(&knots, degree, &mut t, free, parameters_given, axis)?;
            knots
        }
    };
    let (low, high) = (knots[0], knots[knots.len() - 1]);
    if let Some(index) = t.iter().position(|t| !(low..=high).contains(t)) {
        return Err(Invalid::parameter_outside(
            axis,
            index,
            t[index],
            (low, high),
        ));
    }
    let basis = Basis::BSpline { degree, knots };
    let direction = Direction::open(basis, t, free, 0);
    Ok(if spread {
        direction.with_spread_start()
    } else {
        direction
    })
}

/// A B-spline in pieces that meet at corners, each with a share of the control points.
fn with_corners(
    degree: usize,
    corners: &[usize],
    placed: Parametrized,
    (free, closed): (usize, bool),
    axis: Axis,
) -> Result<Direction, Invalid> {
    let Parametrized { values, period } = placed;
    let count = values.len();
    let period = closed.then_some(period);
    let ends = ends_of_pieces(corners, count, closed);
    let t = unrolled(&values, corners, period);
    let data: Vec<usize> = ends.windows(2).map(|ends| ends[1] - ends[0] + 1).collect();
    let shared = data.len() + usize::from(!closed);
    let fewest = if closed { shared.max(3) } else { shared };
    if !(fewest..=count).contains(&free) {
        let corners = corners.len();
        let detail = format!(
            "{count} points that turn at {corners} of them have {fewest} to {count} control points, not {free}"
        );
        return Err(Invalid::at(Place::ControlPoints(axis), detail));
    }
    let counts = pieces::shares(&data, free - shared);
    let pieces: Vec<(&[f64], usize)> = ends
        .windows(2)
        .zip(&counts)
        .map(|(ends, &count)| (&t[ends[0]..=ends[1]], count))
        .collect();
    let knots = Arc::new(knots::in_pieces(degree, &pieces));
    let basis = Basis::BSpline { degree, knots };
    let first = closed.then(|| pieces::first_number(corners[0], free, count));
    let pieces = Pieces::new(degree, &counts, first);
    let direction = Direction::in_pieces(basis, values, pieces, period);
    Ok(if free < count {
        direction.with_spread_start()
    } else {
        direction
    })
}

/// A closed B-spline, with periodic knots.
fn periodic(
    degree: usize,
    choice: &Knots,
    placed: Parametrized,
    free: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    match choice {
        Knots::Usual => {}
        Knots::Adaptive if free < placed.values.len() => {}
        Knots::Data if free == placed.values.len() => {}
        Knots::Data => return Err(least_squares_knots(axis)),
        _ => {
            return Err(Invalid::at(
                Place::Knots(axis),
                "a closed B-spline has its knots at the data: other rules and explicit knots are for open ones",
            ));
        }
    }
    if degree >= free {
        return Err(Invalid::at(
            Place::Degree(axis),
            format!(
                "degree {degree} needs at least {needed} control points on a closed curve, {count} given",
                needed = degree + 1,
                count = free
            ),
        ));
    }
    let knots = knots::periodic(&placed.values, placed.period, degree, free);
    let knots = Arc::new(knots);
    let basis = Basis::BSpline { degree, knots };
    let Parametrized { values, period } = placed;
    Ok(Direction::closed(basis, values, free, period))
}

/// Checks given knots, and scales the parameters to their range unless these are given, too.
fn explicit(
    knots: &[f64],
    degree: usize,
    t: &mut Arc<Vec<f64>>,
    free: usize,
    parameters_given: bool,
    axis: Axis,
) -> Result<(), Invalid> {
    given_knots::check(knots, degree, free, axis)?;
    if !parameters_given {
        let (low, high) = (knots[0], knots[knots.len() - 1]);
        rescale(Arc::make_mut(t).as_mut_slice(), low, high, axis)?;
    }
    Ok(())
}

/// Refuses averaged knots of a degree that is not less than the number of points.
fn check_enough(degree: usize, count: usize, axis: Axis) -> Result<(), Invalid> {
    if degree >= count {
        return Err(Invalid::at(
            Place::Degree(axis),
            format!(
                "degree {degree} needs at least {needed} points with averaged knots, {count} given",
                needed = degree + 1
            ),
        ));
    }
    Ok(())
}

/// Refuses degrees below 1 or above [`MAX_DEGREE`]; `chosen` says whether it was given as a degree,
/// rather than by the number of control points.
pub(crate) fn check_degree(degree: usize, chosen: bool, axis: Axis) -> Result<(), Invalid> {
    let limit = MAX_DEGREE;
    match degree {
        0 => Err(Invalid::at(
            Place::Degree(axis),
            format!("degree {degree} is below 1"),
        )),
        _ if degree > limit => {
            let place = match chosen {
                true => Place::Degree(axis),
                false => Place::Basis(axis),
            };
            let detail = format!(
                "degree {degree} is above {limit}, the highest that is evaluated to full accuracy"
            );
            Err(Invalid::at(place, detail))
        }
        _ => Ok(()),
    }
}

/// Knots at the data, or averaged ones, in a least-squares fit.
fn least_squares_knots(axis: Axis) -> Invalid {
    let detail = "least squares spreads its knots by itself: leave them out, or for open curves name \"spread\" or \"adaptive\", or give numbers";
    Invalid::at(Place::Knots(axis), detail)
}

/// Refuses parameters so large that knots made of them could overflow.
fn check_range(values: &[f64], axis: Axis) -> Result<(), Invalid> {
    let ends = [values[0], values[values.len() - 1]];
    if ends.iter().all(|x| x.abs() <= LARGEST) {
        Ok(())
    } else {
        Err(Invalid::parameter_range(axis))
    }
}
