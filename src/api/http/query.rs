//! The query parameters of streams, iterations and results.

use serde::Deserialize;

use super::negotiate;
use crate::api::parse_uint::plain_number;
use crate::api::problem::Problem;
use crate::model::named::Named;
use crate::model::stream::choices::ChoiceError;
use crate::model::stream::options::{no_milestone, not_positive};
use crate::model::stream::{Choice, MOST_MILESTONES, Samples, StreamSpec, not_samples};
use piad_files::export::{ExportError, Format, Options, Origin, check_options};
use piad_files::text::quoted;

/// The parameters of a single iteration or a result.
pub(super) const OF_RESULTS: [&str; 11] = [
    "view", "samples", "encoding", "digits", "dots", "units", "style", "version", "spacing", "by",
    "origin",
];

/// The query of a single iteration or a result.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IterationQuery {
    view: Option<String>,
    samples: Option<String>,
    encoding: Option<String>,
    digits: Option<String>,
    dots: Option<String>,
    units: Option<String>,
    style: Option<String>,
    version: Option<String>,
    spacing: Option<String>,
    by: Option<String>,
    origin: Option<String>,
}

/// The spacing of samples along a curve: equal lengths.
const BY_LENGTH: &str = "length";

/// A distance between samples.
fn spacing(text: &str) -> Result<f64, Problem> {
    let wrong = || {
        let detail = format!(
            "{} is not a distance; expected a number such as 0.5",
            quoted(text)
        );
        Problem::at_parameter("spacing", detail)
    };
    text.parse().map_err(|_| wrong())
}

/// Latitude and longitude, such as 48.1,11.5.
fn origin(text: &str) -> Result<Origin, Problem> {
    let numbers = text.split_once(',').map(|(latitude, longitude)| {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        Some((number(latitude)?, number(longitude)?))
    });
    let Some(Some((latitude, longitude))) = numbers else {
        let detail = format!(
            "{} is not a latitude and longitude; expected degrees such as 48.1,11.5",
            quoted(text)
        );
        return Err(Problem::at_parameter("origin", detail));
    };
    Ok(Origin {
        longitude,
        latitude,
    })
}

/// The options of a file of this format, for a curve or a surface.
pub(crate) fn file_options(query: &str, format: Format, surface: bool) -> Result<Options, Problem> {
    let uri = format!("/?{query}").parse();
    let uri = uri.map_err(|_| Problem::at_parameter("origin", "it is no query"))?;
    let query: IterationQuery = negotiate::query(&uri)?;
    query.file_options(format, surface)
}

/// The query of a deviation.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeviationQuery {
    iteration: Option<String>,
    list: Option<String>,
}

/// The iteration to measure; `None` is the last one.
fn measured(iteration: Option<&str>) -> Result<Option<usize>, Problem> {
    match iteration {
        None | Some("last") => Ok(None),
        Some(text) => plain_number(text).map(Some).ok_or_else(|| {
            let detail = format!("{} is neither a number nor \"last\"", quoted(text));
            Problem::at_parameter("iteration", detail)
        }),
    }
}

/// The query of a shape.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShapeQuery {
    iteration: Option<String>,
    samples: Option<String>,
    spacing: Option<String>,
    by: Option<String>,
}

impl ShapeQuery {
    /// The iteration; `None` is the last one.
    pub(super) fn iteration(&self) -> Result<Option<usize>, Problem> {
        measured(self.iteration.as_deref())
    }

    /// The samples of a curve or a surface, which are those of a table.
    pub(super) fn samples(self, surface: bool) -> Result<Options, Problem> {
        let query = IterationQuery {
            samples: self.samples,
            spacing: self.spacing,
            by: self.by,
            ..IterationQuery::default()
        };
        query.file_options(Format::Csv, surface)
    }
}

impl DeviationQuery {
    /// The iteration (`None` is the last one), and true if each distance is listed.
    pub(super) fn choices(&self) -> Result<(Option<usize>, bool), Problem> {
        let iteration = measured(self.iteration.as_deref())?;
        let list = match self.list.as_deref() {
            None | Some("false") => false,
            Some("true") => true,
            Some(text) => {
                let detail = format!("{} is neither \"true\" nor \"false\"", quoted(text));
                return Err(Problem::at_parameter("list", detail));
            }
        };
        Ok((iteration, list))
    }
}

/// The parameters of an event stream.
pub(super) const OF_STREAMS: [&str; 11] = [
    "last_event_id",
    "view",
    "samples",
    "every",
    "milestones",
    "pace",
    "changed",
    "describe",
    "encoding",
    "digits",
    "on_disconnect",
];

/// The query of an event stream.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StreamQuery {
    /// For clients that cannot set the header.
    pub last_event_id: Option<String>,
    view: Option<String>,
    samples: Option<String>,
    every: Option<String>,
    milestones: Option<String>,
    pace: Option<String>,
    changed: Option<String>,
    describe: Option<String>,
    encoding: Option<String>,
    digits: Option<String>,
    on_disconnect: Option<String>,
}

impl IterationQuery {
    /// The choices of the query, checked for a curve or a surface.
    pub(super) fn spec(self, surface: bool) -> Result<StreamSpec, Problem> {
        let files = [
            ("dots", &self.dots),
            ("units", &self.units),
            ("style", &self.style),
            ("version", &self.version),
            ("spacing", &self.spacing),
            ("by", &self.by),
            ("origin", &self.origin),
        ];
        if let Some((name, _)) = files.iter().find(|(_, value)| value.is_some()) {
            let detail = "only allowed for files, not for JSON";
            return Err(Problem::at_parameter(*name, detail));
        }
        let query = StreamQuery {
            view: self.view,
            samples: self.samples,
            encoding: self.encoding,
            digits: self.digits,
            ..StreamQuery::default()
        };
        query.spec(surface)
    }

    /// The options of a file of this format; parameters that it does not have are refused.
    pub(super) fn file_options(&self, format: Format, surface: bool) -> Result<Options, Problem> {
        let json = [
            (Choice::View, &self.view),
            (Choice::Encoding, &self.encoding),
            (Choice::Digits, &self.digits),
        ];
        if let Some((choice, _)) = json.iter().find(|(_, value)| value.is_some()) {
            let detail = "only allowed for JSON, not for files";
            return Err(Problem::at_parameter(choice.name(), detail));
        }
        if self.dots.is_some() && !format.has_dots() {
            let detail = format!("it is about drawings (svg), and {format} files have no dots");
            return Err(Problem::at_parameter("dots", detail));
        }
        if self.units.is_some() && !format.has_unit() {
            let error = ExportError::NoUnit { format };
            return Err(Problem::at_parameter("units", error.to_string()));
        }
        if self.samples.is_some() && !format.has_samples() {
            let detail =
                format!("{format} files hold the exact curve or surface and have no samples");
            return Err(Problem::at_parameter(Choice::Samples.name(), detail));
        }
        let grid = |text: &String| {
            let grid = Samples::of_text(text).and_then(|samples| samples.grid(surface));
            grid.ok_or_else(|| wrong(Choice::Samples, not_samples(text, surface)))
        };
        let options = Options {
            samples: self.samples.as_ref().map(grid).transpose()?,
            dots: named("dots", &self.dots)?.unwrap_or_default(),
            unit: named("units", &self.units)?,
            style: named("style", &self.style)?.unwrap_or_default(),
            version: named("version", &self.version)?.unwrap_or_default(),
            spacing: self.spacing.as_deref().map(spacing).transpose()?,
            by_length: self.by.as_deref().is_some_and(|by| by == BY_LENGTH),
            origin: self.origin.as_deref().map(origin).transpose()?,
        };
        if let Some(by) = self.by.as_deref().filter(|by| *by != BY_LENGTH) {
            let detail = format!("unknown choice {}; expected {BY_LENGTH}", quoted(by));
            return Err(Problem::at_parameter("by", detail));
        }
        check_options(format, surface, &options).map_err(|error| {
            let option = error.option().unwrap_or("format");
            Problem::at_parameter(option, error.to_string())
        })?;
        Ok(options)
    }
}

impl StreamQuery {
    /// The name of the first parameter that is given, if there is one.
    pub(super) fn given(&self) -> Option<&'static str> {
        let parameters = [
            ("last_event_id", &self.last_event_id),
            ("view", &self.view),
            ("samples", &self.samples),
            ("every", &self.every),
            ("milestones", &self.milestones),
            ("pace", &self.pace),
            ("changed", &self.changed),
            ("describe", &self.describe),
            ("encoding", &self.encoding),
            ("digits", &self.digits),
            ("on_disconnect", &self.on_disconnect),
        ];
        let given = parameters.into_iter().find(|(_, text)| text.is_some());
        given.map(|(name, _)| name)
    }

    /// The choices of the query for a stream of a curve or a surface.
    pub(super) fn spec(&self, surface: bool) -> Result<StreamSpec, Problem> {
        let samples = |text: &str| {
            let samples = Samples::of_text(text);
            samples.ok_or_else(|| wrong(Choice::Samples, not_samples(text, surface)))
        };
        let every = |text: &str| {
            let every = plain_number(text).filter(|every| *every > 0);
            every.ok_or_else(|| wrong(Choice::Every, not_positive(text)))
        };
        let changed = |text: &str| match text {
            "false" => Ok(false),
            "true" => Ok(true),
            _ => {
                let detail = format!("unknown choice {}; expected false or true", quoted(text));
                Err(wrong(Choice::Changed, detail))
            }
        };
        let text = |text: &'_ Option<String>| text.clone();
        Ok(StreamSpec {
            view: named("view", &self.view)?,
            samples: text(&self.samples).as_deref().map(samples).transpose()?,
            every: text(&self.every).as_deref().map(every).transpose()?,
            milestones: self.milestones.as_deref().map(milestones).transpose()?,
            pace: named("pace", &self.pace)?,
            changed: self.changed.as_deref().map(changed).transpose()?,
            describe: named("describe", &self.describe)?,
            encoding: named("encoding", &self.encoding)?,
            digits: named("digits", &self.digits)?,
            on_disconnect: named("on_disconnect", &self.on_disconnect)?,
        })
    }
}

fn wrong(choice: Choice, detail: impl Into<String>) -> Problem {
    ChoiceError::of_request(choice, detail).into()
}

/// The value that a parameter names.
fn named<T: Named>(parameter: &str, text: &Option<String>) -> Result<Option<T>, Problem> {
    let value = |text: &String| {
        T::of_name(text).ok_or_else(|| {
            let names = T::names().join(", ");
            let detail = format!("unknown choice {}; expected one of {names}", quoted(text));
            Problem::at_parameter(parameter, detail)
        })
    };
    text.as_ref().map(value).transpose()
}

/// Numbers separated by commas; an empty text is an empty list.
fn milestones(text: &str) -> Result<Vec<f64>, Problem> {
    let texts = text.split(',').filter(|_| !text.is_empty());
    if texts.clone().count() > MOST_MILESTONES {
        let detail = format!("there are more than {MOST_MILESTONES}");
        return Err(wrong(Choice::Milestones, detail));
    }
    let milestones = texts.map(|text| {
        let milestone = text.parse();
        milestone.map_err(|_| wrong(Choice::Milestones, no_milestone(text)))
    });
    milestones.collect()
}
