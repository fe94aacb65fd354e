//! Requested weights: of the data points, or fixed ones.

use schemars::JsonSchema;

use super::errors::{OrErrors, SpecPart, ValidationError};
use super::lists::PointNumbers;
use super::named::names;
use super::per_direction::PerDirection;
use piad_fit::data::Grid;
use piad_fit::engine::{DirectionChoice, Request, Weights};
use piad_fit::invalid::{self as fit, Axis, Invalid};

/// The use of weights: in homogeneous coordinates, so that the weights of the control points evolve with them, or as a
/// part of the basis, so that they stay.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(example = &"homogeneous")]
#[allow(missing_docs, reason = "schemas repeat the documentation of a value")]
pub(crate) enum Rational {
    Homogeneous,
    Fixed,
}

names!(Rational, "use of weights", [
    "homogeneous" => Homogeneous,
    "fixed" => Fixed,
]);

impl Rational {
    /// The use of the weights of a problem.
    pub(crate) fn of(request: &Request) -> Option<Self> {
        match (&request.weights, &request.u.weights) {
            (Weights::Homogeneous(_), _) => Some(Self::Homogeneous),
            (Weights::FixedGrid(_), _) | (Weights::None, Some(_)) => Some(Self::Fixed),
            (Weights::None, None) => None,
        }
    }
}

/// Weights as the fitting problem has them.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    /// The weights that are not of a single direction.
    pub weights: Weights,
    /// Fixed ones of the direction u.
    pub u: Option<Vec<f64>>,
    /// Fixed ones of the direction v.
    pub v: Option<Vec<f64>>,
}

impl From<Weights> for Resolved {
    fn from(weights: Weights) -> Self {
        let (u, v) = (None, None);
        Self { weights, u, v }
    }
}

impl Resolved {
    /// The weights of data points that stand in this grid: of a curve a list, of which fixed ones may also be
    /// one for each control point; of a surface rows, or a list for each direction, whose products are those of
    /// the points.
    pub(crate) fn new(
        weights: PerDirection<PointNumbers>,
        rational: Option<Rational>,
        grid: Grid,
        is_surface: bool,
    ) -> OrErrors<Self> {
        use PointNumbers::{Grid as Rows, Line};
        let fixed = rational == Some(Rational::Fixed);
        let of_directions = |u, v| Self {
            weights: Weights::None,
            u: Some(u),
            v,
        };
        let detail = match (weights, is_surface) {
            (PerDirection::Both(Line(weights)), false) if fixed => {
                return Ok(of_directions(weights, None));
            }
            (PerDirection::Both(Line(weights)), false) => {
                return Ok(Weights::Homogeneous(weights).into());
            }
            (PerDirection::Both(Rows { values, columns }), true) => {
                check_grid(&values, columns, grid)?;
                return Ok(match fixed {
                    true => Weights::FixedGrid(values).into(),
                    false => Weights::Homogeneous(values).into(),
                });
            }
            (
                PerDirection::Each {
                    u: Line(u),
                    v: Line(v),
                },
                true,
            ) if fixed => {
                return Ok(of_directions(u, Some(v)));
            }
            (
                PerDirection::Each {
                    u: Line(u),
                    v: Line(v),
                },
                true,
            ) => {
                check_axes(&u, &v, grid)?;
                let products = u.iter().flat_map(|u| v.iter().map(move |v| u * v));
                return Ok(Weights::Homogeneous(products.collect()).into());
            }
            (_, false) => "the weights of a curve are a list of numbers",
            (_, true) => {
                "the weights of a surface are rows of numbers, or {\"u\": […], \"v\": […]}"
            }
        };
        Err(ValidationError::at(SpecPart::Fit(fit::Place::Weights), detail).into())
    }
}

/// The weights of a problem in the form of a request.
pub(super) fn requested(request: &Request) -> Option<PerDirection<PointNumbers>> {
    let rows = |values: &Vec<f64>| match request.v {
        None => PointNumbers::Line(values.clone()),
        Some(_) => PointNumbers::Grid {
            values: values.clone(),
            columns: request.grid.columns,
        },
    };
    let line = |choice: &DirectionChoice| Some(PointNumbers::Line(choice.weights.clone()?));
    match (&request.weights, &request.v) {
        (Weights::None, None) => line(&request.u).map(PerDirection::Both),
        (Weights::None, Some(v)) => {
            let (u, v) = line(&request.u).zip(line(v))?;
            Some(PerDirection::Each { u, v })
        }
        (Weights::Homogeneous(values) | Weights::FixedGrid(values), _) => {
            Some(PerDirection::Both(rows(values)))
        }
    }
}

/// Refuses a use of weights without any.
pub(crate) fn check_unused(rational: Option<Rational>) -> OrErrors<()> {
    let detail = "rational says how weights are used, but there are no weights";
    match rational {
        None => Ok(()),
        Some(_) => Err(ValidationError::at(SpecPart::Rational, detail).into()),
    }
}

fn check_grid(values: &[f64], columns: usize, grid: Grid) -> OrErrors<()> {
    let rows = values.len() / columns.max(1);
    if (rows, columns) == (grid.rows, grid.columns) {
        return Ok(());
    }
    let detail = format!(
        "{rows} rows of {columns} weights for {} rows of {} points: one for each is needed",
        grid.rows, grid.columns
    );
    Err(ValidationError::at(SpecPart::Fit(fit::Place::Weights), detail).into())
}

/// Weights of both directions, one for each line of points.
fn check_axes(u: &[f64], v: &[f64], grid: Grid) -> OrErrors<()> {
    let axes = [(Axis::U, u, grid.rows), (Axis::V, v, grid.columns)];
    let wrong =
        |place, detail: String| Err(ValidationError::at(SpecPart::Fit(place), detail).into());
    for (axis, weights, expected) in axes {
        let given = weights.len();
        if given != expected {
            let detail = fit::one_for_each(given, "weights", expected);
            return wrong(fit::Place::AxisWeights(axis), detail);
        }
    }
    for (axis, weights, _) in axes {
        let positive = |w: &f64| *w > 0.0 && w.is_finite();
        if let Some(index) = weights.iter().position(|w| !positive(w)) {
            let value = weights[index];
            let error = Invalid::axis_weight(axis, index, value);
            return wrong(error.place, error.to_string());
        }
    }
    Ok(())
}
