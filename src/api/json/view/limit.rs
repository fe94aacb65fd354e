//! The limits of the difference vectors of the fixed points of a local fit.

use schemars::JsonSchema;
use serde::Serialize;

use super::error::index;
use crate::model::settings::Index;
use piad_fit::engine::Problem;
use piad_fit::engine::limit::LocalLimit;

/// The limits of the difference vectors of the fixed points of a local fit.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Limit")]
#[schemars(extend("examples" = [{"points": [0, 3], "differences": [[0.0, 0.0], [0.1, -0.2]], "max": 0.223606797749979}]))]
pub(crate) struct LimitView {
    /// The fixed data points.
    points: Vec<Index>,
    /// Their difference vectors, from the limit to the data point, in the same order.
    differences: Vec<Vec<f64>>,
    /// The length of the longest of them.
    max: f64,
}

impl LimitView {
    /// The limit of a fit.
    pub(crate) fn new(problem: &Problem, limit: &LocalLimit) -> Self {
        let indices = limit.fixed.iter();
        let vectors = (0..limit.differences.len()).map(|i| limit.differences.point(i));
        Self {
            points: indices.map(|&i| index(i, problem)).collect(),
            max: vectors
                .clone()
                .map(|it| it.fold(0.0, f64::hypot))
                .fold(0.0, f64::max),
            differences: vectors.map(Iterator::collect).collect(),
        }
    }
}
