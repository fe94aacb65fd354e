//! Timeouts of HTTP/2 streams whose client leaves them no flow-control window.
//!
//! If a client keeps the window of the connection open but not that of a stream, the answer waits although nothing
//! waits to be written to the socket. Each stream has a task of its own, which is dropped when it has had something to
//! send for too long; the other streams of the connection continue.

use std::cell::Cell;
use std::pin::pin;
use std::task::Poll;

use tokio::task_local;
use tokio::time::{Duration, Instant, sleep};
use tracing::debug;

task_local! {
    static STEP: Cell<BodyStep>;
}

/// What a task did with the body of its answer while it was polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BodyStep {
    /// Nothing: it is preparing the answer, or waits for window.
    Untouched,
    /// It polled the body, which had nothing ready.
    Requested,
    /// It got something to send.
    Given,
}

/// Notes that the body is polled.
pub(super) fn requested() {
    set(BodyStep::Requested);
}

/// Notes that the body has returned something.
pub(super) fn given() {
    set(BodyStep::Given);
}

fn set(step: BodyStep) {
    // HTTP/1 answers are polled outside of such a task.
    let _ = STEP.try_with(|current| current.set(step));
}

/// Runs the task of a stream until it ends, or until it could not send anything for `limit`.
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
            BodyStep::Requested => stalled = false,
            BodyStep::Given => {
                stalled = true;
                timer.as_mut().reset(Instant::now() + limit);
            }
        }
        if stalled && timer.as_mut().poll(context).is_ready() {
            debug!("an answer is abandoned: the client has granted it no window for {limit:?}");
            return Poll::Ready(());
        }
        Poll::Pending
    })
    .await;
}
