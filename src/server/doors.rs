//! What it takes to accept and serve connections.

use std::sync::Arc;

use axum::Router;
use ipnet::IpNet;
use parking_lot::Mutex;
use tokio::sync::watch;

use super::activity::Times;
use super::limits::Connections;
use super::tls::Tls;
use crate::job::counters::Counters;
use crate::log_throttle::LogThrottle;

/// What it takes to accept and serve connections.
pub(super) struct Doors {
    /// Where requests go.
    pub(super) router: Router,
    /// How long connections may do nothing.
    pub(super) times: Times,
    pub(super) connections: Connections,
    /// Proxies that report the addresses of their clients.
    pub(super) proxies: Vec<IpNet>,
    /// What connections from the network are encrypted with.
    pub(super) tls: Option<Arc<Tls>>,
    pub(super) counters: Counters,
    /// Becomes true when no more are taken in.
    pub(super) stopping: watch::Receiver<bool>,
    /// Connections beyond the limits.
    pub(super) crowds: Mutex<LogThrottle>,
}
