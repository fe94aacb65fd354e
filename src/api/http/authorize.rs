//! Authorizes requests by token or ticket. Of unauthorized requests only the head is read.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use parking_lot::Mutex;
use tonic::Status;
use tracing::info;
use uuid::Uuid;

use crate::access::Access;
use crate::access::denial::Denial;
use crate::api::grpc;
use crate::api::needs::{Methods, Needs};
use crate::api::problem::{Kind, Problem};
use crate::job::counters::Counters;
use crate::job::peer::Peer;
use crate::log_throttle::LogThrottle;

/// The only resource that takes tickets, and their query parameter.
const EVENTS: &str = "/v1/jobs/{id}/events";
const TICKET: &str = "ticket=";

/// The position of the job's id in its path.
const ID: usize = 3;

/// The tokens to check.
#[derive(Clone)]
pub(super) struct Guard {
    pub(super) access: Access,
    pub(super) methods: Arc<Methods>,
    pub(super) counters: Counters,
    /// Requests without a known tenant.
    pub(super) strangers: Arc<Mutex<LogThrottle>>,
}

/// The shortest time between log lines about unauthenticated requests, so that these do not flood the log.
pub(super) const LOG_INTERVAL: Duration = Duration::from_secs(1);

/// Answers a request for the tenant of its token, or denies it.
pub(super) async fn authorize(
    State(guard): State<Guard>,
    mut request: Request,
    next: Next,
) -> Response {
    let route = request.extensions().get::<MatchedPath>();
    // There is nothing at other paths.
    let Some(route) = route.map(|it| it.as_str().to_owned()) else {
        return next.run(request).await;
    };
    let Needs::A(scope) = guard.needs(&route, &request) else {
        return next.run(request).await;
    };
    let (uri, headers) = (request.uri(), request.headers());
    let ticket = ticket(uri).filter(|_| route == EVENTS);
    let admitted = match (bearer(headers), ticket) {
        (Err(Denial::Missing), Some(ticket)) => {
            let id = uri.path().split('/').nth(ID).unwrap_or_default();
            let job = Uuid::try_parse(id).map_err(|_| Denial::Ticket);
            let Access { tokens, tickets } = &guard.access;
            job.and_then(|job| tokens.admit_by_ticket(ticket, job, tickets))
        }
        (text, _) => text.and_then(|text| guard.access.tokens.admit(text, scope)),
    };
    match admitted {
        Ok(token) => {
            let peer = Peer::Tenant(token.tenant);
            request.extensions_mut().insert(token);
            let mut response = Peer::scope(Some(peer), next.run(request)).await;
            // The body is sent for the tenant, too.
            response.extensions_mut().insert(peer);
            response
        }
        Err(denial) => guard.deny(&denial, &route, &request),
    }
}

impl Guard {
    fn needs(&self, route: &str, request: &Request) -> Needs {
        let Some(methods) = self.methods.get(route) else {
            return grpc::scopes::needs(request.uri().path());
        };
        let verb = match *request.method() {
            Method::HEAD | Method::GET => "get",
            Method::POST => "post",
            Method::DELETE => "delete",
            // The resource does not support the method, and reports that.
            _ => return Needs::Nothing,
        };
        let found = methods.iter().find(|(it, _)| *it == verb);
        found.map_or(Needs::Nothing, |(_, needs)| *needs)
    }

    /// Denies a request, counts it and logs it. Neither reveals a token.
    fn deny(&self, denial: &Denial, route: &str, request: &Request) -> Response {
        let (reason, method) = (denial.name(), request.method());
        self.counters.count_denial(reason);
        let peer = Peer::current().map(|it| it.to_string());
        let token = denial.token();
        let count = match token {
            Some(_) => Some(1),
            None => self.strangers.lock().record(Instant::now()),
        };
        if let Some(count) = count {
            info!(reason, %method, route, peer, token, count, "a request was denied");
        }
        let problem = problem(denial);
        let challenge = match denial {
            Denial::Missing => "Bearer realm=\"piad\"",
            Denial::Scope { .. } => "Bearer realm=\"piad\", error=\"insufficient_scope\"",
            _ => "Bearer realm=\"piad\", error=\"invalid_token\"",
        };
        let mut response = match self.methods.contains_key(route) {
            true => problem.into_response(),
            false => Status::from(problem).into_http(),
        };
        let challenge = HeaderValue::from_static(challenge);
        response
            .headers_mut()
            .insert(header::WWW_AUTHENTICATE, challenge);
        response
    }
}

fn problem(denial: &Denial) -> Problem {
    let detail = match denial {
        Denial::Missing => "a token is needed: Authorization: Bearer piad_…".to_owned(),
        Denial::Malformed(why) => format!("Authorization: {why}"),
        Denial::Unknown => "the token is not valid".to_owned(),
        Denial::Expired { .. } => "the token has expired".to_owned(),
        Denial::Ticket => "the ticket is not valid for this stream, or has expired".to_owned(),
        Denial::Scope { needed, .. } => {
            let detail = format!("the token lacks the scope {needed}");
            return Problem::new(Kind::Forbidden, detail);
        }
    };
    Problem::new(Kind::Unauthenticated, detail)
}

/// The token of a request.
fn bearer(headers: &HeaderMap) -> Result<&str, Denial> {
    let mut values = headers.get_all(header::AUTHORIZATION).iter();
    let value = values.next().ok_or(Denial::Missing)?;
    if values.next().is_some() {
        return Err(Denial::Malformed("there is more than one"));
    }
    let text = value.to_str().unwrap_or_default();
    match text.split_once(' ') {
        Some((scheme, token)) if scheme.eq_ignore_ascii_case("bearer") => Ok(token.trim()),
        _ => Err(Denial::Malformed(
            "its scheme is Bearer, followed by the token",
        )),
    }
}

/// The ticket in the query of an address.
fn ticket(uri: &Uri) -> Option<&str> {
    uri.query()?
        .split('&')
        .find_map(|it| it.strip_prefix(TICKET))
}

/// An address without its ticket, which is hidden from handlers.
pub(super) fn without_ticket(uri: &Uri) -> Uri {
    let Some(query) = uri.query().filter(|_| ticket(uri).is_some()) else {
        return uri.clone();
    };
    let rest = query.split('&').filter(|it| !it.starts_with(TICKET));
    let rest = rest.collect::<Vec<_>>().join("&");
    format!("{}?{rest}", uri.path()).parse().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tickets_are_taken_out_of_addresses() {
        for (text, found, rest) in [
            ("/a?ticket=t&view=x", Some("t"), Some("view=x")),
            ("/a?view=x&ticket=t", Some("t"), Some("view=x")),
            ("/a?ticket=t", Some("t"), Some("")),
            ("/a?ticket=t&ticket=u", Some("t"), Some("")),
            ("/a?tickets=t", None, Some("tickets=t")),
            ("/a", None, None),
        ] {
            let uri = text.parse().unwrap();
            assert_eq!(ticket(&uri), found, "{text}");
            assert_eq!(without_ticket(&uri).query(), rest, "{text}");
        }
    }
}
