//! Problems as gRPC statuses, with details of `google.rpc`.

use std::collections::HashMap;
use std::time::Duration;

use tonic::{Code, Status};
use tonic_types::{ErrorDetails, FieldViolation, StatusExt};

use crate::api::problem::{Kind, Place, Problem};
use crate::job::service::refused::Refused;
use crate::job::store::StoreError;

/// Who says what the reason of an error means.
const DOMAIN: &str = "piad";

/// The most bytes of details: they travel in a header, of which clients take 8 kB.
const MOST_DETAILS: usize = 3000;

/// The code of a kind of problem.
fn code(kind: Kind) -> Code {
    match kind {
        Kind::NotJson
        | Kind::NotProtobuf
        | Kind::InvalidRequest
        | Kind::InvalidFit
        | Kind::NotAcceptable
        | Kind::UnsupportedMediaType
        | Kind::UnsupportedEncoding
        | Kind::KeyTaken => Code::InvalidArgument,
        Kind::NotFound | Kind::UnknownHost | Kind::UnknownJob | Kind::NoSuchIteration => {
            Code::NotFound
        }
        Kind::NoResult | Kind::NoLimit | Kind::NoExport | Kind::AlreadyEnded | Kind::Overflow => {
            Code::FailedPrecondition
        }
        Kind::BodyTooLarge | Kind::QueueFull | Kind::Busy | Kind::TooManyJobs | Kind::StoreFull => {
            Code::ResourceExhausted
        }
        Kind::BodyTimeout => Code::DeadlineExceeded,
        Kind::MethodNotAllowed => Code::Unimplemented,
        Kind::Stopping | Kind::TooManyConnections => Code::Unavailable,
        Kind::Internal => Code::Internal,
    }
}

impl From<Problem> for Status {
    fn from(problem: Problem) -> Self {
        let kind = problem.kind();
        let reason = kind.entry().slug.replace('-', "_").to_uppercase();
        let mut details = ErrorDetails::new();
        details.set_error_info(reason, DOMAIN, HashMap::new());
        let mut room = MOST_DETAILS;
        let violations: Vec<_> = problem
            .errors()
            .iter()
            .filter_map(|error| match &error.place {
                Place::Field(field) => Some(FieldViolation::new(field, &error.detail)),
                _ => None,
            })
            .take_while(|violation| {
                let length = violation.field.len() + violation.description.len();
                let fits = length <= room;
                room = room.saturating_sub(length);
                fits
            })
            .collect();
        if !violations.is_empty() {
            details.set_bad_request(violations);
        }
        if let Some(seconds) = problem.retry() {
            details.set_retry_info(Some(Duration::from_secs(seconds.into())));
        }
        Self::with_error_details(code(kind), problem.detail(), details)
    }
}

impl From<Refused> for Status {
    fn from(refused: Refused) -> Self {
        Problem::from(refused).into()
    }
}

impl From<StoreError> for Status {
    fn from(error: StoreError) -> Self {
        Problem::from(error).into()
    }
}
