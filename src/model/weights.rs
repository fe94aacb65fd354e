//! Weights as they are asked for: of the data points, or fixed ones.

use schemars::JsonSchema;

use super::mistakes::{Mistake, OrMistakes, SpecPart};
use super::named::names;
use crate::fit::invalid::{self as fit, Axis, Invalid};
use crate::fit::points::Grid;
use crate::fit::problem::{Request, Weights};

/// How weights are used: in homogeneous coordinates, so that the weights of the control points
/// evolve with them, or as a part of the basis, so that they stay.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(example = &"homogeneous")]
#[allow(missing_docs, reason = "schemas repeat what is said of a value")]
pub enum Rational {
    Homogeneous,
    Fixed,
}

names!(Rational, "use of weights", [
    "homogeneous" => Homogeneous,
    "fixed" => Fixed,
]);

impl Rational {
    /// How the weights of a problem are used.
    pub fn of(request: &Request) -> Option<Self> {
        match (&request.weights, &request.u.weights) {
            (Weights::Homogeneous(_), _) => Some(Self::Homogeneous),
            (Weights::FixedGrid(_), _) | (Weights::None, Some(_)) => Some(Self::Fixed),
            (Weights::None, None) => None,
        }
    }
}

/// Weights as they are asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightSpec {
    /// Of a curve: one for each data point; fixed ones also one for each control point.
    List(Vec<f64>),
    /// Of a surface: one for each data point.
    Grid {
        /// The weights, row by row.
        values: Vec<f64>,
        /// The length of the rows.
        columns: usize,
    },
    /// Of a surface: of both directions. The weight of a point is their product.
    Axes {
        /// One for each row.
        u: Vec<f64>,
        /// One for each column.
        v: Vec<f64>,
    },
}

/// Weights as the fitting problem has them.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// Those that are not of a single direction.
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

impl WeightSpec {
    /// The weights of data points that stand in this grid.
    pub fn resolve(self, rational: Option<Rational>, grid: Grid) -> OrMistakes<Resolved> {
        let fixed = rational == Some(Rational::Fixed);
        let of_directions = |u, v| Resolved {
            weights: Weights::None,
            u: Some(u),
            v,
        };
        Ok(match self {
            Self::List(weights) if fixed => of_directions(weights, None),
            Self::List(weights) => Weights::Homogeneous(weights).into(),
            Self::Grid { values, columns } => {
                check_grid(&values, columns, grid)?;
                match fixed {
                    true => Weights::FixedGrid(values).into(),
                    false => Weights::Homogeneous(values).into(),
                }
            }
            Self::Axes { u, v } if fixed => of_directions(u, Some(v)),
            Self::Axes { u, v } => {
                check_axes(&u, &v, grid)?;
                let products = u.iter().flat_map(|u| v.iter().map(move |v| u * v));
                Weights::Homogeneous(products.collect()).into()
            }
        })
    }
}

/// Refuses to use weights that there are not.
pub fn check_unused(rational: Option<Rational>) -> OrMistakes<()> {
    let detail = "rational says how weights are used, but there are no weights";
    match rational {
        None => Ok(()),
        Some(_) => Err(Mistake::at(SpecPart::Rational, detail).into()),
    }
}

fn check_grid(values: &[f64], columns: usize, grid: Grid) -> OrMistakes<()> {
    let rows = values.len() / columns.max(1);
    if (rows, columns) == (grid.rows, grid.columns) {
        return Ok(());
    }
    let detail = format!(
        "{rows} rows of {columns} weights for {} rows of {} points",
        grid.rows, grid.columns
    );
    Err(Mistake::at(SpecPart::Fit(fit::Place::Weights), detail).into())
}

/// Weights of both directions, one for each line of points.
fn check_axes(u: &[f64], v: &[f64], grid: Grid) -> OrMistakes<()> {
    let axes = [(Axis::U, u, grid.rows), (Axis::V, v, grid.columns)];
    let wrong = |place, detail: String| Err(Mistake::at(SpecPart::Fit(place), detail).into());
    for (axis, weights, expected) in axes {
        let given = weights.len();
        if given != expected {
            let detail = format!("{given} weights for {expected} points");
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
