//! What the server is, what it can do, and how it is.

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use serde_json::{Value, json};
use tonic::server::NamedService;

use super::path::Named;
use crate::api::app::App;
use crate::api::grpc::service::Service;
use crate::api::json::numbers::MAX_DIMENSION;
use crate::api::problem::{Kind, Problem};
use crate::api::proto::messages::fitting_service_server::FittingServiceServer;
use crate::api::short::quoted;
use crate::export::Format;
use crate::fit::basis::MAX_DEGREE;
use crate::model::named::Named as _;
use crate::model::stream::{Choice, Digits, Encoding, MOST_MILESTONES, MOST_SAMPLES, Pace, View};

/// `GET /`
pub async fn index() -> Json<Value> {
    Json(json!({
        "name": "piad",
        "version": env!("CARGO_PKG_VERSION"),
        "description": env!("CARGO_PKG_DESCRIPTION"),
        "links": {
            "jobs": "/v1/jobs",
            "capabilities": "/v1/capabilities",
            "problems": "/problems",
            "docs": "/docs",
            "openapi": "/openapi.json",
            "metrics": "/metrics",
            "livez": "/livez",
            "readyz": "/readyz",
        },
    }))
}

/// `GET /v1/capabilities`
pub async fn capabilities(State(app): State<App>) -> Json<Value> {
    let config = &app.config;
    let files = Format::ALL.map(Format::media_type);
    let levels = ["application/json", "application/x-protobuf"];
    let results: Vec<_> = levels.into_iter().chain(files).collect();
    Json(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "geometry": ["curve", "surface"],
        "dimensions": (1..=MAX_DIMENSION).collect::<Vec<_>>(),
        "bases": [
            {
                "kind": "bspline",
                "degree": {"min": 1, "max": MAX_DEGREE},
                "knots": ["data", "averaged", "explicit"],
                "closed": true,
            },
            {"kind": "bernstein", "degree": {"min": 1, "max": MAX_DEGREE}, "closed": false},
            {"kind": "said_ball", "degree": {"min": 1, "max": MAX_DEGREE}, "closed": false},
            {"kind": "wang_ball", "degree": {"min": 1, "max": MAX_DEGREE}, "closed": false},
        ],
        "parameters": ["chord_length", "centripetal", "uniform", "explicit"],
        "rational": ["homogeneous", "fixed"],
        "methods": methods(),
        "views": View::names(),
        "encodings": Encoding::names(),
        "digits": Digits::names(),
        "paces": Pace::names(),
        "stream": Choice::names(),
        "formats": {
            "jobs": ["application/json", "application/x-protobuf"],
            "events": ["text/event-stream", "application/x-ndjson", "application/x-protobuf"],
            "result": results,
        },
        "grpc": {
            "service": FittingServiceServer::<Service>::NAME,
            "reflection": ["grpc.reflection.v1", "grpc.reflection.v1alpha"],
            "health": "grpc.health.v1",
        },
        "limits": {
            "body_bytes": config.max_body.as_u64(),
            "points": config.max_points,
            "samples": MOST_SAMPLES,
            "milestones": MOST_MILESTONES,
            "iterations": config.max_iterations,
            "jobs": config.max_jobs,
            "jobs_per_peer": config.jobs_of_a_peer(),
            "memory_bytes": config.memory_bytes(),
            "retained_jobs": config.retain_jobs,
            "retained_bytes": config.retain_bytes.as_u64(),
            "retained_seconds": config.retain_age.as_secs(),
        },
    }))
}

/// The methods: their settings, and what they fit. All of them fit curves, also with fixed weights.
fn methods() -> Value {
    let method = |kind: &str, settings: &[&str], surface: bool, homogeneous: bool| json!({"kind": kind, "settings": settings, "surface": surface, "homogeneous": homogeneous});
    let least_squares = ["control_points", "variant", "mu"];
    json!([
        method("global", &[], true, true),
        method("weighted", &["omega"], true, true),
        method("local", &["indices", "row_by_row"], true, true),
        method("adaptive", &["threshold"], true, true),
        method("extended", &["start"], true, true),
        method("transpose", &[], true, true),
        method("convex", &[], false, false),
        method("chebyshev", &[], true, true),
        method("direct", &[], true, true),
        method("least_squares", &least_squares, true, true),
    ])
}

/// `GET /metrics`: counters, for Prometheus.
pub async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    let mut registry = Registry::default();
    app.jobs.resources().counters.register(&mut registry);
    app.requests.register(&mut registry);
    let queued = i64::try_from(app.jobs.queued()).unwrap_or(i64::MAX);
    let help = "Jobs that wait for their turn";
    registry.register("piad_jobs_queued", help, ConstGauge::new(queued));
    let gauge = |bytes: usize| ConstGauge::new(i64::try_from(bytes).unwrap_or(i64::MAX));
    let memory = &app.jobs.resources().memory;
    let help = "Memory that is handed out, or kept to be quick, in bytes";
    registry.register("piad_memory_used_bytes", help, gauge(memory.used()));
    let help = "Memory that may be handed out and kept, in bytes";
    registry.register("piad_memory_limit_bytes", help, gauge(memory.limit()));
    let build = [
        ("version", env!("CARGO_PKG_VERSION")),
        ("commit", env!("PIAD_BUILD_COMMIT")),
    ];
    let help = "What the server was built from";
    registry.register("piad_build", help, Info::new(build.to_vec()));
    let mut text = String::new();
    encode(&mut text, &registry)
        .map_err(|error| Problem::new(Kind::Internal, error.to_string()))?;
    const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    Ok(([(header::CONTENT_TYPE, OPEN_METRICS)], text).into_response())
}

/// `GET /livez`
pub async fn livez() -> Json<Value> {
    Json(json!({"status": "alive"}))
}

/// `GET /readyz`
pub async fn readyz(State(app): State<App>) -> Response {
    if *app.stopping.borrow() {
        return Problem::new(Kind::Stopping, "the server is stopping")
            .retry_after(5)
            .into_response();
    }
    Json(json!({"status": "ready"})).into_response()
}

/// `GET /problems`: all types of problem objects.
pub async fn problems() -> Json<Value> {
    Json(Kind::ALL.into_iter().map(explain).collect())
}

/// `GET /problems/{slug}`: what the `type` of a problem object stands for.
pub async fn problem(Named(slug): Named<String>) -> Result<(StatusCode, Json<Value>), Problem> {
    Kind::ALL
        .into_iter()
        .find(|kind| kind.entry().slug == slug)
        .map(|kind| (StatusCode::OK, Json(explain(kind))))
        .ok_or_else(|| {
            Problem::new(
                Kind::NotFound,
                format!("no problem is called {}", quoted(&slug)),
            )
        })
}

fn explain(kind: Kind) -> Value {
    let entry = kind.entry();
    json!({
        "type": format!("/problems/{}", entry.slug),
        "title": entry.title,
        "status": entry.status.as_u16(),
        "meaning": entry.meaning,
    })
}
