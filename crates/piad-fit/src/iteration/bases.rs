//! The knots of a level of a fit that chooses them by itself, apart from its problem: what has to be
//! kept of them.

use std::sync::Arc;

use crate::knot_selection::breaks::Breaks;
use crate::problem::Problem;

/// Knots of a level, and the parameters of its data if they have moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Bases {
    /// For each direction both ends of the parameters and the knots between them, increasing.
    pub breaks: Vec<Arc<Vec<f64>>>,
    /// The parameters of the data of a curve.
    pub parameters: Option<Arc<Vec<f64>>>,
}

impl Problem {
    /// The knots of this level, if the fit chooses them by itself.
    pub fn bases(&self) -> Option<Bases> {
        let (_, settings) = self.method().automatic()?;
        let parameters = || Arc::clone(&self.u().parameters);
        Some(Bases {
            breaks: self.breaks()?,
            parameters: settings.correct_parameters.then(parameters),
        })
    }

    /// For each direction both ends of the parameters and the knots between them, where these are
    /// simple, and all functions have control points of their own.
    pub fn breaks(&self) -> Option<Vec<Arc<Vec<f64>>>> {
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
            let line = bases.breaks.get(axis).and_then(|breaks| {
                let degree = direction.basis.degree();
                Breaks::new(degree, direction.is_closed(), breaks.to_vec())
            });
            let moved = bases.parameters.as_ref();
            let moved = moved.filter(|it| axis == 0 && it.len() == direction.parameters.len());
            let parameters = moved.unwrap_or(&direction.parameters);
            match line {
                Some(line) => line.direction(Arc::clone(parameters)),
                None => direction.clone(),
            }
        });
        let directions: Vec<_> = directions.collect();
        self.with_directions(directions)
    }
}
