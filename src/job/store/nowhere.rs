//! The store of an ephemeral fit, which keeps nothing.

use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

use async_trait::async_trait;
use futures_util::FutureExt;
use uuid::Uuid;

use super::{
    Acknowledgement, IdempotencyEntry, IdempotencyKey, Record, Retention, Selection, Store,
    StoreError,
};
use crate::fit::problem::Problem;
use crate::job::result::LastGeometry;
use crate::job::state::Status;

/// Takes every change and forgets it, but for the result of its one job. No other promise of a store
/// holds here: the job is in memory as long as it is read.
#[derive(Debug, Default)]
pub struct Nowhere(OnceLock<LastGeometry>);

fn done<T: Send + 'static>(value: T) -> Acknowledgement<T> {
    std::future::ready(Ok(value)).boxed()
}

#[async_trait]
impl Store for Nowhere {
    fn insert(
        &self,
        _: Record,
        _: Arc<Problem>,
        _: Option<IdempotencyKey>,
    ) -> Acknowledgement<Option<IdempotencyEntry>> {
        done(None)
    }

    fn start(&self, _: Uuid, _: Status, _: bool) -> Acknowledgement<()> {
        done(())
    }

    fn requeue(&self, _: Uuid) -> Acknowledgement<()> {
        done(())
    }

    fn finish(&self, _: Uuid, _: Status, result: Option<LastGeometry>) -> Acknowledgement<()> {
        if let Some(result) = result {
            // A job ends once.
            let _ = self.0.set(result);
        }
        done(())
    }

    fn remove(&self, _: Uuid) -> Acknowledgement<bool> {
        done(false)
    }

    fn retain(&self, _: Retention, _: HashSet<Uuid>) -> Acknowledgement<Vec<Uuid>> {
        done(Vec::new())
    }

    async fn get(&self, _: Uuid) -> Result<Option<Record>, StoreError> {
        Ok(None)
    }

    async fn problem(&self, _: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        Ok(None)
    }

    async fn result(&self, _: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        Ok(self.0.get().cloned())
    }

    async fn list(&self, _: Selection) -> Result<Vec<Record>, StoreError> {
        Ok(Vec::new())
    }

    async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        Ok(Vec::new())
    }

    async fn idempotency_entry(&self, _: &str) -> Result<Option<IdempotencyEntry>, StoreError> {
        Ok(None)
    }
}
