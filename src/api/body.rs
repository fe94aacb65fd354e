//! Reading a request body: its media type and its size.

use axum::body::Body;
use axum::extract::Request;
use axum::http::header;
use bytes::Bytes;
use http_body_util::BodyExt;

use super::negotiate::{Language, PROTOBUF};
use super::problem::{Kind, Problem};
use super::short::quoted;
use super::{App, text};

/// Reads the body of a request, which is JSON or a protobuf message.
pub async fn read(app: &App, request: Request) -> Result<(Language, Bytes), Problem> {
    let language = language(&request)?;
    text::check_coding(request.headers())?;
    let limit = usize::try_from(app.config.max_body.as_u64()).unwrap_or(usize::MAX);
    let announced = request
        .headers()
        .get(header::CONTENT_LENGTH)
        .and_then(|length| length.to_str().ok()?.parse::<usize>().ok());
    if announced > Some(limit) {
        return Err(too_large(limit));
    }
    let body = request.into_body();
    let body = collect(app, body, limit, announced.unwrap_or(0)).await?;
    Ok((language, body))
}

/// The language of a body by its media type.
fn language(request: &Request) -> Result<Language, Problem> {
    let given = request.headers().get(header::CONTENT_TYPE);
    let given = given.and_then(|value| value.to_str().ok()).unwrap_or("");
    let mut parts = given.split(';').map(str::trim);
    let essence = parts.next().unwrap_or("");
    // JSON is UTF-8; another charset would be read wrongly.
    let utf8 = parts.all(|parameter| {
        let (name, value) = parameter.split_once('=').unwrap_or((parameter, ""));
        !name.trim().eq_ignore_ascii_case("charset")
            || value.trim().trim_matches('"').eq_ignore_ascii_case("utf-8")
    });
    if essence.eq_ignore_ascii_case("application/json") && utf8 {
        return Ok(Language::Json);
    }
    if essence.eq_ignore_ascii_case(PROTOBUF) {
        return Ok(Language::Protobuf);
    }
    const SENT: &str = "jobs are sent as application/json in UTF-8, or as application/x-protobuf";
    let detail = match given {
        "" => format!("the Content-Type header is missing; {SENT}"),
        _ => format!("Content-Type is {}; {SENT}", quoted(given)),
    };
    Err(Problem::new(Kind::UnsupportedMediaType, detail))
}

async fn collect(
    app: &App,
    mut body: Body,
    limit: usize,
    announced: usize,
) -> Result<Bytes, Problem> {
    let mut collected = Vec::with_capacity(announced);
    loop {
        let frame = tokio::time::timeout(app.config.body_timeout, body.frame())
            .await
            .map_err(|_| {
                let seconds = app.config.body_timeout.as_secs_f64();
                let detail = format!("no byte of the body came for {seconds} seconds");
                Problem::new(Kind::BodyTimeout, detail)
            })?;
        let Some(frame) = frame else {
            return Ok(collected.into());
        };
        let frame = frame.map_err(|reason| {
            let detail = format!("the body could not be read: {reason}");
            Problem::new(Kind::InvalidRequest, detail)
        })?;
        // Trailers carry nothing that is needed here.
        if let Ok(data) = frame.into_data() {
            if data.len() > limit - collected.len() {
                return Err(too_large(limit));
            }
            collected.extend_from_slice(&data);
        }
    }
}

fn too_large(limit: usize) -> Problem {
    let detail = format!("the body is larger than {limit} bytes, the limit of this server");
    Problem::new(Kind::BodyTooLarge, detail)
}
