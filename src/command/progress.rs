//! Progress of a running fit: a bar on terminals, lines elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::events::{IterationEvent, JobEvent};
use crate::terminal::say;

/// The time between lines.
const PAUSE: Duration = Duration::from_secs(2);

/// The kind of progress output.
pub(super) enum Progress {
    /// Nothing.
    Silent,
    /// A bar, with the number of the last iteration at its right end.
    Bar(ProgressBar),
    /// A line now and then.
    Lines {
        /// When the last one was printed.
        printed: Option<Instant>,
        /// The expected number of iterations, if it is known.
        total: Option<usize>,
    },
}

impl Progress {
    /// Nothing with `--quiet`, a bar if the standard error is a terminal.
    pub(super) fn new(quiet: bool) -> Self {
        if quiet {
            return Self::Silent;
        }
        if !std::io::stderr().is_terminal() {
            return Self::Lines {
                printed: None,
                total: None,
            };
        }
        let bar = ProgressBar::no_length().with_message("reading");
        // One line: what does not fit on a narrow terminal is cut off at its end.
        let style = ProgressStyle::with_template(
            "{bar:12} {pos}/{len}, {elapsed} so far, {eta} left, {wide_msg}",
        );
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self::Bar(bar)
    }

    /// The progress of this many fits.
    pub(super) fn of_many(quiet: bool, count: usize) -> Self {
        let mut progress = Self::new(quiet);
        match &mut progress {
            Self::Silent => {}
            Self::Bar(bar) => bar.set_length(count as u64),
            Self::Lines { total, .. } => *total = Some(count),
        }
        progress
    }

    /// The progress of the parts of a file, whose number is known at the end.
    pub(super) fn of_parts(quiet: bool) -> Self {
        let progress = Self::new(quiet);
        if let Self::Bar(bar) = &progress {
            let style = ProgressStyle::with_template("{pos} parts, {elapsed} so far, {wide_msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        }
        progress
    }

    /// Shows the fit with this index and name.
    pub(super) fn item(&mut self, index: usize, name: &str) {
        match self {
            Self::Silent => {}
            Self::Bar(bar) => {
                bar.set_message(name.to_owned());
                bar.set_position(index as u64);
            }
            Self::Lines { total, .. } => {
                let of = total.map_or_else(String::new, |total| format!(" of {total}"));
                if self.is_due() {
                    say(format_args!("{}{of}: {name}", index + 1));
                }
            }
        }
    }

    /// Returns true if it is time for another line.
    fn is_due(&mut self) -> bool {
        let Self::Lines { printed, .. } = self else {
            return false;
        };
        let due = printed.is_none_or(|printed| printed.elapsed() >= PAUSE);
        if due {
            *printed = Some(Instant::now());
        }
        due
    }

    /// The job has begun.
    pub(super) fn begin(&mut self, job: &JobEvent) {
        let most = job.stop.max_iterations;
        let expected = job.predicted.iterations.map(|it| it.min(most));
        match self {
            Self::Silent => {}
            Self::Bar(bar) => bar.set_length(expected.unwrap_or(most) as u64),
            Self::Lines { total, .. } => *total = expected,
        }
    }

    /// An iteration has been computed.
    pub(super) fn step(&mut self, level: &IterationEvent) {
        match self {
            Self::Silent => {}
            Self::Bar(bar) => {
                let position = level.iteration as u64;
                let expected = level.predicted.map(|it| it as u64).or(bar.length());
                bar.set_length(expected.unwrap_or(position).max(position));
                bar.set_message(distances(level));
                bar.set_position(position);
            }
            Self::Lines { total, .. } => {
                let expected = level.predicted.or(*total);
                if !self.is_due() {
                    return;
                }
                let of = expected.map_or_else(String::new, |it| format!(" of about {it}"));
                say(format_args!(
                    "iteration {}{of}: {}",
                    level.iteration,
                    distances(level)
                ));
            }
        }
    }

    /// The job has ended.
    pub(super) fn end(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn distances(level: &IterationEvent) -> String {
    let max = level.error.max;
    let max = max.map_or_else(|| "infinite".to_owned(), |max| format!("{max:.2e}"));
    let rate = level.rate.map(|rate| format!(", factor {rate:.3}"));
    format!("largest error {max}{}", rate.unwrap_or_default())
}
