//! State shared by the HTTP and gRPC handlers.

use std::sync::Arc;

use tokio::sync::watch;

use super::http::measure::Requests;
use crate::access::Access;
use crate::config::Config;
use crate::job::peer::Peer;
use crate::job::quota::{Exceeded, OpenStream};
use crate::job::service::Jobs;

/// The state of all handlers.
#[derive(Clone)]
pub(crate) struct App {
    pub(in crate::api) jobs: Arc<Jobs>,
    pub(in crate::api) config: Arc<Config>,
    pub(in crate::api) stopping: watch::Receiver<bool>,
    pub(in crate::api) requests: Requests,
    /// The tokens to check requests against; `None` if no token is needed.
    pub(in crate::api) access: Option<Access>,
}

impl App {
    /// An application over `jobs`; streams end when `stopping` becomes true.
    pub(crate) fn new(
        jobs: Arc<Jobs>,
        config: Config,
        stopping: watch::Receiver<bool>,
        access: Option<Access>,
    ) -> Self {
        Self {
            jobs,
            config: Arc::new(config),
            stopping,
            requests: Requests::default(),
            access,
        }
    }

    /// Counts a stream for the caller, if that is within the quota of its tenant.
    pub(in crate::api) fn open_stream(&self) -> Result<OpenStream, Exceeded> {
        let tenant = Peer::owner(Peer::current());
        self.jobs.resources().open_stream(tenant)
    }

    /// Completes when the server begins to stop.
    pub(in crate::api) async fn stopped(&self) {
        // An error means that the server is gone.
        let _ = self.stopping.clone().wait_for(|stopping| *stopping).await;
    }
}
