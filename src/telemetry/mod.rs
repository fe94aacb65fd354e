//! Traces of requests and jobs, for a collector that speaks OTLP (OpenTelemetry) over gRPC.
//!
//! - [`endpoint`]: the address of the collector; `exports`: counts of exported spans;
//! - `request`: the span of a request, and its ids for clients; those of jobs are in `job::trace`.
//!
//! Spans are those of `tracing` with the target `TARGET`, which the log never shows. Each is made with its
//! parent, as work moves between tasks and threads. Without a collector they are disabled, which costs a
//! comparison.

pub mod endpoint;
mod exports;
pub(crate) mod request;

use std::env;
use std::sync::atomic::Ordering;
use std::time::Duration;

use opentelemetry::KeyValue;
use opentelemetry::trace::TracerProvider;
use opentelemetry_otlp::tonic_types::transport::ClientTlsConfig;
use opentelemetry_otlp::{SpanExporter, WithExportConfig, WithTonicConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::resource::{EnvResourceDetector, TelemetryResourceDetector};
use opentelemetry_sdk::trace::SdkTracerProvider;
use tokio::runtime::{Builder, Runtime};
use tracing::Subscriber;
use tracing_subscriber::filter::{EnvFilter, dynamic_filter_fn};
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::registry::{LookupSpan, Registry};
use tracing_subscriber::util::SubscriberInitExt;

use endpoint::Endpoint;
use exports::{Counted, IS_ON};
pub(crate) use exports::{is_on, register};

/// The target of all spans that are exported.
pub(crate) const TARGET: &str = "piad::trace";

/// The longest time that the last export may take.
const LAST_EXPORT: Duration = Duration::from_secs(2);

/// Exports spans until it is stopped.
#[derive(Debug)]
pub struct Telemetry {
    provider: SdkTracerProvider,
    /// The connection to the collector has its own thread: no request waits for it, and it does not wait for a thread
    /// that serves requests, of which there may be one.
    runtime: Runtime,
}

impl Telemetry {
    /// Exports to this collector. A queue of bounded length takes the spans; when it is full they are dropped.
    ///
    /// # Errors
    ///
    /// If there can be no connection or no thread for it.
    pub fn start(endpoint: &Endpoint) -> Result<Self, String> {
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("piad-traces")
            .enable_all()
            .build()
            .map_err(|reason| reason.to_string())?;
        let inside = runtime.enter();
        let exporter = SpanExporter::builder()
            .with_tonic()
            .with_endpoint(endpoint.url());
        let exporter = match endpoint.is_secure() {
            true => exporter.with_tls_config(ClientTlsConfig::new().with_enabled_roots()),
            false => exporter,
        };
        let exporter = exporter.build().map_err(|reason| reason.to_string())?;
        let provider = SdkTracerProvider::builder()
            .with_batch_exporter(Counted(exporter))
            .with_resource(resource())
            .build();
        drop(inside);
        Ok(Self { provider, runtime })
    }

    /// Exports the spans with the [`TARGET`], and no others. They are checked each time, as cached interest of other
    /// spans must not apply to them.
    fn layer<S>(&self) -> impl Layer<S> + use<S>
    where
        S: Subscriber + for<'a> LookupSpan<'a>,
    {
        tracing_opentelemetry::layer()
            .with_tracer(self.provider.tracer("piad"))
            .with_context_activation(false)
            .with_location(false)
            .with_target(false)
            .with_threads(false)
            .with_tracked_inactivity(false)
            .with_filter(dynamic_filter_fn(|span, _| span.target() == TARGET))
    }

    /// Exports the rest, within two seconds and the grace period. Must be called outside of any runtime, as it blocks
    /// the thread.
    pub fn stop(self, grace: Duration) {
        // Success is visible at the collector; the log has ended.
        let _ = self.provider.shutdown_with_timeout(grace.min(LAST_EXPORT));
        self.runtime.shutdown_background();
    }
}

/// Starts the log with this filter, and the export of spans.
///
/// The filter is that of the whole subscriber. If the log alone had it, it would miss an event now and then: the result
/// of a library's `enabled!` is applied to the next event. The log shows no spans, as none is entered.
///
/// # Errors
///
/// If spans cannot be set up.
pub fn start_log(
    log: Box<dyn Layer<Registry> + Send + Sync>,
    filter: EnvFilter,
    telemetry: Option<&Telemetry>,
) -> Result<(), String> {
    let level = if telemetry.is_some() { "debug" } else { "off" };
    let spans = format!("{TARGET}={level}").parse();
    let filter = filter.add_directive(spans.map_err(|reason| format!("{reason}"))?);
    let log = tracing_subscriber::registry().with(log);
    match telemetry {
        Some(telemetry) => log.with(telemetry.layer()).with(filter).init(),
        None => log.with(filter).init(),
    }
    IS_ON.store(telemetry.is_some(), Ordering::Relaxed);
    Ok(())
}

/// The resource of the spans: this program, under the name that the environment gives it.
fn resource() -> Resource {
    let resource = Resource::builder_empty()
        .with_attributes([
            KeyValue::new("service.name", "piad"),
            KeyValue::new("service.version", env!("CARGO_PKG_VERSION")),
        ])
        .with_detectors(&[
            Box::new(TelemetryResourceDetector),
            Box::new(EnvResourceDetector::new()),
        ]);
    match env::var("OTEL_SERVICE_NAME") {
        Ok(name) if !name.is_empty() => resource.with_service_name(name).build(),
        _ => resource.build(),
    }
}
