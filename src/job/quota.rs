//! Quotas: limits of a tenant. Jobs, points and bytes are counted in the store, in the transaction that inserts a new
//! one; streams are counted here.

use std::collections::{BTreeMap, HashMap};
use std::ops::{Add, Sub};
use std::sync::Arc;

use bytesize::ByteSize;
use parking_lot::Mutex;
use serde::{Deserialize, Serialize, Serializer};
use thiserror::Error;

use super::tenant::Tenant;

/// The limits of a tenant; missing ones do not limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Quota {
    /// Jobs that have not ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) jobs: Option<u64>,
    /// Points of these jobs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<u64>,
    /// Bytes of the data and results of all jobs that are kept.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        serialize_with = "exact"
    )]
    pub(crate) bytes: Option<ByteSize>,
    /// Open streams, and running fits for one answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) streams: Option<u64>,
}

/// Writes a size as its number of bytes: in larger units it would be rounded.
fn exact<S: Serializer>(size: &Option<ByteSize>, output: S) -> Result<S::Ok, S::Error> {
    size.map(|it| it.as_u64()).serialize(output)
}

/// Usage of a quota by jobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Amount {
    pub(crate) jobs: u64,
    pub(crate) points: u64,
    pub(crate) bytes: u64,
}

/// A tenant would exceed its quota.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("tenant {tenant} may have {limit} {what} and would have {would}")]
pub struct Exceeded {
    tenant: Tenant,
    what: &'static str,
    limit: u64,
    would: u64,
    /// True if waiting does not help.
    pub(crate) for_good: bool,
}

impl Quota {
    /// Returns true if it limits what the store counts.
    pub(crate) fn limits_jobs(&self) -> bool {
        self.jobs.is_some() || self.points.is_some() || self.bytes.is_some()
    }

    /// Refuses a new job that would exceed the quota of a tenant with this usage.
    pub(crate) fn admit(&self, tenant: Tenant, has: Amount, new: Amount) -> Result<(), Exceeded> {
        let with = has + new;
        let bytes = self.bytes.map(|it| it.as_u64());
        for (what, limit, would, alone) in [
            ("unfinished jobs", self.jobs, with.jobs, new.jobs),
            (
                "points of unfinished jobs",
                self.points,
                with.points,
                new.points,
            ),
            ("bytes of jobs", bytes, with.bytes, new.bytes),
        ] {
            if let Some(limit) = limit.filter(|limit| would > *limit) {
                return Err(Exceeded {
                    tenant,
                    what,
                    limit,
                    would,
                    for_good: alone > limit,
                });
            }
        }
        Ok(())
    }
}

impl Add for Amount {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            jobs: self.jobs.saturating_add(other.jobs),
            points: self.points.saturating_add(other.points),
            bytes: self.bytes.saturating_add(other.bytes),
        }
    }
}

impl Sub for Amount {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            jobs: self.jobs.saturating_sub(other.jobs),
            points: self.points.saturating_sub(other.points),
            bytes: self.bytes.saturating_sub(other.bytes),
        }
    }
}

/// The quotas of all tenants, and the streams that they have open here.
#[derive(Debug, Default)]
pub(crate) struct Quotas {
    limits: Mutex<BTreeMap<Tenant, Quota>>,
    streams: Mutex<HashMap<Tenant, u64>>,
}

/// A stream of a tenant that is open until this is dropped.
#[derive(Debug)]
#[must_use]
pub(crate) struct OpenStream {
    quotas: Arc<Quotas>,
    tenant: Tenant,
}

impl Quotas {
    /// Sets the quotas of tenants from now on. Existing jobs stay.
    pub(crate) fn set(&self, limits: BTreeMap<Tenant, Quota>) {
        *self.limits.lock() = limits;
    }

    /// The quota of a tenant.
    pub(crate) fn of(&self, tenant: Tenant) -> Quota {
        self.limits.lock().get(&tenant).copied().unwrap_or_default()
    }

    /// Counts a stream, if the tenant may have one more.
    pub(crate) fn open_stream(self: &Arc<Self>, tenant: Tenant) -> Result<OpenStream, Exceeded> {
        let limit = self.of(tenant).streams;
        let mut streams = self.streams.lock();
        let would = streams.get(&tenant).copied().unwrap_or(0) + 1;
        if let Some(limit) = limit.filter(|limit| would > *limit) {
            return Err(Exceeded {
                tenant,
                what: "open streams",
                limit,
                would,
                for_good: limit == 0,
            });
        }
        streams.insert(tenant, would);
        let quotas = Arc::clone(self);
        Ok(OpenStream { quotas, tenant })
    }
}

impl Drop for OpenStream {
    fn drop(&mut self) {
        let mut streams = self.quotas.streams.lock();
        if let Some(open) = streams.get_mut(&self.tenant) {
            *open -= 1;
            if *open == 0 {
                streams.remove(&self.tenant);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exceeded_quotas_are_named() {
        let quota = Quota {
            jobs: Some(2),
            points: Some(100),
            bytes: Some(ByteSize(1000)),
            streams: None,
        };
        let amount = |jobs, points, bytes| Amount {
            jobs,
            points,
            bytes,
        };
        let admit = |has, new| quota.admit(Tenant::DEFAULT, has, new);
        let has = amount(1, 60, 600);
        assert_eq!(admit(has, amount(1, 40, 400)), Ok(()));
        for (new, text, for_good) in [
            (
                amount(1, 41, 0),
                "100 points of unfinished jobs and would have 101",
                false,
            ),
            (
                amount(1, 101, 0),
                "100 points of unfinished jobs and would have 161",
                true,
            ),
            (
                amount(1, 0, 401),
                "1000 bytes of jobs and would have 1001",
                false,
            ),
            (amount(2, 0, 0), "2 unfinished jobs and would have 3", false),
        ] {
            let exceeded = admit(has, new).unwrap_err();
            let text = format!("tenant default may have {text}");
            assert_eq!((exceeded.to_string(), exceeded.for_good), (text, for_good));
        }
        assert!(Quota::default().admit(Tenant::DEFAULT, has, has).is_ok());
    }

    #[test]
    fn a_tenant_opens_as_many_streams_as_it_may() {
        let quotas = Arc::new(Quotas::default());
        let cad: Tenant = "cad".parse().unwrap();
        let quota = Quota {
            streams: Some(2),
            ..Quota::default()
        };
        quotas.set([(cad, quota)].into());
        let first = quotas.open_stream(cad).unwrap();
        let second = quotas.open_stream(cad).unwrap();
        let exceeded = quotas.open_stream(cad).unwrap_err();
        assert_eq!((exceeded.limit, exceeded.for_good), (2, false));
        let other = quotas.open_stream(Tenant::DEFAULT).unwrap();
        drop(first);
        let third = quotas.open_stream(cad).unwrap();
        drop((second, third, other));
        assert!(quotas.streams.lock().is_empty());
    }
}
