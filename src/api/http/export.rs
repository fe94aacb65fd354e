//! Iterations and results as files: negotiation of the format, and the answer.

use std::sync::Arc;

use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;

use super::answer::answer;
use super::negotiate;
use crate::api::media_type::{JSON, PROTOBUF};
use crate::api::problem::{Kind, Problem};
use crate::job::Job;
use crate::job::content::{Content, Piece, Pieces};
use crate::job::frame::Frame;
use crate::job::peer::Peer;
use crate::job::scheduler::WorkLane;
use piad_files::export::csv::Table;
use piad_files::export::{
    ExportError, Fitted, Format, MOST_MEASURED, Options, sampling_cost, write,
};
use piad_fit::data::Grid;
use piad_fit::engine as fit;
use piad_fit::engine::{Iteration, System};

/// The most multiplications for computing the earlier levels again, whose errors drawings show.
const HISTORY: usize = 200_000_000;

/// Bytes of memory for each control point or sample while a file is made.
const BYTES_PER_POINT: usize = 300;

/// The most lines of a table that are made at a time.
const LINES: usize = 4096;

/// The multiplications for the lines that are made at a time: some hundredths of a second.
const PART: usize = 20_000_000;

/// Writing a number to a file takes about as long as this many multiplications.
const OPERATIONS_PER_NUMBER: usize = 100;

/// The kind of answer for a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Representation {
    Json,
    /// As a protobuf message.
    Protobuf,
    File(Format),
}

/// The representation that the Accept header prefers; JSON by default.
pub(super) fn representation(headers: &HeaderMap) -> Result<Representation, Problem> {
    let files = Format::ALL.map(|format| (format.media_type(), Representation::File(format)));
    let levels = [
        (JSON, Representation::Json),
        (PROTOBUF, Representation::Protobuf),
    ];
    negotiate::choose(headers, &[levels.as_slice(), files.as_slice()].concat())
}

/// A level of a job as a file.
pub(super) async fn file(
    job: &Arc<Job>,
    frame: Arc<Frame>,
    format: Format,
    options: Options,
) -> Result<Response, Problem> {
    let (level, control_points) = (frame.level.iteration, Arc::clone(&frame.control_points));
    let count = control_points.len() + options.samples.map_or(0, Grid::count);
    let bytes = match format {
        Format::Csv => 0,
        _ => count * BYTES_PER_POINT,
    };
    let permit = job
        .resources()
        .memory
        .files
        .take(Peer::current(), bytes)
        .await;
    let system = job.system().await?;
    let owner = Arc::clone(job);
    let measured = if format == Format::Svg {
        frame.problem.grid().count()
    } else {
        0
    };
    let points = control_points.len() + measured.min(MOST_MEASURED);
    let numbers = points * control_points.dimension();
    let written = numbers.saturating_mul(OPERATIONS_PER_NUMBER);
    let scheduler = &job.resources().scheduler;
    let errors = match format {
        Format::Svg => {
            let problem = Arc::clone(&frame.problem);
            let history = move || history(&problem, level, || system.get());
            scheduler
                .compute(WorkLane::of_wire(written), history)
                .await?
        }
        _ => Vec::new(),
    };
    let lane = match sampling_cost(format, &frame.problem, &options) {
        0 => WorkLane::of_wire(written),
        sampled => WorkLane::of_samples(written.saturating_add(sampled)),
    };
    let write = move || {
        let problem = &frame.problem;
        let outline = owner.outline();
        let fitted = Fitted {
            name: outline.label.name.as_deref(),
            errors: &errors,
            options,
            ..Fitted::new(problem, &control_points, outline.created)
        };
        match format {
            Format::Csv => Table::new(&fitted).map(table),
            _ => write(format, &fitted).map(|bytes| Bytes::from(bytes).into()),
        }
    };
    let content = scheduler.compute_in_turns(lane, write).await??;
    Ok(answer(
        job,
        content.with_permit(permit),
        format.media_type(),
    ))
}

/// The content of a table; long ones are written in parts while they are sent.
fn table(table: Table) -> Content {
    let lines = table.lines();
    let table = Arc::new(table);
    let each = table.multiplications() / lines.max(1);
    let at_once = (PART / each.max(1)).clamp(1, LINES);
    let part = |start: usize| {
        let (table, end) = (Arc::clone(&table), lines.min(start + at_once));
        Piece::Later(Box::new(move || table.part(start..end).into()))
    };
    let mut parts: Vec<Piece> = (0..lines).step_by(at_once).map(part).collect();
    let mut head = table.names();
    if parts.len() == 1 {
        parts.clear();
        head.extend(table.part(0..lines));
    }
    let rest = (!parts.is_empty()).then(|| Arc::new(Pieces::new(parts, None)));
    Content::new(head.into(), rest)
}

/// The largest distance at each level up to this one; empty if that takes too long to compute.
fn history(problem: &fit::Problem, level: usize, system: impl FnOnce() -> Arc<System>) -> Vec<f64> {
    if problem.step_cost().saturating_mul(level) > HISTORY {
        return Vec::new();
    }
    let mut iteration = Iteration::start(system());
    let mut errors = vec![iteration.level().error.max];
    for _ in 0..level {
        errors.push(iteration.step().error.max);
    }
    errors
}

impl From<ExportError> for Problem {
    fn from(error: ExportError) -> Self {
        Self::new(Kind::NoExport, error.to_string())
    }
}
