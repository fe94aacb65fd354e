//! The usage of each tenant in the store: the bookkeeping for quotas, in memory.

use std::collections::HashMap;

use super::tables::Header;
use crate::job::quota::Amount;
use crate::job::tenant::Tenant;

/// The usage by the jobs of each tenant.
#[derive(Clone, Debug, Default)]
pub(super) struct Usage(HashMap<Tenant, Amount>);

impl Usage {
    /// The usage by the jobs of a tenant.
    pub(super) fn of(&self, tenant: Tenant) -> Amount {
        self.0.get(&tenant).copied().unwrap_or_default()
    }

    /// A job was added.
    pub(super) fn add(&mut self, header: &Header) {
        let has = self.0.entry(header.record.outline.tenant).or_default();
        *has = *has + header.amount();
    }

    /// A job is gone, or is replaced.
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
