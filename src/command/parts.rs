//! A file with several parts: a fit of each, all in one request, and one file with all of them.

use axum::body::Body;
use jiff::Timestamp;
use serde::Deserialize;
use serde_json::Value;
use serde_json::value::RawValue;

use super::client::Client;
use super::events::{Distances, Why};
use super::failure::Failure;
use super::file_query::FileQuery;
use super::input::Input;
use super::lines::Lines;
use super::options::Asked;
use super::outputs::{self, Output, OutputFormat, Place};
use super::part_geometry::Geometry;
use super::progress::Progress;
use super::request::Request;
use super::summary;
use super::table::{self, Row};
use crate::config::fit_arguments::FitArguments;
use piad_files::export::{Header, Part, write_parts};

/// A line of the answer: a part, or the end.
#[derive(Debug, Deserialize)]
struct Line<'a> {
    index: Option<usize>,
    name: Option<String>,
    #[serde(default)]
    state: String,
    error: Option<Distances>,
    #[serde(borrow)]
    curve: Option<&'a RawValue>,
    #[serde(borrow)]
    surface: Option<&'a RawValue>,
    problem: Option<Why>,
    totals: Option<Value>,
}

/// What has come of all parts.
#[derive(Debug, Default)]
struct Fits {
    /// The lines of the answer, as JSON.
    lines: Vec<Box<str>>,
    rows: Vec<Row>,
    /// The geometry of each part that has one.
    geometries: Vec<(String, Geometry)>,
}

/// What is done with the parts of a file.
pub(super) struct Parts<'a> {
    pub(super) arguments: &'a FitArguments,
    pub(super) outputs: &'a [Output],
    pub(super) query: &'a FileQuery,
    pub(super) quiet: bool,
}

impl Parts<'_> {
    /// Fits and writes all parts of an input.
    pub(super) async fn fit(
        self,
        client: &Client,
        input: &Input,
        asked: &Asked,
    ) -> Result<Vec<Row>, Failure> {
        check(self.arguments)?;
        let Request {
            path,
            media_type,
            body,
        } = Request::of_parts(input, asked)?;
        let answer = client.post(&path, media_type, body).await?;
        let answer = answer.map_err(|refusal| refusal.of_fit(input, asked))?;
        let progress = Progress::of_parts(self.quiet);
        let fits = follow(Lines::new(answer), &input.name, progress).await?;
        let what = format!("{}: {} parts", input.name, fits.rows.len());
        table::tell_all(&what, &fits.rows, self.quiet);
        for output in self.outputs {
            let bytes = fits.write(output, self.query)?;
            let count = outputs::write(&output.place, Body::from(bytes)).await?;
            if !self.quiet && output.place != Place::Standard {
                summary::tell_written(&output.place.to_string(), count);
            }
        }
        Ok(fits.rows)
    }
}

/// Refuses what is about one curve.
fn check(arguments: &FitArguments) -> Result<(), Failure> {
    for (flag, is_given) in [
        ("--plot", arguments.plot.is_some()),
        ("--iterations", arguments.iterations.is_some()),
    ] {
        if is_given {
            let detail = "the file has several parts, and this is about one: say which (--part 1)";
            return Err(Failure::usage(format!("{flag}: {detail}")));
        }
    }
    Ok(())
}

/// Reads the answer to its end.
async fn follow(mut lines: Lines, name: &str, mut progress: Progress) -> Result<Fits, Failure> {
    let mut fits = Fits::default();
    let broken = |reason: String| Failure::Failed(format!("the answer broke off: {reason}"));
    loop {
        let line = lines.next().await.map_err(broken)?;
        let line = line.ok_or_else(|| broken("it ended too early".to_owned()))?;
        let text = String::from_utf8_lossy(&line);
        let read: Line<'_> = serde_json::from_str(&text).map_err(|reason| {
            Failure::Failed(format!("a line of the answer is not understood: {reason}"))
        })?;
        let Some(index) = read.index else {
            progress.end();
            return match (read.totals, read.problem) {
                (None, Some(why)) => Err(Failure::Failed(why.detail)),
                _ => Ok(fits),
            };
        };
        let part = read
            .name
            .clone()
            .unwrap_or_else(|| format!("part {}", index + 1));
        progress.item(index, &part);
        fits.add(read, part, name)?;
        fits.lines.push(text.trim_end().into());
    }
}

impl Fits {
    fn add(&mut self, line: Line<'_>, part: String, input: &str) -> Result<(), Failure> {
        let geometry = line.curve.or(line.surface).map(|raw| {
            Geometry::read(raw.get()).map_err(|reason| {
                Failure::Failed(format!(
                    "{input}: {part}: the result is not understood: {reason}"
                ))
            })
        });
        let geometry = geometry.transpose()?;
        self.rows.push(Row {
            name: part.clone(),
            state: line.state,
            error: line.error,
            control_points: geometry.as_ref().map(Geometry::counts),
            detail: line.problem.map(|why| why.detail),
        });
        self.geometries.extend(geometry.map(|it| (part, it)));
        Ok(())
    }

    /// All parts that have a result, as one file.
    fn write(&self, output: &Output, query: &FileQuery) -> Result<Vec<u8>, Failure> {
        let OutputFormat::File(format) = output.format else {
            return Ok(format!("{{\"items\":[\n{}\n]}}\n", self.lines.join(",\n")).into_bytes());
        };
        let failed =
            |reason: &dyn std::fmt::Display| Failure::Failed(format!("{}: {reason}", output.place));
        let mut parts = Vec::with_capacity(self.geometries.len());
        for (name, geometry) in &self.geometries {
            let nurbs = geometry.nurbs();
            parts.push(Part {
                name: Some(name.as_str()),
                nurbs: nurbs.map_err(|reason| failed(&format!("{name}: {reason}")))?,
            });
        }
        let surface = parts.iter().any(|part| part.nurbs.v.is_some());
        let options = query
            .options(format, surface)
            .map_err(|reason| failed(&reason))?;
        let header = Header::new(Timestamp::now(), options);
        write_parts(format, &parts, &header).map_err(|reason| failed(&reason))
    }
}
