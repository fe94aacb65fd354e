//! What goes over the wire: HTTP resources, event streams and problem objects.
//!
//! - [`request`]: the JSON of a job, and its way to a fitting problem;
//! - [`strict`], [`numbers`], [`per_direction`]: JSON read to the letter, points and numbers straight into arrays,
//!   one value for both directions or one for each;
//! - [`path`]: the names in a path;
//! - [`body`]: reading a request body, with limits and JSON pointers for what is wrong in it;
//! - [`negotiate`]: `Accept`, `Prefer` and the other headers that choose an answer;
//! - [`order`]: new jobs and edits, in whatever language; [`create`]: posting them;
//! - [`jobs`]: list, get, cancel, delete;
//! - [`feed`]: a job as a sequence of events; [`events`]: the body of an answer with them;
//! - [`milestones`]: which iterations a stream shows that is asked for the progress alone;
//! - [`geometry`]: single iterations and results; [`export`]: as files;
//! - [`options`]: query parameters that say what to show, and the defaults that jobs set;
//! - [`view`]: the JSON of answers; [`encode`]: making it once, off the network threads;
//! - [`rpc`]: the same in protobuf messages, and as a gRPC service;
//! - [`schema`]: what JSON clients may send;
//! - [`info`]: capabilities, health, the catalogue of problems;
//! - [`problem`]: errors as problem objects (RFC 9457).

pub mod body;
pub mod create;
pub mod encode;
pub mod events;
pub mod export;
pub mod feed;
pub mod geometry;
pub mod info;
pub mod jobs;
pub mod milestones;
pub mod negotiate;
pub mod numbers;
pub mod options;
pub mod order;
pub mod path;
pub mod per_direction;
pub mod problem;
pub mod request;
pub mod rpc;
pub mod schema;
pub mod strict;
pub mod view;

use std::sync::Arc;

use axum::extract::Request;
use axum::http::HeaderName;
use axum::middleware;
use axum::response::Response;
use axum::routing::{get, post};
use axum::{Router, http};
use tokio::sync::watch;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::request_id::{MakeRequestId, RequestId, SetRequestIdLayer};
use tower_http::trace::TraceLayer;
use uuid::Uuid;

use crate::config::Config;
use crate::job::service::Jobs;
use problem::{Kind, Problem};

/// What handlers share.
#[derive(Clone)]
pub struct App {
    jobs: Arc<Jobs>,
    config: Arc<Config>,
    stopping: watch::Receiver<bool>,
}

impl App {
    /// An application over `jobs`; streams end when `stopping` becomes true.
    pub fn new(jobs: Arc<Jobs>, config: Config, stopping: watch::Receiver<bool>) -> Self {
        Self {
            jobs,
            config: Arc::new(config),
            stopping,
        }
    }
}

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// All resources.
pub fn router(app: App) -> Router {
    let layers = ServiceBuilder::new()
        .layer(SetRequestIdLayer::new(REQUEST_ID, NewRequestId))
        .layer(TraceLayer::new_for_http().make_span_with(span))
        .layer(middleware::from_fn(problem::render))
        .layer(CatchPanicLayer::custom(|_| {
            use axum::response::IntoResponse;
            Problem::new(
                Kind::Internal,
                "the request ran into a defect of the server",
            )
            .into_response()
        }));
    Router::new()
        .route("/", get(info::index))
        .route("/livez", get(info::livez))
        .route("/readyz", get(info::readyz))
        .route("/metrics", get(info::metrics))
        .route("/problems", get(info::problems))
        .route("/problems/{slug}", get(info::problem))
        .route("/v1/capabilities", get(info::capabilities))
        .route("/v1/jobs", post(create::job).get(jobs::list))
        .route("/v1/jobs/{id}", get(jobs::get).delete(jobs::delete))
        .route("/v1/jobs/{id}/cancel", post(jobs::cancel))
        .route("/v1/jobs/{id}/edits", post(create::edit))
        .route("/v1/jobs/{id}/events", get(events::get))
        .route("/v1/jobs/{id}/input", get(geometry::input))
        .route("/v1/jobs/{id}/iterations/{k}", get(geometry::iteration))
        .route("/v1/jobs/{id}/result", get(geometry::result))
        .route("/v1/jobs/{id}/limit", get(geometry::limit))
        .fallback(not_found)
        .method_not_allowed_fallback(method_not_allowed)
        .merge(rpc::mount::routes(&app))
        .layer(layers)
        .with_state(app)
}

async fn not_found(request: Request) -> Problem {
    let path = request.uri().path();
    Problem::new(Kind::NotFound, format!("there is nothing at {path}"))
}

async fn method_not_allowed(request: Request) -> Problem {
    let (method, path) = (request.method(), request.uri().path());
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{path} does not understand {method}; the Allow header names what it does"),
    )
}

/// Ids that grow with time, as those of jobs do.
#[derive(Clone, Copy)]
struct NewRequestId;

impl MakeRequestId for NewRequestId {
    fn make_request_id<B>(&mut self, _request: &http::Request<B>) -> Option<RequestId> {
        let id = Uuid::now_v7().to_string();
        id.parse().ok().map(RequestId::new)
    }
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

/// Answers of this API are never the same twice.
fn no_store(mut response: Response) -> Response {
    let value = http::HeaderValue::from_static("no-store");
    response
        .headers_mut()
        .insert(http::header::CACHE_CONTROL, value);
    response
}
