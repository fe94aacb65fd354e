//! All jobs from one store to another.

use super::{Record, Selection, Store, StoreError};
use crate::job::state::Status;

/// So many jobs are looked up at a time.
const PAGE: usize = 1000;

/// Copies all jobs, and tells how many there are so far; gives the number in the end. Those that had not ended
/// wait in the copy. A job that is in the copy already stays there as it is.
pub(crate) async fn copy(
    from: &Store,
    to: &Store,
    tell: impl Fn(usize),
) -> Result<usize, StoreError> {
    let (mut count, mut before) = (0, None);
    loop {
        let selection = Selection {
            state: None,
            before,
            limit: PAGE,
        };
        let page = from.list(selection).await?;
        let Some(last) = page.last() else {
            return Ok(count);
        };
        before = Some(last.outline.id);
        for record in page {
            copy_job(record, from, to).await?;
            count += 1;
            tell(count);
        }
    }
}

async fn copy_job(record: Record, from: &Store, to: &Store) -> Result<(), StoreError> {
    let id = record.outline.id;
    if to
        .get(id)
        .await?
        .is_some_and(|it| it.status.state.is_final())
    {
        return Ok(());
    }
    let problem = from.problem(id).await?.ok_or(StoreError::Gone(id))?;
    let result = from.result(id).await?;
    let (status, key) = (record.status.clone(), from.key_of(id).await?);
    let queued = Record {
        status: Status::QUEUED,
        ..record
    };
    to.insert(queued, problem, key).await?;
    if status.state.is_final() {
        to.finish(id, status, result).await?;
    }
    Ok(())
}
