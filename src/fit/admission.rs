//! What a fit may take: known from its sizes, before anything of it is computed.

use thiserror::Error;

use super::problem::Problem;

/// The most that a fit may take.
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

/// What is too much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[allow(missing_docs, reason = "fields are the values that the messages name")]
pub enum TooMuch {
    /// It would never get its memory.
    #[error("the fit needs {needed} bytes of memory, and all fits together may take {limit}")]
    Memory { needed: usize, limit: usize },
    /// Others, and those who cancel it, would wait for seconds.
    #[error(
        "{what} takes about {:.0e} multiplications, and this server computes at most {:.0e} \
         in one piece: choose a lower degree or fewer points", *needed as f64, *limit as f64
    )]
    Work {
        what: &'static str,
        needed: usize,
        limit: usize,
    },
}

impl Admission {
    /// Everything is admitted: it was before, or there is nobody else.
    pub const ANY: Self = Self {
        quick: usize::MAX,
        heavy: usize::MAX,
        small_step: 0,
        step: usize::MAX,
        start: usize::MAX,
    };

    /// Refuses a problem that takes more.
    pub(super) fn check(&self, problem: &Problem) -> Result<(), TooMuch> {
        let step = problem.step_cost();
        let limit = match step <= self.small_step {
            true => self.quick,
            false => self.heavy,
        };
        let needed = problem.memory();
        if needed > limit {
            return Err(TooMuch::Memory { needed, limit });
        }
        let pieces = [
            ("an iteration", step, self.step),
            ("preparing the fit", problem.start_cost(), self.start),
        ];
        match pieces.into_iter().find(|(_, needed, limit)| needed > limit) {
            None => Ok(()),
            Some((what, needed, limit)) => Err(TooMuch::Work {
                what,
                needed,
                limit,
            }),
        }
    }
}
