//! The id of a request: the client's own, if it is valid, or a new one.

use axum::http::{HeaderName, HeaderValue, Request};
use tower_http::request_id::{MakeRequestId, RequestId};
use uuid::Uuid;

/// The header with the id, in requests and in answers.
pub(in crate::api) const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// The longest id that is taken from a client: it is repeated in answers and in the log.
const LONGEST: usize = 128;

/// Makes ids that grow with time, like those of jobs.
#[derive(Clone, Copy)]
pub(super) struct NewRequestId;

impl MakeRequestId for NewRequestId {
    fn make_request_id<B>(&mut self, _request: &Request<B>) -> Option<RequestId> {
        let id = Uuid::now_v7().to_string();
        id.parse().ok().map(RequestId::new)
    }
}

/// Removes request ids that are too long or not visible ASCII, and several ids of one request.
pub(super) fn plain<B>(mut request: Request<B>) -> Request<B> {
    let headers = request.headers_mut();
    let ids: Vec<_> = headers.get_all(REQUEST_ID).iter().collect();
    if ids.len() > 1 || ids.first().is_some_and(|id| !is_plain(id)) {
        headers.remove(REQUEST_ID);
    }
    request
}

fn is_plain(id: &HeaderValue) -> bool {
    (1..=LONGEST).contains(&id.len()) && id.as_bytes().iter().all(u8::is_ascii_graphic)
}
