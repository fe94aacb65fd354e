//! Parameters of the points of another job's surface that are nearest.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::model::errors::{SpecPart, ValidationError};
use crate::model::iteration::IterationChoice;
use crate::model::serde_helpers::object;
use piad_fit::data::Points;
use piad_fit::geometry::{Nurbs, foot_points};
use piad_fit::parameters::Scattered;

/// The surface of another job, for foot points: the nearest points of it. They are computed once, when the new job is
/// created.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "FootPointsRequest")]
#[schemars(example = json!({"job": "01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a", "iteration": 12}))]
pub struct FootPoints {
    /// The id of the job whose surface it is, with as many coordinates as the points.
    pub job: String,
    /// An iteration that the job has reached; without it, the last one of a job that has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) iteration: Option<IterationChoice>,
}

object!(FootPoints, "an object with a job");

/// The parameters of the foot points of scattered points on a surface, or why there are none.
pub(in crate::model) fn on_surface(
    points: &Points,
    surface: Result<&Nurbs, ValidationError>,
) -> Result<Scattered, ValidationError> {
    match foot_points(surface?, points) {
        Ok(pairs) => Ok(Scattered::Given(pairs)),
        Err(reason) => Err(ValidationError::at(
            SpecPart::FootPoints,
            reason.to_string(),
        )),
    }
}

/// The error where other jobs are not available.
pub fn no_base() -> ValidationError {
    ValidationError::at(SpecPart::FootPoints, "other jobs are not known here")
}
