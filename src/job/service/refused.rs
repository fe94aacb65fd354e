//! Why a job is not accepted.

use thiserror::Error;
use uuid::Uuid;

use crate::fit::problem::Problem;
use crate::job::slots::NoSlot;
use crate::job::store::StoreError;

/// The most multiplications of an iteration; they take a second or two.
const MOST_OF_A_STEP: usize = 2_000_000_000;

/// The most multiplications before the first iteration. They have the long lane and take some seconds.
const MOST_OF_A_START: usize = 20_000_000_000;

/// Why a job was not accepted.
#[derive(Clone, Debug, Error)]
pub enum Refused {
    /// There are as many unfinished jobs as are allowed.
    #[error("{limit} jobs are unfinished, the limit of this server")]
    Full { limit: usize },
    /// The peer has as many unfinished jobs as one may have.
    #[error("{limit} jobs from your address are unfinished, the limit of this server for each")]
    PeerFull { limit: usize },
    /// It needs more memory than all jobs together may have.
    #[error("the fit needs {needed} bytes of memory, and all fits together may take {limit}")]
    TooLarge {
        /// Bytes needed.
        needed: usize,
        /// The limit in bytes.
        limit: usize,
    },
    /// A step that cannot be interrupted would take too long.
    #[error(
        "{what} takes about {needed:.0e} multiplications, and this server computes at most {limit:.0e} \
         in one piece: choose a lower degree or fewer points"
    )]
    TooMuchWork {
        /// The piece.
        what: &'static str,
        /// Multiplications of the piece.
        needed: f64,
        /// The most that are done.
        limit: f64,
    },
    /// The idempotency key was used for another request.
    #[error("the key was used for another request, which made job {0}")]
    KeyTaken(Uuid),
    /// It could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<NoSlot> for Refused {
    fn from(no_slot: NoSlot) -> Self {
        match no_slot {
            NoSlot::All(limit) => Self::Full { limit },
            NoSlot::PerPeer(limit) => Self::PeerFull { limit },
        }
    }
}

/// Refuses fits with steps so long that other jobs, and those who cancel this one, would wait for seconds.
pub(super) fn check_work(problem: &Problem) -> Result<(), Refused> {
    let pieces = [
        ("an iteration", problem.step_cost(), MOST_OF_A_STEP),
        ("preparing the fit", problem.start_cost(), MOST_OF_A_START),
    ];
    match pieces.into_iter().find(|(_, needed, limit)| needed > limit) {
        None => Ok(()),
        Some((what, needed, limit)) => Err(Refused::TooMuchWork {
            what,
            needed: needed as f64,
            limit: limit as f64,
        }),
    }
}
