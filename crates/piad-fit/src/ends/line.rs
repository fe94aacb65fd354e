//! The constants of the copies at the ends of a line of points, and the B-spline through one.

use std::sync::Arc;

use super::copies::Copies;
use super::estimate::taylor;
use crate::basis::direction::Direction;
use crate::basis::end_conditions::{End, Ends};
use crate::data::grid::Grid;
use crate::data::points::{Points, normalizing_scale};
use crate::invalid::Side;
use crate::linear::LineMap as _;
use crate::matrix::collocation::Collocation;

/// The points that are fitted, in the coordinates of the loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted<'a> {
    /// The points, of a surface row by row.
    pub points: &'a Points,
    /// Their arrangement.
    pub grid: Grid,
    /// True if the last coordinate is a weight.
    pub homogeneous: bool,
}

/// Functions with the constants of their control points, by coordinate.
pub(super) type Constants = Vec<(usize, Vec<f64>)>;

/// A line of points in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    points: &'a Points,
    first: usize,
    stride: usize,
    homogeneous: bool,
}

impl<'a> Line<'a> {
    pub(super) fn of(fitted: Fitted<'a>, first: usize, stride: usize) -> Self {
        Self {
            points: fitted.points,
            first,
            stride,
            homogeneous: fitted.homogeneous,
        }
    }

    /// All of these points, whatever their last coordinate is.
    pub(super) fn whole(points: &'a Points) -> Self {
        Self {
            points,
            first: 0,
            stride: 1,
            homogeneous: false,
        }
    }

    fn value(&self, coordinate: usize, i: usize) -> f64 {
        self.points.lane(coordinate)[self.first + i * self.stride]
    }

    /// The number of coordinates without the weight.
    fn dimension(&self) -> usize {
        self.points.dimension() - usize::from(self.homogeneous)
    }

    fn weight(&self, i: usize) -> f64 {
        if self.homogeneous {
            self.value(self.dimension(), i)
        } else {
            1.0
        }
    }

    /// The length of the polygon through the first `count` points.
    fn length(&self, count: usize) -> f64 {
        let place = |c: usize, i: usize| self.value(c, i) / self.weight(i);
        let step = |i: usize| -> f64 {
            let steps = (0..self.dimension()).map(|c| place(c, i) - place(c, i - 1));
            steps.fold(0.0, f64::hypot)
        };
        (1..count).map(step).sum()
    }
}

/// A direction with what its ends need.
pub(super) struct Along<'a> {
    direction: &'a Direction,
    /// The sides with constants.
    sides: Vec<(Copies, &'a End)>,
    /// For two points: a natural end next to another one, whose constants it shares by β: its
    /// function, the other one, and β.
    follower: Option<(usize, usize, f64)>,
}

impl<'a> Along<'a> {
    pub(super) fn new(direction: &'a Direction, ends: Option<&'a Ends>) -> Self {
        let side = |side| {
            let end = ends?.at(side);
            let constant = !matches!(end, End::Repeated | End::Natural);
            let copies = constant.then(|| Copies::new(direction, side)).flatten();
            copies.map(|copies| (copies, end))
        };
        let sides = [Side::Start, Side::End].into_iter().filter_map(side);
        let follower = || {
            let natural = [Side::Start, Side::End].map(|side| direction.natural(side));
            match (direction.parameters.len(), natural) {
                (2, [Some(beta), None]) => Some((1, 2, beta)),
                (2, [None, Some(beta)]) => Some((2, 1, beta)),
                _ => None,
            }
        };
        Self {
            direction,
            sides: sides.collect(),
            follower: follower(),
        }
    }

    /// The constants of a line, which is that of the given number on its boundary; without a number
    /// all derivatives are estimated.
    pub(super) fn constants(&self, line: Line<'_>, boundary: Option<usize>) -> Constants {
        let mut constants = Constants::new();
        let count = self.direction.parameters.len();
        let range = self.direction.parameters[count - 1] - self.direction.parameters[0];
        for (copies, end) in &self.sides {
            let given = match (boundary, end) {
                (Some(index), End::Derivatives(orders)) => {
                    let mut power = 1.0;
                    let scaled = |(r, vectors): (usize, &Arc<Points>)| {
                        power *= copies.unit / (r + 1) as f64;
                        vectors.point(index).map(|x| x * power).collect()
                    };
                    orders.iter().enumerate().map(scaled).collect()
                }
                (Some(index), End::Tangent(directions)) => {
                    let length = directions.point(index).fold(0.0, f64::hypot);
                    let factor = line.length(count) / range * copies.unit;
                    let scaled = directions.point(index).map(|x| x / length * factor);
                    vec![scaled.collect()]
                }
                _ => Vec::new(),
            };
            let lanes = of_side(copies, line, given);
            let vector = |j: usize| lanes.iter().map(|lane| lane[j]).collect();
            constants.extend((0..copies.count).map(|j| (copies.function(j + 1), vector(j))));
        }
        if let Some((own, other, beta)) = self.follower {
            let other = constants.iter().find(|(function, _)| *function == other);
            let share = other.map(|(_, it)| it.iter().map(|x| beta * x).collect());
            constants.extend(share.map(|vector| (own, vector)));
        }
        constants
    }

    /// The control points of the B-spline through the points of a line whose ends have these
    /// constants, without the constants themselves unless they are to be `added`.
    pub(super) fn interpolate(
        &self,
        mut line: Points,
        constants: &Constants,
        added: bool,
    ) -> Points {
        let direction = self.direction;
        let inverse = Collocation::new(direction).inverse();
        let functions = direction.basis.functions();
        let shares = |(function, _): &(usize, Vec<f64>)| {
            values_of(direction, *function, &direction.parameters)
        };
        let shares: Vec<_> = constants.iter().map(shares).collect();
        let complete = line.lanes_mut().iter_mut().enumerate().map(|(c, lane)| {
            for (values, (_, vector)) in shares.iter().zip(constants) {
                values
                    .iter()
                    .for_each(|(i, value)| lane[*i] -= value * vector[c]);
            }
            inverse.apply(lane);
            let mut net: Vec<f64> = (0..functions)
                .map(|j| {
                    direction
                        .parts(j)
                        .map(|(index, part)| part * lane[index])
                        .sum()
                })
                .collect();
            for (function, vector) in constants.iter().filter(|_| added) {
                net[*function] += vector[c];
            }
            net
        });
        Points::from_lanes(complete.collect::<Vec<_>>())
    }
}

/// The constants of the copies on one side, coordinate by coordinate, where the first Taylor
/// coefficients of the points are `given`.
fn of_side(copies: &Copies, line: Line<'_>, given: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let points = copies.parameters.len();
    // Differences of points at the edge of the range of numbers must not leave it.
    let estimate = |c: usize, given: &[f64]| -> Vec<f64> {
        let value = |i| line.value(c, copies.point(i));
        let largest = (0..points).map(value).chain(given.iter().copied());
        let scale = normalizing_scale(largest.fold(0.0, |m, x| x.abs().max(m)));
        let values: Vec<f64> = (0..points).map(|i| value(i) * scale).collect();
        let given: Vec<f64> = given.iter().map(|a| a * scale).collect();
        let found = taylor(
            &copies.parameters,
            copies.unit,
            &values,
            &given,
            copies.count,
        );
        found.into_iter().map(|a| a / scale).collect()
    };
    let of_weight = line.homogeneous.then(|| estimate(line.dimension(), &[]));
    let coordinate = |c: usize| {
        let own: Vec<f64> = given.iter().map(|vector| vector[c]).collect();
        let own = match &of_weight {
            None => own,
            Some(weights) => lifted(&own, weights, line.weight(copies.point(0)), {
                line.value(c, copies.point(0)) / line.weight(copies.point(0))
            }),
        };
        copies.offsets(&estimate(c, &own))
    };
    let mut lanes: Vec<Vec<f64>> = (0..line.dimension()).map(coordinate).collect();
    lanes.extend(of_weight.map(|taylor| copies.offsets(&taylor)));
    lanes
}

/// The Taylor coefficients of the product of a coordinate, which is `place` at the end, and the
/// weight, which is `weight` there. There is one for each given coefficient of the coordinate.
fn lifted(own: &[f64], weights: &[f64], weight: f64, place: f64) -> Vec<f64> {
    let coefficient = |r: usize| {
        let inner = weights.iter().zip(own[..r].iter().rev());
        let inner: f64 = inner.map(|(w, a)| w * a).sum();
        weight * own[r] + inner + weights[r] * place
    };
    (0..own.len()).map(coefficient).collect()
}

/// The values of a function at the parameters of its support, with the places of these.
pub(super) fn values_of(
    direction: &Direction,
    function: usize,
    parameters: &[f64],
) -> Vec<(usize, f64)> {
    let Some(knots) = direction.basis.knots() else {
        return Vec::new();
    };
    let support = knots[function]..=knots[function + direction.basis.degree() + 1];
    let mut values = vec![0.0; direction.basis.support_width()];
    let inside = parameters.iter().enumerate();
    let inside = inside.filter(|(_, t)| support.contains(t));
    let value = |(i, &t): (usize, &f64)| {
        let start = direction.evaluate(t, &mut values);
        let place = function.checked_sub(start)?;
        values.get(place).map(|value| (i, *value))
    };
    inside.filter_map(value).collect()
}
