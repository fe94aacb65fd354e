//! Clients that want more than their share: what they get, and that the server and its other clients
//! do not notice. Servers are processes of their own, whose memory is looked at from outside.

mod memory;
mod time;

use tokio::sync::{Mutex, MutexGuard};

/// One attack after the other: each of them is meant to take all of the machine that it can get.
static ALONE: Mutex<()> = Mutex::const_new(());

async fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().await
}

/// A mebibyte.
const MIB: usize = 1 << 20;
