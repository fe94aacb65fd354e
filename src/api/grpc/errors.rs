//! Problems as gRPC statuses, with details of `google.rpc`.

use std::collections::HashMap;
use std::time::Duration;

use tonic::Status;
use tonic_types::{ErrorDetails, FieldViolation, StatusExt};

use crate::api::problem::{Location, Problem};
use crate::job::service::refused::Refused;
use crate::job::store::StoreError;

/// The domain in which reasons of errors are defined.
const DOMAIN: &str = "piad";

/// The most bytes of details: they are sent in a header, and clients accept 8 kB of headers.
const MOST_DETAILS: usize = 3000;

impl From<Problem> for Status {
    fn from(problem: Problem) -> Self {
        let entry = problem.kind().entry();
        let reason = entry.slug.replace('-', "_").to_uppercase();
        let mut details = ErrorDetails::new();
        details.set_error_info(reason, DOMAIN, HashMap::new());
        let mut room = MOST_DETAILS;
        let violations: Vec<_> = problem
            .errors()
            .iter()
            .filter_map(|error| match &error.place {
                Location::Field(field) => Some(FieldViolation::new(field, &error.detail)),
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
        Self::with_error_details(entry.code, problem.detail(), details)
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
