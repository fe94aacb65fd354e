//! The id of a request: as the client says, if that is an id, or a new one.

use axum::http::{HeaderName, HeaderValue, Request};
use tower_http::request_id::{MakeRequestId, RequestId};
use uuid::Uuid;

/// The header with the id, in requests and in answers.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// The longest id of a client. It comes back in every answer and stands in the log.
const LONGEST: usize = 128;

/// Ids that grow with time, as those of jobs do.
#[derive(Clone, Copy)]
pub(super) struct NewRequestId;

impl MakeRequestId for NewRequestId {
    fn make_request_id<B>(&mut self, _request: &Request<B>) -> Option<RequestId> {
        let id = Uuid::now_v7().to_string();
        id.parse().ok().map(RequestId::new)
    }
}

/// A request without ids that are too long or not a word, and without several of them.
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
