//! The body of a request. In HTTP/1 the part that a handler has not read precedes the next request on the connection: a
//! short rest is read and discarded; otherwise the connection is closed after the answer, which announces it.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Body as HttpBody, Frame, SizeHint};
use http_body_util::BodyExt;
use hyper::body::Incoming;
use parking_lot::Mutex;
use tokio::time::{Duration, timeout};

/// The longest rest of a body that is read to keep the connection.
const LITTLE: u64 = 64 * 1024;

/// How long to wait for it.
const SHORT: Duration = Duration::from_secs(1);

/// The body of a request; the unread rest goes to [`Unread`].
pub(super) struct RequestBody {
    body: Option<Incoming>,
    unread: Unread,
}

/// The rest of a body that a handler has not read.
#[derive(Clone, Default)]
pub(super) struct Unread(Arc<Mutex<Option<Incoming>>>);

impl RequestBody {
    pub(super) fn new(body: Incoming) -> (Self, Unread) {
        let unread = Unread::default();
        let arriving = Self {
            body: Some(body),
            unread: unread.clone(),
        };
        (arriving, unread)
    }
}

impl Unread {
    /// Reads the rest if it is short and comes soon; returns true if the connection can be used again. A client that
    /// `expects` 100 Continue may not have begun to send the body.
    pub(super) async fn is_out_of_the_way(&self, expects: bool) -> bool {
        let Some(body) = self.0.lock().take() else {
            return true;
        };
        let little = body.size_hint().upper().is_some_and(|rest| rest <= LITTLE);
        little && !expects && matches!(timeout(SHORT, body.collect()).await, Ok(Ok(_)))
    }
}

impl HttpBody for RequestBody {
    type Data = Bytes;
    type Error = hyper::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, hyper::Error>>> {
        let Some(body) = &mut self.body else {
            return Poll::Ready(None);
        };
        let frame = Pin::new(body).poll_frame(context);
        if let Poll::Ready(None | Some(Err(_))) = frame {
            self.body = None;
        }
        frame
    }

    fn is_end_stream(&self) -> bool {
        self.body.as_ref().is_none_or(HttpBody::is_end_stream)
    }

    fn size_hint(&self) -> SizeHint {
        let of = |body: &Incoming| body.size_hint();
        self.body.as_ref().map_or(SizeHint::with_exact(0), of)
    }
}

impl Drop for RequestBody {
    fn drop(&mut self) {
        let body = self.body.take();
        *self.unread.0.lock() = body.filter(|body| !body.is_end_stream());
    }
}
