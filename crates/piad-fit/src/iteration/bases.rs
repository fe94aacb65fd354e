//! The knots of a level of a fit that chooses them, stored apart from its problem.

use std::sync::Arc;

use crate::basis::direction::Direction;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::clamped_breaks;
use crate::problem::Problem;

/// Knots of a level, and the parameters of its data if they have moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Bases {
    /// For each direction both ends of the parameters and the knots between them; those at corners come p times.
    pub breaks: Vec<Arc<Vec<f64>>>,
    /// The parameters of the data in each direction, if they have moved.
    pub parameters: Vec<Arc<Vec<f64>>>,
}

impl Problem {
    /// The knots of this level, if the fit chooses them.
    pub fn bases(&self) -> Option<Bases> {
        let (_, settings) = self.method().automatic()?;
        let parameters = self.directions().map(|it| Arc::clone(&it.parameters));
        Some(Bases {
            breaks: self.breaks()?,
            parameters: match settings.correct_parameters {
                true => parameters.collect(),
                false => Vec::new(),
            },
        })
    }

    /// For each direction both ends of the parameters and the knots between them, where these are
    /// simple or at corners, and all functions have control points of their own.
    pub fn breaks(&self) -> Option<Vec<Arc<Vec<f64>>>> {
        if self.corners().is_some() {
            return Some(vec![Arc::new(clamped_breaks::of(self.u())?)]);
        }
        let breaks = self.directions().map(|direction| {
            let line = Breaks::of(direction)?;
            let own = line.control_points() == direction.free();
            own.then(|| Arc::new(line.breaks().to_vec()))
        });
        breaks.collect()
    }

    /// The problem with these knots. Numbers that do not increase, as a damaged store can have, leave
    /// their direction as it is.
    pub fn with_bases(&self, bases: &Bases) -> Self {
        let directions = self.directions().enumerate().map(|(axis, direction)| {
            let moved = bases.parameters.get(axis);
            let moved = moved.filter(|it| it.len() == direction.parameters.len());
            let parameters = Arc::clone(moved.unwrap_or(&direction.parameters));
            let breaks = bases.breaks.get(axis);
            let chosen = breaks.and_then(|breaks| self.with_breaks(direction, breaks, parameters));
            chosen.unwrap_or_else(|| direction.clone())
        });
        let directions: Vec<_> = directions.collect();
        self.with_directions(directions)
    }

    /// A direction with other knots, of data at some parameters.
    pub(super) fn with_breaks(
        &self,
        direction: &Direction,
        breaks: &[f64],
        parameters: Arc<Vec<f64>>,
    ) -> Option<Direction> {
        let degree = direction.basis.degree();
        match self.corners() {
            Some(corners) => {
                let around = direction.period().map(|period| (corners[0], period));
                clamped_breaks::direction(degree, breaks, parameters, around)
            }
            None => {
                let line = Breaks::new(degree, direction.is_closed(), breaks.to_vec())?;
                Some(line.direction(parameters))
            }
        }
    }
}
