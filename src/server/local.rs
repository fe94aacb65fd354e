//! A server without a port, for the program that it is a part of.

use std::io;
use std::sync::Arc;

use axum::Router;
use tokio::sync::watch;

use super::{CloseOnDrop, limits, open, resources};
use crate::api::app::App;
use crate::api::http::host::Hosts;
use crate::api::http::router;
use crate::config::Config;
use crate::job::service::Jobs;

/// A server that only this program reaches. Its jobs end when it is dropped.
pub(crate) struct Local {
    /// The handler of requests.
    pub router: Router,
    _stop: watch::Sender<bool>,
    _closed_at_the_end: CloseOnDrop,
}

/// Starts a server with these settings; those of connections do not apply.
pub(crate) async fn start(config: Config) -> io::Result<Local> {
    let resources = resources(&config, Arc::default())?;
    let closed_at_the_end = CloseOnDrop(Arc::clone(&resources));
    let store = open(&config, &resources.counters).await?;
    let jobs = Arc::new(Jobs::new(store, resources, limits(&config)));
    let (stop, stopping) = watch::channel(false);
    let hosts = Hosts::new(&[], true);
    Ok(Local {
        router: router::router(App::new(jobs, config, stopping, None), hosts),
        _stop: stop,
        _closed_at_the_end: closed_at_the_end,
    })
}
