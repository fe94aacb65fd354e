//! Where to listen: addresses, with names as well as numbers, and Unix domain sockets.

use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::PathBuf;
use std::str::FromStr;

use tokio::net::{TcpListener, TcpStream, lookup_host};
use tracing::warn;

use super::listener::Listener;
#[cfg(unix)]
use super::listener::UnixSocket;

/// Where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Listen {
    /// On a port.
    Tcp(Host),
    /// On a Unix domain socket: the path of its file.
    Unix(PathBuf),
}

/// A host, by its name or its address, and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Host {
    /// A name, or an address without brackets.
    host: String,
    port: u16,
}

impl FromStr for Listen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(path) = text.strip_prefix("unix:") {
            return match path {
                "" => Err("not the path of a socket, such as unix:/run/piad.sock".to_owned()),
                _ if !cfg!(unix) => Err("this system has no Unix domain sockets".to_owned()),
                path => Ok(Self::Unix(path.into())),
            };
        }
        if let Ok(address) = text.parse::<SocketAddr>() {
            return Ok(address.into());
        }
        let why = || {
            "not an address or a name with a port, such as 127.0.0.1:8080, [::1]:8080 or localhost:8080, or a socket such as unix:/run/piad.sock".to_owned()
        };
        let (host, port) = text.rsplit_once(':').ok_or_else(why)?;
        let of_a_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
        if host.is_empty() || !host.chars().all(of_a_name) {
            return Err(why());
        }
        Ok(Self::Tcp(Host {
            host: host.to_owned(),
            port: port.parse().map_err(|_| why())?,
        }))
    }
}

impl From<SocketAddr> for Listen {
    fn from(address: SocketAddr) -> Self {
        Self::Tcp(Host {
            host: address.ip().to_string(),
            port: address.port(),
        })
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(host) => write!(f, "{host}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

impl fmt::Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.host.contains(':') {
            true => write!(f, "[{}]:{}", self.host, self.port),
            false => write!(f, "{}:{}", self.host, self.port),
        }
    }
}

impl Listen {
    /// Listens there; on several addresses if a name has them.
    ///
    /// # Errors
    ///
    /// If nobody can listen there.
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
                    warn!("{self} is also {address}, where nobody can listen: {reason}");
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
    fn names_and_addresses_have_a_port_and_sockets_a_path() {
        for text in [
            "127.0.0.1:8080",
            "[::1]:0",
            "localhost:9010",
            "a-b.c_d.example:1",
            "unix:/run/piad.sock",
            "unix:piad.sock",
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
            "unix:",
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
            let Ok(Listen::Tcp(host)) = text.parse() else {
                panic!("{text}");
            };
            assert_eq!(host.reached_at().to_string(), reached);
        }
    }
}
