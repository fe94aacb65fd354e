//! CORS: which pages of other origins may use the API from a browser.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use axum::http::{HeaderName, HeaderValue, Method, Uri, header};
use tower_http::cors::{AllowOrigin, CorsLayer};

use super::request_id::REQUEST_ID;
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

/// An origin, as a browser writes it; or any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// `*`
    Any,
    /// Such as `https://cad.example:8443`.
    One(HeaderValue),
}

impl FromStr for Origin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "*" {
            return Ok(Self::Any);
        }
        let why = || {
            "not *, and not an origin such as https://cad.example or http://localhost:3000, without a path".to_owned()
        };
        let text = text.to_ascii_lowercase();
        let uri: Uri = text.parse().map_err(|_| why())?;
        let (Some(scheme), Some(authority)) = (uri.scheme_str(), uri.authority()) else {
            return Err(why());
        };
        if format!("{scheme}://{authority}") != text || text.contains(['@', '*']) {
            return Err(why());
        }
        text.parse().map(Self::One).map_err(|_| why())
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("*"),
            Self::One(origin) => f.write_str(origin.to_str().unwrap_or("")),
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_written_as_browsers_do() {
        for text in [
            "*",
            "https://cad.example",
            "http://localhost:3000",
            "http://[::1]:80",
        ] {
            assert_eq!(text.parse::<Origin>().unwrap().to_string(), text);
        }
        let upper: Origin = "HTTPS://Cad.Example".parse().unwrap();
        assert_eq!(upper.to_string(), "https://cad.example");
        for text in [
            "",
            "cad.example",
            "https://cad.example/",
            "https://cad.example/path",
            "https://*.example",
            "https://a@b.example",
            "null",
            "https://",
        ] {
            assert!(text.parse::<Origin>().is_err(), "{text}");
        }
    }
}
