//! Enumerations of the contract and what they stand for.

use crate::fit::warning::Warning;
use crate::job::codes;
use crate::job::outline::Outline;
use crate::job::state::State;
use crate::model::mistakes::Mistake;
use crate::proto::messages as pb;
use crate::proto::values::known;

/// Which jobs to list.
pub fn wanted_state(value: i32) -> Result<Option<State>, Mistake> {
    let wanted: pb::JobState = known(value, "state")?;
    Ok(codes::state_of(wanted))
}

/// What is doubtful.
pub fn warning(warning: &Warning) -> pb::WarningCode {
    match warning {
        Warning::FewPoints { .. } => pb::WarningCode::FewPoints,
        Warning::EvenDegree { .. } => pb::WarningCode::EvenDegree,
        Warning::Rounding { .. } => pb::WarningCode::Rounding,
        Warning::ShorterInterval { .. } => pb::WarningCode::ShorterInterval,
        Warning::IllConditioned { .. } => pb::WarningCode::IllConditioned,
        Warning::WithoutData { .. } => pb::WarningCode::WithoutData,
        Warning::Outliers { .. } => pb::WarningCode::Outliers,
    }
}

/// A curve or a surface.
pub fn kind(outline: &Outline) -> pb::GeometryKind {
    match outline.surface {
        false => pb::GeometryKind::Curve,
        true => pb::GeometryKind::Surface,
    }
}
