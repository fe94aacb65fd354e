//! The states and the ends of jobs in messages: in answers and in the store.

use super::state::{Reason, State};
use crate::proto::messages as pb;

/// The message of a state.
pub fn state(state: State) -> pb::JobState {
    match state {
        State::Queued => pb::JobState::Queued,
        State::Running => pb::JobState::Running,
        State::Converged => pb::JobState::Converged,
        State::Exhausted => pb::JobState::Exhausted,
        State::Stalled => pb::JobState::Stalled,
        State::Failed => pb::JobState::Failed,
        State::Cancelled => pb::JobState::Cancelled,
    }
}

/// The state of a message, if it says one.
pub fn state_of(message: pb::JobState) -> Option<State> {
    State::ALL.into_iter().find(|it| state(*it) == message)
}

/// The message of why a job has ended.
pub fn reason(reason: Option<Reason>) -> pb::EndReason {
    match reason {
        None => pb::EndReason::Unspecified,
        Some(Reason::Minimum) => pb::EndReason::Minimum,
        Some(Reason::Convexity) => pb::EndReason::Convexity,
        Some(Reason::Nilpotent) => pb::EndReason::Nilpotent,
        Some(Reason::Rounding) => pb::EndReason::Rounding,
        Some(Reason::Diverging) => pb::EndReason::Diverging,
    }
}

/// Why a job has ended, by its message.
pub fn reason_of(message: pb::EndReason) -> Option<Reason> {
    let mut all = Reason::ALL.into_iter();
    all.find(|it| reason(Some(*it)) == message)
}
