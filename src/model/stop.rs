//! The requested end of an iteration.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::{SpecPart, ValidationError, ValidationErrors};
use super::schema;
use super::serde_helpers::{object, whole};
use piad_fit::engine::{Request, Tolerance};
use piad_fit::invalid as fit;

/// The default last iteration, unless the server's limit is lower.
pub(crate) const DEFAULT_ITERATIONS: usize = 1000;

/// When the iteration ends. There is one of the tolerances, or none.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_stop())]
pub(crate) struct StopRules {
    /// The largest allowed distance from a data point, in data units.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub tolerance: Option<f64>,
    /// The same as a part of the diagonal of the bounding box of the data.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0), extend("default" = 1e-6))]
    pub relative_tolerance: Option<f64>,
    /// The last iteration that is computed. /v1/capabilities returns the server's limit.
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(extend("default" = DEFAULT_ITERATIONS))]
    pub max_iterations: Option<usize>,
}

object!(StopRules, "an object");

impl StopRules {
    /// The stop rules of a problem.
    pub(super) fn of(request: &Request) -> Self {
        let (tolerance, relative_tolerance) = match request.tolerance {
            None => (None, None),
            Some(Tolerance::Absolute(value)) => (Some(value), None),
            Some(Tolerance::Relative(value)) => (None, Some(value)),
        };
        Self {
            tolerance,
            relative_tolerance,
            max_iterations: Some(request.max_iterations),
        }
    }

    /// The largest allowed distance and the last iteration that is computed, with defaults filled in.
    pub(super) fn resolve(
        self,
        most_iterations: usize,
        errors: &mut ValidationErrors,
    ) -> (Option<Tolerance>, usize) {
        let tolerance = match (self.tolerance, self.relative_tolerance) {
            (None, relative) => relative.map(Tolerance::Relative),
            (Some(value), None) => Some(Tolerance::Absolute(value)),
            (Some(_), Some(_)) => {
                let place = SpecPart::Fit(fit::Place::RelativeTolerance);
                let detail = "tolerance is given, so relative_tolerance cannot be";
                errors.push(ValidationError::at(place, detail));
                None
            }
        };
        let usual = DEFAULT_ITERATIONS.min(most_iterations);
        let max_iterations = self.max_iterations.unwrap_or(usual);
        if max_iterations > most_iterations {
            let detail = format!(
                "{max_iterations} iterations are more than {most_iterations}, the limit of this server"
            );
            errors.push(ValidationError::at(SpecPart::MaxIterations, detail));
        }
        (tolerance, max_iterations)
    }
}
