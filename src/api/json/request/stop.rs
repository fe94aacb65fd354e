//! The JSON of the rules when an iteration ends.

use schemars::JsonSchema;
use serde::Deserialize;

use super::schema;
use crate::fit::invalid as fit;
use crate::fit::problem::Tolerance;
use crate::model::either::{object, whole};
use crate::model::mistakes::{Mistake, SpecPart};
use crate::model::stop::{DEFAULT_ITERATIONS, StopSpec};

/// When the iteration ends. There is one of the tolerances, or none.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "StopRules", example = schema::example_stop())]
pub(in crate::api) struct StopRequest {
    /// The largest allowed distance from a data point, in data units.
    #[schemars(range(min = 0))]
    pub(in crate::api) tolerance: Option<f64>,
    /// The same as a part of the diagonal of the bounding box of the data.
    #[schemars(range(min = 0), extend("default" = 1e-6))]
    pub(in crate::api) relative_tolerance: Option<f64>,
    /// The last iteration that is computed. Servers have a limit, which /v1/capabilities tells.
    #[serde(default, deserialize_with = "whole")]
    #[schemars(extend("default" = DEFAULT_ITERATIONS))]
    pub(in crate::api) max_iterations: Option<usize>,
}

object!(StopRequest, "an object");

impl From<StopRequest> for StopSpec {
    fn from(request: StopRequest) -> Self {
        let tolerance = match (request.tolerance, request.relative_tolerance) {
            (None, None) => Ok(None),
            (Some(value), None) => Ok(Some(Tolerance::Absolute(value))),
            (None, Some(value)) => Ok(Some(Tolerance::Relative(value))),
            (Some(_), Some(_)) => {
                let place = SpecPart::Fit(fit::Place::RelativeTolerance);
                let detail = "tolerance is given, so relative_tolerance cannot be";
                Err(Mistake::at(place, detail).into())
            }
        };
        Self {
            tolerance,
            max_iterations: request.max_iterations,
        }
    }
}
