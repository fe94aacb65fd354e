//! `FitBatch`: a call whose messages are read and written here as they arrive. The gRPC library would buffer whole
//! messages outside the memory accounting.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;
use bytes::Bytes;
use futures_util::stream;
use http_body::Frame;
use http_body_util::StreamBody;
use tonic::{Code, Status};

use crate::api::app::App;
use crate::api::batch::driver::Batch;
use crate::api::batch::pieces::BodyForm;
use crate::api::batch::sending::Sending;
use crate::api::batch::settings::{Forms, Settings};
use crate::api::http::request_id::REQUEST_ID;
use crate::api::media_type::Framing;
use crate::api::problem::Problem;
use crate::job::scheduler::Broken;
use crate::proto::messages as pb;

const GRPC: HeaderValue = HeaderValue::from_static("application/grpc");
const ENCODING: &str = "grpc-encoding";
const STATUS: HeaderName = HeaderName::from_static("grpc-status");

/// The state of an answer.
enum Answer {
    /// Nothing has been read.
    Begin(Arc<Settings>, Body),
    /// Messages are being sent.
    Sending(Box<Sending>),
    /// The status has been sent.
    Ended,
}

/// Answers the call. The head is sent at once: some clients wait for it before they send anything.
pub(super) async fn fit_batch(State(app): State<App>, request: Request) -> Response {
    let headers = request.headers();
    if headers.get(ENCODING).is_some_and(|it| it != "identity") {
        let status = Status::unimplemented("messages are not compressed here");
        return status.into_http();
    }
    let forms = match Forms::of_message(&pb::BatchOptions::default()) {
        Ok(forms) => forms,
        Err(problem) => return Status::from(problem).into_http(),
    };
    let request_id = headers.get(REQUEST_ID).and_then(|id| id.to_str().ok());
    let request_id = request_id.map(str::to_owned);
    let framing = Framing::Protobuf;
    let settings = Settings::new(&app, BodyForm::Messages, framing, forms, request_id);
    let answer = Answer::Begin(settings, request.into_body());
    let frames = stream::unfold(answer, |answer| async { next(answer).await });
    let mut response = Response::new(Body::new(StreamBody::new(frames)));
    response.headers_mut().insert(header::CONTENT_TYPE, GRPC);
    response
}

/// The next frame of an answer: a part of its messages, or the status at its end.
async fn next(answer: Answer) -> Option<(Result<Frame<Bytes>, Broken>, Answer)> {
    let mut sending = match answer {
        Answer::Ended => return None,
        Answer::Sending(sending) => sending,
        Answer::Begin(settings, body) => match Batch::begin(settings, body, None).await {
            Ok(batch) => Box::new(Sending::begin(batch)),
            Err(problem) => return Some((Ok(trailers(Err(problem))), Answer::Ended)),
        },
    };
    match sending.next().await {
        None => Some((Ok(trailers(sending.end())), Answer::Ended)),
        Some(bytes) => Some((bytes.map(Frame::data), Answer::Sending(sending))),
    }
}

/// The status of a call with this end.
fn trailers(end: Result<(), Problem>) -> Frame<Bytes> {
    let status = end.map_or_else(Status::from, |()| Status::ok(""));
    let mut headers = HeaderMap::new();
    if status.add_header(&mut headers).is_err() {
        let code = i32::from(Code::Internal);
        headers.insert(STATUS, code.into());
    }
    Frame::trailers(headers)
}
