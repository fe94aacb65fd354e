//! Requested constraints: a location, and one condition that holds there.

mod at;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::model::lists::Vectors;
use crate::model::serde_helpers::object;
use crate::model::settings::Index;
use piad_fit::data::{Grid, Points};
use piad_fit::method::{At, Constraint, Wanted};

use at::PlaceInput;

/// A constraint of every iteration: `{"index": i}` passes through a data point; others have `at` and one of the fields
/// for the condition that holds there.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "Constraint", example = example())]
pub(crate) struct ConstraintInput {
    /// It passes through this data point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) index: Option<Index>,
    /// The location.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) at: Option<PlaceInput>,
    /// The point that it passes through.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) point: Option<Vectors>,
    /// Curves: the first derivative with respect to the parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative: Option<Vectors>,
    /// Curves: the second derivative.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) second_derivative: Option<Vectors>,
    /// Curves: the first derivative is a multiple of this vector that is not negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) tangent: Option<Vectors>,
    /// Surfaces: the derivative with respect to u.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative_u: Option<Vectors>,
    /// Surfaces: the derivative with respect to v.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative_v: Option<Vectors>,
    /// Surfaces: the second derivative with respect to u.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative_uu: Option<Vectors>,
    /// Surfaces: the mixed second derivative.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative_uv: Option<Vectors>,
    /// Surfaces: the second derivative with respect to v.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f64>>")]
    pub(crate) derivative_vv: Option<Vectors>,
    /// Along a boundary: its control points, in the basis of the other direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    pub(crate) control_points: Option<Vectors>,
    /// Along a boundary: the control points of the first derivative across it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    pub(crate) cross_derivatives: Option<Vectors>,
}

object!(
    ConstraintInput,
    "{\"index\": …}, or an object with at and what holds there"
);

fn example() -> Value {
    json!({"at": "start", "tangent": [0.0, 1.0]})
}

/// The condition of a field of a constraint.
#[derive(Clone, Copy)]
enum Meaning {
    /// A point or a derivative of these orders.
    Derivative([usize; 2]),
    Tangent,
    /// Control points of the derivative of this order across a boundary.
    Across(usize),
}

impl ConstraintInput {
    /// The constraint on data points that are arranged in a grid, or the error.
    pub(super) fn constraint(self, grid: Grid, surface: bool) -> Result<Constraint, String> {
        use Meaning::{Across, Derivative, Tangent};
        let fields = [
            ("point", Derivative([0, 0]), self.point),
            ("derivative", Derivative([1, 0]), self.derivative),
            (
                "second_derivative",
                Derivative([2, 0]),
                self.second_derivative,
            ),
            ("tangent", Tangent, self.tangent),
            ("derivative_u", Derivative([1, 0]), self.derivative_u),
            ("derivative_v", Derivative([0, 1]), self.derivative_v),
            ("derivative_uu", Derivative([2, 0]), self.derivative_uu),
            ("derivative_uv", Derivative([1, 1]), self.derivative_uv),
            ("derivative_vv", Derivative([0, 2]), self.derivative_vv),
            ("control_points", Across(0), self.control_points),
            ("cross_derivatives", Across(1), self.cross_derivatives),
        ];
        let given = fields.into_iter();
        let mut given = given.filter_map(|(name, meaning, it)| Some((name, meaning, it?)));
        let (wanted, more) = (given.next(), given.next());
        let (at, (name, meaning, vectors)) = match (self.index, self.at, wanted, more) {
            (Some(index), None, None, None) => {
                let at = At::Index(index.of_point(grid, surface)?);
                let wanted = Wanted::DataPoint;
                return Ok(Constraint { at, wanted });
            }
            (None, Some(at), Some(wanted), None) => (at, wanted),
            (None, None, ..) => return Err("a constraint has an index, or at".to_owned()),
            (Some(_), ..) => return Err("a constraint with an index has nothing else".to_owned()),
            (_, _, None, _) => {
                return Err(
                    "a constraint needs a point or a derivative that holds there".to_owned(),
                );
            }
            (.., Some((other, ..))) => {
                return Err(format!(
                    "one thing holds in a constraint, and {other} is another"
                ));
            }
        };
        let of_curves = ["derivative", "second_derivative", "tangent"].contains(&name);
        if surface && of_curves {
            return Err(format!(
                "{name} is for curves: surfaces have derivative_u, derivative_v"
            ));
        }
        if !surface && !of_curves && name != "point" {
            return Err(format!("{name} is for surfaces"));
        }
        let wanted = match meaning {
            Derivative(orders) => one(vectors).map(|vector| Wanted::Derivative { orders, vector }),
            Tangent => one(vectors).map(Wanted::Tangent),
            Across(order) => many(vectors).map(|control_points| Wanted::Across {
                order,
                control_points,
            }),
        };
        Ok(Constraint {
            at: at.at(grid, surface)?,
            wanted: wanted.map_err(|expected| format!("{name} is {expected}"))?,
        })
    }

    /// A constraint in the form of a request.
    pub(crate) fn of(constraint: &Constraint, grid: Grid, surface: bool) -> Self {
        let columns = (surface && grid.is_rows()).then_some(grid.columns);
        let mut input = Self {
            at: Some(PlaceInput::of(constraint.at, columns)),
            ..Self::default()
        };
        let (field, vectors) = match (&constraint.wanted, constraint.at) {
            (Wanted::DataPoint, At::Index(point)) => {
                return Self {
                    index: Some(Index::new(point, columns)),
                    ..Self::default()
                };
            }
            (Wanted::DataPoint, _) => return input,
            (Wanted::Derivative { orders, vector }, _) => (
                input.derivative_field(*orders, surface),
                Vectors::one(vector),
            ),
            (Wanted::Tangent(vector), _) => (&mut input.tangent, Vectors::one(vector)),
            (
                Wanted::Across {
                    order,
                    control_points,
                },
                _,
            ) => {
                let field = match order {
                    0 => &mut input.control_points,
                    _ => &mut input.cross_derivatives,
                };
                let orders = [Arc::new(control_points.clone())];
                (field, Vectors::of(&orders, true, false))
            }
        };
        *field = Some(vectors);
        input
    }

    /// The field of a point or a derivative of these orders.
    fn derivative_field(&mut self, orders: [usize; 2], surface: bool) -> &mut Option<Vectors> {
        match (orders, surface) {
            ([0, 0], _) => &mut self.point,
            ([1, 0], false) => &mut self.derivative,
            (_, false) => &mut self.second_derivative,
            ([1, 0], true) => &mut self.derivative_u,
            ([0, 1], true) => &mut self.derivative_v,
            ([2, 0], true) => &mut self.derivative_uu,
            ([0, 2], true) => &mut self.derivative_vv,
            (_, true) => &mut self.derivative_uv,
        }
    }
}

/// The coordinates of one vector.
fn one(vectors: Vectors) -> Result<Vec<f64>, &'static str> {
    let vector = vectors.orders(false, false).and_then(|mut it| it.pop());
    let vector = vector.filter(|vector| vector.len() == 1);
    vector.map_or(Err("a vector, [x, y, z]"), |vector| {
        Ok(vector.point(0).collect())
    })
}

/// A list of vectors.
fn many(vectors: Vectors) -> Result<Points, &'static str> {
    let points = vectors.orders(true, false).and_then(|mut it| it.pop());
    points.map_or(Err("a list of vectors, [[x, y, z], …]"), |points| {
        Ok(Points::clone(&points))
    })
}
