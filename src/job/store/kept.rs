//! What stores keep of jobs, and their requests.

use std::collections::HashSet;
use std::time::Duration;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::job::outline::Outline;
use crate::job::peer::Peer;
use crate::job::quota::Exceeded;
use crate::job::state::{State, Status};
use crate::job::tenant::Tenant;

/// The most jobs that a store removes at once. Removal takes space on the disk before it frees some: where the disk is
/// nearly full, many jobs could not be removed together.
pub(crate) const FORGOTTEN_AT_ONCE: usize = 100;

/// The bytes of a secret.
pub(crate) type Secret = [u8; 32];

/// How long an idempotency key is remembered.
pub(crate) const KEY_LIFETIME: Duration = Duration::from_secs(24 * 60 * 60);

/// The record of a job, without its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// The job.
    pub outline: Outline,
    /// Its status.
    pub status: Status,
    /// The number of crashes of the process counted for it.
    pub crashes: u32,
    /// True if it was running in a crash, and is on probation.
    pub on_probation: bool,
}

impl Record {
    /// The record of a job that was just accepted.
    pub(crate) fn new(outline: Outline, status: Status) -> Self {
        Self {
            outline,
            status,
            crashes: 0,
            on_probation: false,
        }
    }
}

/// An idempotency key: the name by which a client recognises its request, with the owner, and a digest of the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct IdempotencyKey {
    /// The name.
    pub name: String,
    /// SHA-256 of the request.
    pub digest: [u8; 32],
}

impl IdempotencyKey {
    /// A key of a peer, under the name that it has chosen. Each peer has its own key space: no name contains a newline.
    pub(crate) fn new(peer: Option<Peer>, name: &str, digest: [u8; 32]) -> Self {
        let owner = peer.map_or_else(String::new, |peer| peer.to_string());
        Self {
            name: format!("{owner}\n{name}"),
            digest,
        }
    }
}

/// The entry of an idempotency key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct IdempotencyEntry {
    /// The job that was made.
    pub id: Uuid,
    /// The digest of the request that made it.
    pub digest: [u8; 32],
    /// When it was made.
    pub created: Timestamp,
}

impl IdempotencyEntry {
    /// Returns true if the key has expired at this time.
    pub(crate) fn has_expired(&self, now: Timestamp) -> bool {
        is_older(self.created, KEY_LIFETIME, now)
    }
}

/// The result of inserting a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Insertion {
    /// It is stored.
    New,
    /// There is an entry for the same key.
    Known(IdempotencyEntry),
    /// Its tenant would exceed its quota.
    Refused(Exceeded),
}

/// The jobs to list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Selection {
    /// Only jobs of this tenant.
    pub tenant: Option<Tenant>,
    /// Only jobs in this state.
    pub state: Option<State>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    /// The page size.
    pub limit: usize,
}

/// The retention of ended jobs: the first jobs to end are removed first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Retention {
    /// The most jobs that have ended.
    pub jobs: usize,
    /// The most bytes of their data and results.
    pub bytes: u64,
    /// How long they are kept after their end.
    pub age: Duration,
}

/// The oldest list of jobs in use that may be used for removal.
pub(crate) const LOOK_LIFETIME: Duration = Duration::from_secs(10 * 60);

/// The jobs in use, which stay although they are beyond the retention.
#[derive(Clone, Debug)]
pub(crate) struct Spared {
    /// Those in use.
    pub held: HashSet<Uuid>,
    /// When these were looked up, by [`Store::now`]. Jobs that have ended since then may be in use, too; not those of a
    /// clock that was far ahead.
    pub since: Timestamp,
}

impl Spared {
    /// Returns true if a job stays that ended at this time.
    pub(super) fn spares(&self, at: Timestamp, id: Uuid) -> bool {
        let after = Duration::try_from(at.duration_since(self.since));
        let is_new = after.is_ok_and(|after| !after.is_zero() && after <= LOOK_LIFETIME);
        is_new || self.held.contains(&id)
    }
}

/// Returns true if it was longer ago than this. A time in the future was not, so that a clock that was ahead removes
/// nothing.
pub(super) fn is_older(at: Timestamp, age: Duration, now: Timestamp) -> bool {
    let passed = now.duration_since(at);
    Duration::try_from(passed).is_ok_and(|passed| passed > age)
}
