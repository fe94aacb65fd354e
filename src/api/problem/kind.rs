//! The kinds of problems, in one table.

use axum::http::StatusCode;
use tonic::Code;

/// The documentation of a kind of problem.
#[derive(Debug)]
pub struct Entry {
    /// The last part of `type`.
    pub slug: &'static str,
    /// The HTTP status of answers with this problem.
    pub status: StatusCode,
    /// The gRPC status code of calls that fail with it.
    pub code: Code,
    /// Its title.
    pub title: &'static str,
    /// Its meaning, and what to do about it.
    pub meaning: &'static str,
}

/// Declares the kinds: name, then slug, HTTP status, gRPC code, title and meaning.
macro_rules! kinds {
    ($($kind:ident { $slug:literal, $status:ident, $code:ident, $title:literal, $meaning:literal })+) => {
        /// The kinds of problems. Their `type` is `/problems/{slug}`, where a server explains them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kind {
            $(#[doc = $title] $kind,)+
        }

        impl Kind {
            /// All kinds, in the order of the table.
            pub const ALL: [Self; ENTRIES.len()] = [$(Self::$kind),+];
        }

        const ENTRIES: &[Entry] = &[$(Entry {
            slug: $slug,
            status: StatusCode::$status,
            code: Code::$code,
            title: $title,
            meaning: $meaning,
        }),+];
    };
}

kinds! {
    // The content of the body.
    NotJson {
        "not-json", BAD_REQUEST, InvalidArgument,
        "The body is not JSON",
        "The body could not be read as JSON; detail names line and column. JSON has no NaN and no Infinity."
    }
    NotProtobuf {
        "not-protobuf", BAD_REQUEST, InvalidArgument,
        "The body is not the protobuf message that is expected",
        "The body could not be read as a message of piad.v1 (proto/piad/v1/fitting.proto): it is cut off, or has fields of other types."
    }
    InvalidRequest {
        "invalid-request", BAD_REQUEST, InvalidArgument,
        "The request is malformed",
        "A query parameter or a header is unknown or has a value that cannot be understood; errors names it."
    }
    InvalidFit {
        "invalid-fit", UNPROCESSABLE_ENTITY, InvalidArgument,
        "The job is not a fit that can be computed",
        "The body can be read, but is not a fitting problem; each entry of errors points at the value that is wrong and says why."
    }
    // Jobs and other resources.
    NotFound {
        "not-found", NOT_FOUND, NotFound,
        "There is no such resource",
        "The path is not one of this API."
    }
    UnknownJob {
        "unknown-job", NOT_FOUND, NotFound,
        "There is no such job",
        "The job never existed, was deleted, or ended so long ago that it was forgotten (see limits in /v1/capabilities)."
    }
    NoSuchIteration {
        "no-such-iteration", NOT_FOUND, NotFound,
        "The job has no such iteration",
        "The job ended before it reached this iteration."
    }
    NotReached {
        "not-reached", SERVICE_UNAVAILABLE, Unavailable,
        "The job has not come to this iteration yet",
        "An iteration that a job has not reached is waited for as long as `Prefer: wait` says, or 10 seconds; detail reports how far the job is. Ask again after the number of seconds in Retry-After."
    }
    NoResult {
        "no-result", CONFLICT, FailedPrecondition,
        "The job has no result",
        "The job has not ended yet, or it ended without any geometry."
    }
    NotConverged {
        "not-converged", UNPROCESSABLE_ENTITY, FailedPrecondition,
        "The fit has not come within its tolerance",
        "POST /v1/fit answers with fits that converge; detail reports how near this one came. Ask for a larger tolerance, more iterations or control points, or make a job, whose result is available in any state."
    }
    NoLimit {
        "no-limit", CONFLICT, FailedPrecondition,
        "The job has no limit to be computed",
        "The closed form of the limit is for local fits that adjust not too many points."
    }
    NoDeviation {
        "no-deviation", CONFLICT, FailedPrecondition,
        "The curve or surface has no nearest points",
        "Nearest points are found on curves up to degree 64 and surfaces up to degree 32 in the plane or in space, with positive weights; detail reports what is in the way."
    }
    NoShape {
        "no-shape", CONFLICT, FailedPrecondition,
        "The curve or surface has no shape that can be measured",
        "Curvature, length and area are those of curves and surfaces of two or more coordinates with positive weights; detail reports what is in the way."
    }
    NoExport {
        "no-export", CONFLICT, FailedPrecondition,
        "The curve or surface cannot be written in this format",
        "The format cannot represent what was fitted; detail gives the reason and an alternative."
    }
    NoTickets {
        "no-tickets", CONFLICT, FailedPrecondition,
        "The server has no tickets",
        "It requires no tokens, and its streams can be opened without tickets."
    }
    // How the request is sent.
    UnknownHost {
        "unknown-host", MISDIRECTED_REQUEST, NotFound,
        "The request is meant for another server",
        "The Host of the request (in HTTP/2, its authority) is not a name of this server. A server on a loopback address is localhost, so that no page of the web reaches it under a name of its own; --allowed-host adds further names."
    }
    Unauthenticated {
        "unauthenticated", UNAUTHORIZED, Unauthenticated,
        "The request has no valid token",
        "This server requires a token: Authorization: Bearer piad_…, in HTTP and in the metadata of gRPC; or, for the streams of browsers, a ticket of POST /v1/jobs/{id}/tickets in the query. The token may have been revoked or have expired: the operator of the server makes another one with piad token create."
    }
    Forbidden {
        "forbidden", FORBIDDEN, PermissionDenied,
        "The token lacks a scope",
        "detail names the scope that is needed: jobs:read, jobs:write or metrics; metrics:all stands for metrics, and admin for all of them."
    }
    MethodNotAllowed {
        "method-not-allowed", METHOD_NOT_ALLOWED, Unimplemented,
        "The resource does not support this method",
        "The Allow header names the methods that it supports."
    }
    NotAcceptable {
        "not-acceptable", NOT_ACCEPTABLE, InvalidArgument,
        "The resource has no such representation",
        "The Accept header allows none of the media types that the resource has; detail names them."
    }
    BodyTimeout {
        "body-timeout", REQUEST_TIMEOUT, DeadlineExceeded,
        "The body did not arrive",
        "The client paused for too long while it sent the body."
    }
    AlreadyEnded {
        "already-ended", CONFLICT, FailedPrecondition,
        "The job has already ended",
        "A job that has ended cannot be cancelled."
    }
    BodyTooLarge {
        "body-too-large", PAYLOAD_TOO_LARGE, ResourceExhausted,
        "The body is too large",
        "The body is larger than this server accepts (see limits in /v1/capabilities)."
    }
    UnsupportedMediaType {
        "unsupported-media-type", UNSUPPORTED_MEDIA_TYPE, InvalidArgument,
        "The body has a media type that is not understood",
        "Jobs are sent as application/json or application/x-protobuf."
    }
    UnsupportedEncoding {
        "unsupported-encoding", UNSUPPORTED_MEDIA_TYPE, InvalidArgument,
        "The body is compressed in a way that is not understood",
        "Bodies are sent as they are, or with Content-Encoding gzip or zstd."
    }
    KeyTaken {
        "key-taken", UNPROCESSABLE_ENTITY, InvalidArgument,
        "The idempotency key belongs to another request",
        "The same Idempotency-Key was sent with another body, or for another resource, within the last day; every request needs a key of its own."
    }
    // Limits of the server.
    QueueFull {
        "queue-full", SERVICE_UNAVAILABLE, ResourceExhausted,
        "The server has reached its limit of jobs",
        "Send the job again after the number of seconds in Retry-After."
    }
    Busy {
        "busy", SERVICE_UNAVAILABLE, ResourceExhausted,
        "The server has no memory for the request just now",
        "Send the request again after the number of seconds in Retry-After."
    }
    TooManyJobs {
        "too-many-jobs", TOO_MANY_REQUESTS, ResourceExhausted,
        "You have reached the limit of jobs for one client",
        "The number of unfinished jobs of one address, or of one tenant where the server requires tokens, is limited (jobs_per_peer among the limits in /v1/capabilities; unless that is set, at most half of what other addresses leave). Send the job again after the number of seconds in Retry-After."
    }
    QuotaExceeded {
        "quota-exceeded", TOO_MANY_REQUESTS, ResourceExhausted,
        "The tenant would exceed its quota",
        "Unfinished jobs, their points, bytes of jobs that are kept and open streams of a tenant may be limited; detail says which. Send the request again after the number of seconds in Retry-After, when jobs or streams have ended, or delete jobs to free bytes. Without Retry-After the request alone is beyond the quota."
    }
    TooManyConnections {
        "too-many-connections", SERVICE_UNAVAILABLE, Unavailable,
        "The server has reached its limit of connections",
        "The number of open connections is limited, in all and for one address; and over HTTP/2, or through a trusted proxy, also the number of requests of one address. Send the request again over a connection that is open, when others have been answered, or after the number of seconds in Retry-After."
    }
    StoreFull {
        "store-full", SERVICE_UNAVAILABLE, ResourceExhausted,
        "The server has no space to store the job",
        "The disk of the server is full. No job is lost; send the request again after the number of seconds in Retry-After, or delete jobs."
    }
    StoreAway {
        "store-away", SERVICE_UNAVAILABLE, Unavailable,
        "The store of the server cannot be used now",
        "The database cannot be reached, or the file of the jobs was moved away. No job is lost, and streams continue as far as possible. Send the request again after the number of seconds in Retry-After; one that makes a job with its Idempotency-Key, as it may have been stored."
    }
    TokensUnreadable {
        "tokens-unreadable", SERVICE_UNAVAILABLE, Unavailable,
        "The server cannot read its tokens file",
        "Only /readyz answers with it. The tokens before stay in use, and those that were revoked since are still accepted. Mend the file, its owner or its permissions: the server reads it again within two seconds."
    }
    Stopping {
        "stopping", SERVICE_UNAVAILABLE, Unavailable,
        "The server is stopping",
        "The server takes no new work; send the request again after the number of seconds in Retry-After."
    }
    // Failures.
    Overflow {
        "overflow", UNPROCESSABLE_ENTITY, FailedPrecondition,
        "The fit left the range of numbers",
        "Distances grew beyond 1e150 times the size of the data, or beyond 1.8e308. Either the iteration diverges, as the extended method does on long curves, where its intermediate errors are astronomic: choose another method. Or the data are too large: scale them down."
    }
    Internal {
        "internal", INTERNAL_SERVER_ERROR, Internal,
        "Internal server error",
        "A bug in the server, or a failure of its store. Other jobs are not affected; please report it with the request_id."
    }
}

impl Kind {
    /// The documentation of this kind.
    pub fn entry(self) -> &'static Entry {
        &ENTRIES[self as usize]
    }

    /// The `type` of problems of this kind, where a server explains it.
    pub fn path(self) -> String {
        format!("/problems/{}", self.entry().slug)
    }
}
