//! Resources about the server itself: its links, health, metrics and kinds of problems.

use std::collections::HashMap;

use axum::Json;
use axum::extract::{Extension, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use super::path::InPath;
use crate::access::file::Token;
use crate::access::scope::Scope;
use crate::api::app::App;
use crate::api::create_job;
use crate::api::problem::{Kind, Problem};
use crate::telemetry;
use piad_files::text::quoted;

/// The description of the server.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Service")]
#[schemars(extend("examples" = [{"name": "piad", "version": "0.1.0", "description": "Curve and surface fitting", "links": {"jobs": "/v1/jobs"}}]))]
pub(crate) struct ServiceIndex {
    /// Its name.
    name: &'static str,
    /// Its version.
    version: &'static str,
    /// What it does.
    description: &'static str,
    /// Links to related resources.
    #[schemars(with = "HashMap<String, String>")]
    links: Value,
}

/// `GET /`, for programs.
pub(super) fn index(base: &str) -> Json<ServiceIndex> {
    let link = |path: &str| format!("{base}{path}");
    Json(ServiceIndex {
        name: "piad",
        version: env!("CARGO_PKG_VERSION"),
        description: env!("CARGO_PKG_DESCRIPTION"),
        links: json!({
            "jobs": link("/v1/jobs"),
            "capabilities": link("/v1/capabilities"),
            "problems": link("/problems"),
            "docs": link("/docs"),
            "openapi": link("/openapi.json"),
            "metrics": link("/metrics"),
            "livez": link("/livez"),
            "readyz": link("/readyz"),
        }),
    })
}

/// `GET /metrics`: counters, for Prometheus. Those of other tenants need a scope of their own.
pub(super) async fn metrics(
    State(app): State<App>,
    token: Option<Extension<Token>>,
) -> Result<Response, Problem> {
    let tenant = token.and_then(|Extension(token)| match token.may(Scope::MetricsAll) {
        true => None,
        false => Some(token.tenant),
    });
    let mut registry = Registry::default();
    let counters = &app.jobs.resources().counters;
    counters.register(&mut registry, tenant);
    app.requests.register(&mut registry);
    telemetry::register(&mut registry);
    let queued = i64::try_from(app.jobs.queued()).unwrap_or(i64::MAX);
    let help = "Jobs that wait for their turn";
    registry.register("piad_jobs_queued", help, ConstGauge::new(queued));
    if let Some((open, used)) = app.jobs.store_connections() {
        let count = |count: usize| ConstGauge::new(i64::try_from(count).unwrap_or(i64::MAX));
        let help = "Connections with the database";
        registry.register("piad_store_connections", help, count(open));
        let help = "Connections with the database that are in use";
        registry.register("piad_store_connections_used", help, count(used));
    }
    let gauge = |bytes: usize| ConstGauge::new(i64::try_from(bytes).unwrap_or(i64::MAX));
    let memory = &app.jobs.resources().memory;
    let help = "Memory in use or cached, in bytes";
    registry.register("piad_memory_used_bytes", help, gauge(memory.used()));
    let help = "Limit of the memory in use or cached, in bytes";
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

/// The health of the server.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"status": "ready"}]))]
pub(crate) struct Health {
    /// Its status.
    #[schemars(extend("enum" = ["alive", "ready"]))]
    status: &'static str,
}

/// `GET /livez`
pub(super) async fn livez() -> Json<Health> {
    Json(Health { status: "alive" })
}

/// `GET /readyz`
pub(super) async fn readyz(State(app): State<App>) -> Response {
    if *app.stopping.borrow() {
        return create_job::stopping().into_response();
    }
    if let Err(error) = app.jobs.check_store() {
        return Problem::from(error).into_response();
    }
    if let Some(access) = &app.access
        && access.tokens.are_stale()
    {
        let detail = "the tokens file cannot be read, or is not valid: tokens that were revoked in it since are still accepted; the log of the server says more";
        return Problem::new(Kind::TokensUnreadable, detail)
            .retry_after(5)
            .into_response();
    }
    Json(Health { status: "ready" }).into_response()
}

/// The documentation of a `type` of problem objects.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"type": "/problems/queue-full", "title": "The server has reached its limit of jobs", "status": 503, "meaning": "Send the job again after the number of seconds in Retry-After."}]))]
pub(crate) struct ProblemType {
    /// The type.
    #[schemars(extend("format" = "uri-reference"))]
    r#type: String,
    /// Its title.
    title: &'static str,
    /// The status of answers with it.
    #[schemars(range(min = 400, max = 599))]
    status: u16,
    /// Its meaning, and what to do about it.
    meaning: &'static str,
}

impl From<Kind> for ProblemType {
    fn from(kind: Kind) -> Self {
        let entry = kind.entry();
        Self {
            r#type: kind.path(),
            title: entry.title,
            status: entry.status.as_u16(),
            meaning: entry.meaning,
        }
    }
}

/// All types of problem objects.
#[derive(Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(extend("examples" = [[]]))]
pub(crate) struct ProblemTypes(Vec<ProblemType>);

/// `GET /problems`: all types of problem objects.
pub(super) async fn problems() -> Json<ProblemTypes> {
    let kinds = Kind::ALL.into_iter();
    Json(ProblemTypes(kinds.map(ProblemType::from).collect()))
}

/// `GET /problems/{slug}`: the documentation of a `type` of problem objects.
pub(crate) async fn problem(InPath(slug): InPath<String>) -> Result<Json<ProblemType>, Problem> {
    let mut kinds = Kind::ALL.into_iter();
    let known = kinds.find(|kind| kind.entry().slug == slug);
    known.map(|kind| Json(kind.into())).ok_or_else(|| {
        let detail = format!("unknown problem type {}", quoted(&slug));
        Problem::new(Kind::NotFound, detail)
    })
}
