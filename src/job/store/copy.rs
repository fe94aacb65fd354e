//! Jobs from one store to another.

use std::sync::Arc;

use super::{IdempotencyKey, Record, Selection, Store, StoreError};
use crate::fit::problem::Problem;
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::state::Status;

/// So many jobs are looked up at a time.
const PAGE: usize = 1000;

/// All that is kept of a job.
pub(crate) struct WholeJob {
    pub record: Record,
    pub problem: Arc<Problem>,
    pub result: Option<LastGeometry>,
    pub key: Option<IdempotencyKey>,
}

/// Copies all jobs, and tells how many there are so far; gives the number in the end. Those that had not ended
/// wait in the copy. A job that is in the copy already stays there as it is.
pub(crate) async fn copy(
    from: &Store,
    to: &Store,
    tell: impl Fn(usize),
) -> Result<usize, StoreError> {
    let mut count = 0;
    let mut jobs = Records::of(from);
    while let Some(record) = jobs.next().await? {
        let id = record.outline.id;
        let there = to.get(id).await?;
        if !there.is_some_and(|it| it.status.state.is_final()) {
            to.put(from.whole(record).await?).await?;
        }
        count += 1;
        tell(count);
    }
    Ok(count)
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
    /// All that is kept of a job.
    pub(crate) async fn whole(&self, record: Record) -> Result<WholeJob, StoreError> {
        let id = record.outline.id;
        Ok(WholeJob {
            record,
            problem: self.problem(id).await?.ok_or(StoreError::Gone(id))?,
            result: self.result(id).await?,
            key: self.key_of(id).await?,
        })
    }

    /// Keeps a job of another store. If it had not ended it waits.
    pub(crate) async fn put(&self, job: WholeJob) -> Result<(), StoreError> {
        let (id, status) = (job.record.outline.id, job.record.status);
        let queued = Record {
            status: Status::QUEUED,
            ..job.record
        };
        let quota = Quota::default();
        self.insert(queued, job.problem, job.key, quota).await?;
        if status.state.is_final() {
            self.finish(id, status, job.result).await?;
        }
        Ok(())
    }
}
