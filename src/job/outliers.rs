//! The points that a robust fit leaves out.

use schemars::JsonSchema;
use serde::Serialize;

use piad_fit::engine::Problem;

/// The most that are listed.
const MOST_LISTED: usize = 1000;

/// The points that a robust fit leaves out.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"count": 2, "indices": [41, 97]}]))]
pub(crate) struct Outliers<'a> {
    /// The number of them.
    pub(crate) count: usize,
    /// Their indices, at most the first 1000.
    pub(crate) indices: &'a [usize],
}

impl<'a> Outliers<'a> {
    /// The outliers of a fit; `None` if it has none.
    pub(crate) fn of(problem: &'a Problem) -> Option<Self> {
        let all = problem.outliers();
        (!all.is_empty()).then(|| Self {
            count: all.len(),
            indices: &all[..all.len().min(MOST_LISTED)],
        })
    }
}
