//! What goes over the wire: HTTP resources, event streams and problem objects.
//!
//! - [`request`]: the JSON of a job, and its way to a fitting problem;
//! - [`read`]: JSON read to the letter, with all that is wrong in it; [`numbers`], [`per_direction`]: points and
//!   numbers straight into arrays, one value for both directions or one for each;
//! - [`path`]: the names in a path;
//! - [`body`]: a request body by its media type; [`text`]: whether its bytes are UTF-8; [`intake`]: how it
//!   arrives, with limits of size, memory and time;
//! - [`negotiate`]: `Accept`, `Prefer` and the other headers that choose an answer;
//! - [`order`]: new jobs and edits, in whatever language; [`create`]: posting them;
//! - [`jobs`]: list, get, cancel, delete;
//! - [`feed`]: a job as a sequence of events; [`events`]: the body of an answer with them;
//! - [`milestones`]: which iterations a stream shows that is asked for the progress alone;
//! - [`geometry`]: single iterations and results; [`export`]: as files; [`file_name`]: what these are called;
//! - [`options`]: query parameters that say what to show, and the defaults that jobs set;
//! - [`view`]: the JSON of answers; [`encode`]: making it once, off the network threads;
//! - [`rpc`]: the same in protobuf messages, and as a gRPC service;
//! - [`openapi`]: the description of all of this in OpenAPI, and its reference for people;
//! - [`schema`]: what JSON clients may send;
//! - [`crowd`]: what is answered on connections beyond the limits;
//! - [`cors`]: what browsers let pages of other origins do;
//! - [`host`]: for whom a request is meant; [`request_id`]: what it is called;
//! - [`info`]: capabilities, health, metrics, the catalogue of problems; [`measure`]: how long requests take;
//! - [`problem`]: errors as problem objects (RFC 9457); [`short`]: texts of clients in them, cut.

pub mod body;
pub mod cors;
pub mod create;
pub mod crowd;
pub mod encode;
pub mod events;
pub mod export;
pub mod feed;
pub mod file_name;
pub mod geometry;
pub mod host;
pub mod info;
pub mod intake;
pub mod jobs;
pub mod measure;
pub mod milestones;
pub mod negotiate;
pub mod numbers;
pub mod openapi;
pub mod options;
pub mod order;
pub mod path;
pub mod per_direction;
pub mod problem;
pub mod read;
pub mod request;
pub mod request_id;
pub mod rpc;
pub mod schema;
pub mod sending;
pub mod short;
pub mod text;
pub mod view;

use std::collections::HashMap;
use std::future::ready;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{MatchedPath, Request};
use axum::http::StatusCode;
use axum::middleware;
use axum::response::Response;
use axum::{Router, http};
use tokio::sync::watch;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::classify::ServerErrorsFailureClass;
use tower_http::request_id::SetRequestIdLayer;
use tower_http::trace::TraceLayer;
use tracing::{Span, error, info};

use crate::config::Config;
use crate::job::service::Jobs;
use host::Hosts;
use measure::Requests;
use openapi::resources::Resources;
use problem::{Kind, Problem};
use request_id::{NewRequestId, REQUEST_ID};

/// What handlers share.
#[derive(Clone)]
pub struct App {
    jobs: Arc<Jobs>,
    config: Arc<Config>,
    stopping: watch::Receiver<bool>,
    requests: Requests,
}

impl App {
    /// An application over `jobs`; streams end when `stopping` becomes true.
    pub fn new(jobs: Arc<Jobs>, config: Config, stopping: watch::Receiver<bool>) -> Self {
        Self {
            jobs,
            config: Arc::new(config),
            stopping,
            requests: Requests::default(),
        }
    }
}

/// All resources, under the names of the server.
pub fn router(app: App, hosts: Hosts) -> Router {
    let trace = TraceLayer::new_for_http().make_span_with(span);
    let layers = ServiceBuilder::new()
        .map_request(request_id::plain)
        .layer(SetRequestIdLayer::new(REQUEST_ID, NewRequestId))
        .layer(trace.on_failure(tell_failure))
        .layer(middleware::from_fn_with_state(
            app.requests.clone(),
            measure::measure,
        ))
        .option_layer(cors::layer(&app.config.cors_origin))
        .layer(middleware::from_fn(problem::render))
        .layer(middleware::from_fn(crowd::hold_back))
        .layer(middleware::from_fn_with_state(hosts, host::check))
        .layer(CatchPanicLayer::custom(|_| {
            use axum::response::IntoResponse;
            Problem::new(
                Kind::Internal,
                "the request ran into a defect of the server",
            )
            .into_response()
        }));
    let resources = resources();
    let methods = Arc::new(resources.methods());
    resources
        .router()
        .fallback(not_found)
        .method_not_allowed_fallback(move |request: Request| {
            ready(method_not_allowed(&methods, &request))
        })
        .merge(rpc::mount::routes(&app))
        .layer(layers)
        .with_state(app)
}

/// Every resource, with its description.
fn resources() -> Resources {
    use openapi::operations::{geometry as of_geometry, jobs as of_jobs, server as of_server};
    use openapi::page;
    Resources::default()
        .get("/", info::index, of_server::index())
        .get("/livez", info::livez, of_server::livez())
        .get("/readyz", info::readyz, of_server::readyz())
        .get("/metrics", info::metrics, of_server::metrics())
        .get("/problems", info::problems, of_server::problems())
        .get("/problems/{slug}", info::problem, of_server::problem())
        .get("/openapi.json", openapi::get, of_server::description())
        .get("/docs", page::page, of_server::reference())
        .get("/docs/{file}", page::file, of_server::reference_file())
        .get(
            "/v1/capabilities",
            info::capabilities,
            of_server::capabilities(),
        )
        .post("/v1/jobs", create::job, of_jobs::create())
        .get("/v1/jobs", jobs::list, of_jobs::list())
        .get("/v1/jobs/{id}", jobs::get, of_jobs::get())
        .delete("/v1/jobs/{id}", jobs::delete, of_jobs::delete())
        .post("/v1/jobs/{id}/cancel", jobs::cancel, of_jobs::cancel())
        .post("/v1/jobs/{id}/edits", create::edit, of_jobs::edit())
        .get("/v1/jobs/{id}/events", events::get, of_jobs::watch())
        .get("/v1/jobs/{id}/input", geometry::input, of_jobs::input())
        .get(
            "/v1/jobs/{id}/iterations/{k}",
            geometry::iteration,
            of_geometry::iteration(),
        )
        .get(
            "/v1/jobs/{id}/result",
            geometry::result,
            of_geometry::result(),
        )
        .get("/v1/jobs/{id}/limit", geometry::limit, of_geometry::limit())
}

async fn not_found(request: Request) -> Problem {
    let path = short::plain(request.uri().path());
    Problem::new(Kind::NotFound, format!("there is nothing at {path}"))
}

/// Says which methods the resource understands, of all resources.
fn method_not_allowed(methods: &HashMap<String, String>, request: &Request) -> Problem {
    let method = short::plain(request.method().as_str());
    let path = short::plain(request.uri().path());
    let matched = request.extensions().get::<MatchedPath>();
    let understood = matched.and_then(|matched| methods.get(matched.as_str()));
    let understood = understood.map_or("others, which the Allow header names", String::as_str);
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{path} does not understand {method}, but {understood}"),
    )
}

fn span<B>(request: &http::Request<B>) -> tracing::Span {
    let id = request.headers().get(REQUEST_ID);
    tracing::info_span!(
        "request",
        method = %request.method(),
        path = request.uri().path(),
        id = id.and_then(|id| id.to_str().ok()),
    )
}

/// A server that takes no more for the moment does as it should.
fn tell_failure(failure: ServerErrorsFailureClass, latency: Duration, _span: &Span) {
    match failure {
        ServerErrorsFailureClass::StatusCode(StatusCode::SERVICE_UNAVAILABLE) => {
            info!(?latency, "answered 503 Service Unavailable");
        }
        failure => error!(?latency, "the request failed: {failure}"),
    }
}

/// Answers of this API are never the same twice.
fn no_store(mut response: Response) -> Response {
    let value = http::HeaderValue::from_static("no-store");
    response
        .headers_mut()
        .insert(http::header::CACHE_CONTROL, value);
    response
}
