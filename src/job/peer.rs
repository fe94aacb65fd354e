//! The peer that work is done for: a tenant, if the server requires tokens; else the machine at the other end of a
//! connection.
//!
//! Limits hold for each peer, so that no one client can take everything. The peer of a request is a
//! task-local variable of the task that answers it; background work has no peer. Behind a trusted proxy the
//! machine is the client that the proxy names.

use std::fmt;
use std::net::{IpAddr, Ipv6Addr};

use tokio::task::JoinHandle;
use tokio::task_local;

use super::tenant::Tenant;

task_local! {
    static CURRENT: Option<Peer>;
}

/// The client of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Peer {
    /// A machine, identified by its IPv4 address or by the /64 network of its IPv6 address, within which a
    /// machine chooses its address itself.
    Machine(IpAddr),
    /// The clients of the proxy at this address that it does not name. They do not share the limits of the proxy
    /// itself.
    Unnamed(IpAddr),
    /// A tenant, whose token the request has.
    Tenant(Tenant),
}

impl Peer {
    /// The machine at an address.
    pub(crate) fn at(address: IpAddr) -> Self {
        match address.to_canonical() {
            IpAddr::V6(address) if !address.is_loopback() => {
                let network = address.to_bits() >> 64 << 64;
                Self::Machine(Ipv6Addr::from_bits(network).into())
            }
            address => Self::Machine(address),
        }
    }

    /// The clients behind a proxy that it does not name.
    pub(crate) fn unnamed_behind(proxy: Self) -> Self {
        match proxy {
            Self::Machine(address) => Self::Unnamed(address),
            other => other,
        }
    }

    /// The tenant, if the server requires tokens.
    pub(crate) fn tenant(self) -> Option<Tenant> {
        match self {
            Self::Machine(_) | Self::Unnamed(_) => None,
            Self::Tenant(tenant) => Some(tenant),
        }
    }

    /// The tenant that owns the results of work for a peer.
    pub(crate) fn owner(peer: Option<Self>) -> Tenant {
        peer.and_then(Self::tenant).unwrap_or(Tenant::DEFAULT)
    }

    /// The peer of the current task.
    pub(crate) fn current() -> Option<Self> {
        CURRENT.try_with(|peer| *peer).ok().flatten()
    }

    /// Calls a function for a peer.
    pub(crate) fn sync_scope<T>(peer: Option<Self>, function: impl FnOnce() -> T) -> T {
        CURRENT.sync_scope(peer, function)
    }

    /// Runs a future for a peer.
    pub(crate) fn scope<F: Future>(
        peer: Option<Self>,
        future: F,
    ) -> impl Future<Output = F::Output> {
        CURRENT.scope(peer, future)
    }
}

/// Runs a future in a task of its own, for the current peer.
pub(crate) fn spawn<F>(future: F) -> JoinHandle<F::Output>
where
    F: Future<Output: Send + 'static> + Send + 'static,
{
    tokio::spawn(Peer::scope(Peer::current(), future))
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tenant(tenant) => write!(f, "tenant {tenant}"),
            Self::Machine(IpAddr::V6(network)) if !network.is_loopback() => {
                write!(f, "{network}/64")
            }
            Self::Machine(address) => write!(f, "{address}"),
            Self::Unnamed(proxy) => write!(f, "unnamed clients of {}", Self::Machine(*proxy)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_one_machine_are_one_peer() {
        let peer = |text: &str| Peer::at(text.parse().unwrap());
        assert_eq!(peer("::ffff:10.1.2.3"), peer("10.1.2.3"));
        assert_ne!(peer("10.1.2.3"), peer("10.1.2.4"));
        assert_eq!(peer("2001:db8::1"), peer("2001:db8::ffff:2"));
        assert_ne!(peer("2001:db8::1"), peer("2001:db8:0:1::1"));
        assert_eq!(peer("2001:db8::1").to_string(), "2001:db8::/64");
        assert_eq!(peer("::1").to_string(), "::1");
    }
}
