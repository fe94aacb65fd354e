//! The memory of a server, divided among its large consumers.
//!
//! | Part | Sixteenths | For |
//! |---|---|---|
//! | `heavy` | 5 | running jobs with large steps |
//! | `quick` | 2 | running jobs with small steps, which wait for no large one |
//! | `again` | 5 | runs that compute levels again that readers have missed |
//! | `bodies` | 1 | requests while they arrive and are read |
//! | `files` | 1 | files that are made as a whole, and searches for foot points |
//! | `cache` | 2 | recent frames, their encoded forms, jobs that have just ended |
//!
//! All but the cache are shares: those who need memory wait for it. The cache only counts its contents,
//! which are evicted when there are too many.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// The unit in which memory is handed out.
pub const PAGE: usize = 4096;

/// The memory of a server: its parts as in the table above.
#[derive(Debug)]
pub struct Memory {
    limit: usize,
    pub(super) heavy: Share,
    pub(super) quick: Share,
    pub again: Share,
    pub bodies: Share,
    pub files: Share,
    pub cache: Arc<Cache>,
}

impl Memory {
    /// Divides this many bytes.
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

    /// Bytes in use, of the shares and of the cache.
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

/// A part of the memory. Those who need some take it, or wait for it in the order in which they came.
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

    /// A request for more than the whole share gets all of it, and so runs alone.
    fn pages(&self, bytes: usize) -> u32 {
        u32::try_from(bytes.div_ceil(PAGE)).map_or(self.pages, |pages| pages.min(self.pages))
    }

    /// Takes this many bytes if they are free.
    pub(super) fn take_at_once(&self, bytes: usize) -> Option<Permit> {
        let free = Arc::clone(&self.free);
        free.try_acquire_many_owned(self.pages(bytes)).ok()
    }

    /// Waits for this many bytes. The semaphore is never closed, so that there is always a permit.
    pub async fn take(&self, bytes: usize) -> Option<Permit> {
        let free = Arc::clone(&self.free);
        free.acquire_many_owned(self.pages(bytes)).await.ok()
    }
}

/// Counts the bytes that are kept to save time.
#[derive(Debug)]
pub struct Cache {
    limit: usize,
    used: AtomicUsize,
}

impl Cache {
    /// Counts these bytes until the charge is dropped.
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

    /// Whether nothing more should be kept that nobody has read yet.
    pub(super) fn is_half_full(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.limit / 2
    }
}

/// Bytes that are counted in the cache.
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
