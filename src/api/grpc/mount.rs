//! The gRPC service on the same port as REST, with reflection and health.

use std::convert::Infallible;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{any_service, post};
use bytes::Bytes;
use futures_util::stream;
use http_body::Frame;
use http_body_util::{BodyExt, StreamBody};
use tokio::runtime::Handle;
use tokio::sync::{oneshot, watch};
use tonic::server::NamedService;
use tonic::{Code, Status};
use tower::Service;
use tower::util::MapResponseLayer;
use tracing::error;

use super::batch;
use super::malformed;
use super::service;
use crate::api::app::App;
use crate::api::create_job::PARSED_AT_ONCE;
use crate::api::http::body_limits;
use crate::api::proto::bounds;
use crate::job::peer::Peer;
use crate::proto::DESCRIPTORS;
use crate::proto::messages::fitting_service_server::FittingServiceServer;

const GRPC_STATUS: HeaderName = HeaderName::from_static("grpc-status");

/// The routes of the gRPC services. Unknown calls at their paths are answered by tonic; all other paths
/// belong to REST.
pub(crate) fn routes(app: &App) -> Router<App> {
    let limit = usize::try_from(app.config.max_body.as_u64()).unwrap_or(usize::MAX);
    let fitting = FittingServiceServer::new(service::Service::new(app.clone()))
        .max_decoding_message_size(limit);
    let arrival = middleware::from_fn_with_state(app.clone(), take_in);
    let fitting = route(fitting).layer(arrival);
    let path = format!(
        "/{}/FitBatch",
        FittingServiceServer::<service::Service>::NAME
    );
    let batch = Router::new().route(&path, post(batch::fit_batch));
    let services = fitting.merge(batch).merge(operations(app));
    services.layer(MapResponseLayer::new(malformed::explained))
}

/// Receives the one message of a call like a body of REST. A large message is decoded off the threads
/// that serve the network.
async fn take_in(State(app): State<App>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    let path = parts.uri.path();
    let more = |bytes: &[u8]| bounds::memory_of_call(path, bytes);
    let taken = match body_limits::take_in(&app, &parts.headers, body, None, more).await {
        Ok(taken) => taken,
        Err(problem) => return Status::from(problem).into_http(),
    };
    let most = app.config.max_points;
    if let Err(problem) = bounds::check_call(path, &taken.bytes, most) {
        return Status::from(problem).into_http();
    }
    let large = taken.bytes.len() > PARSED_AT_ONCE;
    let request = Request::from_parts(parts, Body::from(taken.bytes));
    let room = taken.room;
    let answer = Peer::scope(Peer::current(), async move {
        let answer = next.run(request).await;
        drop(room);
        answer
    });
    if !large {
        return answer.await;
    }
    let here = Handle::current();
    let (waiting, gone) = oneshot::channel::<()>();
    let aside = tokio::task::spawn_blocking(move || {
        here.block_on(async {
            tokio::select! {
                answer = answer => answer,
                // The request is abandoned, and so is its computation.
                _ = gone => Status::cancelled("the client has disconnected").into_http(),
            }
        })
    });
    let broken = |_| Status::internal("internal error in the call").into_http();
    let answer = aside.await.unwrap_or_else(broken);
    drop(waiting);
    answer
}

/// Reflection and health. Their streams last as long as the client likes, and end with the server.
fn operations(app: &App) -> Router<App> {
    let (health, checks) = tonic_health::server::health_reporter();
    let running = app.clone();
    tokio::spawn(async move {
        let name = FittingServiceServer::<service::Service>::NAME;
        use tonic_health::ServingStatus::{NotServing, Serving};
        health.set_service_status(name, Serving).await;
        running.stopped().await;
        health.set_service_status(name, NotServing).await;
        health.set_service_status("", NotServing).await;
    });
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(DESCRIPTORS)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    let mut router = route(checks);
    match (reflection().build_v1(), reflection().build_v1alpha()) {
        (Ok(v1), Ok(v1alpha)) => router = router.merge(route(v1)).merge(route(v1alpha)),
        (Err(reason), _) | (_, Err(reason)) => error!(%reason, "there is no reflection"),
    }
    let stopping = app.stopping.clone();
    let ending = MapResponseLayer::new(move |response| until(stopping.clone(), response));
    router.layer(ending)
}

/// A service at its path.
fn route<S>(service: S) -> Router<App>
where
    S: NamedService
        + Service<axum::extract::Request, Error = Infallible>
        + Clone
        + Send
        + Sync
        + 'static,
    S::Response: IntoResponse,
    S::Future: Send + 'static,
{
    Router::new().route(&format!("/{}/{{*call}}", S::NAME), any_service(service))
}

/// A response that ends when the server stops, with a status that reports this.
fn until(stopping: watch::Receiver<bool>, response: Response) -> Response {
    // A response that consists of its head must not get a body, not even an empty one: clients take that
    // for a broken connection.
    if response.headers().contains_key(GRPC_STATUS) {
        return response;
    }
    response.map(|body| {
        let frames = stream::unfold(Some((body, stopping)), |state| async {
            let (mut body, mut stopping) = state?;
            let frame = tokio::select! {
                frame = body.frame() => frame?,
                _ = stopping.wait_for(|stopping| *stopping) => {
                    return Some((Ok(unavailable()), None));
                }
            };
            Some((frame, Some((body, stopping))))
        });
        Body::new(StreamBody::new(frames))
    })
}

/// The trailers of a response that is cut off because the server stops.
fn unavailable() -> Frame<Bytes> {
    let code = i32::from(Code::Unavailable);
    Frame::trailers(HeaderMap::from_iter([(GRPC_STATUS, code.into())]))
}
