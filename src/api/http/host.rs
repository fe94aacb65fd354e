//! Checks the Host of requests.
//!
//! A server on the loopback interface is intended for programs on this machine, but a web page can reach it through the
//! browser: with DNS rebinding, the page's own host name resolves to 127.0.0.1, and the browser treats the server as
//! part of the page's origin. The Host header then has the wrong name.

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::api::problem::{Kind, Problem};

/// Resources that are answered under any name, for orchestrators.
const ALWAYS: [&str; 2] = ["/livez", "/readyz"];

/// The host names of a server.
#[derive(Clone, Debug)]
pub(crate) struct Hosts {
    /// Names besides those of the loopback interface, in lower case.
    names: Arc<[String]>,
    /// True if requests for other hosts are refused.
    checked: bool,
}

impl Hosts {
    /// These names; they are checked if there are any, or if the server is on the loopback interface.
    pub(crate) fn new(names: &[String], loopback: bool) -> Self {
        let names: Arc<[String]> = names.iter().map(|name| plain(name)).collect();
        let checked = (loopback || !names.is_empty()) && !names.iter().any(|name| name == "*");
        Self { names, checked }
    }

    fn know(&self, host: &str) -> bool {
        let host = plain(host);
        let address = host.trim_start_matches('[').trim_end_matches(']');
        if let Ok(address) = address.parse::<IpAddr>() {
            return address.to_canonical().is_loopback() || self.names.contains(&host);
        }
        host == "localhost"
            || host.ends_with(".localhost")
            || self.names.iter().any(|name| match name.strip_prefix("*.") {
                Some(parent) => is_below(&host, parent),
                None => *name == host,
            })
    }
}

/// Returns true if a name is another one with one or more labels in front.
fn is_below(name: &str, parent: &str) -> bool {
    let labels = name.strip_suffix(parent);
    labels.is_some_and(|labels| labels.len() > 1 && labels.ends_with('.'))
}

fn plain(name: &str) -> String {
    let name = name.trim();
    name.strip_suffix('.').unwrap_or(name).to_ascii_lowercase()
}

/// Refuses requests without a valid Host, and those for another host.
pub(super) async fn check(State(hosts): State<Hosts>, request: Request, next: Next) -> Response {
    match refusal(&hosts, &request) {
        None => next.run(request).await,
        Some(problem) => problem.into_response(),
    }
}

fn refusal(hosts: &Hosts, request: &Request) -> Option<Problem> {
    let authority = match in_header(request.headers(), request.version()) {
        Ok(in_header) => request.uri().authority().cloned().or(in_header),
        Err(why) => return Some(Problem::at_header("Host", why)),
    };
    if !hosts.checked || ALWAYS.contains(&request.uri().path()) {
        return None;
    }
    let host = authority.as_ref().map_or("", Authority::host);
    if hosts.know(host) {
        return None;
    }
    let detail = format!(
        "host {host:?} is not allowed; allowed are localhost and the names of --allowed-host"
    );
    Some(Problem::new(Kind::UnknownHost, detail))
}

/// The Host header, which HTTP/1.1 requires exactly once. The error gives the reason.
fn in_header(headers: &HeaderMap, version: Version) -> Result<Option<Authority>, &'static str> {
    let mut values = headers.get_all(header::HOST).iter();
    match (values.next(), values.next()) {
        (None, _) if version == Version::HTTP_11 => Err("it is missing"),
        (None, _) => Ok(None),
        (Some(_), Some(_)) => Err("there is more than one"),
        (Some(host), None) if host.is_empty() => Ok(None),
        (Some(host), None) => match host.to_str().map(str::parse::<Authority>) {
            Ok(Ok(authority)) if !authority.as_str().contains('@') => Ok(Some(authority)),
            _ => Err("it is not a host with or without a port"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_this_machine_and_given_ones_are_known() {
        let given = [
            "Fit.example.org".to_owned(),
            "*.cad.example".to_owned(),
            "192.0.2.7".to_owned(),
        ];
        let hosts = Hosts::new(&given, true);
        for host in [
            "localhost",
            "LOCALHOST.",
            "a.localhost",
            "127.0.0.1",
            "127.9.8.7",
            "[::1]",
            "[::ffff:127.0.0.1]",
            "fit.example.org",
            "a.cad.example",
            "192.0.2.7",
        ] {
            assert!(hosts.know(host), "{host}");
        }
        for host in [
            "",
            "localhost.evil.example",
            "notlocalhost",
            "10.0.0.1",
            "[::2]",
            "0.0.0.0",
            "cad.example",
            ".cad.example",
            "127.0.0.1.evil.example",
            "example.org",
            "evilcad.example",
        ] {
            assert!(!hosts.know(host), "{host}");
        }
        assert!(
            hosts.checked && Hosts::new(&given, false).checked && Hosts::new(&[], true).checked
        );
        assert!(!Hosts::new(&[], false).checked && !Hosts::new(&["*".to_owned()], true).checked);
    }
}
