//! Admission: the cost of a fit, known from its sizes before anything is computed.

use crate::invalid::{Invalid, Place};

/// Limits of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Admission {
    /// Bytes of a fit with small steps.
    pub quick: usize,
    /// Bytes of a fit with larger steps.
    pub heavy: usize,
    /// The multiplications of an iteration up to which steps are small.
    pub small_step: usize,
    /// Multiplications of an iteration, which is not interrupted.
    pub step: usize,
    /// Multiplications before the first iteration.
    pub start: usize,
}

impl Admission {
    /// Everything is admitted: it was admitted before, or there is no other user.
    pub const ANY: Self = Self {
        quick: usize::MAX,
        heavy: usize::MAX,
        small_step: 0,
        step: usize::MAX,
        start: usize::MAX,
    };

    /// Refuses a fit that needs more: bytes, and multiplications of an iteration and before the
    /// first one.
    pub(crate) fn check(&self, needed: usize, step: usize, start: usize) -> Result<(), Invalid> {
        let limit = match step <= self.small_step {
            true => self.quick,
            false => self.heavy,
        };
        if needed > limit {
            return Err(Invalid::at(
                Place::Whole,
                format!(
                    "the fit needs {needed} bytes of memory, and all fits together may take {limit}"
                ),
            ));
        }
        let pieces = [
            ("an iteration", step, self.step),
            ("preparing the fit", start, self.start),
        ];
        match pieces.into_iter().find(|(_, needed, limit)| needed > limit) {
            None => Ok(()),
            // Other fits, and clients that cancel it, would wait for seconds.
            Some((what, needed, limit)) => {
                let [needed, limit] = [needed, limit].map(|it| it as f64);
                let detail = format!(
                    "{what} takes about {needed:.0e} multiplications, and the limit is {limit:.0e}: choose a lower degree or fewer points"
                );
                Err(Invalid::at(Place::Whole, detail))
            }
        }
    }
}
