//! The request for a fit: what is posted, in this process or to a server.

use bytes::Bytes;
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::{Map, Value, json};

use super::failure::Failure;
use super::input::{Content, Input};
use super::options::{Asked, SIZE, is_grid, merge};

/// Streams of progress: no geometry, and no iteration that is out of date.
pub(super) const PROGRESS: &str = "view=errors&pace=latest";

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
    pub(super) fn new(input: &Input, asked: &Asked) -> Result<Self, Failure> {
        match input.content {
            Content::Text => Self::of_text(input, asked),
            Content::Points => {
                let job = job_of_points(input.value()?, asked)?;
                Ok(Self::of_json(job.to_string().into()))
            }
            Content::Job if asked.size.is_some() => Err(Failure::usage(format!(
                "--surface: {} is a whole job, which has its rows",
                input.name
            ))),
            Content::Job if asked.fields.is_empty() => {
                Ok(Self::of_json(input.bytes.slice_ref(input.json())))
            }
            Content::Job => {
                let mut job = input.value()?;
                if let Some(fields) = job.as_object_mut() {
                    merge(fields, asked.fields.clone());
                }
                Ok(Self::of_json(job.to_string().into()))
            }
        }
    }

    fn of_json(body: Bytes) -> Self {
        Self {
            path: format!("/v1/jobs/stream?{PROGRESS}"),
            media_type: "application/json",
            body,
        }
    }

    /// Points go as they are, and the other fields in the query.
    fn of_text(input: &Input, asked: &Asked) -> Result<Self, Failure> {
        let mut path = format!("/v1/jobs/stream?{PROGRESS}");
        let mut add = |name: &str, text: &str| {
            let text = utf8_percent_encode(text, NON_ALPHANUMERIC);
            path += &format!("&{}={text}", utf8_percent_encode(name, NON_ALPHANUMERIC));
        };
        for (name, value) in &asked.fields {
            match value {
                Value::String(text) => add(name, text),
                value => add(name, &value.to_string()),
            }
        }
        if let Some(size) = &asked.size {
            add(SIZE, size);
        }
        if path.len() > LONGEST {
            let detail = "there is too much beside the points of the file: make it a whole job";
            return Err(Failure::usage(format!("--json: {detail} in JSON")));
        }
        Ok(Self {
            path,
            media_type: "text/csv",
            body: input.bytes.clone(),
        })
    }
}

/// A job with these points, in rows if they are, or if there are so many.
fn job_of_points(points: Value, asked: &Asked) -> Result<Value, Failure> {
    let mut fields: Map<String, Value> = asked.fields.clone();
    let surface = fields.contains_key("surface") || is_grid(&points);
    let name = if surface { "surface" } else { "curve" };
    let points = match (&asked.size, points) {
        (Some(size), Value::Array(points)) if !points.iter().any(|it| it[0].is_array()) => {
            in_rows(points, size)?
        }
        (_, points) => points,
    };
    let scattered = surface && asked.size.is_none() && !is_grid(&points);
    let list = if scattered { "scattered" } else { "points" };
    let shape = fields.entry(name).or_insert_with(|| json!({}));
    if let Some(shape) = shape.as_object_mut() {
        shape.insert(list.to_owned(), points);
    }
    Ok(fields.into())
}

fn in_rows(points: Vec<Value>, size: &str) -> Result<Value, Failure> {
    let mut numbers = size.split('x').filter_map(|text| text.parse().ok());
    let (rows, columns): (usize, usize) = (
        numbers.next().unwrap_or_default(),
        numbers.next().unwrap_or_default(),
    );
    if columns == 0 || rows.checked_mul(columns) != Some(points.len()) {
        let count = points.len();
        let detail = format!("{count} points, which are not {rows} rows of {columns}");
        return Err(Failure::usage(format!("--surface: {detail}")));
    }
    let mut points = points.into_iter();
    let row = |_| points.by_ref().take(columns).collect::<Value>();
    Ok((0..rows).map(row).collect())
}
