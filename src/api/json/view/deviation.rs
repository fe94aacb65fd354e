//! Distances of the data from the nearest points of the curve or surface.

use schemars::JsonSchema;
use serde::Serialize;

use super::error::index;
use crate::api::json::plain::never_null;
use crate::model::settings::Index;
use piad_fit::engine::Problem;
use piad_fit::engine::foot::Deviation;

/// Distances of the data from the nearest points of the curve or surface. They are never larger than the
/// `error` of the iteration, which is taken at the parameters of the data.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Deviation", transform = never_null)]
#[schemars(extend("examples" = [{
    "iteration": 12, "max": 0.0021, "rms": 0.0009, "at": 41,
    "percentiles": {"50": 0.0007, "90": 0.0016, "95": 0.0018, "99": 0.002},
}]))]
pub(crate) struct DeviationView {
    /// The number of the iteration.
    iteration: usize,
    /// The largest distance.
    max: f64,
    /// The root mean square of the distances.
    rms: f64,
    /// The data point with the largest distance.
    at: Index,
    /// Percentiles of the distances.
    percentiles: Percentiles,
    /// The distance of each data point; with `list=true`.
    #[serde(skip_serializing_if = "Option::is_none")]
    distances: Option<Distances>,
    /// By how much the curve leaves the data in each gap between neighbours, and the surface in each cell of a grid,
    /// beyond the freedom that the data leave there; with `list=true`. Scattered points have no neighbours.
    #[serde(skip_serializing_if = "Option::is_none")]
    between: Option<Distances>,
}

/// Percentiles of the distances.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"50": 0.0007, "90": 0.0016, "95": 0.0018, "99": 0.002}]))]
struct Percentiles {
    /// The median.
    #[serde(rename = "50")]
    half: f64,
    /// Of 90 per cent.
    #[serde(rename = "90")]
    ninety: f64,
    /// Of 95 per cent.
    #[serde(rename = "95")]
    ninety_five: f64,
    /// Of 99 per cent.
    #[serde(rename = "99")]
    ninety_nine: f64,
}

/// Distances in the order of the data or of the gaps between them: a list, or rows and columns of a grid; null where a
/// point is missing.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [[0.002, 0.0004, 0.0011]]))]
#[serde(untagged)]
enum Distances {
    List(Vec<f64>),
    Rows(Vec<Vec<Option<f64>>>),
}

impl DeviationView {
    /// The deviation of an iteration, with the distances of all points if requested.
    pub(crate) fn new(
        problem: &Problem,
        iteration: usize,
        deviation: &Deviation,
        list: bool,
    ) -> Self {
        let [half, ninety, ninety_five, ninety_nine] = deviation.percentiles;
        let gridded = problem.v().filter(|_| !problem.is_scattered());
        let listed = |distances: &Vec<f64>, columns: Option<usize>| match columns {
            None => Distances::List(distances.clone()),
            Some(columns) => {
                let known = |&distance: &f64| (!distance.is_nan()).then_some(distance);
                let rows = distances.chunks(columns);
                Distances::Rows(rows.map(|row| row.iter().map(known).collect()).collect())
            }
        };
        let (columns, cells) = (
            gridded.map(|_| problem.grid().columns),
            gridded.map(|v| v.explicit_parameters().len() - 1),
        );
        let distances = list.then(|| listed(&deviation.distances, columns));
        let between = (list && !problem.is_scattered()).then(|| listed(&deviation.between, cells));
        Self {
            iteration,
            max: deviation.max,
            rms: deviation.rms,
            at: index(deviation.at, problem),
            percentiles: Percentiles {
                half,
                ninety,
                ninety_five,
                ninety_nine,
            },
            distances,
            between,
        }
    }
}
