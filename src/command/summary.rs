//! The summary of a fit that has ended.

use serde::Deserialize;
use serde_json::Value;

use super::events::{EndEvent, JobEvent};
use super::table::Row;
use crate::api::batch::part_file::Distances;
use crate::terminal::say;

/// The shape of control points in a result, if they are binary.
#[derive(Debug, Deserialize)]
pub(super) struct Shape {
    shape: Vec<usize>,
}

impl Shape {
    /// The number of control points, in each direction.
    fn text(&self) -> String {
        let counts = self
            .shape
            .split_last()
            .map_or(&[][..], |(_, counts)| counts);
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        counts.join(" × ")
    }
}

/// Returns true if the number of control points is known only after the fit.
pub(super) fn is_automatic(job: &JobEvent) -> bool {
    job.method["control_points"] == "auto"
}

/// Reports a fit and its end.
pub(super) fn tell(name: &str, job: &JobEvent, end: &EndEvent, shape: Option<&Shape>) {
    for notice in &job.notices {
        say(format_args!("{name}: {notice}"));
    }
    for warning in &end.warnings {
        say(format_args!("{name}: warning: {}", warning.detail));
    }
    let JobEvent {
        kind,
        points,
        degree,
        basis,
        ..
    } = job;
    let method = job.method["kind"].as_str().unwrap_or("");
    let control_points = control_points(job, shape);
    say(format_args!(
        "{name}: {kind} of degree {} ({}), {points} points, {control_points} control points, method {method}",
        each(degree),
        each(basis),
    ));
    let iterations = match end.iterations {
        1 => "1 iteration".to_owned(),
        count => format!("{count} iterations"),
    };
    let elapsed = end.elapsed.map(|seconds| format!(" in {}", time(seconds)));
    let error = end.error.as_ref().map(distances).unwrap_or_default();
    say(format_args!(
        "{} after {iterations}{}{error}",
        end.state,
        elapsed.unwrap_or_default()
    ));
    let why = end.problem.as_ref().map(|it| &it.detail);
    if let Some(detail) = why.or(end.detail.as_ref()) {
        say(detail);
    } else if end.state != "converged" {
        say(format_args!("the tolerance was {:.3e}", job.stop.tolerance));
    }
}

/// The same in a line of a table.
pub(super) fn row(name: &str, job: &JobEvent, end: &EndEvent, shape: Option<&Shape>) -> Row {
    let why = end.problem.as_ref().map(|it| &it.detail);
    let tolerance = || format!("the tolerance was {:.3e}", job.stop.tolerance);
    let detail = why.or(end.detail.as_ref()).cloned();
    let detail = detail.unwrap_or_else(tolerance);
    Row {
        name: name.to_owned(),
        state: end.state.clone(),
        error: end.error.clone(),
        control_points: end.error.as_ref().map(|_| control_points(job, shape)),
        detail: (end.state != "converged").then_some(detail),
    }
}

/// The number of control points, in each direction.
fn control_points(job: &JobEvent, shape: Option<&Shape>) -> String {
    shape.map_or_else(|| each(&job.control_points), Shape::text)
}

/// A file that was written.
pub(super) fn tell_written(place: &str, bytes: u64) {
    say(format_args!(
        "wrote {place} ({})",
        bytesize::ByteSize(bytes)
    ));
}

fn distances(error: &Distances) -> String {
    let number =
        |it: Option<f64>| it.map_or_else(|| "infinite".to_owned(), |it| format!("{it:.3e}"));
    format!(
        ": error at most {}, rms {}",
        number(error.max),
        number(error.rms)
    )
}

fn time(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 1.0 => format!("{:.1} ms", 1000.0 * seconds),
        seconds => format!("{seconds:.2} s"),
    }
}

/// A value, or that of each direction where they differ.
fn each(value: &Value) -> String {
    let plain = |it: &Value| match it {
        Value::String(text) => text.clone(),
        it => it.to_string(),
    };
    match value.as_object() {
        None => plain(value),
        Some(each) => each.values().map(plain).collect::<Vec<_>>().join(" × "),
    }
}
