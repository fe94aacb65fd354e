//! A request body and its media type.

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};

use super::body_limits::ReceivedBody;
use super::{body_limits, coding};
use crate::api::app::App;
use crate::api::batch::pieces::BodyForm;
use crate::api::media_type::{JSON, Language, NDJSON, PROTOBUF};
use crate::api::problem::{Kind, Problem};
use crate::api::proto::bounds::{self, Bounded};
use piad_files::text::quoted;

/// The media types of files of points. The format is detected by the content; these only say that
/// it is a file.
const FILES: [&str; 10] = [
    "text/csv",
    "text/plain",
    "application/octet-stream",
    "application/geo+json",
    "application/gpx+xml",
    "application/vnd.google-earth.kml+xml",
    "image/svg+xml",
    "image/vnd.dxf",
    "model/obj",
    "model/stl",
];

/// Receives the body of a request, which is JSON or such a protobuf message.
pub(super) async fn read<M: Bounded>(
    app: &App,
    request: Request,
) -> Result<(Language, ReceivedBody), Problem> {
    let language = language(&request)?;
    let more = match language {
        Language::Json => |_: &[u8]| 0,
        Language::Protobuf => bounds::memory::<M>,
    };
    Ok((language, take_in(app, request, more).await?))
}

/// Receives the body of a request, which is a file of points. They take `more` memory for each byte.
pub(super) async fn read_points(
    app: &App,
    request: Request,
    more: usize,
) -> Result<ReceivedBody, Problem> {
    if !is_points(request.headers()) {
        let given = content_type(request.headers());
        let detail = format!(
            "Content-Type is {}; points are sent as text/csv or text/plain in UTF-8, and any file as application/octet-stream",
            quoted(given)
        );
        return Err(Problem::new(Kind::UnsupportedMediaType, detail));
    }
    take_in(app, request, |bytes| more.saturating_mul(bytes.len())).await
}

async fn take_in(
    app: &App,
    request: Request,
    more: impl FnOnce(&[u8]) -> usize,
) -> Result<ReceivedBody, Problem> {
    let coding = coding::of_body(request.headers())?;
    let (parts, body) = request.into_parts();
    body_limits::take_in(app, &parts.headers, body, coding, more).await
}

/// The format of a batch by its media type.
pub(super) fn of_batch(headers: &HeaderMap) -> Result<BodyForm, Problem> {
    let given = content_type(headers);
    let (essence, utf8) = media_type(given);
    let is = |name: &str| utf8 && essence.eq_ignore_ascii_case(name);
    if is(JSON) {
        return Ok(BodyForm::Document);
    }
    if is(NDJSON) {
        return Ok(BodyForm::Lines);
    }
    let sent = format!("batches are sent as {JSON} or {NDJSON} in UTF-8");
    let detail = match given {
        "" => format!("the Content-Type header is missing; {sent}"),
        _ => format!("Content-Type is {}; {sent}", quoted(given)),
    };
    Err(Problem::new(Kind::UnsupportedMediaType, detail))
}

/// Returns true if a body is a file of points by its media type.
pub(super) fn is_points(headers: &HeaderMap) -> bool {
    let (essence, utf8) = media_type(content_type(headers));
    let is = |name: &str| essence.eq_ignore_ascii_case(name);
    utf8 && FILES.into_iter().any(is)
}

/// Returns true if a page of another origin has sent a text, which browsers allow every page
/// without a preflight request: such a request creates no job.
pub(super) fn is_unasked(headers: &HeaderMap) -> bool {
    let (essence, _) = media_type(content_type(headers));
    let text = |name| {
        headers
            .get(name)
            .and_then(|value: &HeaderValue| value.to_str().ok())
    };
    let host = text(header::HOST).unwrap_or("");
    let foreign = text(header::ORIGIN).is_some_and(|origin| {
        origin
            .split_once("://")
            .is_none_or(|(_, authority)| !authority.eq_ignore_ascii_case(host))
    });
    foreign && essence.eq_ignore_ascii_case("text/plain")
}

fn content_type(headers: &HeaderMap) -> &str {
    let given = headers.get(header::CONTENT_TYPE);
    given.and_then(|value| value.to_str().ok()).unwrap_or("")
}

/// A media type without its parameters, and whether it is in UTF-8 by them.
fn media_type(given: &str) -> (&str, bool) {
    let mut parts = given.split(';').map(str::trim);
    let essence = parts.next().unwrap_or("");
    let utf8 = parts.all(|parameter| {
        let (name, value) = parameter.split_once('=').unwrap_or((parameter, ""));
        !name.trim().eq_ignore_ascii_case("charset")
            || value.trim().trim_matches('"').eq_ignore_ascii_case("utf-8")
    });
    (essence, utf8)
}

/// The encoding of a body by its media type.
fn language(request: &Request) -> Result<Language, Problem> {
    let given = content_type(request.headers());
    // JSON is UTF-8: any other charset is refused.
    let (essence, utf8) = media_type(given);
    if essence.eq_ignore_ascii_case("application/json") && utf8 {
        return Ok(Language::Json);
    }
    if essence.eq_ignore_ascii_case(PROTOBUF) {
        return Ok(Language::Protobuf);
    }
    const SENT: &str = "jobs are sent as application/json in UTF-8, or as application/x-protobuf; the points of new ones also as text/csv or, of any file, as application/octet-stream";
    let detail = match given {
        "" => format!("the Content-Type header is missing; {SENT}"),
        _ => format!("Content-Type is {}; {SENT}", quoted(given)),
    };
    Err(Problem::new(Kind::UnsupportedMediaType, detail))
}
