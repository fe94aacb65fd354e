//! When an iteration ends, as far as a client says it.

use super::mistakes::{Mistake, Mistakes, OrMistakes, SpecPart};
use crate::fit::problem::Tolerance;

/// The last iteration that is computed if nobody says it, and the server computes as many.
pub const DEFAULT_ITERATIONS: usize = 1000;

/// When an iteration ends.
#[derive(Clone, Debug)]
pub struct StopSpec {
    /// The largest allowed distance.
    pub tolerance: OrMistakes<Option<Tolerance>>,
    /// The last iteration that is computed.
    pub max_iterations: Option<usize>,
}

impl Default for StopSpec {
    fn default() -> Self {
        Self {
            tolerance: Ok(None),
            max_iterations: None,
        }
    }
}

/// When an iteration ends.
#[derive(Clone, Copy, Debug)]
pub struct StopRules {
    /// The largest allowed distance, if it was asked for.
    pub tolerance: Option<Tolerance>,
    /// The last iteration that is computed.
    pub max_iterations: usize,
}

impl StopSpec {
    /// The rules, with what is usual where nothing is said, and where it is wrong.
    pub fn rules(self, most_iterations: usize, mistakes: &mut Mistakes) -> StopRules {
        let tolerance = mistakes.keep(self.tolerance).flatten();
        let usual = DEFAULT_ITERATIONS.min(most_iterations);
        let max_iterations = self.max_iterations.unwrap_or(usual);
        if max_iterations > most_iterations {
            let detail = format!(
                "{max_iterations} iterations are more than {most_iterations}, the limit of this server"
            );
            mistakes.push(Mistake::at(SpecPart::MaxIterations, detail));
        }
        StopRules {
            tolerance,
            max_iterations,
        }
    }
}
