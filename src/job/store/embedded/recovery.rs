//! Opening a store whose process has crashed.

use redb::ReadableTable;
use tracing::warn;
use uuid::Uuid;

use super::tables;
use super::transaction::{EndedChange, Transaction};
use crate::job::state::State;
use crate::job::store::StoreError;

impl Transaction<'_> {
    /// Puts jobs that were running when the process ended back into the queue, or fails those that have been in too
    /// many crashes; and counts the jobs that have ended, and the usage of tenants. This reads every header.
    pub(super) fn recover(&mut self) -> Result<(), StoreError> {
        let mut running = Vec::new();
        for item in self.headers.iter()? {
            let (id, bytes) = item?;
            let id = Uuid::from_u128(id.value());
            let header = tables::header_in(id, bytes.value())?;
            if header.record.status.state == State::Running {
                running.push((id, header));
                continue;
            }
            self.usage.add(&header);
            if let Some(at) = header.record.status.finished {
                let bytes = header.bytes;
                self.changes.push(EndedChange::Add { at, id, bytes });
            }
        }
        let mut headers = running.iter().map(|(_, header)| header);
        let any_on_probation = headers.any(|header| header.record.was_on_probation());
        for (id, mut header) in running {
            header.record.recover(any_on_probation);
            let crashes = header.record.crashes;
            warn!(job = %id, crashes, "a job was running when the process ended");
            self.usage.add(&header);
            self.put(id, &header)?;
        }
        Ok(())
    }
}
