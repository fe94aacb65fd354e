//! The JSON of the rules when an iteration ends.

use schemars::JsonSchema;

use super::invalid::invalid;
use super::mistakes::{DEFAULT_TOLERANCE, Mistakes};
use super::schema;
use crate::api::json::read::object;
use crate::api::json::read::values::{Count, Number};
use crate::api::problem::Problem;
use crate::fit::problem::Tolerance;

const DEFAULT_ITERATIONS: usize = 1000;

/// When the iteration ends. There is one of the tolerances, or none.
#[derive(Debug, Default, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "StopRules", example = schema::example_stop())]
pub(in crate::api) struct StopRequest {
    /// The largest allowed distance from a data point, in data units.
    #[schemars(range(min = 0))]
    pub(in crate::api) tolerance: Option<Number>,
    /// The same as a part of the diagonal of the bounding box of the data.
    #[schemars(range(min = 0), extend("default" = 1e-6))]
    pub(in crate::api) relative_tolerance: Option<Number>,
    /// The last iteration that is computed. Servers have a limit, which /v1/capabilities tells.
    #[schemars(extend("default" = DEFAULT_ITERATIONS))]
    pub(in crate::api) max_iterations: Option<Count>,
}

object!(
    StopRequest,
    "an object",
    [tolerance, relative_tolerance, max_iterations]
);
impl StopRequest {
    pub(super) fn rules(&self, most_iterations: usize) -> Result<(Tolerance, usize), Problem> {
        let mut mistakes = Mistakes::default();
        let tolerance = match (self.tolerance, self.relative_tolerance) {
            (None, None) => Ok(DEFAULT_TOLERANCE),
            (Some(Number(value)), None) => Ok(Tolerance::Absolute(value)),
            (None, Some(Number(value))) => Ok(Tolerance::Relative(value)),
            (Some(_), Some(_)) => {
                let detail = "tolerance is given, so relative_tolerance cannot be";
                Err(invalid("/stop/relative_tolerance", detail))
            }
        };
        let tolerance = mistakes.keep(tolerance);
        let usual = DEFAULT_ITERATIONS.min(most_iterations);
        let max_iterations = self.max_iterations.map_or(usual, |Count(count)| count);
        if max_iterations > most_iterations {
            let detail = format!(
                "{max_iterations} iterations are more than {most_iterations}, the limit of this server"
            );
            mistakes.keep::<()>(Err(invalid("/stop/max_iterations", detail)));
        }
        match tolerance.filter(|_| mistakes.none()) {
            Some(tolerance) => Ok((tolerance, max_iterations)),
            None => Err(mistakes.problem()),
        }
    }
}
