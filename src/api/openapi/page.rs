//! The reference of the API for people: Swagger UI over the description, from this server alone.
//!
//! Its files are built into the program, and its pages may not load anything from elsewhere.

use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};

use crate::api::http::path::InPath;
use crate::api::problem::{Kind, Problem};
use crate::model::short::quoted;

const HTML: &str = include_str!("page.html");

/// The files, with their media types.
pub(super) const FILES: [(&str, &str, &[u8]); 5] = [
    (
        "start.js",
        "text/javascript; charset=utf-8",
        include_bytes!("start.js"),
    ),
    (
        "swagger-ui-bundle.js",
        "text/javascript; charset=utf-8",
        include_bytes!(concat!(env!("OUT_DIR"), "/swagger-ui-bundle.js")),
    ),
    (
        "swagger-ui.css",
        "text/css; charset=utf-8",
        include_bytes!(concat!(env!("OUT_DIR"), "/swagger-ui.css")),
    ),
    // The licence of Swagger UI: Apache License 2.0.
    (
        "LICENSE",
        "text/plain; charset=utf-8",
        include_bytes!(concat!(env!("OUT_DIR"), "/LICENSE")),
    ),
    (
        "NOTICE",
        "text/plain; charset=utf-8",
        include_bytes!(concat!(env!("OUT_DIR"), "/NOTICE")),
    ),
];

/// Swagger UI needs inline styles, and has its icons as data in its style sheet.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'";

/// `GET /docs`
pub async fn page() -> Response {
    answer("text/html; charset=utf-8", HTML.as_bytes())
}

/// `GET /docs/{file}`
pub async fn file(InPath(name): InPath<String>) -> Result<Response, Problem> {
    let known = FILES.iter().find(|(file, ..)| *file == name);
    known
        .map(|(_, media_type, bytes)| answer(media_type, bytes))
        .ok_or_else(|| {
            Problem::new(
                Kind::NotFound,
                format!("the reference has no {}", quoted(&name)),
            )
        })
}

fn answer(media_type: &'static str, bytes: &'static [u8]) -> Response {
    let headers = [
        (header::CONTENT_TYPE, media_type),
        // The next version of the program may have other files.
        (header::CACHE_CONTROL, "no-cache"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    let headers =
        headers.map(|(name, value): (HeaderName, _)| (name, HeaderValue::from_static(value)));
    (headers, bytes).into_response()
}
