//! The numbers of spans that have been exported, and that have not.

use opentelemetry_sdk::Resource;
use opentelemetry_sdk::error::OTelSdkResult;
use opentelemetry_sdk::trace::{SpanData, SpanExporter};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::registry::Registry;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// True if spans are exported.
pub(super) static IS_ON: AtomicBool = AtomicBool::new(false);

/// Spans that the collector has accepted, and spans that it has not. Those that do not fit in the queue, when many come
/// or the collector is slow, are in neither.
static EXPORTED: LazyLock<Counter> = LazyLock::new(Counter::default);
static FAILED: LazyLock<Counter> = LazyLock::new(Counter::default);

/// Returns true if spans are exported.
pub(crate) fn is_on() -> bool {
    IS_ON.load(Ordering::Relaxed)
}

/// Registers the metrics under their names, if spans are exported.
pub(crate) fn register(registry: &mut Registry) {
    if !is_on() {
        return;
    }
    let help = "Spans of traces that the collector has accepted";
    registry.register("piad_trace_spans_exported", help, EXPORTED.clone());
    let help = "Spans of traces that were sent to the collector without success, and are lost";
    registry.register("piad_trace_spans_failed", help, FAILED.clone());
}

/// Counts the results of an exporter.
#[derive(Debug)]
pub(super) struct Counted<E>(pub E);

impl<E: SpanExporter> SpanExporter for Counted<E> {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        let count = batch.len() as u64;
        let exported = self.0.export(batch).await;
        let counter = if exported.is_ok() { &EXPORTED } else { &FAILED };
        counter.inc_by(count);
        exported
    }

    fn shutdown_with_timeout(&self, timeout: Duration) -> OTelSdkResult {
        self.0.shutdown_with_timeout(timeout)
    }

    fn force_flush(&self) -> OTelSdkResult {
        self.0.force_flush()
    }

    fn set_resource(&mut self, resource: &Resource) {
        self.0.set_resource(resource);
    }
}
