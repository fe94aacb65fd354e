//! The span of a request: its parent is what `traceparent` names (W3C Trace Context), and its ids are returned to the
//! client. It is a task-local variable of the task that answers the request.

use std::collections::HashMap;

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::Response;
use opentelemetry::Context;
use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::{SpanContext, TraceContextExt};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use prometheus_client::encoding::EncodeLabelSet;
use tokio::task_local;
use tracing::field::Empty;
use tracing::{Span, debug_span};
use tracing_opentelemetry::OpenTelemetrySpanExt;

use super::TARGET;

/// The headers of requests that name their parents.
pub(crate) const TRACE_PARENT: HeaderName = HeaderName::from_static("traceparent");
pub(crate) const TRACE_STATE: HeaderName = HeaderName::from_static("tracestate");

/// The header of answers that names their spans (W3C Trace Context, level 2).
pub(crate) const TRACE_RESPONSE: HeaderName = HeaderName::from_static("traceresponse");

task_local! {
    static CURRENT: RequestTrace;
}

/// The span of a request.
#[derive(Clone, Debug)]
pub(crate) struct RequestTrace {
    pub(crate) span: Span,
    context: SpanContext,
}

/// A request among those of a bucket of the metrics.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub(crate) struct Exemplar {
    trace_id: String,
    span_id: String,
}

impl RequestTrace {
    /// Begins the span of a request, if spans are exported.
    pub(crate) fn begin(method: &str, route: Option<&str>, headers: &HeaderMap) -> Option<Self> {
        let span = debug_span!(
            target: TARGET,
            parent: None,
            "http",
            otel.name = name(method, route),
            otel.kind = "server",
            otel.status_code = Empty,
            http.request.method = method,
            http.route = route,
            http.response.status_code = Empty,
            rpc.grpc.status_code = Empty,
        );
        if span.is_disabled() {
            return None;
        }
        // It has just been created: its parent can still be set.
        let _ = span.set_parent(parent(headers));
        let context = span.context().span().span_context().clone();
        Some(Self { span, context })
    }

    /// The span of the request that the current task answers.
    pub(crate) fn current() -> Option<Self> {
        CURRENT.try_with(Self::clone).ok()
    }

    /// Runs a future that answers the request.
    pub(crate) fn scope<F: Future>(self, future: F) -> impl Future<Output = F::Output> {
        CURRENT.scope(self, future)
    }

    /// Notes how the request was answered, and adds the trace ids to the answer.
    pub(crate) fn answer(&self, response: &mut Response) {
        let status = response.status();
        self.span
            .record("http.response.status_code", i64::from(status.as_u16()));
        let code = response.headers().get("grpc-status");
        let code = code.and_then(|code| code.to_str().ok()?.parse::<i64>().ok());
        if let Some(code) = code {
            self.span.record("rpc.grpc.status_code", code);
        }
        if status.is_server_error() || code.is_some_and(is_fault) {
            self.span.record("otel.status_code", "ERROR");
        }
        let flags = self.context.trace_flags().to_u8();
        let ids = (self.trace_id(), self.context.span_id());
        let header = HeaderValue::try_from(format!("00-{}-{}-{flags:02x}", ids.0, ids.1));
        if let Ok(header) = header {
            response.headers_mut().insert(TRACE_RESPONSE, header);
        }
    }

    /// Makes a new span its child that may end later: a child by `tracing` would keep it open.
    pub(crate) fn adopt(&self, child: &Span) {
        let _ = child.set_parent(self.span.context());
    }

    /// The id of its trace, exported or not.
    pub(crate) fn trace_id(&self) -> String {
        self.context.trace_id().to_string()
    }

    /// Its ids, if it is exported.
    pub(crate) fn exemplar(&self) -> Option<Exemplar> {
        self.context.is_sampled().then(|| Exemplar {
            trace_id: self.trace_id(),
            span_id: self.context.span_id().to_string(),
        })
    }
}

fn name(method: &str, route: Option<&str>) -> String {
    route.map_or_else(|| method.to_owned(), |route| format!("{method} {route}"))
}

/// The span that the headers name; `None` if they are invalid, or name several.
fn parent(headers: &HeaderMap) -> Context {
    let joined = |name: HeaderName| {
        let values = headers.get_all(&name).iter();
        let values: Vec<_> = values.filter_map(|value| value.to_str().ok()).collect();
        (name.as_str().to_owned(), values.join(","))
    };
    let headers = HashMap::from([TRACE_PARENT, TRACE_STATE].map(joined));
    TraceContextPropagator::new().extract_with_context(&Context::new(), &headers)
}

/// Returns true if a status of gRPC is an error of the server: unknown, deadline exceeded, unimplemented, internal,
/// unavailable, data loss.
fn is_fault(code: i64) -> bool {
    matches!(code, 2 | 4 | 12 | 13 | 14 | 15)
}
