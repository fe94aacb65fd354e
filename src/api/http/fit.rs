//! `POST /v1/fit`: one request, one answer, and nothing is stored.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::response::Response;

use super::export::Representation;
use super::geometry::{show_result, wanted};
use super::points::Fields;
use super::query::{IterationQuery, OF_RESULTS};
use super::{body, create, export, negotiate};
use crate::api::app::App;
use crate::api::create_job;
use crate::api::media_type::Language;
use crate::api::problem::Problem;
use crate::job::Job;
use crate::job::state::State as JobState;
use crate::proto::messages as pb;

/// Fits, and answers with the geometry.
pub(super) async fn fit(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    create_job::check_open(&app)?;
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
        query.file_options(format, order.is_surface())?;
    }
    let fit = order.begin(&app, None).await?;
    let job = CancelledWithItsRequest(Arc::clone(&fit.job));
    let wanted = wanted(&job.0, query, representation).await?;
    let status = tokio::select! {
        status = job.0.ended() => status,
        () = app.stopped() => return Err(create_job::stopping()),
    };
    match status.state {
        JobState::Converged => show_result(&job.0, wanted).await,
        _ => Err(Problem::not_converged(job.0.outline(), &status)),
    }
}

/// The job of a request, which ends with it.
struct CancelledWithItsRequest(Arc<Job>);

impl Drop for CancelledWithItsRequest {
    fn drop(&mut self) {
        self.0.request_cancel();
    }
}
