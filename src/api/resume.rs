//! The iteration from which a stream continues.
//!
//! Iterations are computed again when they are read. A program with another [`KERNEL`] computes other bits, so it
//! cannot continue an earlier stream: it restarts at iteration 0, and reports that. The id of an iteration names its
//! kernel.

use std::fmt;

use super::parse_uint::plain_number;
use crate::job::Job;
use crate::job::state::{Failure, State};
use piad_files::text::quoted;
use piad_fit::engine::KERNEL;

/// The id of the last event.
pub(crate) const END: &str = "end";

/// The start of the events of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// At iteration 0.
    First,
    /// After this iteration.
    After(usize),
    /// At iteration 0, although the reader has iterations of another kernel.
    Again,
}

/// The events that a client has received.
pub(crate) enum LastEvent {
    /// An iteration, and where that leaves the stream.
    Iteration(Start),
    /// All events.
    End,
}

/// The id of an iteration: its number, and the kernel if that is not the one with which the job was accepted
/// (`7@2`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct EventId {
    /// The number.
    pub k: usize,
    /// The other kernel.
    pub kernel: Option<u32>,
}

impl EventId {
    /// The id of an iteration that is computed here.
    pub(crate) fn new(job: &Job, k: usize) -> Self {
        let kernel = Some(KERNEL).filter(|here| *here != job.outline().kernel);
        Self { k, kernel }
    }

    fn parse(text: &str) -> Option<Self> {
        let (k, kernel) = match text.split_once('@') {
            None => (text, None),
            Some((k, kernel)) => (k, Some(plain_number(kernel)?)),
        };
        Some(Self {
            k: plain_number(k)?,
            kernel: kernel.map(u32::try_from).transpose().ok()?,
        })
    }
}

impl fmt::Display for EventId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { k, kernel } = self;
        match kernel {
            None => write!(f, "{k}"),
            Some(kernel) => write!(f, "{k}@{kernel}"),
        }
    }
}

/// The event of a job with this id; `None` for an empty id. The error gives the reason.
pub(crate) fn last_event(job: &Job, id: Option<&str>) -> Result<Option<LastEvent>, String> {
    match id {
        None | Some("") => Ok(None),
        Some(END) => Ok(Some(LastEvent::End)),
        Some(text) => {
            let id = EventId::parse(text).ok_or_else(|| {
                let id = quoted(text);
                format!(
                    "{id} is not an event id; expected an iteration number, such as 7 or 7@2, or \"end\""
                )
            })?;
            Ok(Some(LastEvent::Iteration(after(job, id)?)))
        }
    }
}

/// The continuation of a stream for a client that has iteration k.
pub(crate) fn after_iteration(job: &Job, k: usize) -> Result<Start, String> {
    after(job, EventId { k, kernel: None })
}

fn after(job: &Job, id: EventId) -> Result<Start, String> {
    match id.kernel.unwrap_or(job.outline().kernel) == KERNEL {
        true => check_seen(job, id.k).map(|()| Start::After(id.k)),
        false => Ok(Start::Again),
    }
}

/// Checks that a job can have had an iteration that a client claims to have received. A job that runs again after a
/// restart, or that was cancelled then, may have been further before.
fn check_seen(job: &Job, k: usize) -> Result<(), String> {
    let status = job.status();
    let ended_by_itself = match status.state {
        State::Converged | State::Exhausted | State::Stalled => true,
        State::Failed => status.failure == Some(Failure::Overflow),
        State::Queued | State::Running | State::Cancelled => false,
    };
    let last = status.levels.map(|levels| levels.last.iteration);
    let (most, why) = match last.filter(|_| ended_by_itself) {
        Some(last) => (last, "it ended at"),
        None => (job.outline().max_iterations, "it computes at most"),
    };
    match k > most {
        true => Err(format!("the job has no iteration {k}: {why} {most}")),
        false => Ok(()),
    }
}
