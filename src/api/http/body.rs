//! A request body and its media type.

use axum::extract::Request;
use axum::http::header;

use super::intake;
use super::intake::ReceivedBody;
use crate::api::language::{Language, PROTOBUF};
use crate::api::problem::{Kind, Problem};
use crate::api::{app::App, text};
use crate::model::short::quoted;

/// Reads the body of a request, which is JSON or a protobuf message.
pub(super) async fn read(app: &App, request: Request) -> Result<(Language, ReceivedBody), Problem> {
    let language = language(&request)?;
    text::check_coding(request.headers())?;
    let (parts, body) = request.into_parts();
    let taken = intake::take_in(app, &parts.headers, body).await?;
    Ok((language, taken))
}

/// The language of a body by its media type.
fn language(request: &Request) -> Result<Language, Problem> {
    let given = request.headers().get(header::CONTENT_TYPE);
    let given = given.and_then(|value| value.to_str().ok()).unwrap_or("");
    let mut parts = given.split(';').map(str::trim);
    let essence = parts.next().unwrap_or("");
    // JSON is UTF-8: any other charset is refused.
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
