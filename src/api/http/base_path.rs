//! The path prefix under which clients see the server.

use axum::Router;
use axum::extract::Request;
use axum::http::{Method, Uri, uri};
use axum::response::{IntoResponse, Redirect, Response};
use tower::ServiceExt;

use crate::config::BasePath;

/// The resources under a path prefix. They are available without it as well: for proxies that strip it, for health
/// probes, and for gRPC, whose paths have no prefix.
pub(super) fn below(router: Router, base_path: &BasePath) -> Router {
    let base = base_path.as_str().to_owned();
    if base.is_empty() {
        return router;
    }
    Router::new().fallback(async move |mut request: Request| -> Response {
        let reads = matches!(*request.method(), Method::GET | Method::HEAD);
        if reads && request.uri().path() == base {
            // Relative addresses in the page begin below the path, which needs the slash.
            let query = request.uri().query().map(|query| format!("?{query}"));
            let whole = format!("{base}/{}", query.unwrap_or_default());
            return Redirect::permanent(&whole).into_response();
        }
        if let Some(uri) = stripped(request.uri(), &base) {
            *request.uri_mut() = uri;
        }
        match router.oneshot(request).await {
            Ok(response) => response,
            Err(never) => match never {},
        }
    })
}

/// The address without the prefix, if it begins with it.
fn stripped(uri: &Uri, base: &str) -> Option<Uri> {
    let whole = uri.path_and_query()?.as_str();
    let rest = whole.strip_prefix(base)?;
    let rest = match rest.chars().next() {
        Some('/') => rest.to_owned(),
        None | Some('?') => format!("/{rest}"),
        Some(_) => return None,
    };
    let mut parts = uri.clone().into_parts();
    parts.path_and_query = Some(uri::PathAndQuery::try_from(rest).ok()?);
    Uri::from_parts(parts).ok()
}
