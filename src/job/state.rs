//! The state machine of a job: `queued → running → converged | exhausted | stalled | failed | cancelled`.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

pub(crate) use piad_fit::engine::Reason;
use piad_fit::engine::{Forecast, Level};

/// The state of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum State {
    /// Accepted, and waiting for memory.
    Queued,
    /// Being computed.
    Running,
    /// Ended within the tolerance.
    Converged,
    /// Ended at `max_iterations`.
    Exhausted,
    /// Ended because the method cannot continue.
    Stalled,
    /// Ended because of an error.
    Failed,
    /// Ended because a client cancelled it.
    Cancelled,
}

impl State {
    /// All states, in the order of a job's life.
    pub(crate) const ALL: [Self; 7] = [
        Self::Queued,
        Self::Running,
        Self::Converged,
        Self::Exhausted,
        Self::Stalled,
        Self::Failed,
        Self::Cancelled,
    ];

    /// The name on the wire.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Converged => "converged",
            Self::Exhausted => "exhausted",
            Self::Stalled => "stalled",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Returns true if the job has ended.
    pub(crate) fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for State {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|state| state.name() == name)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                format!("unknown state {name:?}; expected one of {names}")
            })
    }
}

/// Why a job failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// The distances left the range of 64-bit floating-point numbers.
    Overflow,
    /// A bug of the program.
    Defect,
    /// The process has crashed several times while the job was running.
    Crashes,
}

/// The first and the last level that a job has reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Levels {
    /// Level 0.
    pub(crate) first: Level,
    /// The last level so far.
    pub(crate) last: Level,
    /// The forecast of the convergence.
    pub(crate) forecast: Forecast,
}

/// The state of a job and its progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Status {
    pub(crate) state: State,
    /// The levels reached, if any.
    pub(crate) levels: Option<Levels>,
    /// When it began to run.
    pub(crate) started: Option<Timestamp>,
    /// When it ended.
    pub(crate) finished: Option<Timestamp>,
    /// The reason of the end, if the state does not imply it.
    pub(crate) reason: Option<Reason>,
    /// Why it failed.
    pub(crate) failure: Option<Failure>,
}

impl Status {
    /// The status of a job that was just accepted.
    pub(crate) const QUEUED: Self = Self {
        state: State::Queued,
        levels: None,
        started: None,
        finished: None,
        reason: None,
        failure: None,
    };

    /// The status of a job that begins to run now.
    pub(crate) fn running() -> Self {
        Self {
            state: State::Running,
            started: Some(Timestamp::now()),
            ..Self::QUEUED
        }
    }
}
