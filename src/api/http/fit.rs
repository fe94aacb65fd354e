//! `POST /v1/fit`: one request, one answer, and nothing is kept.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::response::Response;

use super::export::Representation;
use super::geometry::{show_result, wanted};
use super::points::Fields;
use super::query::{IterationQuery, OF_RESULTS};
use super::{body, create, export, negotiate};
use crate::api::app::App;
use crate::api::language::Language;
use crate::api::order;
use crate::api::problem::{Kind, Problem};
use crate::job::Job;
use crate::job::state::{Levels, State as JobState, Status};
use crate::proto::messages as pb;

/// Fits, and answers with the geometry.
pub(super) async fn fit(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    order::check_open(&app)?;
    let fields = Fields::of_points(&request, &OF_RESULTS)?;
    let (query, fields): (IterationQuery, _) = match fields {
        None => (negotiate::query(request.uri())?, None),
        Some((query, fields)) => (query, Some(fields)),
    };
    let representation = export::representation(request.headers())?;
    let (language, body) = match fields {
        None => body::read::<pb::JobInput>(&app, request).await?,
        Some(_) => (Language::Json, body::read_points(&app, request, 0).await?),
    };
    let (bytes, room) = (body.bytes, body.room);
    let order = create::order(&app, language, bytes, fields).await?;
    drop(room);
    if let Representation::File(format) = representation {
        order.check_export(format)?;
    }
    let fit = order.begin(&app, None).await?;
    let job = CancelledWithItsRequest(Arc::clone(&fit.job));
    let wanted = wanted(&job.0, query, representation).await?;
    let status = tokio::select! {
        status = job.0.ended() => status,
        () = app.stopped() => return Err(order::stopping()),
    };
    match status.state {
        JobState::Converged => show_result(&job.0, wanted).await,
        _ => Err(not_converged(&job.0, status)),
    }
}

/// The job of a request, which ends with it.
struct CancelledWithItsRequest(Arc<Job>);

impl Drop for CancelledWithItsRequest {
    fn drop(&mut self) {
        self.0.request_cancel();
    }
}

/// Why a fit that has ended is no answer.
fn not_converged(job: &Job, status: Status) -> Problem {
    if let Some(failure) = status.failure {
        return Problem::from(failure);
    }
    let (state, outline) = (status.state, job.outline());
    let Some(Levels { last, .. }) = status.levels else {
        return Problem::new(Kind::NotConverged, format!("the fit is {state}"));
    };
    let left = || {
        let (distance, tolerance) = (last.error.max, outline.tolerance);
        format!("a distance of {distance:.3e} is left, the tolerance is {tolerance:.3e}")
    };
    let why = status.detail(outline).unwrap_or_else(left);
    let detail = format!(
        "the fit is {state} after iteration {}: {why}",
        last.iteration
    );
    Problem::new(Kind::NotConverged, detail)
}
