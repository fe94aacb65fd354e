//! Returns freed memory to the operating system even when the server is idle.
//!
//! The allocator, mimalloc, does this only while threads allocate: a thread looks for its empty pages after
//! some thousand allocations, and they are returned a second later by the next thread that allocates.
//! Pages of a thread that is idle would stay for good. So before a thread goes to sleep for long it makes
//! these allocations, in two rounds. With other allocators that does no harm.

use std::hint::black_box;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::time::sleep;

/// The pause before each round: longer than the second after which the allocator returns pages.
pub const PAUSE: Duration = Duration::from_millis(1200);

/// The number of rounds: the first finds empty pages, the second returns them.
pub const ROUNDS: usize = 2;

/// The number of allocations after which mimalloc has looked through all pages of a thread.
const ALLOCATIONS: usize = 10_000;

/// The bytes of each allocation: only those above a kibibyte count, and these are still fast.
const SIZE: usize = 2048;

/// Notified when a request has ended on the network threads.
static ENDED: Notify = Notify::const_new();

/// Returns unused memory of this thread. Takes some tenths of a millisecond.
pub fn this_thread() {
    for _ in 0..ALLOCATIONS {
        drop(black_box(Vec::<u8>::with_capacity(SIZE)));
    }
}

/// Asks for the network threads to be trimmed soon, as a request has ended on them.
pub fn soon() {
    ENDED.notify_one();
}

/// Trims the threads of the runtime some time after requests have ended on them.
pub async fn network() {
    // Tasks cannot be bound to threads: twice the number of threads is likely to reach all.
    let tasks = 2 * Handle::current().metrics().num_workers();
    loop {
        ENDED.notified().await;
        for _ in 0..ROUNDS {
            sleep(PAUSE).await;
            for _ in 0..tasks {
                tokio::spawn(async { this_thread() });
            }
        }
    }
}
