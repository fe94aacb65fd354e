//! The resources and their addresses.

use std::future::ready;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{MatchedPath, Request};
use axum::http::StatusCode;
use axum::middleware;
use axum::{Extension, Router, http};
use parking_lot::Mutex;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::classify::ServerErrorsFailureClass;
use tower_http::request_id::SetRequestIdLayer;
use tower_http::trace::TraceLayer;
use tracing::{Span, error, info};

use super::authorize::{self, Guard};
use super::host::Hosts;
use super::request_id::{NewRequestId, REQUEST_ID};
use super::{
    base_path, batch, capabilities, compression, cors, create, events, fit, geometry, host,
    info as about, jobs, measure, overload, page as viewer, points, rates, render, request_id,
    tickets, trace,
};
use crate::access::scope::Scope;
use crate::api::app::App;
use crate::api::grpc;
use crate::api::needs::{Methods, Needs};
use crate::api::openapi::resources::Resources;
use crate::api::openapi::{self, Description};
use crate::api::problem::{Kind, Problem};
use crate::log_throttle::LogThrottle;
use crate::telemetry;
use crate::telemetry::request::RequestTrace;
use piad_files::text;

/// The router of all resources and gRPC services, with their middleware.
pub(crate) fn router(app: App, hosts: Hosts) -> Router {
    let (routes, methods) = resources().parts();
    let methods = Arc::new(methods);
    let guard = app.access.clone().map(|access| Guard {
        access,
        methods: Arc::clone(&methods),
        counters: app.jobs.resources().counters.clone(),
        strangers: Arc::new(Mutex::new(LogThrottle::new(authorize::LOG_INTERVAL))),
    });
    let guard = guard.map(|guard| middleware::from_fn_with_state(guard, authorize::authorize));
    let log = TraceLayer::new_for_http().make_span_with(span);
    let layers = ServiceBuilder::new()
        .map_request(request_id::plain)
        .layer(SetRequestIdLayer::new(REQUEST_ID, NewRequestId))
        .layer(log.on_failure(tell_failure))
        .layer(middleware::from_fn_with_state(
            app.requests.clone(),
            measure::measure,
        ))
        .option_layer(cors::layer(&app.config.cors_origin))
        .layer(compression::layer())
        .layer(middleware::from_fn(render::render))
        .layer(middleware::from_fn(overload::hold_back))
        .layer(middleware::from_fn_with_state(hosts, host::check))
        .layer(CatchPanicLayer::custom(|_| {
            use axum::response::IntoResponse;
            Problem::new(Kind::Internal, "internal error in the request").into_response()
        }))
        .option_layer(guard);
    let base_path = app.config.base_path.clone();
    let router = routes
        .layer(Extension(Description::new(
            &base_path,
            Arc::clone(&methods),
        )))
        .fallback(not_found)
        .method_not_allowed_fallback(move |request: Request| {
            ready(method_not_allowed(&methods, &request))
        })
        .merge(grpc::mount::routes(&app))
        .layer(layers);
    let router = match telemetry::is_on() {
        true => router.layer(middleware::from_fn(trace::trace)),
        false => router,
    };
    base_path::below(router.with_state(app), &base_path)
}

/// Every resource, with what it needs.
pub(in crate::api) fn resources() -> Resources {
    use crate::api::openapi::page;
    use Needs::{A, Nothing};
    const READ: Needs = A(Scope::JobsRead);
    const WRITE: Needs = A(Scope::JobsWrite);
    const METRICS: Needs = A(Scope::Metrics);
    Resources::default()
        .get("/", Nothing, viewer::root)
        .get("/viewer/{part}", Nothing, viewer::part)
        .get("/livez", Nothing, about::livez)
        .get("/readyz", Nothing, about::readyz)
        .get("/metrics", METRICS, about::metrics)
        .get("/problems", Nothing, about::problems)
        .get("/problems/{slug}", Nothing, about::problem)
        .get("/openapi.json", Nothing, openapi::get)
        .get("/docs", Nothing, page::page)
        .get("/docs/{file}", Nothing, page::file)
        .get("/v1/capabilities", READ, capabilities::get)
        .get("/v1/rates", READ, rates::get)
        .post("/v1/points", WRITE, points::show)
        .post("/v1/fit", WRITE, fit::fit)
        .post("/v1/batch", WRITE, batch::batch)
        .post("/v1/jobs", WRITE, create::job)
        .post("/v1/jobs/stream", WRITE, create::job_stream)
        .get("/v1/jobs", READ, jobs::list)
        .get("/v1/jobs/{id}", READ, jobs::get)
        .delete("/v1/jobs/{id}", WRITE, jobs::delete)
        .post("/v1/jobs/{id}/cancel", WRITE, jobs::cancel)
        .post("/v1/jobs/{id}/edits", WRITE, create::edit)
        .post("/v1/jobs/{id}/edits/stream", WRITE, create::edit_stream)
        .get("/v1/jobs/{id}/events", READ, events::get)
        .post("/v1/jobs/{id}/tickets", READ, tickets::make)
        .get("/v1/jobs/{id}/input", READ, geometry::input)
        .get("/v1/jobs/{id}/iterations/{k}", READ, geometry::iteration)
        .get("/v1/jobs/{id}/result", READ, geometry::result)
        .get(
            "/v1/jobs/{id}/iterations/{k}/{format}",
            READ,
            geometry::iteration_file,
        )
        .get("/v1/jobs/{id}/result/{format}", READ, geometry::result_file)
        .get("/v1/jobs/{id}/deviation", READ, geometry::deviation)
        .get("/v1/jobs/{id}/shape", READ, geometry::shape)
        .get("/v1/jobs/{id}/limit", READ, geometry::limit)
}

async fn not_found(request: Request) -> Problem {
    let path = text::plain(request.uri().path());
    Problem::new(Kind::NotFound, format!("no resource at {path}"))
}

/// The problem of a method that the resource does not support; it names the supported ones.
fn method_not_allowed(methods: &Methods, request: &Request) -> Problem {
    let method = text::plain(request.method().as_str());
    let path = text::plain(request.uri().path());
    let matched = request.extensions().get::<MatchedPath>();
    let understood = matched.and_then(|matched| methods.get(matched.as_str()));
    let understood = understood.map_or("see the Allow header".to_owned(), |verbs| {
        let names = verbs.iter().map(|(verb, _)| match *verb {
            "get" => "GET, HEAD".to_owned(),
            verb => verb.to_uppercase(),
        });
        names.collect::<Vec<_>>().join(", ")
    });
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{path} does not support {method}; allowed: {understood}"),
    )
}

fn span<B>(request: &http::Request<B>) -> tracing::Span {
    let id = request.headers().get(REQUEST_ID);
    let trace = RequestTrace::current();
    tracing::info_span!(
        "request",
        method = %request.method(),
        path = request.uri().path(),
        id = id.and_then(|id| id.to_str().ok()),
        trace_id = trace.map(|trace| trace.trace_id()),
    )
}

/// Logs failed requests. A 503 of a full server is not an error.
fn tell_failure(failure: ServerErrorsFailureClass, latency: Duration, _span: &Span) {
    match failure {
        ServerErrorsFailureClass::StatusCode(StatusCode::SERVICE_UNAVAILABLE) => {
            info!(?latency, "answered 503 Service Unavailable");
        }
        failure => error!(?latency, "the request failed: {failure}"),
    }
}
