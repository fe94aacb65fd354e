//! A connection: its origin, and the answers to its requests.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderValue, Request, Version, header};
use hyper::body::Incoming;
use tower::Service;

use super::context::ServerContext;
use super::idle_tracking::Activity;
use super::proxy;
use super::request_body::RequestBody;
use super::response_body::{ResponseBody, Served};
use crate::api::http::overload::LimitExceeded;
use crate::job::peer::Peer;

/// The origin of a connection.
#[derive(Clone, Copy)]
pub(super) struct Caller {
    pub(super) peer: Peer,
    /// True if it is a trusted proxy, whose requests name their clients.
    is_proxy: bool,
    /// The limit that it exceeds, if any.
    pub(super) exceeded: Option<LimitExceeded>,
}

impl Caller {
    /// A client.
    pub(super) fn direct(peer: Peer) -> Self {
        Self {
            peer,
            is_proxy: false,
            exceeded: None,
        }
    }

    /// A trusted proxy with clients behind it.
    pub(super) fn proxy(peer: Peer) -> Self {
        Self {
            is_proxy: true,
            ..Self::direct(peer)
        }
    }

    /// The peer whose connections are limited; `None` for a proxy.
    pub(super) fn limited(self) -> Option<Peer> {
        (!self.is_proxy).then_some(self.peer)
    }
}

/// Answers a request.
pub(super) async fn answer(
    context: Arc<ServerContext>,
    activity: Arc<Activity>,
    caller: Caller,
    request: Request<Incoming>,
) -> Result<hyper::Response<ResponseBody>, Infallible> {
    let multiplexed = request.version() == Version::HTTP_2;
    let open = activity.open(multiplexed);
    let (mut head, body) = request.into_parts();
    let expects = head.headers.contains_key(header::EXPECT);
    let peer = match caller.is_proxy {
        true => proxy::origin(&head.headers, &context.proxies).peer(caller.peer),
        false => caller.peer,
    };
    let mut exceeded = caller.exceeded;
    // Connections limit the other requests of a peer.
    let slot = (multiplexed || caller.is_proxy).then(|| context.connections.admit_request(peer));
    let slot = slot.and_then(|slot| slot.map_err(|reason| exceeded = Some(reason)).ok());
    if let Some(reason) = exceeded {
        head.extensions.insert(reason);
    }
    let (body, unread) = RequestBody::new(body);
    let request = Request::from_parts(head, Body::new(body));
    let routed = context.router.clone().call(request);
    let mut response = Peer::scope(Some(peer), routed).await?;
    // In HTTP/2 an unread body does not block other streams.
    if !multiplexed && !(unread.is_out_of_the_way(expects).await) {
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
        activity.cut_short();
    }
    // The tenant, if the request had a token.
    let peer = response.extensions_mut().remove().unwrap_or(peer);
    let served = Served {
        peer,
        _open: open,
        _slot: slot,
    };
    Ok(response.map(|body| ResponseBody::new(body, served, multiplexed)))
}
