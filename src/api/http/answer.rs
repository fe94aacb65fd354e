//! Answers: small ones at once, large ones piece by piece.

use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_util::{StreamExt, stream};

use crate::api::stream::sending::{Outgoing, SENT_BYTES};
use crate::job::Job;
use crate::job::content::Content;

/// A content as an answer; large ones are streamed.
pub(super) fn answer(job: &Arc<Job>, content: Content, content_type: &'static str) -> Response {
    if content.rest.is_none() && content.head.len() <= SENT_BYTES {
        return whole(content.head, content_type);
    }
    let length = content.length();
    let mut outgoing = Outgoing::new(Arc::clone(job.resources()));
    outgoing.push(content);
    let body = stream::unfold(outgoing, |mut outgoing| async move {
        let bytes = outgoing.next().await?;
        Some((bytes, outgoing))
    });
    let mut response = whole(Body::from_stream(body.fuse()), content_type);
    if let Some(length) = length {
        let length = HeaderValue::from(length);
        response
            .headers_mut()
            .insert(header::CONTENT_LENGTH, length);
    }
    response
}

/// A body of this media type as an answer.
pub(super) fn whole(body: impl IntoResponse, content_type: &'static str) -> Response {
    let content_type = HeaderValue::from_static(content_type);
    no_store(([(header::CONTENT_TYPE, content_type)], body).into_response())
}

/// Answers of this API change all the time, so they must not be stored.
pub(super) fn no_store(mut response: Response) -> Response {
    let value = HeaderValue::from_static("no-store");
    response.headers_mut().insert(header::CACHE_CONTROL, value);
    response
}
