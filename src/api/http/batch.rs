//! `POST /v1/batch`: many fits in one request, a line for each in one answer, and nothing is kept.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use futures_util::stream;

use super::query::IterationQuery;
use super::request_id::REQUEST_ID;
use super::{body, coding, events, negotiate};
use crate::api::app::App;
use crate::api::batch::driver::Batch;
use crate::api::batch::sending::Sending;
use crate::api::batch::settings::{Forms, Settings};
use crate::api::language::{Framing, NDJSON, SSE};
use crate::api::problem::Problem;
use crate::model::stream::form::Digits;
use crate::model::stream::options;

/// Fits many curves and surfaces.
pub(super) async fn batch(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let query: IterationQuery = negotiate::query(request.uri())?;
    let headers = request.headers();
    let framing = framing(headers)?;
    let form = body::of_batch(headers)?;
    let coding = coding::of_body(headers)?;
    let request_id = headers.get(REQUEST_ID).and_then(|id| id.to_str().ok());
    let request_id = request_id.map(str::to_owned);
    let settings = Settings::new(&app, form, framing, forms(&query)?, request_id);
    let batch = Batch::begin(settings, request.into_body(), coding).await?;
    let lines = stream::unfold(Sending::begin(batch), |mut sending| async move {
        let bytes = sending.next().await?;
        Some((bytes, sending))
    });
    Ok(events::unstored(framing, Body::from_stream(lines)))
}

/// How lines are framed; one a line by default.
fn framing(headers: &HeaderMap) -> Result<Framing, Problem> {
    negotiate::choose(headers, &[(NDJSON, Framing::Ndjson), (SSE, Framing::Sse)])
}

/// How curves and surfaces are shown. What makes sense for neither is refused before anything is read.
fn forms(query: &IterationQuery) -> Result<Forms, Problem> {
    let of = |surface| {
        let spec = query.clone().spec(surface)?;
        let form = options::json_form(&spec, surface)?;
        if form.digits == Digits::Auto {
            let detail = "a result has all digits; rounded ones are for iterations";
            return Err(Problem::at_parameter("digits", detail));
        }
        Ok((spec, form))
    };
    Forms::any(of(false), of(true))
}
