//! One direction of the parameter domain: its basis at the parameters of the data.

use std::ops::Range;
use std::sync::Arc;

use super::basis::{
    Basis, MAX_DEGREE, Polynomial,
    knots::{self, Knots},
};
use super::invalid::{Axis, Invalid};
use super::missing::Missing;
use super::norms::normalizing_scale;
use super::parameters::{Parametrization, Parametrized, parameters, rescale};
use super::points::{Grid, Points};

/// The basis asked for in one direction.
#[derive(Clone, Debug, PartialEq)]
pub enum BasisChoice {
    /// Polynomials of degree control points − 1.
    Polynomial(Polynomial),
    /// B-splines.
    BSpline {
        /// The degree p ≥ 1.
        degree: usize,
        /// How the knots are chosen.
        knots: Knots,
    },
}

/// What is asked for in one direction of the parameter domain.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionChoice {
    /// The basis.
    pub basis: BasisChoice,
    /// The parameters of the data points.
    pub parameters: Parametrization,
    /// The last point is followed by the first.
    pub closed: bool,
    /// The number of control points of a least-squares fit; otherwise one for each data point.
    pub control_points: Option<usize>,
    /// Fixed weights: one for each control point, end copies included, or one for each data point.
    pub weights: Option<Vec<f64>>,
}

/// One direction of a validated problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// The basis, without weights.
    pub basis: Basis,
    /// Strictly increasing parameters of the data, within the domain of the basis.
    pub parameters: Arc<Vec<f64>>,
    free: usize,
    ends: Ends,
    /// Weights of the basis functions, for rational bases.
    weights: Option<Vec<f64>>,
}

/// How basis functions share control points.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ends {
    /// The first control point is repeated so often in front, the last one behind: with knots at
    /// the data there are more basis functions than data points (LBW05 (3.2)).
    Open { front_copies: usize },
    /// The first control points follow the last ones, after a period of the parameters.
    Closed { period: f64 },
}

impl Direction {
    /// Computes parameters and knots and checks them.
    pub fn new(
        choice: DirectionChoice,
        points: &Points,
        grid: Grid,
        missing: Option<&Missing>,
        axis: Axis,
    ) -> Result<Self, Invalid> {
        let count = grid.along(axis);
        let free = choice.control_points.unwrap_or(count);
        let fewer = choice.control_points.is_some();
        if free < 2 || free > count {
            return Err(Invalid::ControlPointCount { axis, free, count });
        }
        let given = matches!(choice.parameters, Parametrization::Explicit(_));
        let placed = parameters(
            choice.parameters,
            points,
            grid,
            missing,
            axis,
            choice.closed,
        )?;
        check_range(&placed.values, axis)?;
        let mut direction = match choice.basis {
            BasisChoice::Polynomial(_) if choice.closed => {
                return Err(Invalid::ClosedPolynomial { axis });
            }
            BasisChoice::Polynomial(kind) => polynomial(kind, placed.values, free, axis)?,
            BasisChoice::BSpline { degree, knots } => {
                check_degree(degree, true, axis)?;
                if choice.closed {
                    periodic(degree, &knots, placed, free, axis)?
                } else if fewer {
                    least_squares(degree, knots, placed.values, free, given, axis)?
                } else {
                    clamped(degree, knots, placed.values, given, axis)?
                }
            }
        };
        direction.weights = choice
            .weights
            .map(|weights| direction.complete_weights(weights, axis))
            .transpose()?;
        Ok(direction)
    }

    /// The parameters as they would be given: on closed curves with the end of the period.
    pub fn explicit_parameters(&self) -> Arc<Vec<f64>> {
        let mut values = Arc::clone(&self.parameters);
        if let Ends::Closed { period } = self.ends {
            let end = values[0] + period;
            Arc::make_mut(&mut values).push(end);
        }
        values
    }

    /// The number of free control points.
    pub fn free(&self) -> usize {
        self.free
    }

    /// Whether the last point is followed by the first.
    pub fn is_closed(&self) -> bool {
        matches!(self.ends, Ends::Closed { .. })
    }

    /// Whether the basis has weights.
    pub fn is_rational(&self) -> bool {
        self.weights.is_some()
    }

    /// The weights of the basis functions of a rational basis.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The free control point that basis function `j` is multiplied with.
    pub fn free_index(&self, j: usize) -> usize {
        match self.ends {
            Ends::Open { front_copies } => j.saturating_sub(front_copies).min(self.free - 1),
            // Basis function p/2 is centred on the first data point.
            Ends::Closed { .. } => {
                (j + self.free - self.basis.degree() / 2 % self.free) % self.free
            }
        }
    }

    /// The basis functions that free control point `index` is multiplied with, increasing: the
    /// inverse of [`Self::free_index`].
    pub fn functions_of(&self, index: usize) -> impl Iterator<Item = usize> + Clone {
        let functions = self.basis.functions();
        match self.ends {
            Ends::Open { front_copies } => {
                let own = index + front_copies;
                let first = if index == 0 { 0 } else { own };
                let is_last = index + 1 == self.free;
                let end = if is_last { functions } else { own + 1 };
                (first..end).step_by(1)
            }
            Ends::Closed { .. } => {
                let first = (index + self.basis.degree() / 2) % self.free;
                (first..functions).step_by(self.free)
            }
        }
    }

    /// The first ones of as many consecutive functions as can differ from zero at a parameter, as far
    /// as each of these has a control point of its own, next to that of the function before (around
    /// the end on closed curves).
    pub fn own_functions(&self) -> Range<usize> {
        let degree = self.basis.degree();
        match self.ends {
            Ends::Open { front_copies } => {
                front_copies..front_copies + self.free.saturating_sub(degree)
            }
            Ends::Closed { .. } => 0..self.basis.functions(),
        }
    }

    /// Writes the values at `t` of the functions that can differ from zero there, with their
    /// weights, and returns the index of the first of them.
    pub fn evaluate(&self, t: f64, values: &mut [f64]) -> usize {
        let (low, high) = self.basis.domain();
        // The knots of even degree lie between the parameters: where the last one is next to the end of
        // the period, rounding may put it behind.
        let wraps = self.is_closed() && t > high;
        let t = if wraps { t - (high - low) } else { t };
        let start = self.basis.evaluate(t, values);
        self.weigh(start, values)
    }

    /// Gives values of the functions from `start` on their weights; returns `start`.
    pub fn weigh(&self, start: usize, values: &mut [f64]) -> usize {
        if let Some(weights) = &self.weights {
            // w_j B_j / Σ w_k B_k (LBW05 (3.7)).
            let weights = &weights[start..];
            let sum: f64 = values
                .iter()
                .zip(weights)
                .map(|(value, weight)| value * weight)
                .sum();
            // Products that have left the range of numbers are brought back by a common factor.
            let largest = || {
                let shown = values
                    .iter()
                    .zip(weights)
                    .filter(|(value, _)| **value > 0.0);
                shown.fold(0.0, |largest: f64, (_, weight)| largest.max(*weight))
            };
            let factor = if sum.is_normal() {
                1.0
            } else {
                normalizing_scale(largest())
            };
            let mut sum = 0.0;
            for (value, weight) in values.iter_mut().zip(weights) {
                // Weights of functions that vanish here may be too large for the factor.
                if *value > 0.0 {
                    *value *= factor * weight;
                    sum += *value;
                }
            }
            values.iter_mut().for_each(|value| *value /= sum);
        }
        start
    }

    /// One weight for each basis function.
    fn complete_weights(&self, weights: Vec<f64>, axis: Axis) -> Result<Vec<f64>, Invalid> {
        for (index, &value) in weights.iter().enumerate() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Invalid::AxisWeight { axis, index, value });
            }
        }
        let functions = self.basis.functions();
        let given = weights.len();
        if given == self.free {
            Ok((0..functions)
                .map(|j| weights[self.free_index(j)])
                .collect())
        } else if given == functions && !self.is_closed() {
            Ok(weights)
        } else {
            Err(Invalid::AxisWeightCount {
                axis,
                given,
                free: self.free,
                functions,
            })
        }
    }

    fn open(basis: Basis, parameters: Arc<Vec<f64>>, free: usize, front_copies: usize) -> Self {
        Self {
            basis,
            parameters,
            free,
            ends: Ends::Open { front_copies },
            weights: None,
        }
    }
}

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
        Knots::Explicit(knots) => {
            explicit(&knots, degree, &mut t, free, parameters_given, axis)?;
            knots::check_schoenberg_whitney(&knots, degree, &t, axis)?;
            knots
        }
    };
    let basis = Basis::BSpline { degree, knots };
    Ok(Direction::open(basis, t, free, front_copies))
}

/// Fewer control points than data: knots by PT97 (9.68)–(9.69), unless they are given.
fn least_squares(
    degree: usize,
    choice: Knots,
    mut t: Arc<Vec<f64>>,
    free: usize,
    parameters_given: bool,
    axis: Axis,
) -> Result<Direction, Invalid> {
    if degree >= free {
        return Err(Invalid::TooFewControlPoints { axis, free, degree });
    }
    let knots = match choice {
        Knots::Usual => Arc::new(knots::least_squares(&t, degree, free)),
        Knots::Data | Knots::Averaged => return Err(Invalid::LeastSquaresKnots { axis }),
        Knots::Explicit(knots) => {
            explicit(&knots, degree, &mut t, free, parameters_given, axis)?;
            knots
        }
    };
    let (low, high) = (knots[0], knots[knots.len() - 1]);
    if let Some(index) = t.iter().position(|t| !(low..=high).contains(t)) {
        return Err(Invalid::ParameterOutside {
            axis,
            index,
            value: t[index],
            low,
            high,
        });
    }
    Ok(Direction::open(
        Basis::BSpline { degree, knots },
        t,
        free,
        0,
    ))
}

fn periodic(
    degree: usize,
    choice: &Knots,
    placed: Parametrized,
    free: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    match choice {
        Knots::Usual => {}
        Knots::Data if free == placed.values.len() => {}
        Knots::Data => return Err(Invalid::LeastSquaresKnots { axis }),
        Knots::Averaged | Knots::Explicit(_) => return Err(Invalid::ClosedKnots { axis }),
    }
    if degree >= free {
        return Err(Invalid::ClosedDegree {
            axis,
            degree,
            count: free,
        });
    }
    let knots = knots::periodic(&placed.values, placed.period, degree, free);
    Ok(Direction {
        basis: Basis::BSpline {
            degree,
            knots: Arc::new(knots),
        },
        parameters: placed.values,
        free,
        ends: Ends::Closed {
            period: placed.period,
        },
        weights: None,
    })
}

/// Checks given knots, and scales parameters to their range unless these are given, too.
fn explicit(
    knots: &[f64],
    degree: usize,
    t: &mut Arc<Vec<f64>>,
    free: usize,
    parameters_given: bool,
    axis: Axis,
) -> Result<(), Invalid> {
    knots::check(knots, degree, free, axis)?;
    if !parameters_given {
        let (low, high) = (knots[0], knots[knots.len() - 1]);
        rescale(Arc::make_mut(t).as_mut_slice(), low, high, axis)?;
    }
    Ok(())
}

fn check_enough(degree: usize, count: usize, axis: Axis) -> Result<(), Invalid> {
    if degree >= count {
        return Err(Invalid::DegreeTooHigh {
            axis,
            degree,
            count,
        });
    }
    Ok(())
}

fn check_degree(degree: usize, chosen: bool, axis: Axis) -> Result<(), Invalid> {
    let limit = MAX_DEGREE;
    match degree {
        0 => Err(Invalid::DegreeTooLow { axis, degree }),
        _ if degree > limit => Err(Invalid::DegreeAboveLimit {
            axis,
            degree,
            limit,
            chosen,
        }),
        _ => Ok(()),
    }
}

fn check_range(values: &[f64], axis: Axis) -> Result<(), Invalid> {
    let ends = [values[0], values[values.len() - 1]];
    if ends.iter().all(|x| x.abs() <= knots::LARGEST) {
        Ok(())
    } else {
        Err(Invalid::ParameterRange { axis })
    }
}
