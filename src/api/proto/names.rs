//! Enumerations of the contract, and their values in the program.

use crate::job::state::{Reason, State};
use crate::model::errors::ValidationError;
use crate::proto::messages as pb;
use crate::proto::values::known;
use piad_fit::engine::Warning;

/// The jobs to list.
pub(crate) fn wanted_state(value: i32) -> Result<Option<State>, ValidationError> {
    let wanted: pb::JobState = known(value, "state")?;
    Ok(State::ALL.into_iter().find(|it| state(*it) == wanted))
}

/// The state of a job.
pub(crate) fn state(state: State) -> pb::JobState {
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

/// The reason of the end of a job, if the state does not imply it.
pub(crate) fn reason(reason: Option<Reason>) -> pb::EndReason {
    match reason {
        None => pb::EndReason::Unspecified,
        Some(Reason::Minimum) => pb::EndReason::Minimum,
        Some(Reason::Convexity) => pb::EndReason::Convexity,
        Some(Reason::Nilpotent) => pb::EndReason::Nilpotent,
        Some(Reason::Rounding) => pb::EndReason::Rounding,
        Some(Reason::Diverging) => pb::EndReason::Diverging,
        Some(Reason::Between) => pb::EndReason::Between,
    }
}

/// The kind of a warning.
pub(crate) fn warning(warning: &Warning) -> pb::WarningCode {
    match warning {
        Warning::FewPoints { .. } => pb::WarningCode::FewPoints,
        Warning::EvenDegree { .. } => pb::WarningCode::EvenDegree,
        Warning::Rounding { .. } => pb::WarningCode::Rounding,
        Warning::ShorterInterval { .. } => pb::WarningCode::ShorterInterval,
        Warning::IllConditioned { .. } => pb::WarningCode::IllConditioned,
        Warning::WithoutData { .. } => pb::WarningCode::WithoutData,
        Warning::Outliers { .. } => pb::WarningCode::Outliers,
        Warning::SlowSteps { .. } => pb::WarningCode::SlowSteps,
        Warning::ReversedTangent { .. } => pb::WarningCode::ReversedTangent,
        Warning::Unordered => pb::WarningCode::Unordered,
        Warning::NoData { .. } => pb::WarningCode::NoDataValue,
        Warning::Between(_) => pb::WarningCode::BetweenPoints,
        Warning::Folded(_) => pb::WarningCode::FoldedParameters,
        Warning::Spikes { .. } => pb::WarningCode::Spikes,
        Warning::RoundedCorners { .. } => pb::WarningCode::RoundedCorners,
    }
}

/// A curve or a surface.
pub(crate) fn kind(surface: bool) -> pb::GeometryKind {
    match surface {
        false => pb::GeometryKind::Curve,
        true => pb::GeometryKind::Surface,
    }
}
