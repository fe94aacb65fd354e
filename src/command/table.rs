//! The report of many fits: a table with a line for each, and totals.

use super::failure::Failure;
use crate::api::batch::part_file::Distances;
use crate::terminal::say;

/// The most lines of a table.
const MOST_ROWS: usize = 20;

/// The widest name in a table; longer ones are cut.
const WIDEST: usize = 40;

/// A fit that has ended.
#[derive(Debug)]
pub(super) struct Row {
    /// The name of the fit.
    pub name: String,
    /// The final state, such as `converged`.
    pub state: String,
    /// The distances from the data; `None` if there is no result.
    pub error: Option<Distances>,
    /// The number of control points, in each direction.
    pub control_points: Option<String>,
    /// Why it has not converged.
    pub detail: Option<String>,
}

impl Row {
    /// An input that could not be fitted.
    pub(super) fn failed(name: String, failure: &Failure) -> Self {
        Self {
            name,
            state: "failed".to_owned(),
            error: None,
            control_points: None,
            detail: Some(failure.to_string()),
        }
    }

    /// Returns true if the fit has converged.
    pub(super) fn is_good(&self) -> bool {
        self.state == "converged"
    }

    /// The same as one of many files: the names of its parts contain the name of the file.
    pub(super) fn within(mut self, file: &str) -> Self {
        if self.name != file {
            self.name = format!("{file}: {}", self.name);
        }
        self
    }

    fn error(&self) -> String {
        let max = self.error.as_ref().and_then(|error| error.max);
        max.map_or_else(|| "-".to_owned(), |max| format!("{max:.3e}"))
    }

    fn control_points(&self) -> &str {
        self.control_points.as_deref().unwrap_or("-")
    }

    fn shown_name(&self) -> String {
        match self.name.chars().count() > WIDEST {
            true => self.name.chars().take(WIDEST - 1).chain(['…']).collect(),
            false => self.name.clone(),
        }
    }
}

/// Reports fits, or with `--quiet` only those that did not converge.
pub(super) fn report(what: &str, rows: &[Row], quiet: bool) {
    match quiet {
        true => report_bad(rows),
        false => report_all(what, rows),
    }
}

/// Reports all fits: those that did not converge come first, with the reason.
fn report_all(what: &str, rows: &[Row]) {
    let (good, bad): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| row.is_good());
    let shown: Vec<&Row> = bad.iter().chain(&good).take(MOST_ROWS).copied().collect();
    let width = |text: fn(&Row) -> usize| shown.iter().map(|row| text(row)).max().unwrap_or(0);
    let names = width(|row| row.shown_name().chars().count());
    let counts = width(|row| row.control_points().chars().count());
    for row in &shown {
        let why = row.detail.as_ref().map(|why| format!(": {why}"));
        say(format_args!(
            "{:names$}  {:>counts$} control points, error at most {}, {}{}",
            row.shown_name(),
            row.control_points(),
            row.error(),
            row.state,
            why.unwrap_or_default()
        ));
    }
    if shown.len() < rows.len() {
        say(format_args!("… and {} more", rows.len() - shown.len()));
    }
    say(format_args!(
        "{what}: {} converged, {} did not",
        good.len(),
        bad.len()
    ));
}

/// Reports the fits that did not converge.
pub(super) fn report_bad(rows: &[Row]) {
    for row in rows.iter().filter(|row| !row.is_good()) {
        let why = row
            .detail
            .as_deref()
            .unwrap_or("the tolerance is not reached");
        let error = row.error.as_ref();
        let error = error.map(|_| format!(", error at most {}", row.error()));
        let error = error.unwrap_or_default();
        say(format_args!("{}: {}{error}: {why}", row.name, row.state));
    }
}
