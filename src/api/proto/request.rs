//! Messages in the bodies of requests.

use bytes::Bytes;
use prost::DecodeError;

use super::bounds::{self, Bounded};
use super::fields::MessageLayout;
use crate::api::problem::{Kind, Problem};
use crate::config::Config;
use crate::model::job::JobRequest;
use crate::proto::job;
use crate::proto::messages as pb;

/// Reads a message from the body of a request.
pub(crate) fn decode<M: Bounded>(body: Bytes, most_points: usize) -> Result<M, Problem> {
    bounds::check::<M>(&body, most_points)?;
    M::decode(body).map_err(|error| Problem::new(Kind::NotProtobuf, unreadable(&error)))
}

/// Endings of prost's decoding errors, and what they mean. The texts are all that prost reveals of an error: its kind
/// is private. Unknown texts get a general reason.
const BROKEN: [(&str, &str); 6] = [
    ("buffer underflow", "it ends too soon"),
    (
        "delimited length exceeded",
        "a field is longer than what it is in",
    ),
    ("recursion limit reached", "messages are nested too deep"),
    ("data is not UTF-8 encoded", "a text is not UTF-8"),
    ("invalid tag value: 0", "a field has the number 0"),
    ("invalid varint", "a number is malformed"),
];

/// Why bytes are not a message, in plain words.
fn unreadable(error: &DecodeError) -> String {
    let text = error.to_string();
    let text = text
        .strip_prefix("failed to decode Protobuf message: ")
        .unwrap_or(&text);
    let known = BROKEN.iter().find(|(end, _)| text.ends_with(end));
    let reason = known.map_or("a field has another type", |(_, plain)| plain);
    // The path of known fields is before the reason: "JobInput.geometry: ".
    match text.split_once(": ") {
        Some((place, _)) if place.contains('.') => format!("{place} cannot be read: {reason}"),
        _ => format!("the message cannot be read: {reason}"),
    }
}

/// The job of a body, and the locations of its parts.
pub(crate) fn read(body: Bytes, config: &Config) -> Result<(JobRequest, MessageLayout), Problem> {
    let input = decode(body, config.max_points)?;
    job(input, config)
}

/// The job of a message, and the locations of its parts, relative to the message.
pub(crate) fn job(
    input: pb::JobInput,
    config: &Config,
) -> Result<(JobRequest, MessageLayout), Problem> {
    let layout = MessageLayout::of(&input);
    match job::request(input, config.limits().points) {
        Ok(request) => Ok((request, layout)),
        Err(errors) => Err(Problem::of_errors(errors, &layout)),
    }
}
