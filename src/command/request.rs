//! The request for a fit, posted to the server in this process or another one.

use bytes::Bytes;
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::Value;

use super::failure::Failure;
use super::input::{Content, Input};
use super::options::{JobOptions, merge, merge_into_items};

/// Streams of progress: no geometry, and only the newest iteration.
pub(super) const PROGRESS: &str = "view=errors&pace=latest";

/// The request for many fits, with their results.
const BATCH: &str = "/v1/batch?view=control_points";

/// The longest address: URIs are shorter than 64 KiB.
const LONGEST: usize = 60_000;

/// A body with its address.
#[derive(Debug)]
pub(super) struct Request {
    /// The path and the query.
    pub path: String,
    /// The media type of the body.
    pub media_type: &'static str,
    /// The body.
    pub body: Bytes,
}

impl Request {
    /// The request for a fit of an input with these options.
    pub(super) fn new(input: &Input, options: &JobOptions) -> Result<Self, Failure> {
        match (input.content, options.reading.first()) {
            (Content::Points, _) => {
                Self::of_points(input, options, format!("/v1/jobs/stream?{PROGRESS}"))
            }
            (content, Some((parameter, _))) => Err(Failure::usage(format!(
                "{}: {} is a whole {}, and no file of points",
                options.flag(parameter).unwrap_or(parameter),
                input.name,
                match content {
                    Content::Batch => "batch",
                    _ => "job",
                }
            ))),
            (content, None) => Ok(Self {
                path: match content {
                    Content::Batch => BATCH.to_owned(),
                    _ => format!("/v1/jobs/stream?{PROGRESS}"),
                },
                media_type: "application/json",
                body: json(input, options)?,
            }),
        }
    }

    /// The request for a fit of each part of a file.
    pub(super) fn of_parts(input: &Input, options: &JobOptions) -> Result<Self, Failure> {
        Self::of_points(input, options, BATCH.to_owned())
    }

    /// Points are sent unchanged, and the other fields in the query.
    fn of_points(input: &Input, options: &JobOptions, mut path: String) -> Result<Self, Failure> {
        let mut add = |name: &str, text: &str| {
            let text = utf8_percent_encode(text, NON_ALPHANUMERIC);
            path += &format!("&{}={text}", utf8_percent_encode(name, NON_ALPHANUMERIC));
        };
        for (name, value) in &options.fields {
            match value {
                Value::String(text) => add(name, text),
                value => add(name, &value.to_string()),
            }
        }
        for (name, text) in &options.reading {
            add(name, text);
        }
        if path.len() > LONGEST {
            let detail = "there is too much beside the points of the file: make it a whole job";
            return Err(Failure::usage(format!("--json: {detail} in JSON")));
        }
        Ok(Self {
            path,
            media_type: "application/octet-stream",
            body: input.bytes.clone(),
        })
    }
}

/// A job or a batch with the overriding fields of the flags.
fn json(input: &Input, options: &JobOptions) -> Result<Bytes, Failure> {
    if options.fields.is_empty() {
        return Ok(input.bytes.slice_ref(input.json()));
    }
    let mut json = input.value()?;
    match (input.content, json.as_object_mut()) {
        (Content::Batch, _) => merge_into_items(&mut json, &options.fields),
        (_, Some(fields)) => merge(fields, options.fields.clone()),
        (_, None) => {}
    }
    Ok(json.to_string().into())
}
