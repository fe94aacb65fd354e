//! A file with several parts: a fit of each, all in one request, and one file with all of them.

use std::collections::HashSet;

use axum::body::Body;

use super::client::Client;
use super::failure::Failure;
use super::file_query::FileQuery;
use super::input::{Content, Input};
use super::options::JobOptions;
use super::outputs::{self, Output, OutputFormat, Place};
use super::progress::Progress;
use super::request::Request;
use super::summary;
use super::table::{self, Row};
use crate::api::batch::geometry::Geometry;
use crate::api::batch::part_file::{BatchLine, PartFile};
use crate::config::fit_arguments::FitArguments;
use crate::lines::Lines;
use crate::terminal::say;

/// The results of all parts.
#[derive(Debug, Default)]
struct Fits {
    /// The lines of the answer, as JSON.
    lines: Vec<Box<str>>,
    rows: Vec<Row>,
    /// Notices about the file. Most are about all of it, and are in each line.
    notices: Vec<String>,
    known: HashSet<String>,
    /// The parts that have a result.
    file: PartFile,
}

/// The actions for the parts of a file.
pub(super) struct Parts<'a> {
    pub(super) arguments: &'a FitArguments,
    pub(super) outputs: &'a [Output],
    pub(super) query: &'a FileQuery,
    /// True if the file is one of many, which are reported together.
    pub(super) is_one_of_many: bool,
}

impl Parts<'_> {
    /// Fits and writes all parts of an input, which this request has.
    pub(super) async fn fit(
        self,
        client: &Client,
        input: &Input,
        options: &JobOptions,
        request: Request,
    ) -> Result<Vec<Row>, Failure> {
        check(self.arguments, input)?;
        let Request {
            path,
            media_type,
            body,
        } = request;
        let answer = client.post(&path, media_type, body).await?;
        let answer = answer.map_err(|refusal| refusal.of_fit(input, options))?;
        let progress = Progress::of_parts(self.is_quiet());
        let fits = follow(Lines::new(answer), &input.name, progress).await?;
        if fits.rows.is_empty() {
            return Err(Failure::usage(format!(
                "{}: there is nothing to fit",
                input.name
            )));
        }
        if !self.is_one_of_many {
            self.report(input, &fits);
        }
        for output in self.outputs {
            let bytes = fits.write(output, self.query)?;
            let count = outputs::write(&output.place, Body::from(bytes)).await?;
            if !self.is_quiet() && output.place != Place::Standard {
                summary::tell_written(&output.place.to_string(), count);
            }
        }
        Ok(fits.rows)
    }

    fn is_quiet(&self) -> bool {
        self.arguments.quiet || self.is_one_of_many
    }

    /// Reports the notices about the file, and the results of its parts.
    fn report(&self, input: &Input, fits: &Fits) {
        if !self.arguments.quiet {
            for notice in &fits.notices {
                say(format_args!("{}: {notice}", input.name));
            }
        }
        let what = format!("{}: {} parts", input.name, fits.rows.len());
        table::report(&what, &fits.rows, self.arguments.quiet);
    }
}

/// Refuses options of a single curve.
fn check(arguments: &FitArguments, input: &Input) -> Result<(), Failure> {
    let detail = match input.content {
        Content::Batch => {
            "the batch has several fits, and this is about one: make it a file of its own"
        }
        _ => "the file has several parts, and this is about one: say which (--part 1)",
    };
    for (flag, is_given) in [
        ("--plot", arguments.plot.is_some()),
        ("--shape", arguments.shape.is_some()),
        ("--iterations", arguments.iterations.is_some()),
    ] {
        if is_given {
            return Err(Failure::usage(format!("{flag}: {detail}")));
        }
    }
    Ok(())
}

/// Reads the answer to its end.
async fn follow(mut lines: Lines, name: &str, mut progress: Progress) -> Result<Fits, Failure> {
    let mut fits = Fits::default();
    let not_understood = |reason: serde_json::Error| {
        Failure::Failed(format!(
            "{name}: a line of the answer is not understood: {reason}"
        ))
    };
    let broken = |reason: String| Failure::Failed(format!("the answer was interrupted: {reason}"));
    loop {
        let line = lines.next().await.map_err(broken)?;
        let line = line.ok_or_else(|| broken("it ended too early".to_owned()))?;
        let text = String::from_utf8_lossy(&line);
        let read: BatchLine<'_> = serde_json::from_str(&text).map_err(not_understood)?;
        let Some(index) = read.index else {
            progress.end();
            return match (read.totals, read.problem) {
                (None, Some(why)) => Err(Failure::Failed(why.detail)),
                _ => Ok(fits),
            };
        };
        let part = read.title();
        progress.item(index, &part);
        fits.add(read, part).map_err(not_understood)?;
        fits.lines.push(text.trim_end().into());
    }
}

impl Fits {
    fn add(&mut self, line: BatchLine<'_>, part: String) -> serde_json::Result<()> {
        let geometry = line.geometry()?;
        for notice in line.notices {
            if self.known.insert(notice.clone()) {
                self.notices.push(notice);
            }
        }
        self.rows.push(Row {
            name: part.clone(),
            state: line.state,
            error: line.error,
            control_points: geometry.as_ref().map(Geometry::counts),
            detail: line.problem.map(|why| why.detail),
        });
        if let Some(geometry) = geometry {
            self.file.add(part, geometry);
        }
        Ok(())
    }

    /// All parts that have a result, as one file.
    fn write(&self, output: &Output, query: &FileQuery) -> Result<Vec<u8>, Failure> {
        let OutputFormat::File(format) = output.format else {
            return Ok(format!("{{\"items\":[\n{}\n]}}\n", self.lines.join(",\n")).into_bytes());
        };
        let failed = |reason: String| Failure::Failed(format!("{}: {reason}", output.place));
        let options = query
            .options(format, self.file.has_surface())
            .map_err(failed)?;
        self.file.write(format, options).map_err(failed)
    }
}
