//! The state machine of a job: `queued → running → converged | exhausted | stalled | failed | cancelled`.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use super::outline::Outline;
use crate::fit::iteration::Level;
use crate::fit::system::Forecast;
pub(crate) use crate::fit::termination::Reason;
use crate::fit::warning::Warning;

/// Where a job is in its life.
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
    /// Ended because the method cannot go on.
    Stalled,
    /// Ended because of an error.
    Failed,
    /// Ended because a client asked for it.
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

    /// Whether the job has ended.
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
                format!("no state is called {name:?}; the states are {names}")
            })
    }
}

/// Why a job failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// The distances left the range of 64-bit floating-point numbers.
    Overflow,
    /// A defect of the program.
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
    /// What is known about the convergence.
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
    /// Why it ended, where the state does not say it.
    pub(crate) reason: Option<Reason>,
    /// Why it failed.
    pub(crate) failure: Option<Failure>,
}

/// Why a job ended, in words, with the largest distance that is left.
fn detail(reason: Reason, status: &Status, levels: &Levels, outline: &Outline) -> String {
    let (first, last) = (levels.first.error.max, levels.last.error.max);
    let tolerance = outline.tolerance;
    let left = format!("a distance of {last:.3e} is left, the tolerance is {tolerance:.3e}");
    match reason {
        Reason::Minimum if status.state == State::Converged => format!(
            "no step brings the fit nearer to all of the data: a distance of {last:.3e} is left, and no tolerance was \
             asked for"
        ),
        Reason::Minimum if matches!(levels.last.found, Some(Warning::Folded(_))) => format!(
            "no step brings the fit nearer to all of the data, as their parameters fold: {left}; give other parameters"
        ),
        Reason::Minimum => {
            let advice = outline.method.advice_at_minimum();
            format!("no step brings the fit nearer to all of the data: {left}; {advice}")
        }
        Reason::Convexity => format!("no step keeps the turns of the data: {left}"),
        Reason::Nilpotent if last > first => format!(
            "the extended method has come to its end, and rounding of the much larger distances in between has \
             spoilt it: {left}; use direct"
        ),
        Reason::Nilpotent => {
            format!("the extended method has come to its end, and what is left is rounding: {left}")
        }
        Reason::Rounding => format!("distances do not fall any more, for rounding: {left}"),
        Reason::Diverging => format!("distances grow, as the step is too long: {left}"),
        Reason::Between => match levels.last.found {
            Some(Warning::Between(excursion)) => format!(
                "the fit is within the tolerance at the data, but {excursion}: use a larger tolerance, fairness, or a \
                 number of control points"
            ),
            _ => format!(
                "a fit within the tolerance at the data leaves them where there are none, and one that does not is not \
                 within it: {left}; use a larger tolerance, fairness, or a number of control points"
            ),
        },
    }
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

    /// Why it ended, in words, where the state does not say it.
    pub(crate) fn detail(&self, outline: &Outline) -> Option<String> {
        let (reason, levels) = self.reason.zip(self.levels)?;
        Some(detail(reason, self, &levels, outline))
    }

    /// How far the fit has come, in [0, 1]. As PIA converges geometrically, this is
    /// `log(e₀/e) / log(e₀/tolerance)` with a tolerance; without one, the share of `max_iterations`.
    pub(crate) fn progress(&self, outline: &Outline) -> f64 {
        if matches!(
            self.state,
            State::Converged | State::Exhausted | State::Stalled
        ) {
            return 1.0;
        }
        let Some(Levels { first, last, .. }) = self.levels else {
            return 0.0;
        };
        let (initial, current) = (first.error.max, last.error.max);
        let tolerance = outline.tolerance;
        let progress = if current <= tolerance {
            1.0
        } else if tolerance > 0.0 {
            (initial / current).ln() / (initial / tolerance).ln()
        } else {
            last.iteration as f64 / outline.max_iterations.max(1) as f64
        };
        // Errors may grow for a while, and a fit that diverges gives NaN.
        if progress.is_nan() {
            0.0
        } else {
            progress.clamp(0.0, 1.0)
        }
    }
}
