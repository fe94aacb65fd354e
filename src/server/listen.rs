//! Listening at addresses and at Unix domain sockets.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use tokio::net::{TcpListener, TcpStream, lookup_host};
use tracing::warn;

use super::listener::Listener;
#[cfg(unix)]
use super::listener::UnixSocket;
use crate::config::listen::{Host, Listen};

impl Listen {
    /// Listens there; on several addresses if a name has them.
    ///
    /// # Errors
    ///
    /// If the address cannot be bound.
    pub async fn bind(&self) -> io::Result<Vec<Listener>> {
        match self {
            Self::Tcp(host) => host.bind().await,
            #[cfg(unix)]
            Self::Unix(path) => Ok(vec![Listener::Unix(UnixSocket::bind(path)?)]),
            #[cfg(not(unix))]
            Self::Unix(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

impl Host {
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

    /// Connects with a server there.
    pub(super) async fn connect(&self) -> io::Result<TcpStream> {
        TcpStream::connect((self.host.as_str(), self.port)).await
    }

    /// Listens on all addresses of the host, on the same port. Addresses that cannot be bound are left out
    /// as long as there is another one.
    async fn bind(&self) -> io::Result<Vec<Listener>> {
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
                    warn!("{self} is also {address}, which cannot be bound: {reason}");
                    missing = Some(reason);
                }
            }
        }
        match (listeners.is_empty(), missing) {
            (false, _) => Ok(listeners.into_iter().map(Listener::Tcp).collect()),
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
    fn any_address_is_reached_on_this_machine() {
        for (text, reached) in [
            ("0.0.0.0:80", "127.0.0.1:80"),
            ("[::]:80", "[::1]:80"),
            ("localhost:80", "localhost:80"),
            ("192.0.2.1:80", "192.0.2.1:80"),
        ] {
            let Ok(Listen::Tcp(host)) = text.parse() else {
                panic!("{text}");
            };
            assert_eq!(host.reached_at().to_string(), reached);
        }
    }
}
