//! The spans of a job: one for the job, with child spans for its work. Without a collector there are none.

use std::sync::atomic::{AtomicUsize, Ordering};

use parking_lot::Mutex;
use tracing::field::Empty;
use tracing::{Span, debug_span};

use super::outline::Outline;
use super::state::{State, Status};
use crate::telemetry::TARGET;
use crate::telemetry::request::RequestTrace;

/// The number of slices of a job with spans, and of encodings: endless jobs have endlessly many.
const MAX_SPANS: usize = 32;

/// The span of a job, shared by all tasks that work on it. It ends with the job, whatever still holds this.
#[derive(Debug)]
pub(crate) struct JobTrace {
    span: Mutex<Span>,
    slices: AtomicUsize,
    encodings: AtomicUsize,
}

impl Default for JobTrace {
    fn default() -> Self {
        Self {
            span: Mutex::new(Span::none()),
            slices: AtomicUsize::new(0),
            encodings: AtomicUsize::new(0),
        }
    }
}

impl JobTrace {
    /// Begins the span of a job, if it has none: a child of the request that has created it.
    pub(crate) fn begin(&self, outline: &Outline, request: Option<&RequestTrace>) {
        let mut span = self.span.lock();
        if !span.is_disabled() {
            return;
        }
        *span = debug_span!(
            target: TARGET,
            parent: None,
            "job",
            otel.status_code = Empty,
            piad.job.id = %outline.id,
            piad.job.kind = if outline.surface { "surface" } else { "curve" },
            piad.job.points = integer(outline.grid.count()),
            piad.job.method = outline.method.name(),
            piad.job.iterations = Empty,
            piad.job.slices = Empty,
            piad.job.state = Empty,
        );
        if let Some(request) = request {
            request.adopt(&span);
        }
    }

    /// Ends the span of a job, whose state is then this one.
    pub(crate) fn end(&self, status: &Status) {
        self.end_in(status.state.name(), status);
    }

    /// Ends the span of a job that was abandoned before it was stored.
    pub(crate) fn abandon(&self, status: &Status) {
        self.end_in("abandoned", status);
    }

    fn end_in(&self, state: &str, status: &Status) {
        let span = std::mem::replace(&mut *self.span.lock(), Span::none());
        if span.is_disabled() {
            return;
        }
        span.record("piad.job.state", state);
        span.record(
            "piad.job.slices",
            integer(self.slices.load(Ordering::Relaxed)),
        );
        if let Some(levels) = status.levels {
            span.record("piad.job.iterations", integer(levels.last.iteration));
        }
        if status.state == State::Failed {
            span.record("otel.status_code", "ERROR");
        }
    }

    /// Waiting for memory and for a turn.
    pub(super) fn queue(&self) -> Span {
        self.child(|job| debug_span!(target: TARGET, parent: job, "queue"))
    }

    /// The computation before level 0.
    pub(super) fn set_up(&self) -> Span {
        self.child(|job| debug_span!(target: TARGET, parent: job, "set-up"))
    }

    /// A slice of the iterations, which begins at this level.
    pub(super) fn slice(&self, level: usize) -> Span {
        match is_one_of_the_first(&self.slices) {
            true => self.child(|job| {
                debug_span!(target: TARGET, parent: job, "slice", piad.iteration = integer(level))
            }),
            false => Span::none(),
        }
    }

    /// The encoding of this many numbers off the network threads, for this request if the job has ended.
    pub(crate) fn encode(&self, numbers: usize) -> Span {
        let encode = |parent: &Span| debug_span!(target: TARGET, parent: parent, "encode", piad.numbers = integer(numbers));
        let job = self.span.lock().clone();
        match RequestTrace::current() {
            _ if !job.is_disabled() && is_one_of_the_first(&self.encodings) => encode(&job),
            Some(request) => encode(&request.span),
            None => Span::none(),
        }
    }

    /// Waits for a change in the store.
    pub(super) async fn store<F: Future>(&self, change: &str, stored: F) -> F::Output {
        let _span = self.child(
            |job| debug_span!(target: TARGET, parent: job, "store", piad.store.change = change),
        );
        stored.await
    }

    /// A child span of the job. Without a span of the job it would be the root of another trace.
    fn child(&self, make: impl FnOnce(&Span) -> Span) -> Span {
        let job = self.span.lock().clone();
        if job.is_disabled() { job } else { make(&job) }
    }
}

fn is_one_of_the_first(count: &AtomicUsize) -> bool {
    count.fetch_add(1, Ordering::Relaxed) < MAX_SPANS
}

/// A number in the form of collectors.
fn integer(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
