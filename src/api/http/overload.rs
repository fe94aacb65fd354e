//! Requests on connections beyond the limits: only health and metrics are answered.

use std::fmt;

use axum::extract::Request;
use axum::http::{HeaderValue, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::api::problem::{Kind, Problem};
use crate::job::slots::NoSlot;

/// Resources that are always answered.
const ALWAYS: [&str; 3] = ["/livez", "/readyz", "/metrics"];

/// The limit that a connection or a request exceeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LimitExceeded {
    Connections(NoSlot),
    /// The peer has this many open requests.
    Requests(usize),
}

impl fmt::Display for LimitExceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connections(NoSlot::All(most)) => {
                write!(f, "{most} connections are open, the limit of this server")
            }
            Self::Connections(NoSlot::PerPeer(most)) => write!(
                f,
                "{most} connections from one address are open, the limit of this server for each"
            ),
            Self::Requests(most) => write!(
                f,
                "{most} requests from one address are open, the limit of this server for each"
            ),
        }
    }
}

/// Answers requests on such connections with 503, except those about the state of the server.
pub(super) async fn hold_back(request: Request, next: Next) -> Response {
    let Some(&exceeded) = request.extensions().get::<LimitExceeded>() else {
        return next.run(request).await;
    };
    let version = request.version();
    let mut response = if ALWAYS.contains(&request.uri().path()) {
        next.run(request).await
    } else {
        Problem::new(Kind::TooManyConnections, exceeded.to_string())
            .retry_after(5)
            .into_response()
    };
    if version <= Version::HTTP_11 {
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
    }
    response
}
