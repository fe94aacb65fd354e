//! The shared resources of the jobs of a server: compute pool, memory and counters.

use std::sync::Arc;

use super::counters::Counters;
use super::memory::Memory;
use super::quota::{Exceeded, OpenStream, Quotas};
use super::scheduler::Scheduler;
use super::tenant::Tenant;

/// The shared resources of all jobs of a server.
#[derive(Debug)]
pub(crate) struct Resources {
    /// The compute pool.
    pub scheduler: Scheduler,
    /// The memory for all of them.
    pub memory: Memory,
    /// Bytes of recent frames that each run keeps at most.
    pub(super) ring_bytes: usize,
    /// The quotas of tenants.
    pub quotas: Arc<Quotas>,
    /// The metrics of the server.
    pub counters: Counters,
    /// The path prefix of jobs, in links.
    pub base_path: String,
}

impl Resources {
    /// Resources with this many bytes of memory.
    pub(crate) fn new(scheduler: Scheduler, memory: usize, ring_bytes: usize) -> Self {
        Self {
            scheduler,
            memory: Memory::new(memory),
            ring_bytes,
            quotas: Arc::default(),
            counters: Counters::default(),
            base_path: String::new(),
        }
    }

    /// The same for a server at this path prefix.
    pub(crate) fn below(self, base_path: &str) -> Self {
        Self {
            base_path: base_path.to_owned(),
            ..self
        }
    }

    /// Counts a stream of a tenant, if that is within its quota.
    pub(crate) fn open_stream(&self, tenant: Tenant) -> Result<OpenStream, Exceeded> {
        let opened = self.quotas.open_stream(tenant);
        opened.inspect_err(|_| self.counters.count_exceeded(tenant))
    }
}
