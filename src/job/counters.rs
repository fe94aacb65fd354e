//! The metrics of a server for Prometheus: counters since its start, and gauges.

use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::Registry;

use super::outline::Outline;
use super::state::State;
use super::tenant::Tenant;

/// Counters from the start of the server on, and gauges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counters {
    /// Levels computed by all runs of all jobs.
    pub iterations: Counter,
    /// Frames encoded: one for each frame and form, however many clients read it.
    pub encodings: Counter,
    /// Events sent.
    pub events: Counter,
    /// Jobs accepted.
    pub accepted: Counter,
    /// Ephemeral edits begun, which are not accepted jobs.
    pub ephemeral: Counter,
    /// Batches begun.
    pub batches: Counter,
    /// Fits of batches that have ended.
    pub batch_items: Counter,
    /// Commits of the embedded store.
    pub commits: Counter,
    /// Writes in those commits.
    pub writes: Counter,
    /// Statements that were sent to the database of several replicas.
    pub store_statements: Counter,
    /// Statements that failed because it could not be reached, and may have been repeated.
    pub store_retries: Counter,
    /// Ends of jobs that were refused, as another replica had claimed the job.
    pub stale_writes: Counter,
    /// Jobs of dead replicas, put back into the queue or failed by this one.
    pub jobs_recovered: Counter,
    /// Connections whose TLS handshake has failed.
    pub handshakes_failed: Counter,
    /// Files with certificates or tokens that could not be loaded again.
    pub reloads_failed: Counter,
    denied: Family<DenialLabel, Counter>,
    tenants: PerTenant,
    ended: Family<EndLabel, Counter>,
    streams: Gauge,
    connections: Gauge,
    running: Gauge,
}

/// Counters of one tenant. Their number is bounded by the tenants of the tokens.
#[derive(Clone, Debug, Default)]
struct PerTenant {
    /// Jobs accepted.
    jobs: Family<TenantLabel, Counter>,
    /// Points of these.
    points: Family<TenantLabel, Counter>,
    /// Requests beyond the quota.
    exceeded: Family<TenantLabel, Counter>,
}

/// Counts a stream, a connection or a running job until it is dropped.
#[derive(Debug)]
#[must_use]
pub(crate) struct Open(Gauge);

impl Open {
    fn new(gauge: &Gauge) -> Self {
        gauge.inc();
        Self(gauge.clone())
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        self.0.dec();
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct EndLabel {
    state: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct TenantLabel {
    tenant: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct DenialLabel {
    reason: &'static str,
}

impl Counters {
    /// Counts a request that was turned away.
    pub(crate) fn count_denial(&self, reason: &'static str) {
        self.denied.get_or_create(&DenialLabel { reason }).inc();
    }

    /// Counts a job that was accepted.
    pub(crate) fn count_job(&self, outline: &Outline) {
        self.accepted.inc();
        let tenant = outline.tenant.name();
        let label = TenantLabel { tenant };
        self.tenants.jobs.get_or_create(&label).inc();
        let points = outline.grid.count() as u64;
        self.tenants.points.get_or_create(&label).inc_by(points);
    }

    /// Counts a request that was beyond the quota of its tenant.
    pub(crate) fn count_exceeded(&self, tenant: Tenant) {
        let tenant = tenant.name();
        self.tenants
            .exceeded
            .get_or_create(&TenantLabel { tenant })
            .inc();
    }

    /// Counts the end of a job.
    pub(crate) fn count_end(&self, state: State) {
        let state = state.name();
        self.ended.get_or_create(&EndLabel { state }).inc();
    }

    /// Counts a stream of events while it is open.
    pub(crate) fn open_stream(&self) -> Open {
        Open::new(&self.streams)
    }

    /// Counts a connection while it is open.
    pub(crate) fn open_connection(&self) -> Open {
        Open::new(&self.connections)
    }

    /// Counts a job while it is running.
    pub(crate) fn run_job(&self) -> Open {
        Open::new(&self.running)
    }

    /// The number of running jobs.
    pub(crate) fn running(&self) -> usize {
        usize::try_from(self.running.get()).unwrap_or(0)
    }

    /// Registers the counters under their names; if a tenant is given, only its counters among those of tenants.
    pub(crate) fn register(&self, registry: &mut Registry, tenant: Option<Tenant>) {
        let plain = [
            ("iterations", "Levels computed", &self.iterations),
            ("encodings", "Frames encoded", &self.encodings),
            ("events", "Events of streams sent", &self.events),
            ("jobs_accepted", "Jobs accepted", &self.accepted),
            ("ephemeral_edits", "Ephemeral edits begun", &self.ephemeral),
            ("batches", "Batches begun", &self.batches),
            (
                "batch_items",
                "Fits of batches that have ended",
                &self.batch_items,
            ),
            ("store_commits", "Commits of the store", &self.commits),
            (
                "store_writes",
                "Writes in commits of the store",
                &self.writes,
            ),
            (
                "store_statements",
                "Statements sent to the database",
                &self.store_statements,
            ),
            (
                "store_retries",
                "Statements that failed as the database could not be reached",
                &self.store_retries,
            ),
            (
                "store_stale_writes",
                "Ends of jobs refused, as another replica had claimed the job",
                &self.stale_writes,
            ),
            (
                "jobs_recovered",
                "Jobs taken over from replicas that were gone",
                &self.jobs_recovered,
            ),
            (
                "tls_handshakes_failed",
                "Connections whose TLS handshake has failed",
                &self.handshakes_failed,
            ),
            (
                "reloads_failed",
                "Times that changed certificates or tokens could not be loaded",
                &self.reloads_failed,
            ),
        ];
        for (name, help, counter) in plain {
            registry.register(format!("piad_{name}"), help, counter.clone());
        }
        let open = [
            ("streams_open", "Event streams that are open", &self.streams),
            (
                "connections_open",
                "Connections that are open",
                &self.connections,
            ),
            ("jobs_running", "Jobs that are running", &self.running),
        ];
        for (name, help, gauge) in open {
            registry.register(format!("piad_{name}"), help, gauge.clone());
        }
        let help = "Requests turned away, by reason";
        registry.register("piad_denied", help, self.denied.clone());
        let PerTenant {
            jobs,
            points,
            exceeded,
        } = &self.tenants;
        for (name, help, family) in [
            ("jobs", "Jobs accepted, by tenant", jobs),
            ("points", "Points of jobs accepted, by tenant", points),
            (
                "quota_exceeded",
                "Requests beyond a quota, by tenant",
                exceeded,
            ),
        ] {
            let family = match tenant {
                None => family.clone(),
                Some(tenant) => of_tenant(family, tenant),
            };
            registry.register(format!("piad_tenant_{name}"), help, family);
        }
        let ended = self.ended.clone();
        registry.register("piad_jobs_ended", "Jobs ended, by state", ended);
    }
}

/// The counter of one tenant.
fn of_tenant(
    family: &Family<TenantLabel, Counter>,
    tenant: Tenant,
) -> Family<TenantLabel, Counter> {
    let label = TenantLabel {
        tenant: tenant.name(),
    };
    let own = Family::<TenantLabel, Counter>::default();
    if let Some(counter) = family.get(&label) {
        own.get_or_create(&label).inc_by(counter.get());
    }
    own
}
