//! Headers and query parameters that choose an answer.

use std::str::FromStr;
use std::time::Duration;

use axum::extract::Query;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Uri, header};
use headers_accept::Accept;
use mediatype::MediaType;
use serde::de::DeserializeOwned;

use crate::api::media_type::{Framing, JSON, Language, NDJSON, PROTOBUF, SSE};
use crate::api::problem::{Kind, Problem};
use piad_files::text::quoted;

/// The longest time of `Prefer: wait`, in seconds.
pub(crate) const LONGEST_WAIT: u64 = 300;

/// The kind of answer for a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The job in its current state.
    Job(Language),
    /// The events of the job.
    Events(Framing),
}

/// The job or its events, whichever the client prefers; the job as JSON by default. A job and an event
/// stream in protobuf have the same media type: `Prefer: stream` asks for the stream.
pub(crate) fn answer(headers: &HeaderMap) -> Result<Answer, Problem> {
    let message = match prefers_stream(headers) {
        true => Answer::Events(Framing::Protobuf),
        false => Answer::Job(Language::Protobuf),
    };
    choose(
        headers,
        &[
            (JSON, Answer::Job(Language::Json)),
            (SSE, Answer::Events(Framing::Sse)),
            (NDJSON, Answer::Events(Framing::Ndjson)),
            (PROTOBUF, message),
        ],
    )
}

/// The framing of an event stream; server-sent events by default.
pub(crate) fn framing(headers: &HeaderMap) -> Result<Framing, Problem> {
    choose(
        headers,
        &[
            (SSE, Framing::Sse),
            (NDJSON, Framing::Ndjson),
            (PROTOBUF, Framing::Protobuf),
        ],
    )
}

/// JSON or a protobuf message; JSON by default.
pub(crate) fn language(headers: &HeaderMap) -> Result<Language, Problem> {
    choose(
        headers,
        &[(JSON, Language::Json), (PROTOBUF, Language::Protobuf)],
    )
}

/// Refuses requests whose Accept header excludes JSON.
pub(super) fn json(headers: &HeaderMap) -> Result<(), Problem> {
    choose(headers, &[(JSON, ())])
}

/// The preferences of a client (RFC 7240).
fn preferences(headers: &HeaderMap) -> impl Iterator<Item = &str> {
    let values = headers.get_all("prefer").iter();
    values.flat_map(|value| value.to_str().unwrap_or("").split(','))
}

fn prefers_stream(headers: &HeaderMap) -> bool {
    preferences(headers).any(|preference| preference.trim().eq_ignore_ascii_case("stream"))
}

/// The first of the representations that the Accept header prefers.
pub(super) fn choose<T: Copy>(headers: &HeaderMap, available: &[(&str, T)]) -> Result<T, Problem> {
    let mut given = Vec::new();
    for value in headers.get_all(header::ACCEPT) {
        let text = value
            .to_str()
            .map_err(|_| Problem::at_header("Accept", "it is not text"))?;
        given.push(text);
    }
    let given = given.join(", ");
    let given: Vec<String> = given.split(',').map(without_parameters).collect();
    let given = given.join(", ");
    let wanted = match given.trim() {
        "" => "*/*",
        given => given,
    };
    let accept = Accept::from_str(wanted).map_err(|_| {
        Problem::at_header(
            "Accept",
            format!("{} is not a list of media types", quoted(wanted)),
        )
    })?;
    let types: Vec<MediaType> = available
        .iter()
        .filter_map(|(name, _)| MediaType::parse(name).ok())
        .collect();
    let best = accept.negotiate(&types);
    best.and_then(|best| types.iter().position(|candidate| candidate == best))
        .and_then(|index| available.get(index))
        .map(|(_, value)| *value)
        .ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|(name, _)| *name).collect();
            let names = names.join(", ");
            Problem::new(
                Kind::NotAcceptable,
                format!("Accept is {}; this resource has {names}", quoted(wanted)),
            )
        })
}

/// A media range without its parameters except the quality: `text/event-stream; charset=utf-8` is an
/// event stream, too.
fn without_parameters(range: &str) -> String {
    let mut parts = range.split(';').map(str::trim);
    let essence = parts.next().unwrap_or("");
    match parts.find(|parameter| parameter.starts_with("q=") || parameter.starts_with("Q=")) {
        Some(quality) => format!("{essence};{quality}"),
        None => essence.to_owned(),
    }
}

/// The time of `Prefer: wait=n` (RFC 7240), in seconds.
pub(super) fn wait(headers: &HeaderMap) -> Result<Option<Duration>, Problem> {
    for preference in preferences(headers) {
        // Parameters of a preference follow a semicolon.
        let preference = preference.split(';').next().unwrap_or("");
        let Some((name, seconds)) = preference.split_once('=') else {
            continue;
        };
        if !name.trim().eq_ignore_ascii_case("wait") {
            continue;
        }
        let seconds = seconds.trim().trim_matches('"');
        return match seconds.parse() {
            Ok(seconds) if seconds <= LONGEST_WAIT => Ok(Some(Duration::from_secs(seconds))),
            _ => Err(Problem::at_header(
                "Prefer",
                format!(
                    "wait is a whole number of seconds from 0 to {LONGEST_WAIT}, not {}",
                    quoted(seconds)
                ),
            )),
        };
    }
    Ok(None)
}

/// Reports in an answer that the client's time was applied.
pub(super) fn waited(headers: &mut HeaderMap, wait: Option<Duration>) {
    let applied = wait.map(|wait| HeaderValue::from_str(&format!("wait={}", wait.as_secs())));
    let name = HeaderName::from_static("preference-applied");
    headers.extend(applied.and_then(Result::ok).map(|applied| (name, applied)));
}

/// The query parameters of a resource; unknown ones are errors.
pub(crate) fn query<T: DeserializeOwned>(uri: &Uri) -> Result<T, Problem> {
    Query::try_from_uri(uri)
        .map(|Query(parameters)| parameters)
        .map_err(|rejection| explain(&rejection.body_text()))
}

/// The error of a query, from the message of its deserializer.
fn explain(text: &str) -> Problem {
    let of_field = |words: &str| {
        let (_, rest) = text.split_once(words)?;
        rest.split_once('`')
    };
    if let Some((name, _)) = of_field("duplicate field `") {
        return Problem::at_parameter(name, "it is given twice");
    }
    if let Some((name, rest)) = of_field("unknown field `") {
        // The known names are between the other backticks.
        let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
        let detail = format!(
            "there is no such parameter; expected one of {}",
            known.join(", ")
        );
        return Problem::at_parameter(name, detail);
    }
    Problem::new(Kind::InvalidRequest, "the query cannot be understood")
}
