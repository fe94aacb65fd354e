//! Conversion between the knots of a schedule and the directions of a problem.
//!
//! Both have the same curves. On closed ones function j belongs to control point `j mod n` here, and
//! to `(j − ⌊p/2⌋) mod n` in a direction, whose control points are counted from the first datum on.

use std::sync::Arc;

use super::breaks::Breaks;
use crate::basis::Basis;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::linear::stencil::Reach;

impl Breaks {
    /// The knots of a direction, if they are simple ones.
    pub(crate) fn of(direction: &Direction) -> Option<Self> {
        let degree = direction.basis.degree();
        let knots = direction.basis.knots()?;
        let end = knots.len().checked_sub(degree)?;
        let breaks = knots.get(degree..end)?.to_vec();
        Self::new(degree, direction.is_closed(), breaks)
    }

    /// The coarsest knots of a direction, from the first of its parameters on.
    pub(crate) fn coarsest_of(direction: &Direction) -> Option<Self> {
        let (degree, t) = (direction.basis.degree(), &direction.parameters);
        let (start, last) = (*t.first()?, *t.last()?);
        let end = direction.period().map_or(last, |period| start + period);
        Self::coarsest(degree, direction.is_closed(), start, end)
    }

    /// The direction with these knots, of data at some parameters.
    pub(crate) fn direction(&self, parameters: Arc<Vec<f64>>) -> Direction {
        let basis = Basis::BSpline {
            degree: self.degree(),
            knots: self.knots(),
        };
        let free = self.control_points();
        if self.is_closed() {
            let breaks = self.breaks();
            Direction::closed(basis, parameters, free, breaks[free] - breaks[0])
        } else {
            Direction::open(basis, parameters, free, 0)
        }
    }

    /// The functions of the line, with a margin around a closed one.
    pub(crate) fn reach(&self) -> Reach {
        Reach {
            count: self.spans() + self.degree(),
            degree: self.degree(),
            is_closed: self.is_closed(),
        }
    }

    /// The control point of the schedule that is this one of a direction.
    pub(crate) fn of_direction(&self, control_point: usize) -> usize {
        (control_point + self.turn()) % self.control_points()
    }

    /// The index in the schedule at which the control points of a direction begin.
    pub(super) fn turn(&self) -> usize {
        match self.is_closed() {
            true => self.degree() / 2 % self.control_points(),
            false => 0,
        }
    }
}

/// The control points of directions, from those of a schedule.
pub(crate) fn in_directions(points: &Points, lines: &[Breaks]) -> Points {
    turned(points, lines, Breaks::turn)
}

/// The control points of a schedule, from those of directions.
pub(crate) fn in_lines(points: &Points, lines: &[Breaks]) -> Points {
    turned(points, lines, |line| {
        (line.control_points() - line.turn()) % line.control_points()
    })
}

/// The control points of a curve or of a grid, rotated in each direction.
fn turned(points: &Points, lines: &[Breaks], turn: impl Fn(&Breaks) -> usize) -> Points {
    let turns: Vec<usize> = lines.iter().map(turn).collect();
    if turns.iter().all(|turn| *turn == 0) {
        return points.clone();
    }
    let rows = lines.first().map_or(1, Breaks::control_points);
    let columns = lines.get(1).map_or(1, Breaks::control_points);
    let [along, across] = [0, 1].map(|axis| turns.get(axis).copied().unwrap_or(0));
    Points::from_lanes(points.lanes().iter().map(|lane| {
        let place = |k: usize| {
            let row = (k / columns + along) % rows;
            let column = (k % columns + across) % columns;
            lane[row * columns + column]
        };
        (0..rows * columns).map(place).collect::<Vec<f64>>()
    }))
}
