//! A running server: connects configuration, jobs and API.
//!
//! - `local`: the same without a port, for programs that send requests to themselves;
//! - [`listen`]: the addresses and sockets of the server; [`listener`]: their connections; `tls`: their encryption;
//! - `accept`: accepts connections; `connection`: serves one;
//! - `idle_tracking`: the activity on a connection, and its timeouts; `write_timeout`: bytes that the client does not read;
//! - `limits`: limits of the number of connections; [`proxy`]: clients behind trusted proxies;
//! - `request_body`: the bodies of requests; `response_body`: those of answers; `stream_timeout`: those of HTTP/2 that
//!   the client does not read;
//! - [`probe`]: asks a server whether it is ready;

mod accept;
mod connection;
mod context;
mod gathered_writes;
mod idle_tracking;
pub(crate) mod limits;
pub mod listen;
pub mod listener;
pub(crate) mod local;
pub mod probe;
pub mod proxy;
mod request_body;
mod response_body;
mod serve_http;
mod stream_timeout;
pub(crate) mod tls;
mod write_timeout;

use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tokio::time::sleep;
use tracing::{debug, info, warn};

use crate::access::Access;
use crate::access::ticket::TicketKey;
use crate::access::tokens::Tokens;
use crate::api::app::App;
use crate::api::http::host::Hosts;
use crate::api::http::router;
use crate::config::Config;
use crate::job::counters::Counters;
use crate::job::quota::Quotas;
use crate::job::resources::Resources;
use crate::job::scheduler::{self, Scheduler};
use crate::job::service::{JobLimits, Jobs};
use crate::job::slots::PerPeer;
use crate::job::store::{OpenError, Retention, Store};
use crate::reload::keep_current;
use context::ServerContext;
use idle_tracking::Times;
use limits::{ConnectionLimits, Connections};
use listener::Listener;
use tls::Tls;

/// How long a server waits for its predecessor to release the data directory, whose last reads may continue for a
/// moment after it has stopped.
const HANDOVER: Duration = Duration::from_secs(3);

/// Serves on `listeners` until `shutdown` completes; then ends event streams, lets other requests
/// finish within the grace period and returns.
pub async fn serve(
    listeners: Vec<Listener>,
    config: Config,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> io::Result<()> {
    let tls = config.tls_files().map_err(io::Error::other)?;
    let tls = tls.map(Tls::load).transpose()?.map(Arc::new);
    let quotas = Arc::default();
    let tokens = Tokens::find(config.tokens.clone(), Arc::clone(&quotas));
    let tokens = tokens.map_err(io::Error::other)?;
    let tokens = tokens.map(Arc::new);
    let is_local = are_local(&listeners)?;
    check_access(&config, is_local, tokens.is_some()).map_err(io::Error::other)?;
    let resources = resources(&config, quotas)?;
    let _closed_at_the_end = CloseOnDrop(Arc::clone(&resources));
    let store = open(&config, &resources.counters).await?;
    let access = access(tokens.clone(), &store).await?;
    let jobs = Arc::new(Jobs::new(store, resources, limits(&config)));
    jobs.resume().await.map_err(io::Error::other)?;
    let (stop, stopping) = watch::channel(false);
    if !config.knows_memory() {
        let memory = config.memory_bytes();
        warn!(
            "the memory of the machine is not known: fits may take {memory} bytes; --memory sets another limit"
        );
    }
    let grace = config.grace;
    let base_path = config.base_path.as_str().to_owned();
    let (times, most) = (times(&config), ConnectionLimits::of(&config));
    let counters = jobs.resources().counters.clone();
    let proxies = config.trusted_proxy.clone();
    let hosts = Hosts::new(&config.allowed_host, is_local);
    let router = router::router(
        App::new(Arc::clone(&jobs), config, stopping.clone(), access),
        hosts,
    );

    for listener in &listeners {
        match (listener.is_network(), &tls) {
            (true, None) => info!("listening on http://{listener}{base_path}"),
            (true, Some(_)) => info!("listening on https://{listener}{base_path}"),
            (false, _) => info!("listening on {listener}"),
        }
    }
    if let Some(tls) = &tls {
        tokio::spawn(keep_current(
            Arc::clone(tls),
            counters.reloads_failed.clone(),
        ));
    }
    if let Some(tokens) = tokens {
        tokio::spawn(keep_current(tokens, counters.reloads_failed.clone()));
    }
    let context = ServerContext {
        router,
        times,
        connections: Connections::new(most),
        proxies,
        tls,
        counters,
        stopping,
        overloads: accept::overloads(),
    };
    tokio::select! {
        () = context.serve(listeners) => {}
        () = async {
            shutdown.await;
            info!("stopping: no new requests, event streams end");
            stop.send_replace(true);
            sleep(grace).await;
        } => warn!("requests were still open after the grace period of {grace:?}"),
    }
    if tokio::time::timeout(grace, jobs.suspend()).await.is_err() {
        warn!("jobs were still running after the grace period of {grace:?}");
    }
    Ok(())
}

/// The shared resources of the jobs of a server with these settings.
fn resources(config: &Config, quotas: Arc<Quotas>) -> io::Result<Arc<Resources>> {
    let workers = config.worker_count();
    scheduler::share_loops(workers);
    let scheduler = Scheduler::new(workers)?;
    let (memory, ring) = (bytes(config.memory_bytes()), bytes(config.ring.as_u64()));
    let mut resources = Resources::new(scheduler, memory, ring);
    resources.quotas = quotas;
    Ok(Arc::new(resources.below(config.base_path.as_str())))
}

/// Checks that the server is not open to the network unless that is intended.
fn check_access(config: &Config, is_local: bool, has_tokens: bool) -> Result<(), &'static str> {
    let is_encrypted = config.tls_cert.is_some();
    match has_tokens {
        true if !is_local && !is_encrypted => {
            warn!("tokens are sent over the network unencrypted: use TLS, here or in a proxy");
            Ok(())
        }
        false if !is_local && config.tls_client_ca.is_none() && !config.insecure_no_auth => Err(
            "this address is open to the network without authentication: give the server tokens (piad token create, --tokens FILE) or client certificates (--tls-client-ca), or pass --insecure-no-auth if that is intended",
        ),
        _ => Ok(()),
    }
}

/// The tokens that a server checks requests against: its tickets are signed by the key in its store.
async fn access(tokens: Option<Arc<Tokens>>, store: &Store) -> io::Result<Option<Access>> {
    let Some(tokens) = tokens else {
        return Ok(None);
    };
    let new = TicketKey::random().map_err(io::Error::other)?;
    let kept = store.secret(new).await.map_err(io::Error::other)?;
    let tickets = TicketKey::of(kept);
    Ok(Some(Access { tokens, tickets }))
}

/// Returns true if only programs of this machine reach the server.
fn are_local(listeners: &[Listener]) -> io::Result<bool> {
    for listener in listeners {
        if !listener.is_local()? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn times(config: &Config) -> Times {
    Times {
        head: config.header_timeout,
        idle: config.idle_timeout,
        write: config.write_timeout,
    }
}

async fn open(config: &Config, counters: &Counters) -> io::Result<Arc<Store>> {
    let begin = Instant::now();
    let store = loop {
        match Store::open(config.store_place(), counters.clone()).await {
            Err(reason @ OpenError::InUse(_)) if begin.elapsed() < HANDOVER => {
                debug!("waiting: {reason}");
                sleep(HANDOVER / 100).await;
            }
            store => break store,
        }
    };
    Ok(Arc::new(store.map_err(io::Error::other)?))
}

fn limits(config: &Config) -> JobLimits {
    JobLimits {
        recent: bytes(config.recent.as_u64()),
        jobs: config.max_jobs,
        jobs_of_a_peer: config
            .max_jobs_per_peer
            .map_or(PerPeer::Fair, PerPeer::Fixed),
        retention: Retention {
            jobs: config.retain_jobs,
            bytes: config.retain_bytes.as_u64(),
            age: config.retain_age,
        },
    }
}

fn bytes(size: u64) -> usize {
    usize::try_from(size).unwrap_or(usize::MAX)
}

/// Closes the compute pool when the server is dropped. Work in the pool holds the pool, so it would never
/// be dropped by itself.
struct CloseOnDrop(Arc<Resources>);

impl Drop for CloseOnDrop {
    fn drop(&mut self) {
        self.0.scheduler.close();
    }
}
