//! Compresses answers for clients that accept it (`Accept-Encoding`), with gzip or zstd.
//!
//! Numbers as text become less than half as long. Event streams stay as they are: their events would wait
//! for each other in the compressor.

use axum::http::{HeaderMap, Response, StatusCode, header};
use http_body::Body;
use tower_http::CompressionLevel;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::Predicate;

/// Shorter answers fit into a packet as they are.
const LEAST: u64 = 1024;

/// Higher levels take much longer on decimal digits and save little. At the lowest one gzip makes binary numbers
/// longer.
const LEVEL: CompressionLevel = CompressionLevel::Precise(2);

/// Compresses answers that are worth it.
pub(super) fn layer() -> CompressionLayer<Worthwhile> {
    CompressionLayer::new()
        .quality(LEVEL)
        .compress_when(Worthwhile)
}

/// Selects answers that are long enough, not compressed yet, and neither an event stream nor gRPC, which compresses by
/// itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worthwhile;

impl Predicate for Worthwhile {
    fn should_compress<B: Body>(&self, response: &Response<B>) -> bool {
        let headers: &HeaderMap = response.headers();
        let text = |name| {
            let value = headers.get(name);
            value.and_then(|value| value.to_str().ok()).unwrap_or("")
        };
        let upper = response.body().size_hint().upper();
        let short = upper.is_some_and(|length| length < LEAST);
        let bodiless = [StatusCode::NO_CONTENT, StatusCode::NOT_MODIFIED];
        let media_type = text(header::CONTENT_TYPE);
        !short
            && !bodiless.contains(&response.status())
            // Files with a tag have compressed forms of their own.
            && !headers.contains_key(header::ETAG)
            && !text(header::CACHE_CONTROL).contains("no-transform")
            && !media_type.is_empty()
            && !media_type.starts_with("application/grpc")
    }
}
