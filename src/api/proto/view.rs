//! Jobs, their descriptions and ends as messages.

use std::sync::Arc;

use bytes::Bytes;
use jiff::Timestamp;
use prost::Message;

use super::fields::MessageLayout;
use super::names;
use crate::api::problem::{self as api, Locator};
use crate::api::rates::Rates;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::outliers::Outliers;
use crate::job::outline::Outline;
use crate::job::state::{Failure, Levels, Status};
use crate::model::errors::SpecPart;
use crate::proto::messages::{self as pb, stop_rules::Rule};
use crate::proto::values::count;
use crate::proto::{basis, ends::rule, job, method, stream};
use piad_fit::basis::{Corners, End, Ends};
use piad_fit::engine::foot::Deviation;
use piad_fit::engine::rates::BasisRate;
use piad_fit::engine::{Direction, DirectionChoice, Forecast, Level, Problem, Warning};
use piad_fit::geometry::FitError;
use piad_fit::method::Method;

/// The job as a resource.
pub(crate) fn job(job: &Job) -> pb::Job {
    let (status, outline) = (job.status(), job.outline());
    let label = &outline.label;
    let level = status.levels.map(|levels| levels.last);
    let forecast = status.levels.map(|levels| levels.forecast);
    let parent = label.parent.map(|parent| pb::Parent {
        id: parent.id.to_string(),
        iteration: parent.iteration as u64,
    });
    pb::Job {
        id: outline.id.to_string(),
        name: label.name.clone(),
        kind: names::kind(outline.surface).into(),
        state: names::state(status.state).into(),
        reason: names::reason(status.reason).into(),
        rows: count(outline.grid.rows),
        columns: count(outline.grid.columns),
        method: Some(method::message(&outline.method, outline.surface, forecast)),
        computed: Some(computed(outline, forecast)),
        stop: Some(stop(outline)),
        stream: stream_options(outline),
        iteration: level.map(|level| level.iteration as u64),
        error: level.map(|level| last_distances(&level, &outline.method)),
        progress: status.progress(outline),
        created_at: Some(time(outline.created)),
        started_at: status.started.map(time),
        finished_at: status.finished.map(time),
        parent,
        problem: status.failure.map(failure),
        detail: status.detail(outline).unwrap_or_default(),
        warnings: warnings(outline, status.levels.as_ref()),
        predicted: Some(prediction(forecast, level)),
        notices: label.notices.clone(),
    }
}

/// The warnings about a job so far.
fn warnings(outline: &Outline, levels: Option<&Levels>) -> Vec<pb::Warning> {
    let layout = MessageLayout::of_shape(outline.surface);
    let view = |warning: Warning| pb::Warning {
        code: names::warning(&warning).into(),
        field: layout.of(SpecPart::Fit(warning.place())),
        detail: warning.detail(),
    };
    outline.warnings(levels).map(view).collect()
}

/// A page of the list of jobs.
pub(crate) fn page(jobs: &[Arc<Job>], more: bool) -> pb::ListJobsResponse {
    let last = jobs.last().filter(|_| more);
    pb::ListJobsResponse {
        jobs: jobs.iter().map(|it| job(it)).collect(),
        next_page_token: last.map_or(String::new(), |job| job.id().to_string()),
    }
}

/// The default options of the streams of a job.
fn stream_options(outline: &Outline) -> Option<pb::StreamOptions> {
    outline.label.stream.as_deref().map(stream::options)
}

/// The bytes of the `JobInput` that would request the same job again.
pub(crate) fn input(outline: &Outline, problem: &Problem) -> Bytes {
    let label = &outline.label;
    let message = job::message(
        label.name.clone(),
        problem.request(),
        label.stream.as_deref(),
    );
    message.encode_to_vec().into()
}

/// The prediction of a level.
fn prediction(forecast: Option<Forecast>, level: Option<Level>) -> pb::Prediction {
    let iterations = level.and_then(|level| level.predicted);
    pb::Prediction {
        rate: forecast.and_then(|it| it.rate),
        iterations: iterations.map(|iterations| iterations as u64),
    }
}

fn computed(outline: &Outline, forecast: Option<Forecast>) -> pb::Computed {
    pb::Computed {
        lambda_min: forecast.and_then(|it| it.block.or(it.lambda_min)),
        adjusted: outline.adjusted.map(|adjusted| adjusted as u64),
    }
}

fn stop(outline: &Outline) -> pb::StopRules {
    pb::StopRules {
        rule: Some(Rule::Tolerance(outline.tolerance)),
        max_iterations: Some(outline.max_iterations as u64),
    }
}

/// The distances of a level from the data.
pub(crate) fn distances(error: &FitError, method: &Method) -> pb::Distances {
    let local = matches!(method, Method::Local(_));
    pb::Distances {
        max: error.max,
        rms: error.rms,
        sum: error.sum,
        at: count(error.at),
        fixed_max: error.fixed_max.filter(|_| local),
        homogeneous: error.homogeneous,
        gradient: error.gradient,
        transformed: error.transformed,
        between: None,
    }
}

/// The distances of the last level of a job so far, with its deviation between data.
fn last_distances(level: &Level, method: &Method) -> pb::Distances {
    pb::Distances {
        between: level.between,
        ..distances(&level.error, method)
    }
}

fn time(at: Timestamp) -> prost_types::Timestamp {
    prost_types::Timestamp {
        seconds: at.as_second(),
        nanos: at.subsec_nanosecond(),
    }
}

fn failure(failure: Failure) -> pb::Problem {
    problem(&api::Problem::from(failure))
}

/// A problem, with the fields that are wrong.
pub(super) fn problem(problem: &api::Problem) -> pb::Problem {
    let entry = problem.kind().entry();
    let errors = problem.errors().iter();
    let errors = errors.filter_map(|error| match &error.place {
        api::Location::Field(field) => Some(pb::FieldProblem {
            field: field.clone(),
            detail: error.detail.clone(),
        }),
        _ => None,
    });
    pb::Problem {
        r#type: problem.kind().path(),
        title: entry.title.to_owned(),
        status: entry.status.as_u16().into(),
        detail: problem.detail().to_owned(),
        errors: errors.collect(),
    }
}

/// A comparison of bases.
pub(crate) fn rates(rates: &Rates) -> pb::CompareBasesResponse {
    let view = |rate: &BasisRate| pb::BasisRate {
        basis: basis::kind(rate.basis).into(),
        degree: count(rate.degree),
        lambda_min: rate.lambda_min,
        rate: rate.rate,
        iterations: rate.iterations(rates.tolerance),
    };
    pb::CompareBasesResponse {
        points: count(rates.points),
        tolerance: rates.tolerance,
        bases: rates.bases.iter().map(view).collect(),
    }
}

/// The distances of the data from a level, with those of all points if requested.
pub(crate) fn deviation(
    iteration: usize,
    deviation: Deviation,
    list: bool,
) -> pb::GetDeviationResponse {
    let listed = |distances: Vec<f64>| if list { distances } else { Vec::new() };
    pb::GetDeviationResponse {
        iteration: iteration as u64,
        max: deviation.max,
        rms: deviation.rms,
        at: count(deviation.at),
        percentiles: deviation.percentiles.to_vec(),
        distances: listed(deviation.distances),
        between: listed(deviation.between),
    }
}

/// A direction of the fit, with knots, weights and the parameters of the data or without them.
fn direction(direction: &Direction, choice: &DirectionChoice, arrays: bool) -> pb::FittedDirection {
    let ends = choice.ends.as_ref();
    let corners = choice.corners.as_ref().map(Corners::indices);
    let fitted = &direction.basis;
    let rule = |end: fn(&Ends) -> &End| ends.map_or(pb::EndRule::Unspecified, |it| rule(end(it)));
    let list = |numbers: &dyn Fn() -> Vec<f64>| match arrays {
        true => numbers(),
        false => Vec::new(),
    };
    pb::FittedDirection {
        basis: basis::kind(fitted.name()).into(),
        degree: count(fitted.degree()),
        closed: direction.is_closed(),
        control_points: count(fitted.functions()),
        knots: list(&|| fitted.knots().unwrap_or_default().into_owned()),
        parameters: list(&|| direction.parameters.to_vec()),
        weights: list(&|| direction.weights().unwrap_or_default().to_vec()),
        start: rule(|it| &it.start).into(),
        end: rule(|it| &it.end).into(),
        corners: corners
            .unwrap_or_default()
            .iter()
            .map(|&index| count(index))
            .collect(),
    }
}

/// Both directions of a problem, or the one of a curve.
pub(crate) fn directions(
    problem: &Problem,
    arrays: bool,
) -> (pb::FittedDirection, Option<pb::FittedDirection>) {
    let request = problem.request();
    let u = direction(problem.u(), &request.u, arrays);
    let v = problem.v().zip(request.v.as_ref());
    let v = v.map(|(v, choice)| direction(v, choice, arrays));
    (u, v)
}

/// All that does not change from iteration to iteration, with its arrays or without them, as the bytes of
/// a `JobDescription`.
pub(crate) fn description(
    job: &Job,
    problem: &Problem,
    levels: Option<Levels>,
    with_arrays: bool,
) -> Content {
    let outline = job.outline();
    let forecast = levels.map(|levels| levels.forecast);
    let first = levels.map(|levels| levels.first);
    let (u, v) = directions(problem, with_arrays);
    let message = pb::JobDescription {
        id: outline.id.to_string(),
        name: outline.label.name.clone(),
        kind: names::kind(outline.surface).into(),
        dimension: count(problem.dimension()),
        rows: count(outline.grid.rows),
        columns: count(outline.grid.columns),
        u: Some(u),
        v,
        rational: job::rational_message(problem.request()).into(),
        method: Some(method::message(&outline.method, outline.surface, forecast)),
        computed: Some(computed(outline, forecast)),
        predicted: Some(prediction(forecast, first)),
        stop: Some(stop(outline)),
        warnings: warnings(outline, levels.as_ref()),
        notices: outline.label.notices.clone(),
        outliers: outliers(problem),
    };
    Bytes::from(message.encode_to_vec()).into()
}

/// The points that a robust fit leaves out, if there are any.
pub(super) fn outliers(problem: &Problem) -> Option<pb::Outliers> {
    let outliers = Outliers::of(problem)?;
    Some(pb::Outliers {
        count: count(outliers.count),
        indices: outliers.indices.iter().map(|&index| count(index)).collect(),
    })
}

/// The end of a job, as the bytes of a `JobEnd`.
pub(crate) fn end(job: &Job, status: &Status) -> Content {
    let level = status.levels.map(|levels| levels.last);
    let times = status.started.zip(status.finished);
    let message = pb::JobEnd {
        state: names::state(status.state).into(),
        reason: names::reason(status.reason).into(),
        iterations: level.map_or(0, |level| level.iteration as u64),
        error: level.map(|level| last_distances(&level, &job.outline().method)),
        elapsed: times.map(|(start, end)| end.duration_since(start).as_secs_f64()),
        problem: status.failure.map(failure),
        detail: status.detail(job.outline()).unwrap_or_default(),
        warnings: warnings(job.outline(), status.levels.as_ref()),
    };
    Bytes::from(message.encode_to_vec()).into()
}
