//! The constants g of control points `c = E x + g`.
//!
//! Of a curve they are a vector for each copy. Of a surface they come from its boundaries: where the
//! derivatives across a boundary are given or estimated at its data points, the copies of the
//! control points there differ from them by a B-spline of the other direction that interpolates the
//! derivatives. With the constants φ_j along u of all columns of data, ψ_l along v of all rows, and
//! the constants τ_jl of φ_j along v (the twists),
//!
//! ```text
//! G = Σ_j  e_j (E_v B_v⁻¹ (φ_j − N_v τ_j) + τ_j)ᵀ  +  Σ_l  E_u B_u⁻¹ (ψ_l − N_u τ_l) e_lᵀ
//! ```
//!
//! so that the limit is the tensor product of the fits of curves. It takes O(n p²) for directions of
//! n points, and two B-splines for each copy.

use super::copies::Copies;
use super::estimate::taylor;
use super::{End, Ends};
use crate::fit::collocation::Collocation;
use crate::fit::direction::Direction;
use crate::fit::invalid::{Axis, Invalid, Side};
use crate::fit::linear::LineMap as _;
use crate::fit::points::{Grid, Points};
use crate::fit::scaling::normalizing_scale;

/// The constants of all copies.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::fit) struct Offsets {
    /// For functions of u: the constants of their row of the control net.
    rows: Vec<Strip>,
    /// For functions of v: the constants of their column.
    columns: Vec<Strip>,
}

/// The constants of a row or a column of the control net.
#[derive(Clone, Debug, PartialEq)]
struct Strip {
    /// The basis function.
    function: usize,
    /// One for each function of the other direction; a single one of a curve.
    values: Points,
}

/// The points that are fitted, in the coordinates of the loop.
#[derive(Clone, Copy, Debug)]
pub(in crate::fit) struct Fitted<'a> {
    /// The points, of a surface row by row.
    pub points: &'a Points,
    /// Their arrangement.
    pub grid: Grid,
    /// Whether the last coordinate is a weight.
    pub homogeneous: bool,
}

impl Offsets {
    /// The constants of a fit; none if all copies are equal to their control points.
    ///
    /// # Errors
    ///
    /// Numbers leave their range.
    pub(in crate::fit) fn new(
        fitted: Fitted<'_>,
        u: (&Direction, Option<&Ends>),
        v: Option<(&Direction, Option<&Ends>)>,
    ) -> Result<Option<Self>, Invalid> {
        let along = Along::new(u.0, u.1);
        let across = v.map(|(direction, ends)| Along::new(direction, ends));
        let offsets = match &across {
            None => Self::of_curve(fitted, &along),
            Some(across) => Self::of_surface(fitted, &along, across),
        };
        for (axis, strips) in [(Axis::U, &offsets.rows), (Axis::V, &offsets.columns)] {
            let finite = |strip: &Strip| strip.values.extents().iter().all(|it| it.is_finite);
            if !strips.iter().all(finite) {
                return Err(Invalid::EndsTooLarge { axis });
            }
        }
        let some = !offsets.rows.is_empty() || !offsets.columns.is_empty();
        Ok(some.then_some(offsets))
    }

    fn of_curve(fitted: Fitted<'_>, along: &Along<'_>) -> Self {
        let line = Line::of(fitted, 0, 1);
        let constants = along.constants(line, Some(0)).into_iter();
        let strip = |(function, vector): (usize, Vec<f64>)| Strip {
            function,
            values: Points::from_lanes(vector.into_iter().map(|x| vec![x])),
        };
        Self {
            rows: constants.map(strip).collect(),
            columns: Vec::new(),
        }
    }

    fn of_surface(fitted: Fitted<'_>, along: &Along<'_>, across: &Along<'_>) -> Self {
        let Grid { rows, columns } = fitted.grid;
        let of_columns =
            (0..columns).map(|j| along.constants(Line::of(fitted, j, columns), Some(j)));
        let fields_u = fields(of_columns);
        let row = |i| Line::of(fitted, i * columns, 1);
        let of_rows = (0..rows).map(|i| across.constants(row(i), Some(i)));
        let fields_v = fields(of_rows);
        let mut offsets = Self::default();
        let mut twists = Vec::new();
        for (function, field) in fields_u {
            let twist = across.constants(Line::whole(&field), None);
            offsets.rows.push(Strip {
                function,
                values: across.interpolate(field, &twist, true),
            });
            twists.push((function, twist));
        }
        for (function, field) in fields_v {
            let own = |(row, twist): &(usize, Constants)| {
                let here = twist.iter().find(|(column, _)| *column == function);
                here.map(|(_, vector)| (*row, vector.clone()))
            };
            let twist: Constants = twists.iter().filter_map(own).collect();
            offsets.columns.push(Strip {
                function,
                values: along.interpolate(field, &twist, false),
            });
        }
        offsets
    }

    /// The constant of one coordinate of the control point at a place of the net.
    pub(in crate::fit) fn at(&self, row: usize, column: usize, coordinate: usize) -> f64 {
        let of = |strips: &[Strip], function, place: usize| -> f64 {
            let own = strips.iter().filter(|strip| strip.function == function);
            own.map(|strip| strip.values.lane(coordinate)[place]).sum()
        };
        of(&self.rows, row, column) + of(&self.columns, column, row)
    }

    /// Adds `factor N g` to the points of a grid of parameters, row by row: `lanes` has those of each
    /// coordinate.
    pub(in crate::fit) fn add(
        &self,
        factor: f64,
        (u, at_u): (&Direction, &[f64]),
        v: Option<(&Direction, &[f64])>,
        lanes: &mut [impl AsMut<[f64]>],
    ) {
        let columns = v.map_or(1, |(_, at_v)| at_v.len());
        for (c, lane) in lanes.iter_mut().enumerate() {
            let lane = lane.as_mut();
            for strip in &self.rows {
                let values = strip.values.lane(c);
                let along: Vec<f64> = match v {
                    None => values.to_vec(),
                    Some((v, at_v)) => at_v.iter().map(|&t| spline(v, values, t)).collect(),
                };
                each_value(u, strip.function, at_u, |i, value| {
                    let row = lane[i * columns..][..columns].iter_mut();
                    row.zip(&along).for_each(|(x, g)| *x += factor * value * g);
                });
            }
            for (strip, (v, at_v)) in self.columns.iter().zip(v.into_iter().cycle()) {
                let values = strip.values.lane(c);
                let along: Vec<f64> = at_u.iter().map(|&t| spline(u, values, t)).collect();
                each_value(v, strip.function, at_v, |j, value| {
                    let column = lane[j..].iter_mut().step_by(columns);
                    column
                        .zip(&along)
                        .for_each(|(x, g)| *x += factor * value * g);
                });
            }
        }
    }

    /// How many numbers are kept.
    pub(in crate::fit) fn numbers(&self) -> usize {
        let strips = self.rows.iter().chain(&self.columns);
        strips
            .map(|strip| strip.values.len() * strip.values.dimension())
            .sum()
    }
}

/// The value at `t` of the B-spline with these control points, one for each function.
fn spline(direction: &Direction, controls: &[f64], t: f64) -> f64 {
    let mut values = vec![0.0; direction.basis.support_width()];
    let start = direction.evaluate(t, &mut values);
    values
        .iter()
        .zip(&controls[start..])
        .map(|(a, x)| a * x)
        .sum()
}

/// Calls `visit` with the value of a function at each parameter of its support.
fn each_value(
    direction: &Direction,
    function: usize,
    parameters: &[f64],
    mut visit: impl FnMut(usize, f64),
) {
    let Some(knots) = direction.basis.knots() else {
        return;
    };
    let support = knots[function]..=knots[function + direction.basis.degree() + 1];
    let mut values = vec![0.0; direction.basis.support_width()];
    for (i, &t) in parameters.iter().enumerate() {
        if support.contains(&t) {
            let start = direction.evaluate(t, &mut values);
            let place = function.checked_sub(start);
            if let Some(value) = place.and_then(|place| values.get(place)) {
                visit(i, *value);
            }
        }
    }
}

/// Functions with the constants of their control points, by coordinate.
type Constants = Vec<(usize, Vec<f64>)>;

/// The constants of many lines, function by function: one point for each line.
fn fields(lines: impl Iterator<Item = Constants>) -> Vec<(usize, Points)> {
    let mut fields: Vec<(usize, Points)> = Vec::new();
    for (k, (function, vector)) in lines.flat_map(|line| line.into_iter().enumerate()) {
        if fields.len() <= k {
            fields.push((function, Points::new(vector.len())));
        }
        fields[k].1.push(&vector);
    }
    fields
}

/// A line of points in one direction.
#[derive(Clone, Copy, Debug)]
struct Line<'a> {
    points: &'a Points,
    first: usize,
    stride: usize,
    homogeneous: bool,
}

impl<'a> Line<'a> {
    fn of(fitted: Fitted<'a>, first: usize, stride: usize) -> Self {
        Self {
            points: fitted.points,
            first,
            stride,
            homogeneous: fitted.homogeneous,
        }
    }

    /// All of these points, whatever their last coordinate is.
    fn whole(points: &'a Points) -> Self {
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
struct Along<'a> {
    direction: &'a Direction,
    /// The sides with constants.
    sides: Vec<(Copies, &'a End)>,
    /// Of two points: a natural end beside another one, whose constants it shares by β: its
    /// function, the other one, and β.
    follower: Option<(usize, usize, f64)>,
}

impl<'a> Along<'a> {
    fn new(direction: &'a Direction, ends: Option<&'a Ends>) -> Self {
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
    fn constants(&self, line: Line<'_>, boundary: Option<usize>) -> Constants {
        let mut constants = Constants::new();
        let count = self.direction.parameters.len();
        let range = self.direction.parameters[count - 1] - self.direction.parameters[0];
        for (copies, end) in &self.sides {
            let given = match (boundary, end) {
                (Some(index), End::Derivatives(orders)) => {
                    let mut power = 1.0;
                    let scaled = |(r, vectors): (usize, &std::sync::Arc<Points>)| {
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
    fn interpolate(&self, mut line: Points, constants: &Constants, added: bool) -> Points {
        let direction = self.direction;
        let inverse = Collocation::new(direction).inverse();
        let functions = direction.basis.functions();
        let complete = line.lanes_mut().iter_mut().enumerate().map(|(c, lane)| {
            for (function, vector) in constants {
                each_value(direction, *function, &direction.parameters, |i, value| {
                    lane[i] -= value * vector[c];
                });
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
/// weight, which is `weight` there: as many as those of the coordinate that are given.
fn lifted(own: &[f64], weights: &[f64], weight: f64, place: f64) -> Vec<f64> {
    let coefficient = |r: usize| {
        let inner = weights.iter().zip(own[..r].iter().rev());
        let inner: f64 = inner.map(|(w, a)| w * a).sum();
        weight * own[r] + inner + weights[r] * place
    };
    (0..own.len()).map(coefficient).collect()
}
