//! Reasons to refuse a job.

use thiserror::Error;
use uuid::Uuid;

use crate::job::quota::Exceeded;
use crate::job::slots::NoSlot;
use crate::job::store::StoreError;

/// Why a job was refused.
#[derive(Clone, Debug, Error)]
pub enum Refused {
    /// There are as many unfinished jobs as allowed.
    #[error("{limit} jobs are unfinished, the limit of this server")]
    Full { limit: usize },
    /// The peer has as many unfinished jobs as allowed.
    #[error("{limit} of your jobs are unfinished, the limit for one client now")]
    PeerFull { limit: usize },
    /// The tenant has reached its quota.
    #[error(transparent)]
    Quota(#[from] Exceeded),
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
