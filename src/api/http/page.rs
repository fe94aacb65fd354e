//! The viewer: the page that browsers get at `/`, and its files.
//!
//! It is built from `viewer` and committed in `viewer/dist`, so that building the program needs
//! only Rust. All of its addresses are relative: it works under any path of a proxy.

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};

use super::assets::{Asset, Site};
use super::path::InPath;
use super::{info, negotiate};
use crate::api::app::App;
use crate::api::media_type::JSON;
use crate::api::problem::Problem;

static PAGE: Site = Site {
    name: "the page",
    files: include!(concat!(env!("OUT_DIR"), "/viewer.rs")),
    root: "index.html",
    policy: POLICY,
};

/// The Content-Security-Policy of the page.
///
/// - `script-src`, `style-src`: the scripts and styles of this server. Inline ones are forbidden,
///   so that the name of a job is never executed.
/// - `connect-src`: the API of this server; data of the user go nowhere else.
/// - `img-src`: pictures of this server, and those that the page makes, as `data:` and `blob:`.
/// - `worker-src`: scripts of this server in threads of their own.
/// - `base-uri`: the meaning of relative addresses cannot be changed.
/// - `frame-ancestors`: no other page can embed this one, which prevents clickjacking.
/// - `form-action`: forms cannot be sent.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
    img-src 'self' data: blob:; worker-src 'self'; base-uri 'none'; frame-ancestors 'none'; form-action 'none'";

/// `GET /`: the page for browsers, which prefer HTML, and the index for programs.
pub(super) async fn root(State(app): State<App>, headers: HeaderMap) -> Result<Response, Problem> {
    // An Accept header that excludes both, or cannot be read, gets the index.
    let html = negotiate::choose(&headers, &[(JSON, false), ("text/html", true)]);
    let mut response = match html.unwrap_or(false) {
        true => PAGE.root(&headers)?,
        false => info::index(app.config.base_path.as_str()).into_response(),
    };
    let vary = HeaderValue::from_static("accept");
    response.headers_mut().append(header::VARY, vary);
    Ok(response)
}

/// `GET /viewer/{part}`: a file that the page needs.
pub(super) async fn part(
    InPath(name): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    PAGE.part(&headers, &name)
}
