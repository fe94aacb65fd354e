//! Streams of HTTP/2 whose client leaves them no room.
//!
//! A client that opens the window of the connection but not that of a stream lets the answer wait
//! though nothing waits to be written. Each answer has a task of its own, which is given up when it
//! has something to send and may not for too long; other streams of the connection are not concerned.

use std::cell::Cell;
use std::pin::pin;
use std::task::Poll;

use tokio::task_local;
use tokio::time::{Duration, Instant, sleep};
use tracing::debug;

task_local! {
    static STEP: Cell<BodyStep>;
}

/// What a task has done with the body of its answer when it was polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BodyStep {
    /// Nothing: it works on the answer, or waits for room.
    Untouched,
    /// It has asked for more, and there was nothing yet.
    Asked,
    /// It was given something to send.
    Given,
}

/// The body is asked for more.
pub(super) fn asked() {
    set(BodyStep::Asked);
}

/// The body has given something.
pub(super) fn given() {
    set(BodyStep::Given);
}

fn set(step: BodyStep) {
    // Other tasks send without windows of streams.
    let _ = STEP.try_with(|current| current.set(step));
}

/// Runs the task of a stream until it ends, or cannot send anything for longer than `limit`.
pub(super) async fn unless_stalled(limit: Duration, task: impl Future<Output = ()>) {
    let mut task = pin!(task);
    let mut timer = pin!(sleep(limit));
    let mut stalled = false;
    std::future::poll_fn(|context| {
        let (polled, step) = STEP.sync_scope(Cell::new(BodyStep::Untouched), || {
            (task.as_mut().poll(context), STEP.with(Cell::get))
        });
        if polled.is_ready() {
            return Poll::Ready(());
        }
        match step {
            BodyStep::Untouched => {}
            BodyStep::Asked => stalled = false,
            BodyStep::Given => {
                stalled = true;
                timer.as_mut().reset(Instant::now() + limit);
            }
        }
        if stalled && timer.as_mut().poll(context).is_ready() {
            debug!("an answer is given up: the client has left it no room for {limit:?}");
            return Poll::Ready(());
        }
        Poll::Pending
    })
    .await;
}
