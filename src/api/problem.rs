//! Errors as problem objects (RFC 9457, `application/problem+json`).

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::request_id::REQUEST_ID;
use super::short;
use crate::job::scheduler::Broken;
use crate::job::service::Refused;
use crate::job::state::Failure;
use crate::job::store::StoreError;
use crate::job::store::blame::MOST_CRASHES;

/// The kinds of problems. Their `type` is `/problems/{slug}`, where a server explains them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is described in `catalogue`")]
pub enum Kind {
    NotJson,
    NotProtobuf,
    InvalidRequest,
    InvalidFit,
    NotFound,
    UnknownJob,
    NoSuchIteration,
    NoResult,
    NoLimit,
    NoExport,
    UnknownHost,
    MethodNotAllowed,
    NotAcceptable,
    BodyTimeout,
    AlreadyEnded,
    BodyTooLarge,
    UnsupportedMediaType,
    UnsupportedEncoding,
    KeyTaken,
    QueueFull,
    Busy,
    TooManyJobs,
    TooManyConnections,
    StoreFull,
    Stopping,
    Overflow,
    Internal,
}

/// The entry of a kind in the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The last part of `type`.
    pub slug: &'static str,
    /// The status of answers with this problem.
    pub status: StatusCode,
    /// What it is called.
    pub title: &'static str,
    /// What it means and what to do about it.
    pub meaning: &'static str,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 27] = [
        Self::NotJson,
        Self::NotProtobuf,
        Self::InvalidRequest,
        Self::InvalidFit,
        Self::NotFound,
        Self::UnknownJob,
        Self::NoSuchIteration,
        Self::NoResult,
        Self::NoLimit,
        Self::NoExport,
        Self::UnknownHost,
        Self::MethodNotAllowed,
        Self::NotAcceptable,
        Self::BodyTimeout,
        Self::AlreadyEnded,
        Self::BodyTooLarge,
        Self::UnsupportedMediaType,
        Self::UnsupportedEncoding,
        Self::KeyTaken,
        Self::QueueFull,
        Self::Busy,
        Self::TooManyJobs,
        Self::TooManyConnections,
        Self::StoreFull,
        Self::Stopping,
        Self::Overflow,
        Self::Internal,
    ];

    /// What this kind means.
    pub fn entry(self) -> Entry {
        let (slug, status, title, meaning) = self.catalogue();
        Entry {
            slug,
            status,
            title,
            meaning,
        }
    }

    fn catalogue(self) -> (&'static str, StatusCode, &'static str, &'static str) {
        use StatusCode as S;
        match self {
            Self::NotJson => (
                "not-json",
                S::BAD_REQUEST,
                "The body is not JSON",
                "The body could not be read as JSON; detail names line and column. JSON has no NaN and no Infinity.",
            ),
            Self::NotProtobuf => (
                "not-protobuf",
                S::BAD_REQUEST,
                "The body is not the protobuf message that is expected",
                "The body could not be read as a message of piad.v1 (proto/piad/v1/fitting.proto): it is cut off, or has fields of other types.",
            ),
            Self::InvalidRequest => (
                "invalid-request",
                S::BAD_REQUEST,
                "The request is malformed",
                "A query parameter or a header is unknown or has a value that cannot be understood; errors names it.",
            ),
            Self::InvalidFit => (
                "invalid-fit",
                S::UNPROCESSABLE_ENTITY,
                "The job is not a fit that can be computed",
                "The body can be read, but is not a fitting problem; each entry of errors points at the value that is wrong and says why.",
            ),
            Self::NotFound => (
                "not-found",
                S::NOT_FOUND,
                "There is no such resource",
                "The path is not one of this API.",
            ),
            Self::UnknownJob => (
                "unknown-job",
                S::NOT_FOUND,
                "There is no such job",
                "The job never existed, was deleted, or ended so long ago that it was forgotten (see limits in /v1/capabilities).",
            ),
            Self::NoSuchIteration => (
                "no-such-iteration",
                S::NOT_FOUND,
                "The job has no such iteration",
                "The job ended before it reached this iteration.",
            ),
            Self::NoResult => (
                "no-result",
                S::CONFLICT,
                "The job has no result",
                "The job has not ended yet, or it ended without any geometry.",
            ),
            Self::NoLimit => (
                "no-limit",
                S::CONFLICT,
                "The job has no limit to be computed",
                "The closed form of the limit is for local fits that adjust not too many points.",
            ),
            Self::NoExport => (
                "no-export",
                S::CONFLICT,
                "The curve or surface cannot be written in this format",
                "The format cannot say what was fitted; detail tells why and what to do instead.",
            ),
            Self::UnknownHost => (
                "unknown-host",
                S::MISDIRECTED_REQUEST,
                "The request is meant for another server",
                "The Host of the request (in HTTP/2, its authority) is not a name of this server. A server on a loopback address is localhost, so that no page of the web reaches it under a name of its own; it is told further names with --allowed-host.",
            ),
            Self::MethodNotAllowed => (
                "method-not-allowed",
                S::METHOD_NOT_ALLOWED,
                "The resource does not understand this method",
                "The Allow header names the methods that it understands.",
            ),
            Self::NotAcceptable => (
                "not-acceptable",
                S::NOT_ACCEPTABLE,
                "The resource has no such representation",
                "The Accept header allows none of the media types that the resource has; detail names them.",
            ),
            Self::BodyTimeout => (
                "body-timeout",
                S::REQUEST_TIMEOUT,
                "The body did not arrive",
                "The client paused for too long while it sent the body.",
            ),
            Self::AlreadyEnded => (
                "already-ended",
                S::CONFLICT,
                "The job has already ended",
                "A job that has ended cannot be cancelled.",
            ),
            Self::BodyTooLarge => (
                "body-too-large",
                S::PAYLOAD_TOO_LARGE,
                "The body is too large",
                "The body is larger than this server accepts (see limits in /v1/capabilities).",
            ),
            Self::UnsupportedMediaType => (
                "unsupported-media-type",
                S::UNSUPPORTED_MEDIA_TYPE,
                "The body has a media type that is not understood",
                "Jobs are sent as application/json or application/x-protobuf.",
            ),
            Self::UnsupportedEncoding => (
                "unsupported-encoding",
                S::UNSUPPORTED_MEDIA_TYPE,
                "The body is compressed",
                "Bodies are sent as they are, without Content-Encoding.",
            ),
            Self::KeyTaken => (
                "key-taken",
                S::UNPROCESSABLE_ENTITY,
                "The idempotency key belongs to another request",
                "The same Idempotency-Key was sent with another body, or for another resource, within the last day; every request needs a key of its own.",
            ),
            Self::StoreFull => (
                "store-full",
                S::SERVICE_UNAVAILABLE,
                "The server has no room to keep the job",
                "The disk of the server is full. No job is lost; send the request again after the number of seconds in Retry-After, or delete jobs.",
            ),
            Self::QueueFull => (
                "queue-full",
                S::SERVICE_UNAVAILABLE,
                "The server has as many jobs as it takes",
                "Send the job again after the number of seconds in Retry-After.",
            ),
            Self::Busy => (
                "busy",
                S::SERVICE_UNAVAILABLE,
                "The server has no memory for the request just now",
                "Send the request again after the number of seconds in Retry-After.",
            ),
            Self::TooManyJobs => (
                "too-many-jobs",
                S::TOO_MANY_REQUESTS,
                "You have as many jobs as one client may have",
                "So many jobs from one address may be unfinished (jobs_per_peer among the limits in /v1/capabilities). Send the job again after the number of seconds in Retry-After.",
            ),
            Self::TooManyConnections => (
                "too-many-connections",
                S::SERVICE_UNAVAILABLE,
                "The server has as many connections as it takes",
                "So many connections may be open, in all and from one address. Send requests over those that are open, or again after the number of seconds in Retry-After.",
            ),
            Self::Stopping => (
                "stopping",
                S::SERVICE_UNAVAILABLE,
                "The server is stopping",
                "The server takes no new work; send the request again after the number of seconds in Retry-After.",
            ),
            Self::Overflow => (
                "overflow",
                S::UNPROCESSABLE_ENTITY,
                "The fit left the range of numbers",
                "Distances grew beyond 1e150 times the size of the data, or beyond 1.8e308. Either the iteration diverges, as the extended method does on long curves, where its intermediate errors are astronomic: choose another method. Or the data are too large: scale them down.",
            ),
            Self::Internal => (
                "internal",
                S::INTERNAL_SERVER_ERROR,
                "The server made a mistake",
                "A defect of the server or of its store. Other jobs are not affected; please report it with the request_id.",
            ),
        }
    }
}

/// One thing that is wrong.
#[derive(Clone, Debug, Serialize)]
pub struct FieldError {
    /// JSON pointer (RFC 6901) into the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// A query parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<String>,
    /// A header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header: Option<&'static str>,
    /// A field of a protobuf message, such as `curve.points[34]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// Why it is wrong.
    pub detail: String,
}

/// The most characters of a detail. What clients have written is repeated in part already; this is
/// for what nobody has thought of.
const LONGEST_DETAIL: usize = 1000;

/// The most characters of a place.
const LONGEST_PLACE: usize = 300;

impl FieldError {
    /// What is wrong, wherever that is.
    fn new(detail: &str) -> Self {
        Self {
            pointer: None,
            parameter: None,
            header: None,
            field: None,
            detail: short::cut(detail, LONGEST_DETAIL).into_owned(),
        }
    }

    /// Where and what.
    fn told(&self) -> String {
        let detail = &self.detail;
        match (&self.pointer, &self.parameter, self.header, &self.field) {
            (Some(pointer), ..) if pointer.is_empty() => format!("/: {detail}"),
            (Some(pointer), ..) => format!("{pointer}: {detail}"),
            (_, Some(name), ..) => format!("query parameter {name}: {detail}"),
            (_, _, Some(name), _) => format!("header {name}: {detail}"),
            (.., Some(field)) if !field.is_empty() => format!("{field}: {detail}"),
            _ => detail.clone(),
        }
    }
}

/// A problem object.
#[derive(Clone, Debug)]
pub struct Problem {
    kind: Kind,
    detail: String,
    errors: Vec<FieldError>,
    retry_after: Option<u32>,
}

/// The JSON of a problem object.
#[derive(Serialize)]
struct ProblemBody<'a> {
    r#type: String,
    title: &'static str,
    status: u16,
    detail: &'a str,
    #[serde(skip_serializing_if = "<[FieldError]>::is_empty")]
    errors: &'a [FieldError],
    #[serde(skip_serializing_if = "Option::is_none")]
    request_id: Option<&'a str>,
}

impl Problem {
    /// A problem that is not about a particular field.
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self {
            kind,
            detail: short::cut(&detail, LONGEST_DETAIL).into_owned(),
            errors: Vec::new(),
            retry_after: None,
        }
    }

    /// A problem with a value in the body.
    pub fn at_pointer(kind: Kind, pointer: String, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        let pointer = short::cut(&pointer, LONGEST_PLACE).into_owned();
        let place = if pointer.is_empty() { "/" } else { &pointer };
        let mut problem = Self::new(kind, format!("{place}: {detail}"));
        problem.errors.push(FieldError {
            pointer: Some(pointer),
            ..FieldError::new(&detail)
        });
        problem
    }

    /// One problem of several, of which the first says what kind it is; none of none.
    pub fn of_all(problems: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut problems = problems.into_iter();
        let mut all = problems.next()?;
        let mut details = vec![std::mem::take(&mut all.detail)];
        for problem in problems {
            all.errors.extend(problem.errors);
            details.push(problem.detail);
        }
        all.detail = short::cut(&details.join("; "), LONGEST_DETAIL).into_owned();
        Some(all)
    }

    /// A problem with a query parameter.
    pub fn at_parameter(name: impl Into<String>, detail: impl Into<String>) -> Self {
        let (name, detail) = (name.into(), detail.into());
        let name = short::cut(&name, LONGEST_PLACE).into_owned();
        let mut problem = Self::new(
            Kind::InvalidRequest,
            format!("query parameter {name}: {detail}"),
        );
        problem.errors.push(FieldError {
            parameter: Some(name),
            ..FieldError::new(&detail)
        });
        problem
    }

    /// A problem with a field of a message, of which the path is told.
    pub fn at_field(field: impl Into<String>, detail: impl Into<String>) -> Self {
        let mut problem = Self::at_pointer(Kind::InvalidFit, String::new(), detail);
        let field = field.into();
        problem.name_fields(|_| Some(field.clone()));
        problem
    }

    /// Says of errors which field of a message they are about, where `name` knows it, instead of
    /// where it would be in JSON or in a query.
    pub fn name_fields(&mut self, name: impl Fn(&FieldError) -> Option<String>) {
        let mut named = false;
        for error in &mut self.errors {
            if let Some(field) = name(error) {
                error.field = Some(field);
                (error.pointer, error.parameter) = (None, None);
                named = true;
            }
        }
        if named {
            let told = self.errors.iter().map(FieldError::told);
            let told = told.collect::<Vec<_>>().join("; ");
            self.detail = short::cut(&told, LONGEST_DETAIL).into_owned();
        }
    }

    /// The same with paths of fields that start further up, at a message with this field.
    pub fn within(mut self, parent: &str) -> Self {
        self.name_fields(|error| match error.field.as_deref()? {
            "" => Some(parent.to_owned()),
            field => Some(format!("{parent}.{field}")),
        });
        self
    }

    /// The kind.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// What is wrong.
    pub fn detail(&self) -> &str {
        &self.detail
    }

    /// The single things that are wrong.
    pub fn errors(&self) -> &[FieldError] {
        &self.errors
    }

    /// After how many seconds to try again.
    pub fn retry(&self) -> Option<u32> {
        self.retry_after
    }

    /// A problem with a header.
    pub fn at_header(name: &'static str, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        let mut problem = Self::new(Kind::InvalidRequest, format!("header {name}: {detail}"));
        problem.errors.push(FieldError {
            header: Some(name),
            ..FieldError::new(&detail)
        });
        problem
    }

    /// The job does not exist.
    pub fn unknown_job(id: &str) -> Self {
        Self::new(
            Kind::UnknownJob,
            format!("there is no job {}", short::quoted(id)),
        )
    }

    /// The same problem, to be tried again after so many seconds.
    pub fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }

    /// The object as JSON.
    pub fn to_json(&self, request_id: Option<&str>) -> serde_json::Value {
        let Entry {
            slug,
            status,
            title,
            ..
        } = self.kind.entry();
        serde_json::json!(ProblemBody {
            r#type: format!("/problems/{slug}"),
            title,
            status: status.as_u16(),
            detail: &self.detail,
            errors: &self.errors,
            request_id,
        })
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Overflow => Self::new(
                Kind::Overflow,
                "the distances from the data have left the range of numbers: the iteration has diverged, or the data are too large",
            ),
            Failure::Crashes => Self::new(
                Kind::Internal,
                format!(
                    "the server has crashed at least {MOST_CRASHES} times while this job was running; it is not tried again"
                ),
            ),
            Failure::Defect => Self::new(Kind::Internal, "the computation broke down"),
        }
    }
}

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let detail = refused.to_string();
        match refused {
            Refused::Full { .. } => Self::new(Kind::QueueFull, detail).retry_after(5),
            Refused::PeerFull { .. } => Self::new(Kind::TooManyJobs, detail).retry_after(5),
            Refused::TooLarge { .. } | Refused::TooMuchWork { .. } => {
                Self::at_pointer(Kind::InvalidFit, String::new(), detail)
            }
            Refused::KeyTaken(_) => Self::new(Kind::KeyTaken, detail),
            Refused::Store(error) => error.into(),
        }
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        let detail = error.to_string();
        match error {
            StoreError::Gone(id) => Self::unknown_job(&id.to_string()),
            StoreError::Full(_) => Self::new(Kind::StoreFull, detail).retry_after(60),
            StoreError::Failed(_) | StoreError::Broken(_) => Self::new(Kind::Internal, detail),
        }
    }
}

impl From<Broken> for Problem {
    fn from(broken: Broken) -> Self {
        Self::new(Kind::Internal, broken.to_string())
    }
}

impl IntoResponse for Problem {
    /// The problem travels as an extension; [`render`] writes it, with the id of the request.
    fn into_response(self) -> Response {
        let mut response = self.kind.entry().status.into_response();
        let headers = response.headers_mut();
        if self.kind == Kind::UnsupportedEncoding {
            // What would be understood (RFC 9110, 15.5.16).
            headers.insert(
                header::ACCEPT_ENCODING,
                HeaderValue::from_static("identity"),
            );
        }
        if let Some(seconds) = self.retry_after {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response.extensions_mut().insert(self);
        response
    }
}

/// Writes problems as JSON and names the request in every answer.
pub async fn render(request: Request, next: Next) -> Response {
    let id = request.headers().get(REQUEST_ID).cloned();
    let mut response = next.run(request).await;
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        let text = id.as_ref().and_then(|id| id.to_str().ok());
        let json = problem.to_json(text).to_string();
        *response.body_mut() = Body::from(json);
        let headers = response.headers_mut();
        headers.insert(
            header::CONTENT_TYPE,
            HeaderValue::from_static("application/problem+json"),
        );
        headers.remove(header::CONTENT_LENGTH);
    }
    if let Some(id) = id {
        response.headers_mut().insert(REQUEST_ID, id);
    }
    response
}
