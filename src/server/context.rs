//! Shared state to accept and serve connections.

use std::sync::Arc;

use axum::Router;
use ipnet::IpNet;
use parking_lot::Mutex;
use tokio::sync::watch;

use super::idle_tracking::Times;
use super::limits::Connections;
use super::tls::Tls;
use crate::job::counters::Counters;
use crate::log_throttle::LogThrottle;

/// Shared state to accept and serve connections.
pub(super) struct ServerContext {
    /// The handler of requests.
    pub(super) router: Router,
    /// The timeouts of connections.
    pub(super) times: Times,
    pub(super) connections: Connections,
    /// Proxies that report the addresses of their clients.
    pub(super) proxies: Vec<IpNet>,
    /// TLS for connections from the network.
    pub(super) tls: Option<Arc<Tls>>,
    pub(super) counters: Counters,
    /// Becomes true when no more connections are accepted.
    pub(super) stopping: watch::Receiver<bool>,
    /// Connections beyond the limits.
    pub(super) overloads: Mutex<LogThrottle>,
}
