//! The store of ephemeral edits, which keeps nothing.

use std::collections::HashSet;
use std::sync::Arc;

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

/// Takes every change and forgets it. No other promise of a store holds here: jobs of this store are in
/// memory as long as they are read.
#[derive(Clone, Copy, Debug)]
pub struct Nowhere;

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

    fn end_watch(&self, _: Uuid) -> Acknowledgement<()> {
        done(())
    }

    fn requeue(&self, _: Uuid) -> Acknowledgement<()> {
        done(())
    }

    fn finish(&self, _: Uuid, _: Status, _: Option<LastGeometry>) -> Acknowledgement<()> {
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
        Ok(None)
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
