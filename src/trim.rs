//! Memory that was freed goes back to the operating system soon, also when nothing happens any more.
//!
//! The allocator, mimalloc, does this while threads allocate: pages of a thread that have become empty
//! are looked for after some thousand allocations of it, and given back a second later by whoever
//! allocates next. What a thread has when it begins to wait would stay for good, and so would what others
//! free of it. So threads that have worked and wait make these allocations, in two rounds, and then wait
//! without an end. With other allocators that does no harm.

use std::hint::black_box;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::time::sleep;

/// How long threads wait before each round of trimming: for longer than the allocator, which returns
/// nothing in its first second.
pub const PAUSE: Duration = Duration::from_millis(1200);

/// How many rounds there are: one finds pages that are empty, the next returns them.
pub const ROUNDS: usize = 2;

/// After so many allocations mimalloc has looked through all pages of a thread.
const ALLOCATIONS: usize = 10_000;

/// Bytes of each: what has more than a kibibyte counts, and is quick nevertheless.
const SIZE: usize = 2048;

/// Something has ended on the threads of the network.
static ENDED: Notify = Notify::const_new();

/// Looks for memory of this thread that is not used. Takes some tenths of a millisecond.
pub fn this_thread() {
    for _ in 0..ALLOCATIONS {
        drop(black_box(Vec::<u8>::with_capacity(SIZE)));
    }
}

/// Something has ended that is served by the threads of the network: they are trimmed soon.
pub fn soon() {
    ENDED.notify_one();
}

/// Trims the threads of the runtime whenever something has ended on them, and sleeps while nothing does.
pub async fn network() {
    // Nobody can choose the threads of tasks: there are enough of them to wake all threads.
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
