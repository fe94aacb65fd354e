//! Errors: problem objects (RFC 9457) in HTTP, statuses in gRPC.
//!
//! - [`kind`]: the kinds of problems, and what to do about them; [`field_error`]: errors of single fields;
//! - `causes`: errors of lower layers as problems.

mod causes;
mod field_error;
mod kind;

use schemars::JsonSchema;
use serde::Serialize;

use super::json::view::examples;
use crate::api::json::plain::never_null;
use crate::model::errors::{self as model, ValidationErrors};
use field_error::LONGEST_DETAIL;
pub(super) use field_error::{FieldError, Location};
pub(super) use kind::Kind;
use piad_files::text;

/// Locations of the parts of a request in an encoding.
pub trait Locator {
    /// The location of a part, as a text.
    fn of(&self, place: model::SpecPart) -> String;

    /// The kind of location that the text is.
    fn place(&self, text: String) -> Location;
}

/// A problem object.
#[derive(Clone, Debug)]
pub struct Problem {
    kind: Kind,
    detail: String,
    errors: Vec<FieldError>,
    retry_after: Option<u32>,
}

/// An error (RFC 9457).
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "Problem", example = examples::problem())]
pub struct ProblemBody {
    /// The kind of problem; the server explains it there.
    #[schemars(extend("enum" = Kind::ALL.map(Kind::path).to_vec()))]
    r#type: String,
    /// The title of the kind.
    title: &'static str,
    /// The status of the answer.
    #[schemars(range(min = 400, max = 599))]
    status: u16,
    /// The error, for people.
    detail: String,
    /// The errors of single fields.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<FieldError>,
    /// The id of the request, as in X-Request-Id.
    #[serde(skip_serializing_if = "Option::is_none")]
    request_id: Option<String>,
    /// The id of the trace of the request, as in traceresponse, if the server exports traces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace_id: Option<String>,
}

impl Problem {
    /// A problem that is not about a particular field.
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self {
            kind,
            detail: text::cut(&detail, LONGEST_DETAIL).into_owned(),
            errors: Vec::new(),
            retry_after: None,
        }
    }

    /// A problem at a location.
    fn at(kind: Kind, place: Location, detail: &str) -> Self {
        let error = FieldError::new(place, detail);
        let mut problem = Self::new(kind, error.description());
        problem.errors.push(error);
        problem
    }

    /// A problem with a value in the body.
    pub fn at_pointer(kind: Kind, pointer: String, detail: impl Into<String>) -> Self {
        Self::at(kind, Location::Pointer(pointer), &detail.into())
    }

    /// One problem of several, of the kind of the first; `None` if there are none.
    pub fn of_all(problems: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut problems = problems.into_iter();
        let mut all = problems.next()?;
        let mut details = vec![std::mem::take(&mut all.detail)];
        for problem in problems {
            all.errors.extend(problem.errors);
            details.push(problem.detail);
        }
        all.detail = text::cut(&details.join("; "), LONGEST_DETAIL).into_owned();
        Some(all)
    }

    /// A problem with a line of a file of points.
    pub fn at_line(line: usize, detail: &str) -> Self {
        Self::at(Kind::InvalidFit, Location::Line(line), detail)
    }

    /// A problem with a file that a query parameter does not fit, or that needs one.
    pub fn of_hint(name: &str, detail: &str) -> Self {
        Self::at(
            Kind::InvalidFit,
            Location::Parameter(name.to_owned()),
            detail,
        )
    }

    /// A problem with a query parameter.
    pub fn at_parameter(name: impl Into<String>, detail: impl Into<String>) -> Self {
        let place = Location::Parameter(name.into());
        Self::at(Kind::InvalidRequest, place, &detail.into())
    }

    /// A problem with a field of a message, located by its path.
    pub fn at_field(field: impl Into<String>, detail: impl Into<String>) -> Self {
        Self::at(
            Kind::InvalidFit,
            Location::Field(field.into()),
            &detail.into(),
        )
    }

    /// All errors of a job or an edit, located in the encoding of the request.
    pub fn of_errors(errors: ValidationErrors, locator: &impl Locator) -> Self {
        let problems = errors.into_iter().map(|error| {
            let text = match error.location {
                model::Location::Part(place) => locator.of(place),
                model::Location::Text(text) => text,
            };
            Self::at(Kind::InvalidFit, locator.place(text), &error.detail)
        });
        let unsaid = || Self::new(Kind::InvalidFit, "the request is not understood");
        Self::of_all(problems).unwrap_or_else(unsaid)
    }

    /// The same with field paths that start further up, at a message with this field.
    pub fn within(mut self, parent: &str) -> Self {
        let mut named = false;
        for error in &mut self.errors {
            if let Location::Field(field) = &mut error.place {
                let dot = if field.is_empty() { "" } else { "." };
                *field = format!("{parent}{dot}{field}");
                named = true;
            }
        }
        if named {
            self.detail = self.description();
        }
        self
    }

    /// The same with other locations.
    pub fn relocated(mut self, place: impl Fn(Location) -> Location) -> Self {
        for error in &mut self.errors {
            error.place = place(error.place.clone());
        }
        if !self.errors.is_empty() {
            self.detail = self.description();
        }
        self
    }

    /// All errors, with their locations.
    fn description(&self) -> String {
        let description = self.errors.iter().map(FieldError::description);
        let description = description.collect::<Vec<_>>().join("; ");
        text::cut(&description, LONGEST_DETAIL).into_owned()
    }

    /// The kind.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The error.
    pub fn detail(&self) -> &str {
        &self.detail
    }

    /// The errors of single fields.
    pub fn errors(&self) -> &[FieldError] {
        &self.errors
    }

    /// The seconds after which to retry.
    pub fn retry(&self) -> Option<u32> {
        self.retry_after
    }

    /// A problem with a header.
    pub fn at_header(name: &'static str, detail: impl Into<String>) -> Self {
        Self::at(Kind::InvalidRequest, Location::Header(name), &detail.into())
    }

    /// The job does not exist.
    pub fn unknown_job(id: &str) -> Self {
        Self::new(
            Kind::UnknownJob,
            format!("there is no job {}", text::quoted(id)),
        )
    }

    /// The same problem, with a `Retry-After` of this many seconds.
    pub fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }

    /// The object in the form of answers.
    pub fn body(&self, request_id: Option<&str>) -> ProblemBody {
        let entry = self.kind.entry();
        ProblemBody {
            r#type: self.kind.path(),
            title: entry.title,
            status: entry.status.as_u16(),
            detail: self.detail.clone(),
            errors: self.errors.clone(),
            request_id: request_id.map(str::to_owned),
            trace_id: None,
        }
    }
}
