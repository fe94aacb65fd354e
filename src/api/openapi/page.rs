//! The reference page of the API: Swagger UI for the OpenAPI document, served by this server alone.
//!
//! Its files are built into the program, and its pages may not load anything from elsewhere.

use axum::http::HeaderMap;
use axum::response::Response;

use crate::api::http::assets::{Asset, Site};
use crate::api::http::path::InPath;
use crate::api::problem::Problem;

/// Its files, with the licence of Swagger UI: Apache License 2.0.
pub(super) static REFERENCE: Site = Site {
    name: "the reference",
    files: include!(concat!(env!("OUT_DIR"), "/reference.rs")),
    root: "page.html",
    policy: POLICY,
};

/// Swagger UI needs inline styles, and has its icons as data in its style sheet.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'";

/// `GET /docs`
pub(crate) async fn page(headers: HeaderMap) -> Result<Response, Problem> {
    REFERENCE.root(&headers)
}

/// `GET /docs/{file}`
pub(crate) async fn file(
    InPath(name): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    REFERENCE.part(&headers, &name)
}
