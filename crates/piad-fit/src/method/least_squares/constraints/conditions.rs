//! From constraints to linear conditions `C X = R` on the free control points.

use super::MOST_CONDITIONS;
use super::{At, Constraint, Wanted};
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place, Setting, Side};
use crate::method::least_squares::settings::{EndPoints, LeastSquares};
use crate::setup::Setup;

/// A row of C and of R.
#[derive(Clone, Debug)]
pub(in super::super) struct Condition {
    pub origin: Origin,
    /// Free control points and their factors.
    pub row: Vec<(usize, f64)>,
    /// The sum, for each coordinate.
    pub value: Vec<f64>,
    /// The sum is a multiple of `value` that is not negative.
    pub is_tangent: bool,
}

impl Condition {
    /// The largest of these factors among its control points.
    pub(in super::super) fn largest(&self, scale: &[f64]) -> f64 {
        let factors = self.row.iter().map(|&(index, _)| scale[index]);
        factors.fold(0.0, f64::max)
    }

    /// The unit vector of a tangent.
    pub(super) fn direction(&self) -> Vec<f64> {
        let norm = self.value.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.value.iter().map(|x| x / norm).collect()
    }
}

/// The origin of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) enum Origin {
    /// The data point at the start of a curve is interpolated.
    Start,
    /// That at its end.
    End,
    /// That at a corner of a surface.
    Corner,
    /// A constraint, by its index.
    Constraint(usize),
}

/// A condition that is not possible for this fit.
pub(super) fn unfit(index: usize, detail: &str) -> Invalid {
    let detail = format!("constraint {index} {detail}");
    Invalid::at(Place::Constraint(index), detail)
}

/// The conditions of a fit: end points to interpolate first, then its constraints, and tangents last. An end point for
/// which a constraint gives another one is left out, unless the ends are requested by name.
///
/// # Errors
///
/// The first constraint that is invalid in itself.
pub(super) fn conditions(
    setup: &Setup,
    settings: &LeastSquares,
) -> Result<Vec<Condition>, Invalid> {
    let mut given = Vec::new();
    for (index, constraint) in settings.constraints.iter().enumerate() {
        let maker = Maker { setup, index };
        given.extend(maker.conditions(constraint)?);
    }
    given.sort_by_key(|condition| condition.is_tangent);
    let corners = corners(setup);
    if settings.ends == EndPoints::Interpolated && corners.is_empty() {
        return Err(Invalid::at(
            Place::Setting(Setting::EndPoints),
            "there are no ends to interpolate: closed directions have none, and neither have scattered points and grids with missing points whose knots the fit chooses",
        ));
    }
    let is_replaced = |point: usize| {
        settings.ends == EndPoints::Usual
            && settings
                .constraints
                .iter()
                .any(|it| replaces(setup, it, point))
    };
    let ends = corners
        .into_iter()
        .filter(|_| settings.ends != EndPoints::Free);
    let ends = ends.filter(|&point| !is_replaced(point));
    let mut conditions: Vec<Condition> = ends.filter_map(|point| end(setup, point)).collect();
    conditions.append(&mut given);
    match conditions.len() {
        count if count > MOST_CONDITIONS => Err(Invalid::at(
            Place::Setting(Setting::Constraints),
            format!("there are {count} conditions, at most {MOST_CONDITIONS} are accepted"),
        )),
        _ => Ok(conditions),
    }
}

/// The data points at the ends of a curve and at the corners of a surface; scattered ones have none.
fn corners(setup: &Setup) -> Vec<usize> {
    if setup.is_scattered() || setup.directions().any(Direction::is_closed) {
        return Vec::new();
    }
    if setup.v().is_none() {
        return setup.ends().to_vec();
    }
    let grid = setup.grid();
    let rows = [0, grid.rows - 1].into_iter();
    let columns = [0, grid.columns - 1];
    rows.flat_map(|row| columns.map(|column| row * grid.columns + column))
        .collect()
}

/// Returns true if a constraint gives the point at an end of a curve, or at a corner of a surface.
fn replaces(setup: &Setup, constraint: &Constraint, end: usize) -> bool {
    let (grid, at_end) = (setup.grid(), parameters(setup, end));
    let is_point = match &constraint.wanted {
        Wanted::DataPoint => true,
        Wanted::Derivative { orders, .. } => *orders == [0, 0],
        Wanted::Across { order, .. } => *order == 0,
        Wanted::Tangent(_) => false,
    };
    let last = |count: usize, side: Side| match side {
        Side::Start => 0,
        Side::End => count - 1,
    };
    is_point
        && match constraint.at {
            At::Side(side) => end == end_of_curve(setup, side),
            At::Index(point) => end == point,
            At::Parameter(u) => at_end[0] == u,
            At::Parameters(u, v) => at_end == [u, v],
            At::Boundary(Axis::U, side) => end / grid.columns == last(grid.rows, side),
            At::Boundary(Axis::V, side) => end % grid.columns == last(grid.columns, side),
        }
}

/// The data point at an end of a curve.
fn end_of_curve(setup: &Setup, side: Side) -> usize {
    let [first, last] = setup.ends();
    match side {
        Side::Start => first,
        Side::End => last,
    }
}

/// The condition to pass through a data point, unless it is missing.
fn end(setup: &Setup, point: usize) -> Option<Condition> {
    if setup
        .missing()
        .is_some_and(|missing| missing.contains(point))
    {
        return None;
    }
    Some(Condition {
        origin: match (setup.v(), point) {
            (Some(_), _) => Origin::Corner,
            (None, _) if point == setup.ends()[0] => Origin::Start,
            (None, _) => Origin::End,
        },
        row: row(setup, parameters(setup, point), [0, 0])?,
        value: setup.data().point(point).collect(),
        is_tangent: false,
    })
}

/// The parameters of a data point; that of v is ignored on curves.
fn parameters(setup: &Setup, point: usize) -> [f64; 2] {
    let columns = setup.grid().columns;
    let (row, column) = match setup.is_scattered() {
        true => (point, point),
        false => (point / columns, point % columns),
    };
    let v = setup.v().map_or(0.0, |v| v.parameters[column]);
    [setup.u().parameters[row], v]
}

/// The factors of a value or a derivative; `None` if the basis has no derivatives.
fn row(setup: &Setup, [u, v]: [f64; 2], orders: [usize; 2]) -> Option<Vec<(usize, f64)>> {
    let along = setup.u().functional(u, orders[0])?;
    let Some(direction) = setup.v() else {
        return Some(along);
    };
    let across = direction.functional(v, orders[1])?;
    let columns = setup.control_grid().columns;
    let products = along.iter().flat_map(|&(i, a)| {
        let across = across.iter();
        across.map(move |&(j, b)| (i * columns + j, a * b))
    });
    Some(products.collect())
}

/// Makes the conditions of one constraint.
struct Maker<'a> {
    setup: &'a Setup,
    index: usize,
}

impl Maker<'_> {
    fn conditions(&self, constraint: &Constraint) -> Result<Vec<Condition>, Invalid> {
        match (constraint.at, &constraint.wanted) {
            (
                At::Boundary(axis, side),
                Wanted::Across {
                    order,
                    control_points,
                },
            ) => self.across((axis, side), *order, control_points),
            (At::Boundary(..), _) => Err(unfit(
                self.index,
                "is along a boundary: it needs control points or cross derivatives",
            )),
            (at, wanted) => Ok(vec![self.condition(at, wanted)?]),
        }
    }

    /// A condition at a point.
    fn condition(&self, at: At, wanted: &Wanted) -> Result<Condition, Invalid> {
        let (index, setup) = (self.index, self.setup);
        let (parameters, point) = self.place(at)?;
        let (orders, value) = match wanted {
            Wanted::DataPoint => {
                let point = point.ok_or_else(|| {
                    unfit(
                        index,
                        "is not at a data point: it needs a point to pass through",
                    )
                })?;
                ([0, 0], setup.data().point(point).collect())
            }
            Wanted::Derivative { orders, vector } => (*orders, self.value(*orders, vector, point)?),
            Wanted::Tangent(vector) => ([1, 0], self.tangent(vector)?),
            Wanted::Across { .. } => {
                return Err(unfit(
                    index,
                    "has control points of a boundary, and is not at one",
                ));
            }
        };
        if setup.v().is_none() && orders[1] > 0 {
            return Err(unfit(index, "has a derivative in v, and a curve has none"));
        }
        let row = row(setup, parameters, orders).ok_or_else(|| {
            unfit(
                index,
                "has a derivative, which only B-splines and Bernstein polynomials obey",
            )
        })?;
        Ok(Condition {
            origin: Origin::Constraint(index),
            row,
            value,
            is_tangent: matches!(wanted, Wanted::Tangent(_)),
        })
    }

    /// The parameters at which it holds, and the data point, if it is at one.
    fn place(&self, at: At) -> Result<([f64; 2], Option<usize>), Invalid> {
        let (index, setup) = (self.index, self.setup);
        let (is_surface, count) = (setup.v().is_some(), setup.grid().count());
        let point = match at {
            At::Side(_) if is_surface => {
                return Err(unfit(index, "is at an end, and a surface has boundaries"));
            }
            At::Side(_) if setup.u().is_closed() => {
                return Err(unfit(index, "is at an end, and a closed curve has none"));
            }
            At::Side(side) => end_of_curve(setup, side),
            At::Index(point) if point >= count => {
                return Err(unfit(
                    index,
                    &format!("is at data point {point}, but there are {count} of them"),
                ));
            }
            At::Index(point) => point,
            At::Parameter(_) if is_surface => {
                return Err(unfit(index, "is at one parameter, and a surface has two"));
            }
            At::Parameter(u) => return Ok(([self.inside(Axis::U, u)?, 0.0], None)),
            At::Parameters(u, v) => {
                if !is_surface {
                    return Err(unfit(index, "is at two parameters, and a curve has one"));
                }
                let place = [self.inside(Axis::U, u)?, self.inside(Axis::V, v)?];
                return Ok((place, None));
            }
            At::Boundary(..) => return Err(unfit(index, "is along a boundary")),
        };
        if setup
            .missing()
            .is_some_and(|missing| missing.contains(point))
        {
            return Err(unfit(
                index,
                &format!("is at data point {point}, which is missing"),
            ));
        }
        Ok((parameters(setup, point), Some(point)))
    }

    fn direction(&self, axis: Axis) -> Option<&Direction> {
        match axis {
            Axis::U => Some(self.setup.u()),
            Axis::V => self.setup.v(),
        }
    }

    /// A parameter, if it lies in the domain.
    fn inside(&self, axis: Axis, value: f64) -> Result<f64, Invalid> {
        let domain = self.direction(axis).map(|it| it.basis.domain());
        let (low, high) = domain.unwrap_or((0.0, 0.0));
        if low <= value && value <= high {
            return Ok(value);
        }
        let name = axis.name();
        Err(unfit(
            self.index,
            &format!("is at the parameter {value} of {name}, outside of {low} to {high}"),
        ))
    }

    /// The value of a given point or derivative. In homogeneous coordinates a given point has the
    /// weight of its data point, and derivatives are not linear.
    fn value(
        &self,
        orders: [usize; 2],
        vector: &[f64],
        point: Option<usize>,
    ) -> Result<Vec<f64>, Invalid> {
        let mut value = self.checked(vector)?;
        if self.setup.is_homogeneous() {
            let weight = point.filter(|_| orders == [0, 0]);
            let weight = weight.and_then(|point| self.setup.data().point(point).last());
            let weight = weight.ok_or_else(|| {
                unfit(
                    self.index,
                    "is not linear in homogeneous coordinates: only points at data points are",
                )
            })?;
            value.iter_mut().for_each(|x| *x *= weight);
            value.push(weight);
        }
        Ok(value)
    }

    /// As many finite coordinates as the data have.
    fn checked(&self, vector: &[f64]) -> Result<Vec<f64>, Invalid> {
        let (index, given, expected) = (self.index, vector.len(), self.setup.dimension());
        if given != expected {
            return Err(unfit(
                index,
                &format!("has {given} coordinates, the data have {expected}"),
            ));
        }
        match vector.iter().find(|x| !x.is_finite()) {
            Some(&value) => Err(unfit(
                index,
                &format!("has the coordinate {value}, which is not a finite number"),
            )),
            None => Ok(vector.to_vec()),
        }
    }

    /// The unit vector of a direction.
    fn tangent(&self, vector: &[f64]) -> Result<Vec<f64>, Invalid> {
        let vector = self.checked(vector)?;
        if self.setup.v().is_some() {
            return Err(unfit(
                self.index,
                "has a tangent, and surfaces have derivatives",
            ));
        }
        let vector = self.value([1, 0], &vector, None)?;
        let largest = vector.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if largest == 0.0 {
            return Err(unfit(self.index, "has a tangent of length zero"));
        }
        let scaled: Vec<f64> = vector.iter().map(|x| x / largest).collect();
        let norm = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
        Ok(scaled.iter().map(|x| x / norm).collect())
    }

    /// A boundary, or the derivative across it: one condition for each control point along it, in the order
    /// of the control net. Along a closed direction the copies at its end may be given, too.
    fn across(
        &self,
        (axis, side): (Axis, Side),
        order: usize,
        control_points: &Points,
    ) -> Result<Vec<Condition>, Invalid> {
        let (index, setup) = (self.index, self.setup);
        let grid = setup.control_grid();
        let direction = self.direction(axis).filter(|_| setup.v().is_some());
        let direction =
            direction.ok_or_else(|| unfit(index, "is along a boundary, and a curve has none"))?;
        if direction.is_closed() {
            return Err(unfit(index, "is along a boundary of a closed direction"));
        }
        let other = match axis {
            Axis::U => self.direction(Axis::V),
            Axis::V => self.direction(Axis::U),
        };
        let other = other.unwrap_or(direction);
        let (given, expected) = (control_points.len(), other.free());
        let repeats = |k: usize| {
            control_points
                .point(k)
                .eq(control_points.point(k % expected))
        };
        let complete = given == other.basis.functions() && (expected..given).all(repeats);
        if given != expected && !complete {
            return Err(unfit(
                index,
                &format!("has {given} control points along a boundary of {expected}"),
            ));
        }
        let (low, high) = direction.basis.domain();
        let t = match side {
            Side::Start => low,
            Side::End => high,
        };
        let factors = direction.functional(t, order).ok_or_else(|| {
            unfit(
                index,
                "has derivatives, which only B-splines and Bernstein polynomials obey",
            )
        })?;
        let at = |across: usize, along: usize| match axis {
            Axis::U => across * grid.columns + along,
            Axis::V => along * grid.columns + across,
        };
        let condition = |along: usize| {
            let vector: Vec<f64> = control_points.point(along).collect();
            let row = factors.iter();
            // Free control points of a closed direction are counted from another one on.
            let free = other.equal_to(along).unwrap_or(along);
            Ok(Condition {
                origin: Origin::Constraint(index),
                is_tangent: false,
                row: row
                    .map(|&(across, factor)| (at(across, free), factor))
                    .collect(),
                value: self.value([order, 0], &vector, None)?,
            })
        };
        (0..expected).map(condition).collect()
    }
}
