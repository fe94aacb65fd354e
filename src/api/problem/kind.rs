//! The kinds of problems.

use axum::http::StatusCode;

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
    /// The `type` of problems of this kind, where a server explains it.
    pub fn path(self) -> String {
        format!("/problems/{}", self.entry().slug)
    }

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
