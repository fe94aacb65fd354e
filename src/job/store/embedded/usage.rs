//! What each tenant has in the store: the bookkeeping for quotas, in memory.

use std::collections::HashMap;

use super::tables::Header;
use crate::job::quota::Amount;
use crate::job::tenant::Tenant;

/// What the jobs of each tenant take.
#[derive(Clone, Debug, Default)]
pub(super) struct Usage(HashMap<Tenant, Amount>);

impl Usage {
    /// What the jobs of a tenant take.
    pub(super) fn of(&self, tenant: Tenant) -> Amount {
        self.0.get(&tenant).copied().unwrap_or_default()
    }

    /// There is this job.
    pub(super) fn add(&mut self, header: &Header) {
        let has = self.0.entry(header.record.outline.tenant).or_default();
        *has = *has + header.amount();
    }

    /// This job is gone, or is another one now.
    pub(super) fn remove(&mut self, header: &Header) {
        let tenant = header.record.outline.tenant;
        let has = self.of(tenant) - header.amount();
        if has == Amount::default() {
            self.0.remove(&tenant);
        } else {
            self.0.insert(tenant, has);
        }
    }
}
