//! `POST /v1/batch`: many fits in one request, a line for each in one answer, and nothing is stored.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use futures_util::stream;

use super::answer::whole;
use super::body_limits::take_memory;
use super::points::{Fields, PartJobs};
use super::query::{IterationQuery, OF_RESULTS};
use super::request_id::REQUEST_ID;
use super::{body, coding, events, negotiate};
use crate::api::app::App;
use crate::api::batch::driver::Batch;
use crate::api::batch::part_file::{BatchLine, PartFile};
use crate::api::batch::pieces::BodyForm;
use crate::api::batch::sending::Sending;
use crate::api::batch::settings::{Forms, Settings};
use crate::api::media_type::{Framing, NDJSON, SSE};
use crate::api::problem::{Kind, Problem};
use crate::lines::Lines;
use crate::model::stream::form::Digits;
use crate::model::stream::options;
use piad_files::export::Format;

/// The memory of results as numbers and as a file, for each byte of their lines.
const WRITING: usize = 3;

/// Fits many curves and surfaces: the items of a batch, or the parts of a file.
pub(super) async fn batch(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let fields = Fields::of_points(&request, &OF_RESULTS)?;
    let (query, fields): (IterationQuery, _) = match fields {
        None => (negotiate::query(request.uri())?, None),
        Some((query, fields)) => (query, Some(fields)),
    };
    let headers = request.headers();
    let wanted = wanted(headers)?;
    let (framing, forms) = match wanted {
        Wanted::Lines(framing) => (framing, forms(&query)?),
        Wanted::File(format) => {
            query.file_options(format, false)?;
            (Framing::Ndjson, forms(&IterationQuery::default())?)
        }
    };
    let form = match fields {
        None => body::of_batch(headers)?,
        Some(_) => BodyForm::Lines,
    };
    let request_id = headers.get(REQUEST_ID).and_then(|id| id.to_str().ok());
    let request_id = request_id.map(str::to_owned);
    let settings = Settings::new(&app, form, framing, forms, request_id);
    let batch = match fields {
        None => {
            let coding = coding::of_body(headers)?;
            Batch::begin(settings, request.into_body(), coding).await?
        }
        Some(fields) => {
            let mut jobs = PartJobs::read(&app, request, fields).await?;
            settings.set_notices(jobs.take_notices());
            Batch::begin(settings, jobs.into_body(), None).await?
        }
    };
    let sending = Sending::begin(batch);
    let lines = Body::from_stream(stream::unfold(sending, |mut sending| async move {
        let bytes = sending.next().await?;
        Some((bytes, sending))
    }));
    match wanted {
        Wanted::Lines(framing) => Ok(events::unstored(framing, lines)),
        Wanted::File(format) => one_file(&app, Lines::new(lines), format, &query).await,
    }
}

/// The kind of answer.
#[derive(Clone, Copy)]
enum Wanted {
    /// Lines with this framing.
    Lines(Framing),
    /// A file with all curves and surfaces.
    File(Format),
}

/// What the Accept header prefers; lines of JSON by default.
fn wanted(headers: &HeaderMap) -> Result<Wanted, Problem> {
    let lines = [
        (NDJSON, Wanted::Lines(Framing::Ndjson)),
        (SSE, Wanted::Lines(Framing::Sse)),
    ];
    let files = Format::ALL.map(|format| (format.media_type(), Wanted::File(format)));
    negotiate::choose(headers, &[lines.as_slice(), files.as_slice()].concat())
}

/// All curves and surfaces as one file, if all have converged.
async fn one_file(
    app: &App,
    mut lines: Lines,
    format: Format,
    query: &IterationQuery,
) -> Result<Response, Problem> {
    let limit = usize::try_from(app.config.max_body.as_u64()).unwrap_or(usize::MAX);
    let files = &app.jobs.resources().memory.files;
    let broken = |reason| Problem::new(Kind::Internal, reason);
    let mut file = PartFile::default();
    let (mut memory, mut taken) = (None, 0);
    while let Some(line) = lines.next().await.map_err(broken)? {
        taken += line.len();
        if taken > limit {
            let detail = format!(
                "the results are too large for one file here: as lines they take more than {limit} bytes; ask for lines"
            );
            return Err(Problem::new(Kind::NoExport, detail));
        }
        take_memory(files, &mut memory, WRITING.saturating_mul(line.len())).await?;
        add(&mut file, &line)?;
    }
    let options = query.file_options(format, file.has_surface())?;
    let failed = |reason| Problem::new(Kind::NoExport, reason);
    Ok(whole(
        file.write(format, options).map_err(failed)?,
        format.media_type(),
    ))
}

/// Adds the contents of a line.
fn add(file: &mut PartFile, line: &[u8]) -> Result<(), Problem> {
    let unreadable = |reason: serde_json::Error| Problem::new(Kind::Internal, reason.to_string());
    let line: BatchLine<'_> = serde_json::from_slice(line).map_err(unreadable)?;
    if let Some(why) = &line.problem {
        let detail = match line.index {
            None => why.detail.clone(),
            Some(_) => format!(
                "{}: {}; lines of JSON have the others",
                line.title(),
                why.detail
            ),
        };
        return Err(Problem::new(Kind::NotConverged, detail));
    }
    if let Some(geometry) = line.geometry().map_err(unreadable)? {
        file.add(line.title(), geometry);
    }
    Ok(())
}

/// The form of curves and surfaces. Choices that suit neither are refused before anything is read.
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
