//! Clients behind trusted proxies: their addresses, as the proxy reports them.
//!
//! A proxy reports the address of a connection in a header of the [PROXY protocol] before its first byte, in version 1
//! or 2, or that of each request in `Forwarded` (RFC 7239) or `X-Forwarded-For`; after a PROXY header the others come
//! from the client, and are ignored. Headers from any other peer are ignored: a client that could choose its address
//! would have no limits. Clients that a proxy does not name share one set of limits.
//!
//! [PROXY protocol]: https://www.haproxy.org/download/3.0/doc/proxy-protocol.txt

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

use axum::http::HeaderMap;
use ipnet::IpNet;
use tokio::io::{AsyncRead, AsyncReadExt};

use crate::job::peer::Peer;

/// The first bytes of a header in version 1 and in version 2.
const VERSION_1: &[u8] = b"PROXY ";
const VERSION_2: &[u8] = b"\r\n\r\n\0\r\nQUIT\n";

/// The longest header in version 1, with its end of line.
const LONGEST_LINE: usize = 107;

/// Returns true if the proxy at an address is trusted.
pub(super) fn is_trusted(networks: &[IpNet], address: IpAddr) -> bool {
    let address = address.to_canonical();
    networks.iter().any(|network| network.contains(&address))
}

/// The origin of a request from a trusted proxy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// From the proxy itself: no header names a client.
    Proxy,
    /// From the client at this address.
    Client(IpAddr),
    /// From a client that is not named: the header has no valid address, or the two headers have different ones, one of
    /// which the client may have sent.
    Unnamed,
}

impl Origin {
    /// The peer whose limits hold, behind this proxy.
    pub(super) fn peer(self, proxy: Peer) -> Peer {
        match self {
            Self::Proxy => proxy,
            Self::Client(address) => Peer::at(address),
            Self::Unnamed => Peer::unnamed_behind(proxy),
        }
    }
}

/// The origin of a request that came from a trusted proxy: the last address on its way that is not a trusted proxy
/// itself.
pub(super) fn origin(headers: &HeaderMap, networks: &[IpNet]) -> Origin {
    let last = |way: Vec<Option<IpAddr>>| {
        let mut hops = way.into_iter().rev();
        match hops.find(|hop| hop.is_none_or(|address| !is_trusted(networks, address))) {
            None => Origin::Proxy,
            Some(None) => Origin::Unnamed,
            Some(Some(address)) => Origin::Client(address),
        }
    };
    let forwarded = way(headers, "forwarded", forwarded_for);
    let x_forwarded = way(headers, "x-forwarded-for", |hop| Some(hop));
    match (forwarded.is_empty(), x_forwarded.is_empty()) {
        (true, _) => last(x_forwarded),
        (_, true) => last(forwarded),
        _ => {
            let origin = last(forwarded);
            match origin == last(x_forwarded) {
                true => origin,
                false => Origin::Unnamed,
            }
        }
    }
}

/// The addresses in all headers of a name, the nearest one last; `None` for invalid ones.
fn way(
    headers: &HeaderMap,
    name: &str,
    address: impl Fn(&str) -> Option<&str>,
) -> Vec<Option<IpAddr>> {
    let values = headers.get_all(name).iter();
    let hops = values.flat_map(|value| value.to_str().unwrap_or("?").split(','));
    let read = |hop: &str| without_port(address(hop.trim())?.trim());
    hops.map(read).collect()
}

/// The value of `for` in an element of `Forwarded`.
fn forwarded_for(element: &str) -> Option<&str> {
    let mut pairs = element.split(';').filter_map(|pair| pair.split_once('='));
    let (_, value) = pairs.find(|(name, _)| name.trim().eq_ignore_ascii_case("for"))?;
    Some(value.trim().trim_matches('"'))
}

/// An address, perhaps in brackets, perhaps with a port.
fn without_port(text: &str) -> Option<IpAddr> {
    if let Some((address, _)) = text.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        return address.parse().ok();
    }
    let host = text.split_once(':').map_or(text, |(host, _)| host);
    text.parse().or_else(|_| host.parse()).ok()
}

/// The first bytes of a trusted proxy.
#[derive(Debug)]
pub(super) struct Beginning {
    /// The origin of the connection, if there is a header.
    pub(super) origin: Option<Origin>,
    /// Bytes that were read and belong to the first request.
    pub(super) rest: Vec<u8>,
}

/// Reads the header of the PROXY protocol, if there is one.
pub(super) async fn read(stream: &mut (impl AsyncRead + Unpin)) -> io::Result<Beginning> {
    let mut bytes = Vec::new();
    loop {
        // Byte by byte: a header is short, and the bytes after it may not come.
        let Ok(byte) = stream.read_u8().await else {
            return Ok(Beginning {
                origin: None,
                rest: bytes,
            });
        };
        bytes.push(byte);
        if bytes.starts_with(VERSION_2) {
            return version_2(stream).await;
        }
        if bytes.starts_with(VERSION_1) {
            if bytes.ends_with(b"\r\n") {
                return version_1(&bytes);
            }
            if bytes.len() >= LONGEST_LINE {
                return Err(malformed());
            }
        } else if !VERSION_1.starts_with(&bytes) && !VERSION_2.starts_with(&bytes) {
            return Ok(Beginning {
                origin: None,
                rest: bytes,
            });
        }
    }
}

fn malformed() -> io::Error {
    io::Error::new(
        io::ErrorKind::InvalidData,
        "a malformed header of the PROXY protocol",
    )
}

fn begins_after(origin: Origin) -> Beginning {
    Beginning {
        origin: Some(origin),
        rest: Vec::new(),
    }
}

/// `PROXY TCP4 192.0.2.1 192.0.2.2 4711 80`, or `PROXY UNKNOWN` for requests of the proxy itself.
fn version_1(line: &[u8]) -> io::Result<Beginning> {
    let text = std::str::from_utf8(line).map_err(|_| malformed())?;
    let mut words = text.split_whitespace().skip(1);
    match words.next() {
        Some("UNKNOWN") => Ok(begins_after(Origin::Proxy)),
        Some("TCP4" | "TCP6") => {
            let address = words.next().and_then(|word| word.parse().ok());
            address
                .map(|address| begins_after(Origin::Client(address)))
                .ok_or_else(malformed)
        }
        _ => Err(malformed()),
    }
}

/// After the signature: version and command, family, length, addresses.
async fn version_2(stream: &mut (impl AsyncRead + Unpin)) -> io::Result<Beginning> {
    let mut head = [0; 4];
    stream.read_exact(&mut head).await?;
    let [command, family, high, low] = head;
    let mut addresses = vec![0; usize::from(u16::from_be_bytes([high, low]))];
    stream.read_exact(&mut addresses).await?;
    // The highest bits are the version; LOCAL is for requests of the proxy itself.
    let is_local = match command {
        0x20 => true,
        0x21 => false,
        _ => return Err(malformed()),
    };
    let client = match family >> 4 {
        1 => addresses
            .first_chunk()
            .map(|bytes: &[u8; 4]| Ipv4Addr::from(*bytes).into()),
        2 => addresses
            .first_chunk()
            .map(|bytes: &[u8; 16]| Ipv6Addr::from(*bytes).into()),
        _ => return Ok(begins_after(Origin::Proxy)),
    };
    match client {
        _ if is_local => Ok(begins_after(Origin::Proxy)),
        Some(client) => Ok(begins_after(Origin::Client(client))),
        None => Err(malformed()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::network;

    fn networks(texts: &[&str]) -> Vec<IpNet> {
        texts.iter().map(|text| network(text).unwrap()).collect()
    }

    #[test]
    fn networks_contain_addresses() {
        let trusts =
            |text: &str, address: &str| is_trusted(&networks(&[text]), address.parse().unwrap());
        assert!(trusts("10.0.0.0/8", "10.255.0.1") && !trusts("10.0.0.0/8", "11.0.0.1"));
        assert!(trusts("10.1.2.3", "10.1.2.3") && !trusts("10.1.2.3", "10.1.2.2"));
        assert!(trusts("10.1.2.3", "::ffff:10.1.2.3") && !trusts("0.0.0.0/0", "::1"));
        assert!(trusts("0.0.0.0/0", "203.0.113.1") && trusts("fd00::/8", "fdff::1"));
        assert!(!trusts("2001:db8::/33", "2001:db8:8000::1"));
        for text in [
            "",
            "10.0.0.0/33",
            "::/129",
            "10.0.0.0/",
            "10.0.0/8",
            "a/8",
            "10.0.0.0/-1",
        ] {
            assert!(network(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_last_address_that_is_no_proxy_is_the_client() {
        let trusted = networks(&["10.0.0.0/8", "::1"]);
        let origin = |pairs: &[(&'static str, &'static str)]| {
            let mut headers = HeaderMap::new();
            for (name, value) in pairs {
                headers.append(*name, value.parse().unwrap());
            }
            super::origin(&headers, &trusted)
        };
        let is = |pairs: &[(&'static str, &'static str)], address: &str| {
            let address = address.parse().unwrap();
            assert_eq!(origin(pairs), Origin::Client(address), "{pairs:?}");
        };
        is(&[("x-forwarded-for", "192.0.2.1")], "192.0.2.1");
        is(
            &[("x-forwarded-for", "198.51.100.9, 192.0.2.1:80 ,10.1.1.1")],
            "192.0.2.1",
        );
        is(
            &[
                ("x-forwarded-for", "6.6.6.6"),
                ("x-forwarded-for", "192.0.2.1"),
            ],
            "192.0.2.1",
        );
        is(
            &[("x-forwarded-for", "[2001:db8::7]:80, ::1")],
            "2001:db8::7",
        );
        is(
            &[(
                "forwarded",
                "for=6.6.6.6, For=\"[2001:db8::7]:80\";proto=http",
            )],
            "2001:db8::7",
        );
        is(&[("forwarded", "by=10.0.0.1; for=192.0.2.1")], "192.0.2.1");
        let same = [
            ("forwarded", "for=192.0.2.1"),
            ("x-forwarded-for", "6.6.6.6, 192.0.2.1"),
        ];
        is(&same, "192.0.2.1");
        for pairs in [&[][..], &[("x-forwarded-for", "10.1.1.1")]] {
            assert_eq!(origin(pairs), Origin::Proxy, "{pairs:?}");
        }
        for pairs in [
            &[("x-forwarded-for", "192.0.2.1, unknown")][..],
            &[("x-forwarded-for", "")],
            &[("x-forwarded-for", "nowhere, 10.1.1.1")],
            &[("forwarded", "for=unknown")],
            &[("forwarded", "for=_hidden")],
            &[("forwarded", "for=\"")],
            &[("forwarded", "for")],
            &[("forwarded", "proto=http")],
            &[
                ("forwarded", "for=6.6.6.6"),
                ("x-forwarded-for", "192.0.2.1"),
            ],
            &[
                ("forwarded", "for=unknown"),
                ("x-forwarded-for", "192.0.2.1"),
            ],
            &[
                ("forwarded", "for=10.1.1.1"),
                ("x-forwarded-for", "192.0.2.1"),
            ],
        ] {
            assert_eq!(origin(pairs), Origin::Unnamed, "{pairs:?}");
        }
    }

    async fn begins(mut bytes: &[u8]) -> Option<(Option<Origin>, Vec<u8>)> {
        let Beginning { origin, mut rest } = read(&mut bytes).await.ok()?;
        rest.extend_from_slice(bytes);
        Some((origin, rest))
    }

    #[tokio::test]
    async fn headers_of_both_versions_are_read() {
        let version_2 = |rest: &[u8]| [VERSION_2, rest].concat();
        let client = |text: &str| {
            let address = text.parse().unwrap();
            Some((Some(Origin::Client(address)), b"GET".to_vec()))
        };
        let itself = Some((Some(Origin::Proxy), b"GET".to_vec()));
        assert_eq!(begins(b"GET").await, Some((None, b"GET".to_vec())));
        assert_eq!(begins(b"POST /").await.unwrap().1, b"POST /");
        assert_eq!(begins(b"PRO").await.unwrap().1, b"PRO");
        let line = b"PROXY TCP4 192.0.2.1 10.0.0.1 4711 80\r\nGET";
        assert_eq!(begins(line).await, client("192.0.2.1"));
        let line = b"PROXY TCP6 2001:db8::1 ::1 4711 80\r\nGET";
        assert_eq!(begins(line).await, client("2001:db8::1"));
        assert_eq!(begins(b"PROXY UNKNOWN\r\nGET").await, itself);
        let four = version_2(b"\x21\x11\0\x0c\xc0\0\x02\x01\x0a\0\0\x01\x12\x67\0\x50GET");
        assert_eq!(begins(&four).await, client("192.0.2.1"));
        let six = [&[0x21, 0x21, 0, 36][..], &[0xfd; 36], b"GET"].concat();
        let address = Ipv6Addr::from([0xfd; 16]).to_string();
        assert_eq!(begins(&version_2(&six)).await, client(&address));
        assert_eq!(begins(&version_2(b"\x20\0\0\0GET")).await, itself);
        assert_eq!(begins(&version_2(b"\x21\0\0\0GET")).await, itself);
        for bytes in [
            &b"PROXY TCP4 nowhere\r\n"[..],
            b"PROXY HTTP\r\n",
            &[b"PROXY TCP4 ", &[b'1'; 200][..]].concat(),
            &version_2(b"\x31\x11\0\0"),
            &version_2(b"\x21\x11\0\x02\xc0\0"),
            &version_2(b"\x21\x11\0\x0c\xc0"),
        ] {
            assert!(begins(bytes).await.is_none(), "{bytes:?}");
        }
    }
}
