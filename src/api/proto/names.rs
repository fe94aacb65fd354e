//! Numbers and enumerations of the contract and what they stand for.

use super::messages as pb;
use crate::api::problem::Problem;
use crate::fit::basis::{Basis, Polynomial};
use crate::fit::direction::{BasisChoice, Direction};
use crate::fit::outcome::Stall;
use crate::fit::problem as fit;
use crate::fit::warning::Warning;
use crate::job::outline::Outline;
use crate::job::state::{Reason, State};

/// Numbers of points, which are limited by what a request can carry.
pub fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// A list that is given.
pub fn some<T>(list: Vec<T>) -> Option<Vec<T>> {
    (!list.is_empty()).then_some(list)
}

/// The value of an enumeration; values that are not known are errors of this field.
pub fn known<E: TryFrom<i32>>(value: i32, field: &str) -> Result<E, Problem> {
    E::try_from(value).map_err(|_| {
        let detail = format!("{value} is no value of this enumeration");
        Problem::at_field(field, detail)
    })
}

/// The state of a job.
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

/// Which jobs to list.
pub fn wanted_state(value: i32) -> Result<Option<State>, Problem> {
    let wanted: pb::JobState = known(value, "state")?;
    Ok(State::ALL.into_iter().find(|it| state(*it) == wanted))
}

/// Why a job has ended.
pub fn reason(reason: Option<Reason>) -> pb::EndReason {
    match reason {
        None => pb::EndReason::Unspecified,
        Some(Reason::Stationary) => pb::EndReason::Stationary,
        Some(Reason::Stalled(stall)) => match stall {
            Stall::Convexity => pb::EndReason::Convexity,
            Stall::Nilpotent => pb::EndReason::Nilpotent,
            Stall::Rounding => pb::EndReason::Rounding,
            Stall::Diverging => pb::EndReason::Diverging,
        },
    }
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
    }
}

/// A curve or a surface.
pub fn kind(outline: &Outline) -> pb::GeometryKind {
    match outline.surface {
        false => pb::GeometryKind::Curve,
        true => pb::GeometryKind::Surface,
    }
}

/// How the weights of a fit are used.
pub fn rational(problem: &fit::Problem) -> pb::Rational {
    if problem.is_homogeneous() {
        pb::Rational::Homogeneous
    } else if problem.directions().any(Direction::is_rational) {
        pb::Rational::Fixed
    } else {
        pb::Rational::Unspecified
    }
}

/// The kind of a basis.
pub fn basis(basis: &Basis) -> pb::BasisKind {
    match basis.name() {
        "bernstein" => pb::BasisKind::Bernstein,
        "said_ball" => pb::BasisKind::SaidBall,
        "wang_ball" => pb::BasisKind::WangBall,
        _ => pb::BasisKind::Bspline,
    }
}

/// The kind of a basis that was asked for.
pub fn basis_choice(choice: &BasisChoice) -> pb::BasisKind {
    match choice {
        BasisChoice::BSpline { .. } => pb::BasisKind::Bspline,
        BasisChoice::Polynomial(Polynomial::Bernstein) => pb::BasisKind::Bernstein,
        BasisChoice::Polynomial(Polynomial::SaidBall) => pb::BasisKind::SaidBall,
        BasisChoice::Polynomial(Polynomial::WangBall) => pb::BasisKind::WangBall,
    }
}
