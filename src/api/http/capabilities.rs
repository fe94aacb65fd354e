//! Capabilities and limits of the server.

use axum::Json;
use axum::extract::State;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use tonic::server::NamedService;

use crate::api::app::App;
use crate::api::grpc::service::Service;
use crate::api::json::plain::never_null;
use crate::api::media_type::{JSON, NDJSON, PROTOBUF, SSE};
use crate::config::Config;
use crate::model::basis::BasisKind;
use crate::model::method::{MethodKind, settings_of};
use crate::model::named::Named;
use crate::model::stream::{Choice, Digits, Encoding, MOST_MILESTONES, MOST_SAMPLES, Pace, View};
use crate::proto::messages::fitting_service_server::FittingServiceServer;
use piad_files::export::Format;
use piad_fit::basis::MAX_DEGREE;
use piad_fit::data::MAX_DIMENSION;

/// A list of names that is fixed in the program.
type Names = &'static [&'static str];

/// The capabilities of the server, and its limits.
#[derive(Serialize, JsonSchema)]
#[schemars(example = example())]
pub(crate) struct Capabilities {
    /// The version of the server.
    version: &'static str,
    /// The kinds of geometry.
    geometry: Names,
    /// The numbers of coordinates of points.
    dimensions: Vec<usize>,
    /// The bases.
    bases: Vec<BasisCapability>,
    /// The rules for the parameters of data points.
    parameters: Names,
    /// The uses of weights.
    rational: Names,
    /// The methods.
    methods: Vec<MethodCapability>,
    /// The views of an iteration.
    views: Vec<&'static str>,
    /// The encodings of arrays of numbers in JSON.
    encodings: Vec<&'static str>,
    /// The precisions of coordinates.
    digits: Vec<&'static str>,
    /// The choices for slow clients.
    paces: Vec<&'static str>,
    /// The parameters of event streams.
    stream: Vec<&'static str>,
    /// Media types.
    formats: Formats,
    /// The same service in gRPC.
    grpc: Grpc,
    /// Limits of this server.
    limits: ServerLimits,
}

/// A basis.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(extend("examples" = [{"kind": "bernstein", "degree": {"min": 1, "max": 1000}, "closed": false}]))]
struct BasisCapability {
    /// Its kind.
    #[schemars(with = "BasisKind")]
    kind: &'static str,
    /// The degrees.
    degree: DegreeRange,
    /// The rules for knots, with a control point for each data point.
    #[serde(skip_serializing_if = "<[&str]>::is_empty")]
    knots: Names,
    /// True if it can be periodic.
    closed: bool,
}

/// Degrees from the lowest to the highest.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"min": 1, "max": 1000}]))]
struct DegreeRange {
    /// The lowest.
    min: usize,
    /// The highest.
    max: usize,
}

impl BasisCapability {
    /// A basis that fits any degree.
    fn new(kind: &'static str, knots: Names) -> Self {
        let degree = DegreeRange {
            min: 1,
            max: MAX_DEGREE,
        };
        Self {
            kind,
            degree,
            knots,
            // Only B-splines are periodic.
            closed: !knots.is_empty(),
        }
    }
}

/// A method. All of them fit curves, also with fixed weights.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(extend("examples" = [{"kind": "weighted", "settings": ["omega"], "surface": true, "homogeneous": true}]))]
struct MethodCapability {
    /// Its kind.
    #[schemars(with = "MethodKind")]
    kind: &'static str,
    /// Its settings.
    settings: Vec<String>,
    /// The rules for knots of open B-splines, where it has its own.
    #[serde(skip_serializing_if = "<[&str]>::is_empty")]
    knots: Names,
    /// True if it fits surfaces.
    surface: bool,
    /// True if it fits in homogeneous coordinates.
    homogeneous: bool,
}

impl MethodCapability {
    /// All methods.
    fn all() -> Vec<Self> {
        let method = |&kind: &&'static str| Self {
            kind,
            settings: settings_of(kind),
            knots: match kind {
                "least_squares" => &["spread", "adaptive", "explicit"],
                _ => &[],
            },
            surface: kind != "convex",
            homogeneous: kind != "convex",
        };
        MethodKind::names().iter().map(method).collect()
    }
}

/// Media types.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"jobs": ["application/json"], "events": ["text/event-stream"], "result": ["model/step"]}]))]
struct Formats {
    /// Of jobs.
    jobs: Names,
    /// Of event streams.
    events: Names,
    /// Of iterations and results.
    result: Vec<&'static str>,
}

/// The same service in gRPC, on the same port.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"service": "piad.v1.FittingService", "reflection": ["grpc.reflection.v1"], "health": "grpc.health.v1"}]))]
struct Grpc {
    /// Its name.
    service: &'static str,
    /// The reflection services.
    reflection: Names,
    /// The health service.
    health: &'static str,
}

/// Limits of this server.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Limits", example = limits_example())]
struct ServerLimits {
    /// The largest request body.
    body_bytes: u64,
    /// The most data points of a job.
    points: usize,
    /// The most samples of an iteration.
    samples: usize,
    /// The most milestones of a stream.
    milestones: usize,
    /// The largest max_iterations.
    iterations: usize,
    /// The most jobs that have not ended.
    jobs: usize,
    /// The most jobs from one address that have not ended.
    jobs_per_peer: usize,
    /// Memory for running jobs.
    memory_bytes: u64,
    /// The most ended jobs that are kept.
    retained_jobs: usize,
    /// Room for the data and results of ended jobs.
    retained_bytes: u64,
    /// How long ended jobs are kept.
    retained_seconds: u64,
}

impl ServerLimits {
    fn new(config: &Config) -> Self {
        Self {
            body_bytes: config.max_body.as_u64(),
            points: config.max_points,
            samples: MOST_SAMPLES,
            milestones: MOST_MILESTONES,
            iterations: config.max_iterations,
            jobs: config.max_jobs,
            jobs_per_peer: config.jobs_of_a_peer(),
            memory_bytes: config.memory_bytes(),
            retained_jobs: config.retain_jobs,
            retained_bytes: config.retain_bytes.as_u64(),
            retained_seconds: config.retain_age.as_secs(),
        }
    }
}

/// `GET /v1/capabilities`
pub(super) async fn get(State(app): State<App>) -> Json<Capabilities> {
    let results = [JSON, PROTOBUF].into_iter();
    Json(Capabilities {
        version: env!("CARGO_PKG_VERSION"),
        geometry: &["curve", "surface"],
        dimensions: (1..=MAX_DIMENSION).collect(),
        bases: vec![
            BasisCapability::new("bspline", &["data", "averaged", "explicit"]),
            BasisCapability::new("bernstein", &[]),
            BasisCapability::new("said_ball", &[]),
            BasisCapability::new("wang_ball", &[]),
        ],
        parameters: &["chord_length", "centripetal", "uniform", "explicit"],
        rational: &["homogeneous", "fixed"],
        methods: MethodCapability::all(),
        views: View::names(),
        encodings: Encoding::names(),
        digits: Digits::names(),
        paces: Pace::names(),
        stream: Choice::names(),
        formats: Formats {
            jobs: &[JSON, PROTOBUF],
            events: &[SSE, NDJSON, PROTOBUF],
            result: results.chain(Format::ALL.map(Format::media_type)).collect(),
        },
        grpc: Grpc {
            service: FittingServiceServer::<Service>::NAME,
            reflection: &["grpc.reflection.v1", "grpc.reflection.v1alpha"],
            health: "grpc.health.v1",
        },
        limits: ServerLimits::new(&app.config),
    })
}

fn example() -> Value {
    json!({
        "version": "0.1.0", "geometry": ["curve", "surface"], "dimensions": [1, 2, 3], "bases": [], "parameters": ["chord_length"],
        "rational": ["homogeneous"], "methods": [], "views": ["control_points"], "encodings": ["json"], "digits": ["full"],
        "paces": ["all"], "stream": ["view"],
        "formats": {"jobs": ["application/json"], "events": ["text/event-stream"], "result": ["model/step"]},
        "grpc": {"service": "piad.v1.FittingService", "reflection": ["grpc.reflection.v1"], "health": "grpc.health.v1"},
        "limits": limits_example(),
    })
}

fn limits_example() -> Value {
    json!({
        "body_bytes": 268435456, "points": 4000000, "samples": 1000000, "milestones": 100, "iterations": 1000000, "jobs": 10000, "jobs_per_peer": 5000,
        "memory_bytes": 8589934592_u64, "retained_jobs": 1000, "retained_bytes": 1073741824, "retained_seconds": 604800,
    })
}
