//! CORS: which pages of other origins may use the API from a browser.

use std::time::Duration;

use axum::http::{HeaderName, Method, header};
use tower_http::cors::{AllowOrigin, CorsLayer};

use super::request_id::REQUEST_ID;
use crate::config::origin::Origin;
use crate::telemetry::request::{TRACE_PARENT, TRACE_RESPONSE, TRACE_STATE};

/// How long browsers cache the answer to a preflight request.
const MAX_AGE: Duration = Duration::from_secs(7200);

/// The request headers that pages may send.
const READ: [HeaderName; 11] = [
    header::ACCEPT,
    header::AUTHORIZATION,
    header::CONTENT_ENCODING,
    header::CONTENT_TYPE,
    HeaderName::from_static("idempotency-key"),
    HeaderName::from_static("last-event-id"),
    HeaderName::from_static("prefer"),
    REQUEST_ID,
    TRACE_PARENT,
    TRACE_STATE,
    // Browsers send it when a page bypasses the cache.
    header::CACHE_CONTROL,
];

/// The answer headers that pages may read, beyond those that they always may.
const SHOWN: [HeaderName; 10] = [
    header::ALLOW,
    header::CONTENT_DISPOSITION,
    header::LOCATION,
    header::RETRY_AFTER,
    header::WWW_AUTHENTICATE,
    HeaderName::from_static("idempotency-replayed"),
    HeaderName::from_static("piad-resumed-after"),
    HeaderName::from_static("preference-applied"),
    REQUEST_ID,
    TRACE_RESPONSE,
];

/// Allows pages of these origins to use the whole API. Without origins there is no layer, and browsers
/// let no page read an answer.
pub(super) fn layer(origins: &[Origin]) -> Option<CorsLayer> {
    let mut listed = Vec::new();
    for origin in origins {
        match origin {
            Origin::Any => return Some(of(AllowOrigin::any())),
            Origin::One(origin) => listed.push(origin.clone()),
        }
    }
    (!listed.is_empty()).then(|| of(AllowOrigin::list(listed)))
}

fn of(origins: AllowOrigin) -> CorsLayer {
    CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::DELETE])
        .allow_headers(READ)
        .expose_headers(SHOWN)
        .max_age(MAX_AGE)
}
