//! The resources and their addresses.

use std::collections::BTreeMap;
use std::future::ready;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{MatchedPath, Request};
use axum::http::StatusCode;
use axum::middleware;
use axum::{Extension, Router, http};
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::classify::ServerErrorsFailureClass;
use tower_http::request_id::SetRequestIdLayer;
use tower_http::trace::TraceLayer;
use tracing::{Span, error, info};

use super::host::Hosts;
use super::request_id::{NewRequestId, REQUEST_ID};
use super::{
    base_path, capabilities, compression, cors, create, events, fit, geometry, host, info as about,
    jobs, measure, overload, page as viewer, points, rates, render, request_id, trace,
};
use crate::api::app::App;
use crate::api::grpc;
use crate::api::openapi::resources::Resources;
use crate::api::openapi::{self, Description};
use crate::api::problem::{Kind, Problem};
use crate::model::short;
use crate::telemetry;
use crate::telemetry::request::RequestTrace;

/// The router of all resources and gRPC services, with their middleware.
pub(crate) fn router(app: App, hosts: Hosts) -> Router {
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
            Problem::new(
                Kind::Internal,
                "the request ran into a defect of the server",
            )
            .into_response()
        }));
    let (routes, methods) = resources().parts();
    let methods = Arc::new(methods);
    let base_path = app.config.base_path.clone();
    let router = routes
        .layer(Extension(Description::new(&base_path)))
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

/// Every resource.
pub(in crate::api) fn resources() -> Resources {
    use crate::api::openapi::page;
    Resources::default()
        .get("/", viewer::root)
        .get("/viewer/{part}", viewer::part)
        .get("/livez", about::livez)
        .get("/readyz", about::readyz)
        .get("/metrics", about::metrics)
        .get("/problems", about::problems)
        .get("/problems/{slug}", about::problem)
        .get("/openapi.json", openapi::get)
        .get("/docs", page::page)
        .get("/docs/{file}", page::file)
        .get("/v1/capabilities", capabilities::get)
        .get("/v1/rates", rates::get)
        .post("/v1/points", points::show)
        .post("/v1/fit", fit::fit)
        .post("/v1/jobs", create::job)
        .post("/v1/jobs/stream", create::job_stream)
        .get("/v1/jobs", jobs::list)
        .get("/v1/jobs/{id}", jobs::get)
        .delete("/v1/jobs/{id}", jobs::delete)
        .post("/v1/jobs/{id}/cancel", jobs::cancel)
        .post("/v1/jobs/{id}/edits", create::edit)
        .post("/v1/jobs/{id}/edits/stream", create::edit_stream)
        .get("/v1/jobs/{id}/events", events::get)
        .get("/v1/jobs/{id}/input", geometry::input)
        .get("/v1/jobs/{id}/iterations/{k}", geometry::iteration)
        .get("/v1/jobs/{id}/result", geometry::result)
        .get(
            "/v1/jobs/{id}/iterations/{k}/{format}",
            geometry::iteration_file,
        )
        .get("/v1/jobs/{id}/result/{format}", geometry::result_file)
        .get("/v1/jobs/{id}/deviation", geometry::deviation)
        .get("/v1/jobs/{id}/limit", geometry::limit)
}

async fn not_found(request: Request) -> Problem {
    let path = short::plain(request.uri().path());
    Problem::new(Kind::NotFound, format!("there is nothing at {path}"))
}

/// The problem of a method that the resource does not understand; it names those that it does.
fn method_not_allowed(methods: &BTreeMap<&str, Vec<&str>>, request: &Request) -> Problem {
    let method = short::plain(request.method().as_str());
    let path = short::plain(request.uri().path());
    let matched = request.extensions().get::<MatchedPath>();
    let understood = matched.and_then(|matched| methods.get(matched.as_str()));
    let understood =
        understood.map_or("others, which the Allow header names".to_owned(), |verbs| {
            let names = verbs.iter().map(|verb| match *verb {
                "get" => "GET, HEAD".to_owned(),
                verb => verb.to_uppercase(),
            });
            names.collect::<Vec<_>>().join(", ")
        });
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{path} does not understand {method}, but {understood}"),
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

/// Logs failed requests. A server that answers 503 when it is full works as it should.
fn tell_failure(failure: ServerErrorsFailureClass, latency: Duration, _span: &Span) {
    match failure {
        ServerErrorsFailureClass::StatusCode(StatusCode::SERVICE_UNAVAILABLE) => {
            info!(?latency, "answered 503 Service Unavailable");
        }
        failure => error!(?latency, "the request failed: {failure}"),
    }
}
