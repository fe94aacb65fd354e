//! The outline of a job: everything but its points, for lists and for admission.

use std::sync::Arc;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::job::peer::Peer;
use crate::job::quota::Amount;
use crate::job::state::Levels;
use crate::job::tenant::Tenant;
use crate::model::stream::StreamSpec;
use piad_fit::data::Grid;
use piad_fit::engine::{KERNEL, Problem, Warning};
use piad_fit::method::Method;

/// A job without its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Outline {
    /// The id; ids grow with time.
    pub(crate) id: Uuid,
    /// To whom it belongs.
    pub(crate) tenant: Tenant,
    /// Name, parent and stream defaults, as the client gave them.
    pub(crate) label: Label,
    /// When it was accepted.
    pub(crate) created: Timestamp,
    /// Whether it is a surface.
    pub(crate) surface: bool,
    /// The arrangement of the data points.
    pub(crate) grid: Grid,
    /// The method, without the lists of its settings.
    pub(crate) method: Method,
    /// Local fits: how many control points may move.
    pub(crate) adjusted: Option<usize>,
    /// The largest allowed distance of the curve from a data point, in data units.
    pub(crate) tolerance: f64,
    /// The last level that is computed.
    pub(crate) max_iterations: usize,
    /// Bytes that running it takes.
    pub(crate) memory: usize,
    /// Multiplications of one iteration.
    pub(crate) step_cost: usize,
    /// The warnings when it was accepted.
    pub(super) warnings: Vec<Warning>,
    /// Surfaces: the bases of both directions were asked for separately.
    pub(crate) bases_differ: bool,
    /// The kernel of the program that accepted it.
    pub(crate) kernel: u32,
}

/// What a client says about a job besides the problem.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Label {
    /// The client's name for the job.
    pub(crate) name: Option<String>,
    /// The job and level that it started from, if it is an edit.
    pub(crate) parent: Option<Parent>,
    /// The defaults of its streams.
    pub(crate) stream: Option<Arc<StreamSpec>>,
    /// What was understood of the file that its points come from, in sentences.
    #[serde(default)]
    pub(crate) notices: Vec<String>,
}

/// The level of another job from whose control points a job has started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Parent {
    /// The other job.
    pub(crate) id: Uuid,
    /// Its level.
    pub(crate) iteration: usize,
}

impl Outline {
    /// The outline of a new job that a peer has asked for.
    pub(crate) fn new(label: Label, problem: &Problem, peer: Option<Peer>) -> Self {
        let adjusted = || {
            let all = problem.grid().count();
            problem.selected().map_or(all, <[usize]>::len)
        };
        Self {
            id: Uuid::now_v7(),
            tenant: Peer::owner(peer),
            label,
            created: Timestamp::now(),
            surface: problem.v().is_some(),
            grid: problem.grid(),
            method: problem.method().outline(),
            adjusted: matches!(problem.method(), Method::Local(_)).then(adjusted),
            tolerance: problem.tolerance(),
            max_iterations: problem.max_iterations(),
            memory: problem.memory(),
            step_cost: problem.step_cost(),
            warnings: problem.warnings(),
            bases_differ: problem.bases_differ(),
            kernel: KERNEL,
        }
    }

    /// What it takes of the quota of its tenant until it has ended, besides bytes.
    pub(super) fn amount(&self) -> Amount {
        Amount {
            jobs: 1,
            points: self.grid.count() as u64,
            bytes: 0,
        }
    }

    /// All warnings so far; some are found only when the job runs.
    pub(crate) fn warnings(&self, levels: Option<&Levels>) -> impl Iterator<Item = Warning> {
        let found = levels.map(|levels| {
            let Levels {
                forecast,
                first,
                last,
            } = levels;
            let of_method = self
                .method
                .warnings(forecast, first.predicted, self.max_iterations);
            of_method.into_iter().chain(last.found)
        });
        self.warnings
            .clone()
            .into_iter()
            .chain(found.into_iter().flatten())
    }
}
