//! Where jobs are kept: their problems, states and final control points. Frames are not.

pub mod memory;

use std::sync::Arc;

use async_trait::async_trait;
use jiff::Timestamp;
use thiserror::Error;
use uuid::Uuid;

use super::state::{State, Status};
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// A job as it is kept.
#[derive(Clone, Debug)]
pub struct Record {
    /// The id; ids grow with time.
    pub id: Uuid,
    /// The client's name for the job.
    pub name: Option<String>,
    /// When it was accepted.
    pub created: Timestamp,
    /// The problem.
    pub problem: Arc<Problem>,
    /// The state.
    pub status: Status,
    /// The free control points of the last level, once it has ended.
    pub result: Option<Arc<Points>>,
}

/// Which jobs to list.
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    /// Only jobs in this state.
    pub state: Option<State>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    /// At most so many.
    pub limit: usize,
}

/// How much of the past is kept.
#[derive(Clone, Copy, Debug)]
pub struct Retention {
    /// Jobs that have ended.
    pub jobs: usize,
    /// Bytes of their data and results.
    pub bytes: usize,
}

/// The store did not do what it was asked for.
#[derive(Clone, Debug, Error)]
#[error("the store failed: {0}")]
pub struct StoreError(pub String);

/// Keeps jobs. What a method has returned from is kept as well as the store can keep it.
#[async_trait]
pub trait Store: Send + Sync {
    /// Keeps a new job.
    async fn insert(&self, record: Record) -> Result<(), StoreError>;

    /// Keeps the state of a job. A job that is gone stays gone.
    async fn update(&self, id: Uuid, status: Status) -> Result<(), StoreError>;

    /// Keeps the final state and control points of a job. A job that is gone stays gone.
    async fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<Arc<Points>>,
    ) -> Result<(), StoreError>;

    /// The job of this id.
    async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError>;

    /// Jobs, the newest first.
    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError>;

    /// Forgets a job; says whether there was one.
    async fn remove(&self, id: Uuid) -> Result<bool, StoreError>;

    /// Forgets jobs that have ended, the first to end first, until the rest is within `retention`.
    async fn retain(&self, retention: Retention) -> Result<Vec<Uuid>, StoreError>;
}
