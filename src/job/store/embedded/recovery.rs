//! The first transaction after a start.

use redb::ReadableTable;
use tracing::warn;

use super::super::{Record, StoreError};
use super::header::Header;
use super::transaction::{EndedChange, Transaction};
use crate::job::state::State;

impl Transaction<'_> {
    /// Puts jobs that were running when the process ended back into the queue, or fails those that have
    /// been in too many crashes; and counts the jobs that have ended. This reads every header.
    pub(super) fn recover(&mut self) -> Result<(), StoreError> {
        let mut running = Vec::new();
        for item in self.headers.iter()? {
            let header = Header::read(item?.1.value())?;
            let bytes = header.bytes;
            let record = header.clone().into_record()?;
            if record.status.state == State::Running {
                running.push((record, header));
            } else if let Some(at) = record.status.finished {
                let id = record.outline.id;
                self.ended.push(EndedChange::Add { at, id, bytes });
            }
        }
        let any_on_probation = running.iter().any(|(record, _)| record.was_on_probation());
        for (mut record, mut header) in running {
            record.recover(any_on_probation);
            let Record {
                outline, status, ..
            } = &record;
            let id = outline.id;
            warn!(job = %id, crashes = record.crashes, "a job was running when the process ended");
            header.recover(&record);
            self.put(id, &header)?;
            if let Some(at) = status.finished {
                let bytes = header.bytes;
                self.ended.push(EndedChange::Add { at, id, bytes });
            }
        }
        Ok(())
    }
}
