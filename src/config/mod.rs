//! The settings of a server: flags, `PIAD_*` variables, and a file.
//!
//! - `cli`: the command line of the program, `fit_arguments`: that of `piad fit`;
//! - `values`, [`listen`], [`origin`]: parsing of values;
//! - [`file`]: a file of settings; `sources`: the source of each setting;
//! - `machine`: the available memory.

mod cli;
mod file;
pub(crate) mod fit_arguments;
pub mod listen;
mod machine;
pub mod origin;
mod sources;
mod values;

use std::path::PathBuf;
use std::time::Duration;

use bytesize::ByteSize;
use clap::{Args, Parser};
use ipnet::IpNet;

pub use cli::{Cli, Command, StoreCommand, TokenCommand};
use listen::Listen;
use origin::Origin;
pub use sources::{Sources, parse};
pub(crate) use values::TlsFiles;
pub use values::{BasePath, Lifetime, LogFormat, Storage, network};
use values::{duration, host_name, seconds, some_seconds};

use crate::job::store::StorePlace;
use crate::job::store::shared::Settings;
use crate::model::job::Limits;
use piad_fit::engine::Admission;

/// The settings of a server.
#[derive(Args, Clone, Debug)]
pub struct Config {
    /// A file of settings in TOML, under the names of the flags, such as max-jobs = 500. Flags and variables
    /// override it.
    #[arg(long = "config", env = "PIAD_CONFIG", value_name = "FILE")]
    pub config_file: Option<PathBuf>,

    /// Listen addresses: an address or a name with a port (all addresses of a name; port 0 takes any free one), or a
    /// Unix domain socket such as unix:/run/piad.sock. Several are possible.
    #[arg(
        long,
        env = "PIAD_LISTEN",
        value_delimiter = ',',
        value_name = "PLACE",
        default_value = "127.0.0.1:8080"
    )]
    pub listen: Vec<Listen>,

    /// The certificate for TLS, with those of the authorities below the root, as PEM: ports then speak HTTPS.
    /// The files are loaded again when they change, and on SIGHUP.
    #[arg(long, env = "PIAD_TLS_CERT", value_name = "FILE")]
    pub tls_cert: Option<PathBuf>,

    /// The private key of that certificate, as PEM.
    #[arg(long, env = "PIAD_TLS_KEY", value_name = "FILE")]
    pub tls_key: Option<PathBuf>,

    /// Authorities, as PEM: only clients with a certificate of one of them are served (mutual TLS).
    #[arg(long, env = "PIAD_TLS_CLIENT_CA", value_name = "FILE")]
    pub tls_client_ca: Option<PathBuf>,

    /// The file of tokens made by `piad token`; requests then need a token. It is read again when it changes, and on
    /// SIGHUP. The variable PIAD_TOKEN is a further token, with all scopes.
    #[arg(long, env = "PIAD_TOKENS", value_name = "FILE")]
    pub tokens: Option<PathBuf>,

    /// Let everyone who reaches the server use it, also on network addresses.
    #[arg(long, env = "PIAD_INSECURE_NO_AUTH")]
    pub insecure_no_auth: bool,

    /// Names by which clients reach the server, such as fit.example.org or *.example.org; requests
    /// for others are refused. Without any, a server on a loopback address is localhost and others
    /// are not checked; * allows all names.
    #[arg(
        long,
        env = "PIAD_ALLOWED_HOST",
        value_delimiter = ',',
        value_name = "NAME",
        value_parser = host_name
    )]
    pub allowed_host: Vec<String>,

    /// Trusted proxies, such as 10.0.0.0/8: the client address is taken from the PROXY protocol (versions
    /// 1 and 2) or from Forwarded and X-Forwarded-For, so that limits for an address are those of their
    /// clients.
    #[arg(
        long,
        env = "PIAD_TRUSTED_PROXY",
        value_delimiter = ',',
        value_name = "NETWORK",
        value_parser = network
    )]
    pub trusted_proxy: Vec<IpNet>,

    /// The path prefix of the server for clients, such as /fits: links begin with it, and requests may
    /// have it or, from a proxy that strips it, not.
    #[arg(long, env = "PIAD_BASE_PATH", default_value = "/", value_name = "PATH")]
    pub base_path: BasePath,

    /// Origins whose pages may use the API from a browser, such as https://cad.example; * allows
    /// all.
    #[allow(rustdoc::bare_urls, reason = "the text is the help of a flag")]
    #[arg(
        long,
        env = "PIAD_CORS_ORIGIN",
        value_delimiter = ',',
        value_name = "ORIGIN"
    )]
    pub cors_origin: Vec<Origin>,

    /// Threads of each lane of the compute pool (small steps, large steps, requests and answers, set-ups), and those
    /// that share long loops [default: the number of cores].
    #[arg(long, env = "PIAD_WORKERS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub workers: Option<u16>,

    /// Largest request body.
    #[arg(long, env = "PIAD_MAX_BODY", default_value = "256MiB")]
    pub max_body: ByteSize,

    /// Most data points of a job.
    #[arg(long, env = "PIAD_MAX_POINTS", default_value_t = 4_000_000)]
    pub max_points: usize,

    /// Largest `max_iterations` of a job.
    #[arg(long, env = "PIAD_MAX_ITERATIONS", default_value_t = 1_000_000)]
    pub max_iterations: usize,

    /// Most jobs that have not ended; further ones are refused with 503.
    #[arg(long, env = "PIAD_MAX_JOBS", default_value_t = 10_000)]
    pub max_jobs: usize,

    /// Most jobs of one client address that have not ended; further ones are refused with 429. A proxy that is not
    /// trusted is one address: set it to --max-jobs [default: half of what other addresses leave of --max-jobs].
    #[arg(long, env = "PIAD_MAX_JOBS_PER_PEER")]
    pub max_jobs_per_peer: Option<usize>,

    /// Most connections; further ones are answered 503, except for /livez, /readyz and /metrics
    /// [default: the largest number within the limit of open files, which is also the maximum].
    #[arg(long, env = "PIAD_MAX_CONNECTIONS")]
    pub max_connections: Option<usize>,

    /// Most connections of one client address. A proxy that is not trusted is one address: set it to --max-connections
    /// [default: half of --max-connections].
    #[arg(long, env = "PIAD_MAX_CONNECTIONS_PER_PEER")]
    pub max_connections_per_peer: Option<usize>,

    /// Most requests of one client address that are open at a time over HTTP/2 or through a trusted proxy,
    /// event streams included; further ones are answered 503.
    #[arg(long, env = "PIAD_MAX_REQUESTS_PER_PEER", default_value_t = 1000)]
    pub max_requests_per_peer: usize,

    /// The store of jobs: a directory; :memory: to forget them when the server ends; or a PostgreSQL database, such as
    /// postgres://piad@db.example/piad?sslmode=verify-full, that several servers share.
    #[arg(
        long,
        env = "PIAD_STORE",
        default_value = "./piad-data",
        value_name = "PLACE",
        hide_env_values = true
    )]
    pub store: Storage,

    /// Most connections with the database, besides one that listens.
    #[arg(long, env = "PIAD_STORE_CONNECTIONS", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub store_connections: u16,

    /// Seconds without a heartbeat after which the jobs of a server are taken over by others with the same database.
    #[arg(long, env = "PIAD_LEASE", default_value = "15", value_parser = some_seconds)]
    pub lease: Duration,

    /// Memory for running fits, the iterations for their readers, requests and files. Jobs that do not fit
    /// wait; jobs that can never fit are refused
    /// [default: half of the memory of the machine or its control group; 512MiB if that is unknown].
    #[arg(long, env = "PIAD_MEMORY")]
    pub memory: Option<ByteSize>,

    /// Memory for the recent iterations of each fit, from which its readers are served.
    #[arg(long, env = "PIAD_RING", default_value = "64MiB")]
    pub ring: ByteSize,

    /// Memory for jobs that have just ended, so that reading and editing them is quick.
    #[arg(long, env = "PIAD_RECENT", default_value = "64MiB")]
    pub recent: ByteSize,

    /// Most ended jobs to keep; the first to end is removed first.
    #[arg(long, env = "PIAD_RETAIN_JOBS", default_value_t = 1000)]
    pub retain_jobs: usize,

    /// Space for the data and results of ended jobs; the first to end is removed first.
    #[arg(long, env = "PIAD_RETAIN_BYTES", default_value = "1GiB")]
    pub retain_bytes: ByteSize,

    /// How long ended jobs are kept, such as 36h or 90m.
    #[arg(long, env = "PIAD_RETAIN_AGE", default_value = "168h", value_parser = duration)]
    pub retain_age: Duration,

    /// Seconds between the comments that keep a quiet event stream open.
    #[arg(long, env = "PIAD_HEARTBEAT", default_value = "15", value_parser = some_seconds)]
    pub heartbeat: Duration,

    /// Seconds without a byte after which a request body times out.
    #[arg(long, env = "PIAD_BODY_TIMEOUT", default_value = "30", value_parser = seconds)]
    pub body_timeout: Duration,

    /// Least rate of a request body in bytes per second, on average; slower ones time out after
    /// --body-timeout.
    #[arg(long, env = "PIAD_MIN_BODY_RATE", default_value = "16KiB")]
    pub min_body_rate: ByteSize,

    /// Seconds in which the head of a request must arrive, from its first byte on, and in which a
    /// connection must send its first request.
    #[arg(long, env = "PIAD_HEADER_TIMEOUT", default_value = "30", value_parser = some_seconds)]
    pub header_timeout: Duration,

    /// Seconds without a request after which a connection is closed. Behind a proxy: more than the
    /// idle timeout of its connections to the server.
    #[arg(long, env = "PIAD_IDLE_TIMEOUT", default_value = "120", value_parser = some_seconds)]
    pub idle_timeout: Duration,

    /// Seconds after which an answer is aborted if the client does not read.
    #[arg(long, env = "PIAD_WRITE_TIMEOUT", default_value = "60", value_parser = some_seconds)]
    pub write_timeout: Duration,

    /// Seconds for open requests to end after SIGTERM or SIGINT.
    #[arg(long, env = "PIAD_GRACE", default_value = "4", value_parser = seconds)]
    pub grace: Duration,

    /// End the server when its standard input ends, for programs that start a server of their own and hold a pipe to
    /// it: it ends with them, also if they are killed.
    #[arg(long, env = "PIAD_EXIT_WITH_STDIN")]
    pub exit_with_stdin: bool,

    /// The collector for traces of requests and jobs, by OTLP over gRPC, such as http://localhost:4317;
    /// the variables OTEL_* of OpenTelemetry apply, too [default: that of OTEL_EXPORTER_OTLP_ENDPOINT, if any].
    #[arg(
        long,
        env = "PIAD_OTLP_ENDPOINT",
        value_name = "URL",
        hide_env_values = true
    )]
    pub otlp_endpoint: Option<String>,

    /// The format of log lines, on standard error.
    #[arg(long, env = "PIAD_LOG_FORMAT", value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,

    /// The log filter: a level, or directives such as `info,piad::job=debug`.
    #[arg(long, env = "PIAD_LOG", default_value = "info")]
    pub log: String,
}

impl Config {
    /// The settings of a server that is started without flags and variables.
    pub fn standard() -> Self {
        // The attributes above are the only definition of the defaults; they always parse.
        match Standard::try_parse_from(["piad"]) {
            Ok(standard) => standard.config,
            Err(error) => error.exit(),
        }
    }

    /// The files for TLS, if the server speaks it; the error says which one is missing.
    pub(crate) fn tls_files(&self) -> Result<Option<TlsFiles>, &'static str> {
        match (&self.tls_cert, &self.tls_key, &self.tls_client_ca) {
            (Some(certificate), Some(key), clients) => Ok(Some(TlsFiles {
                certificate: certificate.clone(),
                key: key.clone(),
                clients: clients.clone(),
            })),
            (None, None, None) => Ok(None),
            (Some(_), None, _) => Err("--tls-cert needs the private key, --tls-key"),
            (None, Some(_), _) => Err("--tls-key needs the certificate, --tls-cert"),
            (None, None, Some(_)) => Err("--tls-client-ca needs --tls-cert and --tls-key"),
        }
    }

    /// The largest jobs that are accepted, if there is memory and time for any.
    pub fn limits(&self) -> Limits {
        Limits {
            points: self.max_points,
            iterations: self.max_iterations,
            admission: Admission::ANY,
        }
    }

    /// The store, and its settings.
    pub(crate) fn store_place(&self) -> StorePlace<'_> {
        let settings = Settings {
            connections: usize::from(self.store_connections),
            lease: self.lease,
        };
        self.store.place(settings)
    }

    /// Bytes that running fits may take together: as set, or half of the available memory.
    pub fn memory_bytes(&self) -> u64 {
        let half = || machine::memory().map_or(UNKNOWN_MEMORY, |memory| memory / 2);
        self.memory.map_or_else(half, |size| size.as_u64())
    }

    /// Returns true if the memory is set, or that of the machine is known.
    pub fn knows_memory(&self) -> bool {
        self.memory.is_some() || machine::memory().is_some()
    }

    /// Jobs of one peer that may be unfinished: as set, or half of all.
    pub fn jobs_of_a_peer(&self) -> usize {
        let half = self.max_jobs.div_ceil(2);
        self.max_jobs_per_peer.unwrap_or(half).min(self.max_jobs)
    }

    /// The number of compute threads of each lane.
    pub fn worker_count(&self) -> usize {
        self.workers.map_or_else(
            || std::thread::available_parallelism().map_or(1, usize::from),
            usize::from,
        )
    }
}

/// The memory for fits if that of the machine is not known.
const UNKNOWN_MEMORY: u64 = 512 << 20;

#[derive(Parser)]
struct Standard {
    #[command(flatten)]
    config: Config,
}
