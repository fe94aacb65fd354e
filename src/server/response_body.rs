//! The body of an answer; its request counts as open until all of it has been sent, and is computed for its peer.

use std::pin::Pin;
use std::task::{Context, Poll, ready};

use axum::body::Body;
use bytes::Bytes;
use http_body::{Body as HttpBody, Frame, SizeHint};

use super::idle_tracking::OpenRequest;
use super::stream_timeout;
use crate::job::peer::Peer;
use crate::job::slots::Slot;

/// The most bytes that an HTTP/2 stream is given at once: those of a frame. A client that does not read this many
/// within the time limit is stalled.
const PIECE: usize = 16 * 1024;

/// The request of an answer.
pub(super) struct Served {
    /// Its peer.
    pub(super) peer: Peer,
    pub(super) _open: OpenRequest,
    /// Its slot among the requests of the peer, if these are limited.
    pub(super) _slot: Option<Slot>,
}

/// The body of an answer.
pub(super) struct ResponseBody {
    body: Body,
    /// The part of the last frame that is still to be sent.
    rest: Bytes,
    /// The most bytes that are given at once.
    most: usize,
    request: Served,
}

impl ResponseBody {
    pub(super) fn new(body: Body, request: Served, multiplexed: bool) -> Self {
        Self {
            body,
            rest: Bytes::new(),
            most: if multiplexed { PIECE } else { usize::MAX },
            request,
        }
    }

    fn piece(&mut self) -> Frame<Bytes> {
        let length = self.rest.len().min(self.most);
        Frame::data(self.rest.split_to(length))
    }
}

impl HttpBody for ResponseBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        stream_timeout::requested();
        if self.rest.is_empty() {
            let peer = Some(self.request.peer);
            let body = Pin::new(&mut self.body);
            let frame = Peer::sync_scope(peer, || body.poll_frame(context));
            let frame = ready!(frame.map(|frame| frame.transpose())?);
            stream_timeout::given();
            match frame.map(Frame::into_data) {
                None => return Poll::Ready(None),
                Some(Err(trailers)) => return Poll::Ready(Some(Ok(trailers))),
                Some(Ok(data)) => self.rest = data,
            }
        }
        stream_timeout::given();
        Poll::Ready(Some(Ok(self.piece())))
    }

    fn is_end_stream(&self) -> bool {
        self.rest.is_empty() && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        let (rest, of_body) = (self.rest.len() as u64, self.body.size_hint());
        let mut hint = SizeHint::new();
        hint.set_lower(of_body.lower() + rest);
        if let Some(upper) = of_body.upper() {
            hint.set_upper(upper + rest);
        }
        hint
    }
}
