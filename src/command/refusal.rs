//! Errors of a request in the terms of the command line: flags, files and lines.

use axum::http::StatusCode;
use serde::Deserialize;

use super::failure::Failure;
use super::input::{Content, Input};
use super::options::JobOptions;
use super::pointer;
use crate::api::json::request::file::{PART, SIZE};

/// The used fields of a problem object.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Refusal {
    /// The status of the answer.
    #[serde(skip)]
    pub status: StatusCode,
    /// The error.
    #[serde(default)]
    pub detail: String,
    #[serde(default)]
    errors: Vec<ValidationError>,
}

#[derive(Debug, Deserialize)]
struct ValidationError {
    pointer: Option<String>,
    parameter: Option<String>,
    line: Option<usize>,
    detail: String,
}

impl Refusal {
    /// Reads the answer of a server.
    pub(super) fn read(status: StatusCode, body: &[u8]) -> Self {
        let read: Option<Self> = serde_json::from_slice(body).ok();
        let mut refusal = read.unwrap_or_default();
        refusal.status = status;
        if refusal.detail.is_empty() {
            refusal.detail = format!("the server answers {status}");
        }
        refusal
    }

    /// Returns true if a file has several parts, or not the requested one.
    pub(super) fn wants_part(&self) -> bool {
        let is_part = |error: &ValidationError| error.parameter.as_deref() == Some(PART);
        self.errors.iter().any(is_part)
    }

    /// The failure of a refused fit.
    pub(super) fn of_fit(self, input: &Input, options: &JobOptions) -> Failure {
        let about_the_request = matches!(
            self.status,
            StatusCode::BAD_REQUEST
                | StatusCode::PAYLOAD_TOO_LARGE
                | StatusCode::UNSUPPORTED_MEDIA_TYPE
                | StatusCode::UNPROCESSABLE_ENTITY
        );
        if !about_the_request {
            return Failure::Failed(self.detail);
        }
        if self.errors.is_empty() {
            return Failure::usage(format!("{}: {}", input.name, self.detail));
        }
        let message = self.errors.iter().map(|it| it.message(input, options));
        Failure::Usage(message.collect())
    }
}

impl ValidationError {
    fn message(&self, input: &Input, options: &JobOptions) -> String {
        let (name, detail) = (&input.name, &self.detail);
        if let Some(line) = self.line {
            return format!("{name}:{line}: {detail}");
        }
        if let Some(parameter) = &self.parameter {
            let flag = options.flag(parameter);
            return format!("{}: {detail}", flag.unwrap_or(parameter));
        }
        let Some(pointer) = &self.pointer else {
            return format!("{name}: {detail}");
        };
        let path = pointer.trim_start_matches('/').replace('/', ".");
        if let Some(flag) = options.flag(&path) {
            return format!("{flag}: {detail}");
        }
        match input.content {
            Content::Points => format!("{name}: {detail}"),
            Content::Job | Content::Batch => {
                let line = pointer::line(&input.bytes, pointer);
                format!("{name}:{line}: {pointer}: {detail}")
            }
        }
    }
}

impl JobOptions {
    /// The flag that a field comes from: the one with the longest path that contains it, or one inside it.
    pub(super) fn flag(&self, path: &str) -> Option<&str> {
        if path == SIZE {
            return Some("--surface");
        }
        let is_in = |outer: &str, inner: &str| {
            let rest = inner.strip_prefix(outer);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let around = self.flags.iter().filter(|(it, _)| is_in(it, path));
        let around = around.max_by_key(|(it, _)| it.len());
        let wide = matches!(path, "" | "curve" | "surface" | "stop");
        let inside = || self.flags.iter().find(|(it, _)| !wide && is_in(path, it));
        let found = around.or_else(inside);
        found.map(|(_, flag)| flag.as_str())
    }
}
