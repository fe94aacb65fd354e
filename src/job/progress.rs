//! The progress of a job, and the reason of its end in words.

use super::outline::Outline;
use super::state::{Levels, State, Status};
use piad_fit::engine::{Reason, Warning};

impl Status {
    /// The reason of the end, in words, if the state does not imply it.
    pub(crate) fn detail(&self, outline: &Outline) -> Option<String> {
        let (reason, levels) = self.reason.zip(self.levels)?;
        Some(detail(reason, self, &levels, outline))
    }

    /// The progress of the fit, in [0, 1]. As PIA converges geometrically, this is `log(e₀/e) /
    /// log(e₀/tolerance)` with a tolerance; without one, the share of `max_iterations`.
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

/// Why a job ended, in words, with the largest remaining distance.
fn detail(reason: Reason, status: &Status, levels: &Levels, outline: &Outline) -> String {
    let (first, last) = (levels.first.error.max, levels.last.error.max);
    let tolerance = outline.tolerance;
    let left = format!("a distance of {last:.3e} is left, the tolerance is {tolerance:.3e}");
    match reason {
        Reason::Minimum if status.state == State::Converged => format!(
            "no step brings the fit nearer to all of the data: a distance of {last:.3e} is left, \
             and no tolerance was requested"
        ),
        Reason::Minimum if matches!(levels.last.found, Some(Warning::Folded(_))) => format!(
            "no step brings the fit nearer to all of the data, as their parameters fold: {left}; give other parameters"
        ),
        Reason::Minimum => {
            let advice = outline.method.advice_at_minimum();
            format!("no step brings the fit nearer to all of the data: {left}; {advice}")
        }
        Reason::Convexity => format!("no step keeps the convexity of the data: {left}"),
        Reason::Nilpotent if last > first => format!(
            "the extended method has ended, and rounding of the much larger intermediate distances has \
             spoilt it: {left}; use direct"
        ),
        Reason::Nilpotent => {
            format!(
                "the extended method has ended, and the remaining distances are rounding errors: {left}"
            )
        }
        Reason::Rounding => format!("distances no longer decrease, because of rounding: {left}"),
        Reason::Diverging => format!("distances grow, as the step is too long: {left}"),
        Reason::Between => match levels.last.found {
            Some(warning @ Warning::Between(_)) => {
                format!(
                    "the fit has converged at the data, but {}",
                    warning.detail()
                )
            }
            _ => format!(
                "a fit within the tolerance at the data deviates between them, and one that does \
                 not deviate is not within it: {left}; use a larger tolerance, fairness, or a \
                 number of control points"
            ),
        },
    }
}
