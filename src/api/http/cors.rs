//! Which pages of other origins may use the API from a browser.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use axum::http::{HeaderName, HeaderValue, Method, Uri, header};
use tower_http::cors::{AllowOrigin, CorsLayer};

use super::request_id::REQUEST_ID;

/// How long a browser need not ask again what it may send.
const MAX_AGE: Duration = Duration::from_secs(7200);

/// What the API reads of requests.
const READ: [HeaderName; 7] = [
    header::ACCEPT,
    header::CONTENT_TYPE,
    HeaderName::from_static("idempotency-key"),
    HeaderName::from_static("last-event-id"),
    HeaderName::from_static("prefer"),
    REQUEST_ID,
    // Browsers set it for pages that ask for the newest.
    header::CACHE_CONTROL,
];

/// What answers have for clients, beyond what browsers show to every page.
const SHOWN: [HeaderName; 8] = [
    header::ALLOW,
    header::CONTENT_DISPOSITION,
    header::LOCATION,
    header::RETRY_AFTER,
    HeaderName::from_static("idempotency-replayed"),
    HeaderName::from_static("piad-resumed-after"),
    HeaderName::from_static("preference-applied"),
    REQUEST_ID,
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

/// Tells browsers what pages of these origins may do, which is everything; `None` tells them nothing,
/// so that they let no page read an answer.
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
