//! A store that lasts as long as the process.

use std::collections::BTreeMap;
use std::sync::Arc;

use async_trait::async_trait;
use parking_lot::Mutex;
use uuid::Uuid;

use super::{Record, Retention, Selection, Store, StoreError};
use crate::fit::points::Points;
use crate::job::state::Status;

/// Jobs in memory, in the order of their ids, which is that of their creation.
#[derive(Debug, Default)]
pub struct MemoryStore {
    records: Mutex<BTreeMap<Uuid, Record>>,
}

#[async_trait]
impl Store for MemoryStore {
    async fn insert(&self, record: Record) -> Result<(), StoreError> {
        self.records.lock().insert(record.id, record);
        Ok(())
    }

    async fn update(&self, id: Uuid, status: Status) -> Result<(), StoreError> {
        if let Some(record) = self.records.lock().get_mut(&id) {
            record.status = status;
        }
        Ok(())
    }

    async fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<Arc<Points>>,
    ) -> Result<(), StoreError> {
        if let Some(record) = self.records.lock().get_mut(&id) {
            record.status = status;
            record.result = result;
        }
        Ok(())
    }

    async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        Ok(self.records.lock().get(&id).cloned())
    }

    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        let records = self.records.lock();
        let end = selection.before.unwrap_or(Uuid::max());
        let selected = records
            .range(..end)
            .rev()
            .map(|(_, record)| record)
            .filter(|record| {
                selection
                    .state
                    .is_none_or(|state| record.status.state == state)
            })
            .take(selection.limit);
        Ok(selected.cloned().collect())
    }

    async fn remove(&self, id: Uuid) -> Result<bool, StoreError> {
        Ok(self.records.lock().remove(&id).is_some())
    }

    async fn retain(&self, retention: Retention) -> Result<Vec<Uuid>, StoreError> {
        let mut records = self.records.lock();
        let mut ended: Vec<_> = records
            .values()
            .filter(|record| record.status.state.is_final())
            .map(|record| (record.status.finished, record.id, size(record)))
            .collect();
        ended.sort_unstable();
        let mut jobs = ended.len();
        let mut bytes: usize = ended.iter().map(|(.., size)| size).sum();
        let mut forgotten = Vec::new();
        for (_, id, size) in ended {
            if jobs <= retention.jobs && bytes <= retention.bytes {
                break;
            }
            records.remove(&id);
            forgotten.push(id);
            jobs -= 1;
            bytes -= size;
        }
        Ok(forgotten)
    }
}

/// Bytes of the arrays of a job that has ended.
fn size(record: &Record) -> usize {
    let problem = &record.problem;
    let result = record.result.as_deref();
    let coordinates = [Some(problem.data()), result]
        .into_iter()
        .flatten()
        .map(|points| points.dimension() * points.len())
        .sum::<usize>();
    let parameters_and_knots = problem
        .directions()
        .map(|direction| 2 * direction.parameters.len() + direction.basis.degree())
        .sum::<usize>();
    (coordinates + parameters_and_knots) * size_of::<f64>() + size_of::<Record>()
}
