//! Problems as answers of HTTP.

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::coding::UNDERSTOOD;
use super::newline;
use super::request_id::REQUEST_ID;
use crate::api::json::view::to_bytes;
use crate::api::problem::{Kind, Problem};
use crate::telemetry::request::RequestTrace;

impl IntoResponse for Problem {
    /// The problem is passed as an extension; [`render`] writes it, with the id of the request.
    fn into_response(self) -> Response {
        let mut response = self.kind().entry().status.into_response();
        let headers = response.headers_mut();
        if self.kind() == Kind::UnsupportedEncoding {
            // The codings that are accepted (RFC 9110, 15.5.16).
            headers.insert(
                header::ACCEPT_ENCODING,
                HeaderValue::from_static(UNDERSTOOD),
            );
        }
        if let Some(seconds) = self.retry() {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response.extensions_mut().insert(self);
        response
    }
}

/// Writes problems as JSON, ends JSON with a newline, and names the request in every answer.
pub(super) async fn render(request: Request, next: Next) -> Response {
    let id = request.headers().get(REQUEST_ID).cloned();
    let mut response = next.run(request).await;
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        let text = id.as_ref().and_then(|id| id.to_str().ok());
        let mut body = problem.body(text);
        body.trace_id = RequestTrace::current().map(|trace| trace.trace_id());
        *response.body_mut() = Body::from(to_bytes(&body));
        let headers = response.headers_mut();
        headers.insert(
            header::CONTENT_TYPE,
            HeaderValue::from_static("application/problem+json"),
        );
        headers.remove(header::CONTENT_LENGTH);
    }
    let mut response = newline::ended(response);
    if let Some(id) = id {
        response.headers_mut().insert(REQUEST_ID, id);
    }
    response
}
