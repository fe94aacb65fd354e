//! Changes of the store, and what comes of them.

use std::collections::HashSet;
use std::sync::Arc;

use uuid::Uuid;

use super::super::{IdempotencyEntry, IdempotencyKey, Record, Retention};
use crate::fit::problem::Problem;
use crate::job::result::LastGeometry;
use crate::job::state::Status;

/// A change of the store.
pub(super) enum Change {
    Insert {
        record: Box<Record>,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
    },
    Start {
        id: Uuid,
        status: Status,
        on_probation: bool,
    },
    Requeue {
        id: Uuid,
    },
    Finish {
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    },
    Remove {
        id: Uuid,
    },
    Retain {
        retention: Retention,
        spared: HashSet<Uuid>,
    },
    /// Nothing: its reply comes after the changes before it.
    Nothing,
}

/// What has come of a change.
pub(super) enum Outcome {
    Done,
    /// There is a job for the key already.
    Existing(IdempotencyEntry),
    /// Whether there was a job to be removed.
    Removed(bool),
    /// The jobs that were forgotten.
    Forgotten(Vec<Uuid>),
}

impl Change {
    /// Whether it needs more than a few pages of the file. Others must be possible when the disk is full.
    pub(super) fn adds(&self) -> bool {
        self.points() > 0
    }

    /// How many points it writes.
    pub(super) fn points(&self) -> usize {
        match self {
            Self::Insert { problem, .. } => problem.grid().count(),
            Self::Finish { result, .. } => result.as_ref().map_or(0, |it| it.control_points.len()),
            _ => 0,
        }
    }
}
