//! Jobs from one store to another.

use std::sync::Arc;

use super::{Acknowledgement, IdempotencyKey, Record, Selection, Store, StoreError};
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use piad_fit::engine::Problem;

/// The number of jobs looked up at a time.
const PAGE: usize = 1000;

/// The most jobs copied at a time, and their points: they are in memory.
const JOBS_OF_BATCH: usize = 100;
const POINTS_OF_BATCH: usize = 1_000_000;

/// The stored data of a job.
pub(crate) struct WholeJob {
    pub record: Record,
    pub problem: Arc<Problem>,
    pub result: Option<LastGeometry>,
    pub key: Option<IdempotencyKey>,
}

/// Copies all jobs, and reports the number so far; returns the final number. Those that had not ended wait in the copy.
/// A job that is in the copy already stays as it is.
pub(crate) async fn copy(
    from: &Store,
    to: &Store,
    tell: impl Fn(usize),
) -> Result<usize, StoreError> {
    let mut count = 0;
    let mut jobs = Records::of(from);
    let mut batch = Batch::to(to);
    while let Some(record) = jobs.next().await? {
        let id = record.outline.id;
        let there = to.get(id).await?;
        if !there.is_some_and(|it| it.status.state.is_final()) {
            batch.put(from.whole(record).await?).await?;
        }
        count += 1;
        tell(count);
    }
    batch.end().await?;
    Ok(count)
}

/// Jobs on their way to a store, many at a time, so that they go into few commits.
pub(crate) struct Batch<'a> {
    store: &'a Store,
    under_way: Vec<Acknowledgement<()>>,
    points: usize,
}

impl<'a> Batch<'a> {
    pub(crate) fn to(store: &'a Store) -> Self {
        Self {
            store,
            under_way: Vec::new(),
            points: 0,
        }
    }

    /// Keeps a job in a moment.
    pub(crate) async fn put(&mut self, job: WholeJob) -> Result<(), StoreError> {
        self.points += job.problem.grid().count();
        self.under_way.push(self.store.put(job));
        if self.points >= POINTS_OF_BATCH || self.under_way.len() >= JOBS_OF_BATCH {
            self.end().await?;
        }
        Ok(())
    }

    /// Returns when all are stored.
    pub(crate) async fn end(&mut self) -> Result<(), StoreError> {
        self.points = 0;
        for kept in self.under_way.drain(..) {
            kept.await?;
        }
        Ok(())
    }
}

/// The jobs of a store, the newest first.
pub(crate) struct Records<'a> {
    store: &'a Store,
    page: std::vec::IntoIter<Record>,
    before: Option<uuid::Uuid>,
}

impl<'a> Records<'a> {
    pub(crate) fn of(store: &'a Store) -> Self {
        Self {
            store,
            page: Vec::new().into_iter(),
            before: None,
        }
    }

    pub(crate) async fn next(&mut self) -> Result<Option<Record>, StoreError> {
        if self.page.len() == 0 {
            let selection = Selection {
                tenant: None,
                state: None,
                before: self.before,
                limit: PAGE,
            };
            self.page = self.store.list(selection).await?.into_iter();
        }
        let next = self.page.next();
        self.before = next.as_ref().map(|it| it.outline.id).or(self.before);
        Ok(next)
    }
}

impl Store {
    /// The stored data of a job.
    pub(crate) async fn whole(&self, record: Record) -> Result<WholeJob, StoreError> {
        let id = record.outline.id;
        Ok(WholeJob {
            record,
            problem: self.problem(id).await?.ok_or(StoreError::Gone(id))?,
            result: self.result(id).await?,
            key: self.key_of(id).await?,
        })
    }

    /// Stores a job of another store. If it had not ended it waits.
    fn put(&self, job: WholeJob) -> Acknowledgement<()> {
        let (id, status) = (job.record.outline.id, job.record.status);
        let queued = Record {
            status: Status::QUEUED,
            ..job.record
        };
        let inserted = self.insert(queued, job.problem, job.key, Quota::default());
        let is_final = status.state.is_final();
        let finished = is_final.then(|| self.finish(id, status, job.result));
        Box::pin(async move {
            inserted.await?;
            if let Some(finished) = finished {
                finished.await?;
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;

    use super::*;
    use crate::job::counters::Counters;
    use crate::job::samples::{problem, queued};
    use crate::job::state::State;
    use crate::job::store::StorePlace;

    fn ended() -> WholeJob {
        let mut record = queued();
        record.status = Status {
            state: State::Exhausted,
            finished: Some(Timestamp::now()),
            ..Status::running()
        };
        WholeJob {
            record,
            problem: Arc::new(problem()),
            result: None,
            key: None,
        }
    }

    #[tokio::test]
    async fn many_jobs_go_into_few_commits() {
        let directory = tempfile::tempdir().unwrap();
        let counters = Counters::default();
        let place = StorePlace::Directory(directory.path());
        let store = Store::open(place, counters.clone()).await.unwrap();
        let mut batch = Batch::to(&store);
        let mut ids = Vec::new();
        for _ in 0..3 * JOBS_OF_BATCH / 2 {
            let job = ended();
            ids.push(job.record.outline.id);
            batch.put(job).await.unwrap();
        }
        batch.end().await.unwrap();
        let mut kept = Records::of(&store);
        while let Some(record) = kept.next().await.unwrap() {
            assert_eq!(Some(record.outline.id), ids.pop());
            assert_eq!(record.status.state, State::Exhausted);
        }
        assert!(ids.is_empty());
        let commits = counters.commits.get();
        assert!(commits < JOBS_OF_BATCH as u64, "{commits}");
    }
}
