//! The parameters in a path.

use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use crate::api::problem::{Kind, Problem};
use piad_files::text;

/// The parameters in a path. Those that are not UTF-8, such as `%FF`, give 404.
#[derive(Debug)]
pub(crate) struct InPath<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for InPath<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let path = Path::from_request_parts(parts, state).await;
        path.map(|Path(names)| Self(names)).map_err(|_| {
            let path = text::plain(parts.uri.path());
            Problem::new(Kind::NotFound, format!("no resource at {path}"))
        })
    }
}
