//! Listen addresses: with names as well as numbers, and Unix domain sockets.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;

/// A listen address.
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
    pub(crate) host: String,
    pub(crate) port: u16,
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
}
