//! The JSON of constraints: where, and one thing that holds there.

mod at;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::api::json::lists::Vectors;
use crate::api::json::request::settings::Index;
use crate::api::json::view::error::PointIndex;
use crate::fit::method::{At, Constraint, Wanted};
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Problem;
use crate::model::either::object;
use at::AtRequest;

/// What every iteration obeys: `{"index": i}` passes through a data point; others have `at` and one of
/// the fields that say what holds there.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "Constraint", example = example())]
pub(in crate::api) struct ConstraintRequest {
    /// It passes through this data point.
    index: Option<Index>,
    /// Where it holds.
    at: Option<AtRequest>,
    /// The point that it passes through.
    #[schemars(with = "Option<Vec<f64>>")]
    point: Option<Vectors>,
    /// Curves: the first derivative with respect to the parameter.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative: Option<Vectors>,
    /// Curves: the second derivative.
    #[schemars(with = "Option<Vec<f64>>")]
    second_derivative: Option<Vectors>,
    /// Curves: the direction of the first derivative. Its length is that of the polygon through the
    /// points over the range of the parameters.
    #[schemars(with = "Option<Vec<f64>>")]
    tangent: Option<Vectors>,
    /// Surfaces: the derivative with respect to u.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative_u: Option<Vectors>,
    /// Surfaces: the derivative with respect to v.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative_v: Option<Vectors>,
    /// Surfaces: the second derivative with respect to u.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative_uu: Option<Vectors>,
    /// Surfaces: the mixed second derivative.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative_uv: Option<Vectors>,
    /// Surfaces: the second derivative with respect to v.
    #[schemars(with = "Option<Vec<f64>>")]
    derivative_vv: Option<Vectors>,
    /// Along a boundary: its control points, in the basis of the other direction.
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    control_points: Option<Vectors>,
    /// Along a boundary: the control points of the first derivative across it.
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    cross_derivatives: Option<Vectors>,
}

object!(
    ConstraintRequest,
    "{\"index\": …}, or an object with at and what holds there"
);

fn example() -> Value {
    json!({"at": "start", "tangent": [0.0, 1.0]})
}

impl ConstraintRequest {
    /// The constraint, or why it is none.
    pub(super) fn spec(self, grid: Grid, surface: bool) -> Result<Constraint, String> {
        let derivative = |orders| move |vector| Wanted::Derivative { orders, vector };
        let curves = [
            self.point
                .map(|it| ("point", of_vector(it).map(derivative([0, 0])))),
            self.derivative
                .map(|it| ("derivative", of_vector(it).map(derivative([1, 0])))),
            self.second_derivative
                .map(|it| ("second_derivative", of_vector(it).map(derivative([2, 0])))),
            self.tangent
                .map(|it| ("tangent", of_vector(it).map(Wanted::Tangent))),
        ];
        let surfaces = [
            ("derivative_u", self.derivative_u, [1, 0]),
            ("derivative_v", self.derivative_v, [0, 1]),
            ("derivative_uu", self.derivative_uu, [2, 0]),
            ("derivative_uv", self.derivative_uv, [1, 1]),
            ("derivative_vv", self.derivative_vv, [0, 2]),
        ];
        let surfaces = surfaces.map(|(name, vector, orders)| {
            vector.map(|it| (name, of_vector(it).map(derivative(orders))))
        });
        let across = |order| {
            move |control_points| Wanted::Across {
                order,
                control_points,
            }
        };
        let boundaries = [
            ("control_points", self.control_points, 0),
            ("cross_derivatives", self.cross_derivatives, 1),
        ];
        let boundaries = boundaries.map(|(name, vectors, order)| {
            vectors.map(|it| (name, of_vectors(it).map(across(order))))
        });
        let mut given = curves
            .into_iter()
            .chain(surfaces)
            .chain(boundaries)
            .flatten();
        let (wanted, more) = (given.next(), given.next());
        let (at, (name, wanted)) = match (self.index, self.at, wanted, more) {
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
            (.., Some((other, _))) => {
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
        Ok(Constraint {
            at: at.of(grid, surface)?,
            wanted: wanted.map_err(|expected| format!("{name} is {expected}"))?,
        })
    }
}

/// The coordinates of one vector.
fn of_vector(vectors: Vectors) -> Result<Vec<f64>, &'static str> {
    let vector = vectors.orders(false, false).and_then(|mut it| it.pop());
    let vector = vector.filter(|vector| vector.len() == 1);
    vector.map_or(Err("a vector, [x, y, z]"), |vector| {
        Ok(vector.point(0).collect())
    })
}

/// A list of vectors.
fn of_vectors(vectors: Vectors) -> Result<Points, &'static str> {
    let points = vectors.orders(true, false).and_then(|mut it| it.pop());
    points.map_or(Err("a list of vectors, [[x, y, z], …]"), |points| {
        Ok(Points::clone(&points))
    })
}

/// The JSON that asks for a constraint.
pub(super) fn written(constraint: &Constraint, problem: &Problem) -> Value {
    let index = |index| json!(PointIndex::new(index, problem));
    let at = match constraint.at {
        At::Side(side) => json!(side.name()),
        At::Index(point) => json!({"index": index(point)}),
        At::Parameter(t) => json!({"parameter": t}),
        At::Parameters(u, v) => json!({"parameter": [u, v]}),
        At::Boundary(axis, side) => {
            json!({"boundary": format!("{}_{}", axis.name(), side.name())})
        }
    };
    let (name, value) = match &constraint.wanted {
        Wanted::DataPoint => return json!({"index": at["index"]}),
        Wanted::Derivative { orders, vector } => (
            derivative_name(*orders, problem.v().is_some()),
            json!(vector),
        ),
        Wanted::Tangent(vector) => ("tangent", json!(vector)),
        Wanted::Across {
            order,
            control_points,
        } => {
            let points = 0..control_points.len();
            let points = points.map(|k| json!(control_points.point(k).collect::<Vec<f64>>()));
            let name = match order {
                0 => "control_points",
                _ => "cross_derivatives",
            };
            (name, points.collect())
        }
    };
    json!({"at": at, name: value})
}

/// The field of a point or a derivative of these orders.
fn derivative_name(orders: [usize; 2], surface: bool) -> &'static str {
    match (orders, surface) {
        ([0, 0], _) => "point",
        ([1, 0], false) => "derivative",
        (_, false) => "second_derivative",
        ([1, 0], true) => "derivative_u",
        ([0, 1], true) => "derivative_v",
        ([2, 0], true) => "derivative_uu",
        ([0, 2], true) => "derivative_vv",
        (_, true) => "derivative_uv",
    }
}
