//! The memory of a server, divided among its large consumers.
//!
//! | Part | Sixteenths | For |
//! |---|---|---|
//! | `heavy` | 5 | running jobs with large steps |
//! | `quick` | 2 | running jobs with small steps, which wait for no large one |
//! | `replays` | 4½ | runs that compute levels again that readers have missed |
//! | `requests` | ½ | small requests while they arrive and are read |
//! | `bodies` | ½ | large ones while they arrive, which small ones do not wait for |
//! | `reading` | ¼ | large ones while they are read, which wait for no client |
//! | `files` | ¾ | files that are made as a whole, and searches for foot points |
//! | `numbers` | ½ | what readers of difference streams have |
//! | `cache` | 2 | recent frames, their encoded forms, jobs that have just ended |
//!
//! All but the last two are [shares](Share), for which tasks wait. A [cache](Cache) only counts its contents, which are
//! evicted when there are too many, or not kept.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(crate) use super::memory_pool::{Permit, Share};

/// The memory of a server: its parts as in the table above.
#[derive(Debug)]
pub(crate) struct Memory {
    limit: usize,
    pub(super) heavy: Share,
    pub(super) quick: Share,
    pub replays: Share,
    pub requests: Share,
    pub bodies: Share,
    pub reading: Share,
    pub files: Share,
    pub numbers: Arc<Cache>,
    pub cache: Arc<Cache>,
}

impl Memory {
    /// Divides this many bytes.
    pub(super) fn new(bytes: usize) -> Self {
        let part = |parts: usize| bytes / 64 * parts;
        Self {
            limit: bytes,
            heavy: Share::new(part(20)),
            quick: Share::new(part(8)),
            replays: Share::new(part(18)),
            requests: Share::new(part(2)),
            bodies: Share::new(part(2)),
            reading: Share::new(part(1)),
            files: Share::new(part(3)),
            numbers: Arc::new(Cache::new(part(2))),
            cache: Arc::new(Cache::new(part(8))),
        }
    }

    /// All of it, in bytes.
    pub(crate) fn limit(&self) -> usize {
        self.limit
    }

    /// Bytes in use, of the shares and of the caches.
    pub(crate) fn used(&self) -> usize {
        let shares = [
            &self.heavy,
            &self.quick,
            &self.replays,
            &self.requests,
            &self.bodies,
            &self.reading,
            &self.files,
        ];
        let used = shares.iter().map(|share| share.used());
        let counted = [&self.numbers, &self.cache];
        let counted = counted.map(|cache| cache.used.load(Ordering::Relaxed));
        used.sum::<usize>() + counted.iter().sum::<usize>()
    }
}

/// Counts the bytes of caches.
#[derive(Debug)]
pub(crate) struct Cache {
    limit: usize,
    used: AtomicUsize,
}

impl Cache {
    /// Nothing is kept yet.
    fn new(limit: usize) -> Self {
        Self {
            limit,
            used: AtomicUsize::new(0),
        }
    }

    /// Counts these bytes until the charge is dropped.
    pub(crate) fn charge(self: &Arc<Self>, bytes: usize) -> Charge {
        self.used.fetch_add(bytes, Ordering::Relaxed);
        Charge {
            cache: Arc::clone(self),
            bytes,
        }
    }

    /// Returns true if nothing more should be kept.
    pub(crate) fn is_full(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.limit
    }

    /// Returns true if unread frames should no longer be kept.
    pub(super) fn is_half_full(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.limit / 2
    }
}

/// Bytes that are counted in the cache.
#[derive(Debug)]
pub(crate) struct Charge {
    cache: Arc<Cache>,
    bytes: usize,
}

impl Charge {
    /// Returns true if more may be cached.
    pub(super) fn has_room(&self) -> bool {
        !self.cache.is_full()
    }
}

/// The same bytes once more.
impl Clone for Charge {
    fn clone(&self) -> Self {
        self.cache.charge(self.bytes)
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.cache.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_shares_are_counted() {
        let memory = Memory::new(32 << 20);
        assert_eq!(memory.bodies.bytes(), 1 << 20);
        let taken = memory.bodies.take_at_once(None, 1 << 19);
        assert_eq!(memory.used(), 1 << 19);
        drop(taken);
        assert_eq!(memory.used(), 0);
    }

    #[test]
    fn the_cache_counts_what_lives() {
        let memory = Memory::new(16 << 20);
        let cache = &memory.cache;
        let half = cache.charge(1 << 20);
        assert!(!cache.is_half_full());
        let rest = cache.charge((1 << 20) + 1);
        assert!(cache.is_full());
        drop(half);
        assert!(cache.is_half_full() && !cache.is_full());
        drop(rest);
        assert_eq!(memory.used(), 0);
    }
}
