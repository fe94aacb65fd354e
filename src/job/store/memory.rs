//! A store that lasts as long as the process.

use std::collections::{BTreeMap, HashMap};
use std::future::ready;
use std::sync::Arc;

use async_trait::async_trait;
use parking_lot::Mutex;
use uuid::Uuid;

use super::{Ended, Kept, Key, Made, Record, Retention, Selection, Store, StoreError};
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::job::state::Status;

/// Jobs in memory, in the order of their ids, which is that of their creation.
#[derive(Debug, Default)]
pub struct MemoryStore(Mutex<Content>);

#[derive(Debug, Default)]
struct Content {
    entries: BTreeMap<Uuid, Entry>,
    keys: HashMap<String, Made>,
    ended: Ended,
}

#[derive(Debug)]
struct Entry {
    record: Record,
    problem: Arc<Problem>,
    result: Option<Arc<Points>>,
    key: Option<String>,
}

impl Content {
    fn insert(&mut self, record: Record, problem: Arc<Problem>, key: Option<Key>) -> Option<Made> {
        let id = record.outline.id;
        if let Some(key) = &key {
            if let Some(made) = self.made(&key.name) {
                return Some(made);
            }
            let (digest, at) = (key.digest, record.outline.created);
            self.keys.insert(key.name.clone(), Made { id, digest, at });
        }
        let entry = Entry {
            record,
            problem,
            result: None,
            key: key.map(|key| key.name),
        };
        self.entries.insert(id, entry);
        None
    }

    fn made(&self, key: &str) -> Option<Made> {
        let made = self.keys.get(key).copied();
        made.filter(|made| !made.is_forgotten())
    }

    fn set_status(&mut self, id: Uuid, status: Status) {
        if let Some(entry) = self.entries.get_mut(&id) {
            entry.record.status = status;
        }
    }

    fn finish(&mut self, id: Uuid, status: Status, result: Option<Arc<Points>>) {
        if let Some(entry) = self.entries.get_mut(&id) {
            entry.record.status = status;
            entry.result = result;
            if let Some(at) = entry.record.status.finished {
                self.ended.add(at, id, entry.bytes());
            }
        }
    }

    fn remove(&mut self, id: Uuid) -> bool {
        let Some(entry) = self.entries.remove(&id) else {
            return false;
        };
        if let Some(at) = entry.record.status.finished {
            self.ended.remove(at, id);
        }
        // A forgotten key may have been used again.
        if let Some(key) = entry.key
            && self.keys.get(&key).is_some_and(|made| made.id == id)
        {
            self.keys.remove(&key);
        }
        true
    }

    fn retain(&mut self, retention: Retention) -> Vec<Uuid> {
        self.keys.retain(|_, made| !made.is_forgotten());
        let forgotten = self.ended.surplus(retention);
        for &id in &forgotten {
            self.remove(id);
        }
        forgotten
    }
}

impl Entry {
    /// Bytes of the arrays of a job that has ended.
    fn bytes(&self) -> u64 {
        let problem = &self.problem;
        let result = self.result.as_deref();
        let coordinates = [Some(&**problem.data()), result]
            .into_iter()
            .flatten()
            .map(|points| points.dimension() * points.len())
            .sum::<usize>();
        let parameters_and_knots = problem
            .directions()
            .map(|direction| 2 * direction.parameters.len() + direction.basis.degree())
            .sum::<usize>();
        let numbers = coordinates + parameters_and_knots;
        (numbers * size_of::<f64>() + size_of::<Self>()) as u64
    }
}

/// Nothing that is written to memory has to be waited for.
fn kept<T: Send + 'static>(value: T) -> Kept<T> {
    Box::pin(ready(Ok(value)))
}

#[async_trait]
impl Store for MemoryStore {
    fn insert(
        &self,
        record: Record,
        problem: Arc<Problem>,
        key: Option<Key>,
    ) -> Kept<Option<Made>> {
        kept(self.0.lock().insert(record, problem, key))
    }

    fn start(&self, id: Uuid, status: Status, _watched: bool) -> Kept<()> {
        self.0.lock().set_status(id, status);
        kept(())
    }

    // Nothing outlives a crash.
    fn clear(&self, _id: Uuid) -> Kept<()> {
        kept(())
    }

    fn requeue(&self, id: Uuid) -> Kept<()> {
        self.0.lock().set_status(id, Status::QUEUED);
        kept(())
    }

    fn finish(&self, id: Uuid, status: Status, result: Option<Arc<Points>>) -> Kept<()> {
        self.0.lock().finish(id, status, result);
        kept(())
    }

    fn remove(&self, id: Uuid) -> Kept<bool> {
        kept(self.0.lock().remove(id))
    }

    fn retain(&self, retention: Retention) -> Kept<Vec<Uuid>> {
        kept(self.0.lock().retain(retention))
    }

    async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        let content = self.0.lock();
        Ok(content.entries.get(&id).map(|entry| entry.record.clone()))
    }

    async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        let content = self.0.lock();
        let entry = content.entries.get(&id);
        Ok(entry.map(|entry| Arc::clone(&entry.problem)))
    }

    async fn result(&self, id: Uuid) -> Result<Option<Arc<Points>>, StoreError> {
        let content = self.0.lock();
        Ok(content.entries.get(&id).and_then(|it| it.result.clone()))
    }

    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        let content = self.0.lock();
        let end = selection.before.unwrap_or(Uuid::max());
        let chosen = |record: &&Record| {
            let state = record.status.state;
            selection.state.is_none_or(|wanted| wanted == state)
        };
        let newest_first = content.entries.range(..end).rev();
        let records = newest_first.map(|(_, entry)| &entry.record).filter(chosen);
        Ok(records.take(selection.limit).cloned().collect())
    }

    async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        let content = self.0.lock();
        let records = content.entries.values().map(|entry| &entry.record);
        let unfinished = records.filter(|record| !record.status.state.is_final());
        Ok(unfinished.cloned().collect())
    }

    async fn made(&self, key: &str) -> Result<Option<Made>, StoreError> {
        Ok(self.0.lock().made(key))
    }
}
