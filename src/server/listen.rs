//! Addresses to listen on, with names as well as numbers.

use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::str::FromStr;

use tokio::net::{TcpListener, lookup_host};
use tracing::warn;

/// A host, by its name or its address, and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen {
    /// A name, or an address without brackets.
    host: String,
    port: u16,
}

impl FromStr for Listen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Ok(address) = text.parse::<SocketAddr>() {
            return Ok(address.into());
        }
        let why = || {
            "not an address or a name with a port, such as 127.0.0.1:8080, [::1]:8080 or localhost:8080".to_owned()
        };
        let (host, port) = text.rsplit_once(':').ok_or_else(why)?;
        let of_a_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
        if host.is_empty() || !host.chars().all(of_a_name) {
            return Err(why());
        }
        Ok(Self {
            host: host.to_owned(),
            port: port.parse().map_err(|_| why())?,
        })
    }
}

impl From<SocketAddr> for Listen {
    fn from(address: SocketAddr) -> Self {
        Self {
            host: address.ip().to_string(),
            port: address.port(),
        }
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.host.contains(':') {
            true => write!(f, "[{}]:{}", self.host, self.port),
            false => write!(f, "{}:{}", self.host, self.port),
        }
    }
}

impl Listen {
    /// The address at which a client on this machine reaches the server: unspecified addresses become
    /// loopback ones.
    pub(super) fn reached_at(&self) -> Self {
        let host = match self.host.parse() {
            Ok(IpAddr::V4(Ipv4Addr::UNSPECIFIED)) => Ipv4Addr::LOCALHOST.to_string(),
            Ok(IpAddr::V6(Ipv6Addr::UNSPECIFIED)) => Ipv6Addr::LOCALHOST.to_string(),
            _ => self.host.clone(),
        };
        let port = self.port;
        Self { host, port }
    }

    /// Listens on all addresses of the host, on the same port. Addresses that cannot be bound are left out
    /// as long as there is another one.
    pub async fn bind(&self) -> io::Result<Vec<TcpListener>> {
        let found = lookup_host((self.host.as_str(), self.port)).await?;
        let mut addresses: Vec<SocketAddr> = found.collect();
        // IPv4 comes first; with port 0 the first address chooses the port for all.
        addresses.sort_by_key(SocketAddr::is_ipv6);
        addresses.dedup();
        let mut listeners: Vec<TcpListener> = Vec::new();
        let mut missing = None;
        for mut address in addresses {
            if let (0, Some(first)) = (self.port, listeners.first()) {
                address.set_port(first.local_addr()?.port());
            }
            match TcpListener::bind(address).await {
                Ok(listener) => listeners.push(listener),
                // A port that is taken on one of the addresses is an error.
                Err(reason) if is_taken(&reason) => return Err(reason),
                Err(reason) => {
                    warn!("{self} is also {address}, where nobody can listen: {reason}");
                    missing = Some(reason);
                }
            }
        }
        match (listeners.is_empty(), missing) {
            (false, _) => Ok(listeners),
            (true, Some(reason)) => Err(reason),
            (true, None) => Err(io::Error::other("the name has no address")),
        }
    }
}

fn is_taken(reason: &io::Error) -> bool {
    use io::ErrorKind::{AddrInUse, PermissionDenied};
    matches!(reason.kind(), AddrInUse | PermissionDenied)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_addresses_have_a_port() {
        for text in [
            "127.0.0.1:8080",
            "[::1]:0",
            "localhost:9010",
            "a-b.c_d.example:1",
        ] {
            let listen: Listen = text.parse().unwrap();
            assert_eq!(listen.to_string(), text);
        }
        for text in [
            "",
            "nowhere",
            ":80",
            "::1:80",
            "localhost:",
            "localhost:x",
            "localhost:65536",
            "a b:80",
            "http://a:80",
        ] {
            assert!(text.parse::<Listen>().is_err(), "{text}");
        }
    }

    #[test]
    fn any_address_is_reached_on_this_machine() {
        for (text, reached) in [
            ("0.0.0.0:80", "127.0.0.1:80"),
            ("[::]:80", "[::1]:80"),
            ("localhost:80", "localhost:80"),
            ("192.0.2.1:80", "192.0.2.1:80"),
        ] {
            let listen: Listen = text.parse().unwrap();
            assert_eq!(listen.reached_at().to_string(), reached);
        }
    }
}
