//! Messages that cannot be decoded are an error of the client. The gRPC library reports them as
//! internal errors; here they become INVALID_ARGUMENT.

use axum::response::Response;
use tonic::{Code, Status};

use crate::api::problem::{Kind, Problem};

/// The beginning of the library's messages for undecodable input.
const MALFORMED: [&str; 4] = [
    "failed to decode Protobuf message",
    "Unexpected EOF decoding stream",
    "Missing request message",
    "protocol error: received message with",
];

/// The answer to a call, with the right status if its message could not be decoded.
pub(super) fn explained(response: Response) -> Response {
    let Some(status) = Status::from_header_map(response.headers()) else {
        return response;
    };
    let message = status.message();
    if status.code() != Code::Internal || !MALFORMED.iter().any(|it| message.starts_with(it)) {
        return response;
    }
    let detail = format!("the message of the call cannot be read: {message}");
    Status::from(Problem::new(Kind::NotProtobuf, detail)).into_http()
}
