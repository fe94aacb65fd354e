//! The JSON of weights: of the data points, or fixed ones.

use schemars::JsonSchema;

use super::invalid::invalid;
use crate::api::json::numbers::WeightList;
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::names;
use crate::api::problem::Problem;
use crate::fit::points::Grid;
use crate::fit::problem::Weights;

/// How weights are used: in homogeneous coordinates, so that the weights of the control points
/// evolve with them, or as a part of the basis, so that they stay.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "Rational", example = &"homogeneous")]
pub(in crate::api) enum RationalRequest {
    Homogeneous,
    Fixed,
}

names!(RationalRequest, "use of weights", [
    "homogeneous" => Homogeneous,
    "fixed" => Fixed,
]);
/// Weights of a curve: of the data points, or fixed ones.
pub(super) fn curve_weights(
    weights: Option<WeightList>,
    rational: Option<RationalRequest>,
) -> Result<(Weights, Option<Vec<f64>>), Problem> {
    let weights = match weights {
        None => None,
        Some(WeightList::Line(weights)) => Some(weights),
        Some(WeightList::Grid { .. }) => {
            let detail = "the weights of a curve are a list of numbers";
            return Err(invalid("/curve/weights", detail));
        }
    };
    match (rational, weights) {
        (None, None) => Ok((Weights::None, None)),
        (Some(_), None) => Err(no_weights()),
        (Some(RationalRequest::Fixed), Some(weights)) => Ok((Weights::None, Some(weights))),
        (_, Some(weights)) => Ok((Weights::Homogeneous(weights), None)),
    }
}

/// Fixed weights of both directions.
pub(super) type FixedWeights = Option<(Vec<f64>, Vec<f64>)>;

/// Weights of a surface: a grid, or one list for each direction whose products they are.
pub(super) fn surface_weights(
    weights: Option<PerDirection<WeightList>>,
    rational: Option<RationalRequest>,
    grid: Grid,
    pointer: &str,
) -> Result<(Weights, FixedWeights), Problem> {
    let Some(weights) = weights else {
        return match rational {
            None => Ok((Weights::None, None)),
            Some(_) => Err(no_weights()),
        };
    };
    let fixed = rational == Some(RationalRequest::Fixed);
    match weights {
        PerDirection::Both(WeightList::Grid { values, columns }) => {
            let rows = values.len() / columns.max(1);
            if (rows, columns) != (grid.rows, grid.columns) {
                let detail = format!(
                    "{rows} rows of {columns} weights for {} rows of {} points",
                    grid.rows, grid.columns
                );
                return Err(invalid(pointer, detail));
            }
            let weights = if fixed {
                Weights::FixedGrid(values)
            } else {
                Weights::Homogeneous(values)
            };
            Ok((weights, None))
        }
        PerDirection::Each {
            u: WeightList::Line(u),
            v: WeightList::Line(v),
        } => {
            if fixed {
                return Ok((Weights::None, Some((u, v))));
            }
            for (name, given, expected) in [("u", u.len(), grid.rows), ("v", v.len(), grid.columns)]
            {
                if given != expected {
                    let detail = format!("{given} weights for {expected} points");
                    return Err(invalid(&format!("{pointer}/{name}"), detail));
                }
            }
            for (name, weights) in [("u", &u), ("v", &v)] {
                let wrong = |w: &f64| !(*w > 0.0 && w.is_finite());
                if let Some(index) = weights.iter().position(wrong) {
                    let value = weights[index];
                    let detail =
                        format!("weight {index} is {value}; weights are finite and greater than 0");
                    return Err(invalid(&format!("{pointer}/{name}/{index}"), detail));
                }
            }
            let products = u.iter().flat_map(|u| v.iter().map(move |v| u * v));
            Ok((Weights::Homogeneous(products.collect()), None))
        }
        _ => {
            let detail =
                "the weights of a surface are rows of numbers, or {\"u\": […], \"v\": […]}";
            Err(invalid(pointer, detail))
        }
    }
}

pub(super) fn no_weights() -> Problem {
    invalid(
        "/rational",
        "rational says how weights are used, but there are no weights",
    )
}
