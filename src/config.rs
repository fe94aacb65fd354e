//! The settings of a server: flags and `PIAD_*` variables.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use bytesize::ByteSize;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use ipnet::IpNet;
use jiff::SignedDuration;

use crate::api::http::cors::Origin;
use crate::command::arguments::FitArguments;
use crate::server::listen::Listen;
use crate::server::proxy;

use crate::fit::admission::Admission;
use crate::job::store::StorePlace;
use crate::job::store::shared::Settings;
use crate::model::job::Limits;

/// Curve and surface fitting by progressive iterative approximation, every iteration streamed.
#[derive(Debug, Parser)]
#[command(name = "piad", version = env!("PIAD_VERSION"), long_version = concat!(env!("PIAD_VERSION"), "\n", env!("PIAD_FEATURES")), about, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// What to do; without a command, serve.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Settings of the server.
    #[command(flatten)]
    pub config: Config,
}

/// The commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serve fitting jobs over HTTP (what piad does without a command).
    Serve(Box<Config>),
    /// Ask a running server whether it is ready; exit with 0 if it is (for containers).
    Health {
        /// The server's address; 0.0.0.0 and [::] stand for this machine.
        #[arg(long, env = "PIAD_LISTEN", default_value = "127.0.0.1:8080")]
        listen: Listen,
        /// How many seconds to wait for the answer.
        #[arg(long, default_value = "3")]
        timeout: u64,
    },
    /// Fit the points of a file, or a job, and write the result; no server is needed.
    Fit(Box<FitArguments>),
    /// Copy, check, repair or export the jobs of servers, while none runs.
    #[command(subcommand)]
    Store(StoreCommand),
    /// Write completions for a shell to the standard output.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Write a manual page to the standard output, in the format of man(1).
    Man {
        /// The command that it is about, such as fit; without one the program.
        command: Option<String>,
    },
}

/// What can be done with stores.
#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// Copy all jobs, their results and idempotency keys into another store, which keeps what it has. What was
    /// cut off can be done again.
    Copy {
        /// Where they are: a directory, or the URL of a PostgreSQL database.
        from: Storage,
        /// Where they go.
        to: Storage,
    },
    /// Read everything in a store and say what is damaged; the store stays as it is. Exit status 1 if anything is.
    Check {
        /// A directory, or the URL of a PostgreSQL database.
        store: Storage,
    },
    /// Put a new file with all that can be read in the place of a damaged one, which stays beside it. Jobs whose
    /// results are lost run again.
    Repair {
        /// The directory of the file.
        store: Storage,
    },
    /// Write each job that can be read as ID.json, which POST /v1/jobs takes again, and its result as
    /// ID.result.json; the store stays as it is. Exit status 1 if anything is damaged.
    Export {
        /// A directory, or the URL of a PostgreSQL database.
        store: Storage,
        /// Where the files go.
        directory: PathBuf,
    },
}

/// The settings of a server.
#[derive(Args, Clone, Debug)]
pub struct Config {
    /// Address or name, and port, to listen on: all addresses of a name; port 0 takes any free one.
    #[arg(long, env = "PIAD_LISTEN", default_value = "127.0.0.1:8080")]
    pub listen: Listen,

    /// Names by which clients reach the server, such as fit.example.org or *.example.org; requests
    /// for others are refused. Without any, a server on a loopback address is localhost and others
    /// are not checked; * stands for all names.
    #[arg(
        long,
        env = "PIAD_ALLOWED_HOST",
        value_delimiter = ',',
        value_name = "NAME",
        value_parser = host_name
    )]
    pub allowed_host: Vec<String>,

    /// Proxies, such as 10.0.0.0/8, that are believed whose connections (PROXY protocol, versions 1 and 2)
    /// and requests (Forwarded, X-Forwarded-For) they pass on: limits for an address are then those of
    /// their clients.
    #[arg(
        long,
        env = "PIAD_TRUSTED_PROXY",
        value_delimiter = ',',
        value_name = "NETWORK",
        value_parser = proxy::network
    )]
    pub trusted_proxy: Vec<IpNet>,

    /// The path below which clients see the server, such as /fits: links begin with it, and requests may
    /// come with it or, from a proxy that takes it off, without it.
    #[arg(long, env = "PIAD_BASE_PATH", default_value = "/", value_name = "PATH")]
    pub base_path: BasePath,

    /// Origins whose pages may use the API from a browser, such as https://cad.example; * stands for
    /// all of them.
    #[arg(
        long,
        env = "PIAD_CORS_ORIGIN",
        value_delimiter = ',',
        value_name = "ORIGIN"
    )]
    pub cors_origin: Vec<Origin>,

    /// Compute threads for each of the two lanes (small and large steps) [default: the number of cores].
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

    /// Most jobs of one client address that have not ended; further ones are refused with 429.
    /// Behind a proxy that is not trusted, which is one address: as many as --max-jobs
    /// [default: half of what other addresses leave of --max-jobs].
    #[arg(long, env = "PIAD_MAX_JOBS_PER_PEER")]
    pub max_jobs_per_peer: Option<usize>,

    /// Most connections; further ones are answered 503, but for /livez, /readyz and /metrics
    /// [default: what the limit of open files leaves, which is the most in any case].
    #[arg(long, env = "PIAD_MAX_CONNECTIONS")]
    pub max_connections: Option<usize>,

    /// Most connections of one client address. Behind a proxy that is not trusted, which is one address: as
    /// many as --max-connections [default: half of --max-connections].
    #[arg(long, env = "PIAD_MAX_CONNECTIONS_PER_PEER")]
    pub max_connections_per_peer: Option<usize>,

    /// Most requests of one client address that are open at a time over HTTP/2 or through a trusted proxy,
    /// event streams included; further ones are answered 503.
    #[arg(long, env = "PIAD_MAX_REQUESTS_PER_PEER", default_value_t = 1000)]
    pub max_requests_per_peer: usize,

    /// Where jobs are kept: a directory; :memory: to forget them when the server ends; or a PostgreSQL
    /// database, such as postgres://piad@db.example/piad?sslmode=verify-full, that several servers share.
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

    /// Seconds after which the jobs of a server that says nothing any more are taken over by others with the
    /// same database.
    #[arg(long, env = "PIAD_LEASE", default_value = "15", value_parser = some_seconds)]
    pub lease: Duration,

    /// Memory for all that takes much of it: running fits, what their readers are served from, requests
    /// and files. Jobs that do not fit in wait, those that never fit are refused
    /// [default: half of what the machine or its control group has; 512MiB where that is not known].
    #[arg(long, env = "PIAD_MEMORY")]
    pub memory: Option<ByteSize>,

    /// Memory for the recent iterations of each fit, from which its readers are served.
    #[arg(long, env = "PIAD_RING", default_value = "64MiB")]
    pub ring: ByteSize,

    /// Memory for jobs that have just ended, so that reading and editing them is quick.
    #[arg(long, env = "PIAD_RECENT", default_value = "64MiB")]
    pub recent: ByteSize,

    /// Most ended jobs that are kept; the first to end goes first.
    #[arg(long, env = "PIAD_RETAIN_JOBS", default_value_t = 1000)]
    pub retain_jobs: usize,

    /// Room for the data and results of ended jobs; the first to end goes first.
    #[arg(long, env = "PIAD_RETAIN_BYTES", default_value = "1GiB")]
    pub retain_bytes: ByteSize,

    /// How long ended jobs are kept, such as 36h or 90m.
    #[arg(long, env = "PIAD_RETAIN_AGE", default_value = "168h", value_parser = duration)]
    pub retain_age: Duration,

    /// Seconds between the comments that keep a quiet event stream open.
    #[arg(long, env = "PIAD_HEARTBEAT", default_value = "15", value_parser = some_seconds)]
    pub heartbeat: Duration,

    /// Seconds without a byte after which a request body is given up.
    #[arg(long, env = "PIAD_BODY_TIMEOUT", default_value = "30", value_parser = seconds)]
    pub body_timeout: Duration,

    /// Bytes of a request body that come in a second at least, on average; slower ones are given up after
    /// the time of --body-timeout.
    #[arg(long, env = "PIAD_MIN_BODY_RATE", default_value = "16KiB")]
    pub min_body_rate: ByteSize,

    /// Seconds in which the head of a request must arrive, from its first byte on; and in which a
    /// connection must bring its first request.
    #[arg(long, env = "PIAD_HEADER_TIMEOUT", default_value = "30", value_parser = some_seconds)]
    pub header_timeout: Duration,

    /// Seconds without a request after which a connection is closed. Behind a proxy: more than it
    /// keeps its own connections to the server.
    #[arg(long, env = "PIAD_IDLE_TIMEOUT", default_value = "120", value_parser = some_seconds)]
    pub idle_timeout: Duration,

    /// Seconds after which an answer is given up of which the client takes nothing.
    #[arg(long, env = "PIAD_WRITE_TIMEOUT", default_value = "60", value_parser = some_seconds)]
    pub write_timeout: Duration,

    /// Seconds that requests may take to end after SIGTERM or SIGINT.
    #[arg(long, env = "PIAD_GRACE", default_value = "4", value_parser = seconds)]
    pub grace: Duration,

    /// The collector that gets traces of requests and jobs, by OTLP over gRPC, such as http://localhost:4317;
    /// the variables OTEL_* of OpenTelemetry hold, too [default: that of OTEL_EXPORTER_OTLP_ENDPOINT, if any].
    #[arg(long, env = "PIAD_OTLP_ENDPOINT", value_name = "URL")]
    pub otlp_endpoint: Option<String>,

    /// How log lines, on standard error, look.
    #[arg(long, env = "PIAD_LOG_FORMAT", value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,

    /// What is logged: a level, or directives such as `info,piad::job=debug`.
    #[arg(long, env = "PIAD_LOG", default_value = "info")]
    pub log: String,
}

/// The path below which clients see a server: empty, or such as `/fits`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BasePath(String);

impl BasePath {
    /// Without a slash at the end.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for BasePath {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = text.trim_end_matches('/');
        let plain = |c: char| c.is_ascii_alphanumeric() || "-._~".contains(c);
        let mut parts = path.split('/');
        let begins = parts.next() == Some("");
        let whole = parts
            .all(|part| !part.is_empty() && part != "." && part != ".." && part.chars().all(plain));
        match begins && whole && !text.is_empty() {
            true => Ok(Self(path.to_owned())),
            false => Err("a path such as /fits, of letters, digits, -, ., _ and ~".to_owned()),
        }
    }
}

impl fmt::Display for BasePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_empty() { "/" } else { &self.0 })
    }
}

/// Where jobs are kept.
#[derive(Clone, PartialEq, Eq)]
pub enum Storage {
    /// Nowhere: they end with the server.
    Memory,
    /// In a file of this directory.
    Directory(PathBuf),
    /// In the PostgreSQL database of this URL.
    Database(String),
}

impl Storage {
    /// The place that is meant; a database is used with these settings.
    pub(crate) fn place(&self, settings: Settings) -> StorePlace<'_> {
        match self {
            Self::Memory => StorePlace::Memory,
            Self::Directory(path) => StorePlace::Directory(path),
            Self::Database(url) => StorePlace::Database(url, settings),
        }
    }
}

/// Without the URL of a database, which may contain a password.
impl fmt::Debug for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Memory => f.write_str(":memory:"),
            Self::Directory(path) => write!(f, "{path:?}"),
            Self::Database(_) => f.write_str("a database"),
        }
    }
}

impl FromStr for Storage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            ":memory:" => Ok(Self::Memory),
            "" => Err("a directory, :memory: or the URL of a database".to_owned()),
            url if is_database(url) => Ok(Self::Database(url.to_owned())),
            url if url.contains("://") => {
                Err("a database has a URL that begins with postgres://".to_owned())
            }
            path => Ok(Self::Directory(path.into())),
        }
    }
}

fn is_database(text: &str) -> bool {
    let schemes = ["postgres://", "postgresql://"];
    schemes.iter().any(|scheme| text.starts_with(scheme))
}

/// How log lines look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

impl Config {
    /// The settings of a server that is started without flags and variables.
    pub fn standard() -> Self {
        // The attributes above are the one place of the defaults; they always parse.
        match Standard::try_parse_from(["piad"]) {
            Ok(standard) => standard.config,
            Err(error) => error.exit(),
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

    /// Where the store is, and how it is used.
    pub(crate) fn store_place(&self) -> StorePlace<'_> {
        let settings = Settings {
            connections: usize::from(self.store_connections),
            lease: self.lease,
        };
        self.store.place(settings)
    }

    /// Bytes that running fits may take together: as set, or half of what there is.
    pub fn memory_bytes(&self) -> u64 {
        let half = || machine_memory().map_or(UNKNOWN_MEMORY, |memory| memory / 2);
        self.memory.map_or_else(half, |size| size.as_u64())
    }

    /// Whether the memory is set, or that of the machine is known.
    pub fn knows_memory(&self) -> bool {
        self.memory.is_some() || machine_memory().is_some()
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

/// The memory of the machine, or of its control group if that has less. `None` if the system does not tell,
/// such as Linux without /proc.
fn machine_memory() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let machine = Some(system.total_memory()).filter(|&memory| memory > 0)?;
    let group = system.cgroup_limits().map(|limits| limits.total_memory);
    let group = group.filter(|&group| group > 0).unwrap_or(machine);
    Some(group.min(machine))
}

#[derive(Parser)]
struct Standard {
    #[command(flatten)]
    config: Config,
}

/// A name, or all names below one.
fn host_name(text: &str) -> Result<String, String> {
    let name = text.strip_prefix("*.").unwrap_or(text);
    match text != "*" && (name.is_empty() || name.contains('*')) {
        true => Err("not a name such as fit.example.org, *.example.org or *".to_owned()),
        false => Ok(text.to_owned()),
    }
}

fn duration(text: &str) -> Result<Duration, String> {
    let duration: SignedDuration = text
        .parse()
        .map_err(|_| "not a duration such as 36h or 90m".to_owned())?;
    Duration::try_from(duration).map_err(|_| "a duration is not negative".to_owned())
}

fn some_seconds(text: &str) -> Result<Duration, String> {
    match seconds(text)? {
        seconds if seconds < Duration::from_millis(10) => {
            Err("must be at least 0.01 seconds".to_owned())
        }
        seconds => Ok(seconds),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| "not a number of seconds".to_owned())?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if duration <= Duration::from_secs(86_400) => Ok(duration),
        _ => Err("must lie between 0 and 86400 seconds".to_owned()),
    }
}
