//! `POST /v1/batch`: many fits in one request, a line for each in one answer, and nothing is kept.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use futures_util::stream;

use super::points::{Fields, PartJobs};
use super::query::{IterationQuery, OF_RESULTS};
use super::request_id::REQUEST_ID;
use super::{body, coding, events, negotiate};
use crate::api::app::App;
use crate::api::batch::driver::Batch;
use crate::api::batch::pieces::BodyForm;
use crate::api::batch::sending::Sending;
use crate::api::batch::settings::{Forms, Settings};
use crate::api::language::{Framing, NDJSON, SSE};
use crate::api::problem::Problem;
use crate::model::stream::form::Digits;
use crate::model::stream::options;

/// Fits many curves and surfaces: the items of a batch, or the parts of a file.
pub(super) async fn batch(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let fields = Fields::of_points(&request, &OF_RESULTS)?;
    let (query, fields): (IterationQuery, _) = match fields {
        None => (negotiate::query(request.uri())?, None),
        Some((query, fields)) => (query, Some(fields)),
    };
    let headers = request.headers();
    let framing = framing(headers)?;
    let form = match fields {
        None => body::of_batch(headers)?,
        Some(_) => BodyForm::Lines,
    };
    let request_id = headers.get(REQUEST_ID).and_then(|id| id.to_str().ok());
    let request_id = request_id.map(str::to_owned);
    let settings = Settings::new(&app, form, framing, forms(&query)?, request_id);
    let batch = match fields {
        None => {
            let coding = coding::of_body(headers)?;
            Batch::begin(settings, request.into_body(), coding).await?
        }
        Some(fields) => {
            let jobs = PartJobs::read(&app, request, fields).await?;
            Batch::begin(settings, jobs.into_body(), None).await?
        }
    };
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
