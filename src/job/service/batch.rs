//! Batches: many fits in one request, computed for its answer alone.

use super::Jobs;
use super::refused::Refused;
use crate::job::counters::Open;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use crate::job::quota::OpenStream;
use crate::job::slots::Slot;

/// The slot of a batch among the jobs of a server: it counts as one unfinished job of its peer, and as one open stream
/// of its tenant, however many fits it has.
#[must_use]
pub(crate) struct BatchPlace {
    _slot: Slot,
    _stream: OpenStream,
    _running: Open,
}

impl Jobs {
    /// Takes the slot of a batch for the current peer, until it is dropped.
    pub(crate) fn begin_batch(&self) -> Result<BatchPlace, Refused> {
        let peer = Peer::current();
        let slot = self.slots.take(peer)?;
        let stream = self.resources.open_stream(Peer::owner(peer))?;
        self.resources.counters.batches.inc();
        Ok(BatchPlace {
            _slot: slot,
            _stream: stream,
            _running: self.resources.counters.run_job(),
        })
    }

    /// Waits for memory for a fit of the current peer, with steps of this cost.
    pub(crate) async fn fit_memory(&self, step_cost: usize, bytes: usize) -> Option<Permit> {
        self.share(step_cost).take(Peer::current(), bytes).await
    }
}
