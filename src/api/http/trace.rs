//! The spans of requests: from their heads to the heads of their answers.

use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::Response;

use super::measure;
use crate::telemetry::request::RequestTrace;

/// Answers a request within a span.
pub(super) async fn trace(request: Request, next: Next) -> Response {
    let method = measure::name(request.method());
    let route = request.extensions().get::<MatchedPath>();
    let route = route.map(MatchedPath::as_str);
    let Some(trace) = RequestTrace::begin(method, route, request.headers()) else {
        return next.run(request).await;
    };
    let mut response = trace.clone().scope(next.run(request)).await;
    trace.answer(&mut response);
    response
}
