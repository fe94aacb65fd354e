//! The memory of a server, divided among all that takes much of it.
//!
//! | Part | Sixteenths | For |
//! |---|---|---|
//! | `heavy` | 5 | running jobs with large steps |
//! | `quick` | 2 | running jobs with small steps, which wait for no large one |
//! | `again` | 5 | runs that compute again what readers have missed |
//! | `bodies` | 1 | requests while they arrive and are read |
//! | `files` | 1 | files that are made as a whole |
//! | `cache` | 2 | what is kept to be quick: recent frames, their forms, jobs that have just ended |
//!
//! All but the cache are shares that are waited for. What is cached is counted, and goes when there is
//! too much of it.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// The unit in which memory is handed out.
pub const PAGE: usize = 4096;

/// The memory of a server.
#[derive(Debug)]
pub struct Memory {
    limit: usize,
    /// For running jobs with large steps.
    pub(super) heavy: Share,
    /// For running jobs with small steps.
    pub(super) quick: Share,
    /// For runs that compute again what readers have missed.
    pub again: Share,
    /// For requests while they arrive and are read.
    pub bodies: Share,
    /// For files that are made as a whole.
    pub files: Share,
    /// What is kept to be quick.
    pub cache: Arc<Cache>,
}

impl Memory {
    /// Divides so many bytes.
    pub(super) fn new(bytes: usize) -> Self {
        let part = |sixteenths: usize| bytes / 16 * sixteenths;
        Self {
            limit: bytes,
            heavy: Share::new(part(5)),
            quick: Share::new(part(2)),
            again: Share::new(part(5)),
            bodies: Share::new(part(1)),
            files: Share::new(part(1)),
            cache: Arc::new(Cache {
                limit: part(2),
                used: AtomicUsize::new(0),
            }),
        }
    }

    /// All of it, in bytes.
    pub fn limit(&self) -> usize {
        self.limit
    }

    /// Bytes that are handed out or cached.
    pub fn used(&self) -> usize {
        let shares = [
            &self.heavy,
            &self.quick,
            &self.again,
            &self.bodies,
            &self.files,
        ];
        let used = shares.iter().map(|share| share.used());
        used.sum::<usize>() + self.cache.used.load(Ordering::Relaxed)
    }
}

/// Memory that those who need it take, or wait for in the order in which they came.
#[derive(Debug)]
pub struct Share {
    pages: u32,
    free: Arc<Semaphore>,
}

/// Memory that was taken; given back when it is dropped.
pub type Permit = OwnedSemaphorePermit;

impl Share {
    fn new(bytes: usize) -> Self {
        let most = Semaphore::MAX_PERMITS.min(u32::MAX as usize);
        let pages = (bytes / PAGE).clamp(1, most) as u32;
        Self {
            pages,
            free: Arc::new(Semaphore::new(pages as usize)),
        }
    }

    /// All of it, in bytes.
    pub fn bytes(&self) -> usize {
        self.pages as usize * PAGE
    }

    /// Whether so many bytes fit in at all.
    pub(super) fn holds(&self, bytes: usize) -> bool {
        bytes <= self.bytes()
    }

    fn used(&self) -> usize {
        self.bytes() - (self.free.available_permits() * PAGE).min(self.bytes())
    }

    /// What needs more than there is at all gets everything there is, and runs alone.
    fn pages(&self, bytes: usize) -> u32 {
        u32::try_from(bytes.div_ceil(PAGE)).map_or(self.pages, |pages| pages.min(self.pages))
    }

    /// So many bytes, if nobody has to wait for them.
    pub(super) fn take_at_once(&self, bytes: usize) -> Option<Permit> {
        let free = Arc::clone(&self.free);
        free.try_acquire_many_owned(self.pages(bytes)).ok()
    }

    /// Waits for so many bytes. The semaphore is never closed: there is always a permit in the end.
    pub async fn take(&self, bytes: usize) -> Option<Permit> {
        let free = Arc::clone(&self.free);
        free.acquire_many_owned(self.pages(bytes)).await.ok()
    }
}

/// The sum of what is kept to be quick.
#[derive(Debug)]
pub struct Cache {
    limit: usize,
    used: AtomicUsize,
}

impl Cache {
    /// Counts what is kept, as long as the charge lives.
    pub fn charge(self: &Arc<Self>, bytes: usize) -> Charge {
        self.used.fetch_add(bytes, Ordering::Relaxed);
        Charge {
            cache: Arc::clone(self),
            bytes,
        }
    }

    /// Whether nothing more should be kept.
    pub fn is_full(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.limit
    }

    /// Whether nothing more should be kept that nobody reads yet.
    pub(super) fn is_half_full(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.limit / 2
    }
}

/// What something takes that is kept.
#[derive(Debug)]
pub struct Charge {
    cache: Arc<Cache>,
    bytes: usize,
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.cache.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn shares_are_taken_and_given_back() {
        let memory = Memory::new(16 << 20);
        let share = &memory.bodies;
        assert_eq!(share.bytes(), 1 << 20);
        let most = share.take_at_once(1 << 19).unwrap();
        assert!(share.take_at_once((1 << 19) + 1).is_none());
        assert_eq!(memory.used(), 1 << 19);
        drop(most);
        // More than there is waits for all that there is.
        let all = share.take(usize::MAX).await.unwrap();
        assert!(!share.holds(usize::MAX) && share.take_at_once(1).is_none());
        drop(all);
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
