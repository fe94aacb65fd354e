//! Answers in JSON end with a newline, so the shell prompt starts on a new line.
//!
//! Lines of event streams have theirs already.

use std::pin::Pin;
use std::task::{Context, Poll, ready};

use axum::body::Body;
use axum::http::{HeaderValue, header};
use axum::response::Response;
use bytes::Bytes;
use http_body::{Frame, SizeHint};

use crate::api::media_type::JSON;

const NEWLINE: Bytes = Bytes::from_static(b"\n");

/// The answer with a newline behind its JSON.
pub(super) fn ended(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let media_type = headers.get(header::CONTENT_TYPE);
    let media_type = media_type.and_then(|value| value.to_str().ok());
    let is_json = matches!(media_type, Some(JSON | "application/problem+json"));
    // Files of the page are unchanged: their tags are hashes of their bytes.
    if !is_json || headers.contains_key(header::ETAG) {
        return response;
    }
    let length = headers.get(header::CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if let Some(length) = length {
        headers.insert(header::CONTENT_LENGTH, HeaderValue::from(length + 1));
    }
    response.map(|body| {
        Body::new(Ended {
            body,
            newline: Some(NEWLINE),
        })
    })
}

/// A body with a newline behind it.
struct Ended {
    body: Body,
    /// Until it has been sent.
    newline: Option<Bytes>,
}

impl http_body::Body for Ended {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        if self.newline.is_none() {
            return Poll::Ready(None);
        }
        let frame = match ready!(Pin::new(&mut self.body).poll_frame(context)) {
            None => self.newline.take().map(|newline| Ok(Frame::data(newline))),
            // A body that is cut short has no end.
            Some(Err(error)) => {
                self.newline = None;
                Some(Err(error))
            }
            frame => frame,
        };
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.newline.is_none()
    }

    fn size_hint(&self) -> SizeHint {
        let mut hint = self.body.size_hint();
        let more = u64::from(self.newline.is_some());
        if let Some(upper) = hint.upper() {
            hint.set_upper(upper + more);
        }
        hint.set_lower(hint.lower() + more);
        hint
    }
}
