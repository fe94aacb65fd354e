//! What to show of a fit, and how a stream goes: parameters of the query, or the `stream` object
//! of a job with the defaults of all its streams.
//!
//! - [`form`]: the form of a level: view, encoding, digits;
//! - [`object`]: the `stream` object;
//! - `given`: who has chosen what, and which choices do not go together.

pub mod form;
mod given;
pub mod object;

use serde::Deserialize;

use crate::api::language::Framing;
use crate::api::problem::Problem;
use crate::api::short::quoted;
use crate::api::whole::plain_number;
use crate::fit::points::Grid;
use crate::fit::problem as fit;
use form::{Digits, Encoding, Form, View};
use given::{Conflict, Given, Sources};
use object::StreamObject;

/// What clients that are slower than the fit can get.
pub const PACES: [&str; 2] = ["all", "latest"];

/// What can become of a job when a client of its stream goes away.
pub const DISCONNECTS: [&str; 2] = ["continue", "cancel"];

/// The most milestones of a stream.
pub const MOST_MILESTONES: usize = 100;

/// The query of a single iteration or a result.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewParameters {
    /// `json`, or a file format.
    pub format: Option<String>,
    view: Option<String>,
    samples: Option<String>,
    encoding: Option<String>,
    digits: Option<String>,
}

/// The parameters of event streams, as they are written in a query.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreamParameters {
    /// For clients that cannot set the header.
    pub last_event_id: Option<String>,
    view: Option<String>,
    samples: Option<String>,
    every: Option<String>,
    milestones: Option<String>,
    pace: Option<String>,
    changed: Option<String>,
    encoding: Option<String>,
    digits: Option<String>,
    on_disconnect: Option<String>,
}

/// How a stream goes.
#[derive(Clone, Debug)]
pub struct StreamOptions {
    /// What each event shows.
    pub form: Form,
    /// What events show instead once the client has complete control points.
    pub changes: Option<Form>,
    /// Only iterations that are multiples of this, and the last.
    pub every: usize,
    /// Only the first iteration whose largest distance is within each of these, which decrease.
    pub milestones: Vec<f64>,
    /// A slow client skips to the newest iteration.
    pub latest: bool,
    /// The job ends with this stream.
    pub cancels: bool,
}

impl ViewParameters {
    /// How many samples a file should have; what is about JSON is refused.
    pub fn samples_of_file(&self, surface: bool) -> Result<Option<Grid>, Problem> {
        let json = [
            ("view", &self.view),
            ("encoding", &self.encoding),
            ("digits", &self.digits),
        ];
        if let Some((name, _)) = json.iter().find(|(_, value)| value.is_some()) {
            return Err(Problem::at_parameter(
                *name,
                "it is about JSON, not about files",
            ));
        }
        let parameters = StreamParameters {
            samples: self.samples.clone(),
            ..StreamParameters::default()
        };
        let job = StreamParameters::default();
        let given = Sources::new(&parameters, &job).get("samples");
        given
            .map(|given| form::sample_grid(given, surface))
            .transpose()
    }
}

impl From<ViewParameters> for StreamParameters {
    fn from(parameters: ViewParameters) -> Self {
        Self {
            view: parameters.view,
            samples: parameters.samples,
            encoding: parameters.encoding,
            digits: parameters.digits,
            ..Self::default()
        }
    }
}

impl StreamParameters {
    /// The names of those that the `stream` object of a job has, too.
    pub const NAMES: [&'static str; 9] = [
        "view",
        "samples",
        "every",
        "milestones",
        "pace",
        "changed",
        "encoding",
        "digits",
        "on_disconnect",
    ];

    /// The name of a parameter that is given, if there is one.
    pub fn given(&self) -> Option<&'static str> {
        let id = self.last_event_id.as_ref().map(|_| "last_event_id");
        id.or_else(|| {
            let mut names = Self::NAMES.into_iter();
            names.find(|name| self.get(name).is_some())
        })
    }

    fn get(&self, name: &str) -> Option<&str> {
        let value = match name {
            "view" => &self.view,
            "samples" => &self.samples,
            "every" => &self.every,
            "milestones" => &self.milestones,
            "pace" => &self.pace,
            "changed" => &self.changed,
            "encoding" => &self.encoding,
            "digits" => &self.digits,
            "on_disconnect" => &self.on_disconnect,
            _ => &None,
        };
        value.as_deref()
    }

    /// The form of a single level of a curve or a surface.
    pub fn form(&self, surface: bool) -> Result<Form, Problem> {
        let job = Self::default();
        form(Sources::new(self, &job), surface)
    }

    /// Checks that numbers of 32 bits, where they are asked for, have room for the data.
    pub fn check_range(
        &self,
        job: Option<&StreamObject>,
        problem: &fit::Problem,
    ) -> Result<(), Problem> {
        let job = job.map(StreamObject::parameters).unwrap_or_default();
        form::check_range(Sources::new(self, &job).get("encoding"), problem)
    }

    /// The options of a stream that is framed like this.
    pub fn framed(
        &self,
        framing: Framing,
        job: Option<&StreamObject>,
        surface: bool,
    ) -> Result<StreamOptions, Problem> {
        if framing != Framing::Protobuf {
            return self.options(job, surface);
        }
        self.refuse_numbers()?;
        // How numbers are written in JSON is of no interest, whatever the job says of it.
        let parameters = Self {
            encoding: Some("json".to_owned()),
            digits: Some("full".to_owned()),
            ..self.clone()
        };
        let options = parameters.options(job, surface)?;
        Ok(StreamOptions {
            form: options.form.in_protobuf(),
            changes: options.changes.map(|form| form.in_protobuf()),
            ..options
        })
    }

    /// The options of a stream of a job that another request has made: it shows the job, and does
    /// not end it, whatever the job says of its own stream.
    pub fn of_reader(
        &self,
        framing: Framing,
        job: Option<&StreamObject>,
        surface: bool,
    ) -> Result<StreamOptions, Problem> {
        let options = self.framed(framing, job, surface)?;
        if options.cancels && self.on_disconnect.is_some() {
            let detail = "only the stream that is the answer to the request for the job can end it";
            return Err(Problem::at_parameter("on_disconnect", detail));
        }
        Ok(StreamOptions {
            cancels: false,
            ..options
        })
    }

    /// The form of a single level of a curve or a surface as a protobuf message.
    pub fn message_form(&self, surface: bool) -> Result<Form, Problem> {
        self.refuse_numbers()?;
        Ok(self.form(surface)?.in_protobuf())
    }

    /// Messages have no choice of how numbers are written.
    fn refuse_numbers(&self) -> Result<(), Problem> {
        for (name, given) in [("encoding", &self.encoding), ("digits", &self.digits)] {
            if given.is_some() {
                let detail = "it is about numbers in JSON; protobuf messages have all 64 bits";
                return Err(Problem::at_parameter(name, detail));
            }
        }
        Ok(())
    }

    /// The options of a stream of a curve or a surface. Where the query says nothing, the stream
    /// goes as the `stream` object of its job says.
    pub fn options(
        &self,
        job: Option<&StreamObject>,
        surface: bool,
    ) -> Result<StreamOptions, Problem> {
        let job = job.map(StreamObject::parameters).unwrap_or_default();
        let sources = Sources::new(self, &job);
        let form = form(sources, surface)?;
        let yes_or_no = |name, no, yes| match sources.get(name) {
            None => Ok(false),
            Some(given) => given.one_of(&[(no, false), (yes, true)]),
        };
        let changed = yes_or_no("changed", "false", "true")?;
        let options = StreamOptions {
            changes: changed.then(|| Form::new(View::Changed, form.encoding, form.digits)),
            form,
            every: sources.get("every").map_or(Ok(1), every)?,
            milestones: match sources.get("milestones") {
                None => Vec::new(),
                Some(given) => milestones(given)?,
            },
            latest: yes_or_no("pace", "all", "latest")?,
            cancels: yes_or_no("on_disconnect", "continue", "cancel")?,
        };
        options.check(sources)?;
        Ok(options)
    }
}

impl StreamOptions {
    /// Refuses what does not go together.
    fn check(&self, sources: Sources<'_>) -> Result<(), Problem> {
        const COMPLETE: &str =
            "what has changed is said from each iteration to the next, so none may be left out";
        let changed = self.changes.is_some();
        let some = self.every > 1;
        let chosen = !self.milestones.is_empty();
        let Form {
            view,
            encoding,
            digits,
            ..
        } = self.form;
        sources.refuse(&[
            (
                changed && view != View::ControlPoints,
                "changed",
                "view",
                "it is about control points",
            ),
            (
                changed && encoding != Encoding::Json,
                "changed",
                "encoding",
                "indices with their points are no array of numbers",
            ),
            (
                changed && digits != Digits::Full,
                "changed",
                "digits",
                "a point that stays would keep the coarser rounding of an earlier iteration",
            ),
            (changed && some, "changed", "every", COMPLETE),
            (changed && chosen, "changed", "milestones", COMPLETE),
            (changed && self.latest, "changed", "pace", COMPLETE),
            (
                chosen && some,
                "milestones",
                "every",
                "milestones choose the iterations themselves",
            ),
            (
                chosen && self.latest,
                "milestones",
                "pace",
                "the first iteration to reach a milestone may not be skipped",
            ),
        ])
    }
}

/// View, encoding and digits.
fn form(sources: Sources<'_>, surface: bool) -> Result<Form, Problem> {
    let view = form::view(sources.get("view"), sources.get("samples"), surface)?;
    let encoding = form::encoding(sources.get("encoding"))?;
    let digits = form::digits(sources.get("digits"))?;
    let errors = view == View::Errors;
    let binary = encoding != Encoding::Json;
    let rounded = digits == Digits::Auto;
    let conflicts: [Conflict; 3] = [
        (
            errors && binary,
            "encoding",
            "view",
            "there are no arrays of numbers without geometry",
        ),
        (
            errors && rounded,
            "digits",
            "view",
            "there are no coordinates to be rounded without geometry",
        ),
        (
            binary && rounded,
            "digits",
            "encoding",
            "rounding makes decimal numbers shorter, but not binary ones",
        ),
    ];
    sources.refuse(&conflicts)?;
    Ok(Form::new(view, encoding, digits))
}

fn every(given: Given<'_>) -> Result<usize, Problem> {
    plain_number(given.text)
        .filter(|every| *every > 0)
        .ok_or_else(|| {
            given.problem(format!(
                "{} is no positive whole number",
                quoted(given.text)
            ))
        })
}

/// Numbers between commas; none at all if the text is empty.
fn milestones(given: Given<'_>) -> Result<Vec<f64>, Problem> {
    let mut milestones: Vec<f64> = Vec::new();
    for (index, text) in given.text.split(',').enumerate() {
        if given.text.is_empty() {
            break;
        }
        if index == MOST_MILESTONES {
            return Err(given.problem(format!("there are more than {MOST_MILESTONES}")));
        }
        let wrong = |detail| Err(given.problem_at(index, detail));
        let milestone = text.parse().ok();
        let Some(milestone) = milestone.filter(|x: &f64| *x > 0.0 && x.is_finite()) else {
            return wrong(format!("{} is no positive finite number", quoted(text)));
        };
        if let Some(before) = milestones.last().filter(|before| **before <= milestone) {
            return wrong(format!(
                "milestones decrease, and {milestone} does not lie below {before}"
            ));
        }
        milestones.push(milestone);
    }
    Ok(milestones)
}
