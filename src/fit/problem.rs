//! A fitting problem: from what was asked for to what can be iterated.

use super::basis::{
    Basis, MAX_DEGREE,
    knots::{self, Knots},
};
use super::collocation::Collocation;
use super::invalid::{Axis, Invalid};
use super::parameters::{Parametrization, parameters, rescale};
use super::points::{Grid, Points};
use super::transform::Method;

/// Parameters and knots further out than this would overflow in sums of a few of them.
const PARAMETER_RANGE: f64 = 1e300;

/// The basis asked for in one direction.
#[derive(Clone, Debug, PartialEq)]
pub enum BasisChoice {
    /// Bernstein polynomials of degree points − 1.
    Bernstein,
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
}

/// When to stop, as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// In data units.
    Absolute(f64),
    /// In units of the diagonal of the data's bounding box.
    Relative(f64),
}

/// A fitting problem as asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The data points; of a surface row by row.
    pub points: Points,
    /// Their arrangement.
    pub grid: Grid,
    /// The direction of a curve, or u of a surface.
    pub u: DirectionChoice,
    /// The second direction of a surface.
    pub v: Option<DirectionChoice>,
    /// The method.
    pub method: Method,
    /// The largest allowed distance of the curve from a data point.
    pub tolerance: Tolerance,
    /// The last level that is computed.
    pub max_iterations: usize,
}

/// One direction of a validated problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// The basis.
    pub basis: Basis,
    /// Strictly increasing parameters of the data, within the domain of the basis.
    pub parameters: Vec<f64>,
    /// Copies of the first control point in front of it: with knots at the data there are more
    /// basis functions than data points (LBW05 (3.2)).
    pub front_copies: usize,
}

impl Direction {
    /// The number of free control points, which is the number of data points.
    pub fn free(&self) -> usize {
        self.parameters.len()
    }

    /// The free control point that basis function `j` is multiplied with. End copies move with
    /// their control point.
    pub fn free_index(&self, j: usize) -> usize {
        j.saturating_sub(self.front_copies).min(self.free() - 1)
    }
}

/// A validated fitting problem. It can be iterated, and every error left is one of arithmetic.
#[derive(Clone, Debug)]
pub struct Problem {
    points: Points,
    grid: Grid,
    u: Direction,
    v: Option<Direction>,
    method: Method,
    tolerance: f64,
    max_iterations: usize,
    diagonal: f64,
}

impl Problem {
    /// Validates a request, computes parameters and knots and resolves the tolerance.
    pub fn new(request: Request) -> Result<Self, Invalid> {
        let Request { points, grid, .. } = request;
        if grid.rows < 2 || (request.v.is_some() && grid.columns < 2) {
            let count = if grid.rows < 2 {
                grid.rows
            } else {
                grid.columns
            };
            return Err(Invalid::TooFewPoints { count });
        }
        check_finite(&points)?;
        let diagonal = points.bounding_diagonal();
        if !diagonal.is_finite() {
            return Err(Invalid::TooLarge);
        }
        let tolerance = resolve_tolerance(request.tolerance, diagonal)?;
        let u = direction(request.u, &points, grid, Axis::U)?;
        let v = request
            .v
            .map(|choice| direction(choice, &points, grid, Axis::V))
            .transpose()?;
        Ok(Self {
            points,
            grid,
            u,
            v,
            method: request.method,
            tolerance,
            max_iterations: request.max_iterations,
            diagonal,
        })
    }

    /// The data points; of a surface row by row.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// The arrangement of the data points.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The direction of a curve, or u of a surface.
    pub fn u(&self) -> &Direction {
        &self.u
    }

    /// The second direction of a surface.
    pub fn v(&self) -> Option<&Direction> {
        self.v.as_ref()
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The largest allowed distance of the curve from a data point, in data units.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The last level that is computed.
    pub fn max_iterations(&self) -> usize {
        self.max_iterations
    }

    /// The diagonal of the data's bounding box, in data units.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Bytes that iterating this problem once takes, the data included.
    pub fn memory(&self) -> usize {
        let points = self.grid.count();
        // Data, control points and residual; one coordinate of scratch on surfaces.
        let scratch = usize::from(self.v.is_some());
        let vectors = (3 * self.points.dimension() + scratch) * points * size_of::<f64>();
        let directions = [Some(&self.u), self.v.as_ref()];
        directions
            .into_iter()
            .flatten()
            .map(|direction| {
                2 * direction.free() * size_of::<f64>() + Collocation::memory(direction)
            })
            .sum::<usize>()
            + vectors
    }

    /// Multiplications of one iteration, set-up spread over it: the measure of how long a step takes.
    pub fn step_cost(&self) -> usize {
        let width = |direction: &Direction| direction.basis.support_width();
        let widths = width(&self.u) + self.v.as_ref().map_or(0, width);
        self.points.dimension() * self.grid.count() * widths
    }
}

fn check_finite(points: &Points) -> Result<(), Invalid> {
    for (coordinate, lane) in points.lanes().iter().enumerate() {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::NotFinite {
                index,
                coordinate,
                value: lane[index],
            });
        }
    }
    Ok(())
}

fn resolve_tolerance(tolerance: Tolerance, diagonal: f64) -> Result<f64, Invalid> {
    let (value, unit, relative) = match tolerance {
        Tolerance::Absolute(value) => (value, 1.0, false),
        Tolerance::Relative(value) => (value, diagonal, true),
    };
    if value.is_finite() && value >= 0.0 {
        Ok(value * unit)
    } else {
        Err(Invalid::Tolerance { value, relative })
    }
}

/// Parameters, basis and knots of one direction.
fn direction(
    choice: DirectionChoice,
    points: &Points,
    grid: Grid,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let given = matches!(choice.parameters, Parametrization::Explicit(_));
    let mut t = parameters(choice.parameters, points, grid, axis)?;
    check_range(&t, axis)?;
    match choice.basis {
        BasisChoice::Bernstein => {
            let degree = t.len() - 1;
            check_degree(degree, axis)?;
            rescale(&mut t, 0.0, 1.0, axis)?;
            Ok(Direction {
                basis: Basis::Bernstein { degree },
                parameters: t,
                front_copies: 0,
            })
        }
        BasisChoice::BSpline { degree, knots } => {
            check_degree(degree, axis)?;
            bspline_direction(degree, knots, t, given, axis)
        }
    }
}

fn bspline_direction(
    degree: usize,
    choice: Knots,
    mut t: Vec<f64>,
    parameters_given: bool,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let mut front_copies = 0;
    let knots = match choice {
        Knots::Data => {
            // ⌈(p−1)/2⌉ copies of the first control point in front, ⌊(p−1)/2⌋ of the last behind.
            front_copies = degree / 2;
            knots::at_data(&t, degree)
        }
        Knots::Averaged => {
            let count = t.len();
            if degree >= count {
                return Err(Invalid::DegreeTooHigh {
                    axis,
                    degree,
                    count,
                });
            }
            knots::averaged(&t, degree)
        }
        Knots::Explicit(knots) => {
            knots::check(&knots, degree, t.len(), axis)?;
            check_range(&knots, axis)?;
            if !parameters_given {
                rescale(&mut t, knots[0], knots[knots.len() - 1], axis)?;
            }
            knots::check_schoenberg_whitney(&knots, degree, &t, axis)?;
            knots
        }
    };
    Ok(Direction {
        basis: Basis::BSpline { degree, knots },
        parameters: t,
        front_copies,
    })
}

fn check_degree(degree: usize, axis: Axis) -> Result<(), Invalid> {
    let limit = MAX_DEGREE;
    match degree {
        0 => Err(Invalid::DegreeTooLow { axis, degree }),
        _ if degree > limit => Err(Invalid::DegreeAboveLimit {
            axis,
            degree,
            limit,
        }),
        _ => Ok(()),
    }
}

fn check_range(values: &[f64], axis: Axis) -> Result<(), Invalid> {
    let ends = [values[0], values[values.len() - 1]];
    if ends.iter().all(|x| x.abs() <= PARAMETER_RANGE) {
        Ok(())
    } else {
        Err(Invalid::ParameterRange { axis })
    }
}
