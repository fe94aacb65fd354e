//! Files of points as the bodies of requests: shown as JSON, or fitted as they are.
//!
//! What JSON says beside the points stands in the query then, by its path: `curve.degree=3` for
//! `{"curve": {"degree": 3}}`. It becomes that JSON, which is read as any other.

use std::convert::Infallible;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::Uri;
use axum::response::Response;
use bytes::Bytes;
use futures_util::{StreamExt, stream};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::answer::whole;
use super::{body, negotiate};
use crate::api::app::App;
use crate::api::json::request::file::{self, FileHints, FileWords};
use crate::api::json::request::path;
use crate::api::json::view::points::PointsView;
use crate::api::json::view::to_bytes;
use crate::api::language::JSON;
use crate::api::order::{self, ReadJob};
use crate::api::problem::Problem;
use crate::api::stream::sending::ENOUGH;
use crate::config::Config;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use crate::model::stream::Samples;
use piad_files::import::{self, Hints, Imported};
use piad_files::short::quoted;
use piad_fit::data::Grid;

/// How many rows and columns the points of a file are: not a field of a job, but a help to read it.
const SIZE: &str = "surface.size";

/// The order of the points of a curve.
const ORDER: &str = "curve.order";

/// Those that there are.
const ORDERS: [&str; 2] = ["given", "nearest"];

/// The JSON of points takes at most so many times the memory of their file, also while it grows: 1e15 has sixteen
/// digits there.
const JSON_OF_POINTS: usize = 12;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointsQuery {
    #[serde(rename = "surface.size")]
    size: Option<String>,
    #[serde(rename = "curve.order")]
    order: Option<String>,
}

/// `POST /v1/points`: the points of a file, as the JSON of a job has them.
pub(super) async fn show(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    negotiate::json(request.headers())?;
    let query: PointsQuery = negotiate::query(request.uri())?;
    let mut reading = FileHints::default();
    for (name, text) in [(SIZE, query.size), (ORDER, query.order)] {
        if let Some(text) = text {
            take(&mut reading, name, &text)?;
        }
    }
    let body = body::read_points(&app, request, JSON_OF_POINTS).await?;
    let (length, most) = (body.bytes.len(), app.config.limits().points);
    let work = move || {
        let hints = file::hints(&Map::new(), reading, most);
        let points = imported(&body.bytes, &hints)?;
        let json = to_bytes(&PointsView::new(points));
        // Held until now: the file and its points take memory.
        drop(body);
        Ok(json)
    };
    let json = order::read(&app, length, work).await?;
    if json.len() <= ENOUGH {
        return Ok(whole(json, JSON));
    }
    let room = app
        .jobs
        .resources()
        .memory
        .files
        .take(Peer::current(), json.len())
        .await;
    Ok(whole(in_parts(json, room), JSON))
}

/// A long body, which takes memory until the last part of it has gone.
fn in_parts(bytes: Bytes, room: Option<Permit>) -> Body {
    let parts = stream::unfold((bytes, room), |(mut bytes, room)| async move {
        let part = bytes.split_to(bytes.len().min(ENOUGH));
        (!part.is_empty()).then_some((Ok::<_, Infallible>(part), (bytes, room)))
    });
    Body::from_stream(parts.fuse())
}

/// The points of a body.
fn imported(bytes: &Bytes, hints: &Hints) -> Result<Imported, Problem> {
    import::read(bytes, hints).map_err(Problem::from)
}

/// What the query says of a job whose points are in the body.
#[derive(Clone, Debug, Default)]
pub(super) struct Fields {
    json: Map<String, Value>,
    reading: FileHints,
}

impl Fields {
    /// Of a request whose body is a text with the points of a job: what the query says of the answer,
    /// in parameters of these names, and the other fields of the job.
    pub(super) fn of_points<Q: DeserializeOwned>(
        request: &Request,
        of_answer: &[&str],
    ) -> Result<Option<(Q, Self)>, Problem> {
        let headers = request.headers();
        let points = body::is_points(headers) && !body::is_unasked(headers);
        points
            .then(|| Self::split(request.uri(), of_answer))
            .transpose()
    }

    fn split<Q: DeserializeOwned>(uri: &Uri, of_answer: &[&str]) -> Result<(Q, Self), Problem> {
        let parameters = uri.query().unwrap_or("").split('&');
        let name = |parameter: &&str| parameter.split('=').next().unwrap_or("").to_owned();
        let (answer, job): (Vec<&str>, Vec<&str>) = parameters
            .filter(|parameter| !parameter.is_empty())
            .partition(|parameter| of_answer.contains(&name(parameter).as_str()));
        let answer = negotiate::query(&only(uri, &answer))?;
        let given: Vec<(String, String)> = negotiate::query(&only(uri, &job))?;
        let mut fields = Self::default();
        for (name, text) in given {
            // The order of points says how the file is read, and is a field of the job.
            if !take(&mut fields.reading, &name, &text)? || name == ORDER {
                path::insert(&mut fields.json, &name, &text)
                    .map_err(|detail| Problem::at_parameter(&name, detail))?;
            }
        }
        Ok((answer, fields))
    }

    /// The same text for the same fields.
    pub(super) fn text(&self) -> String {
        let size = self.reading.size;
        let size = size.map(|size| format!("{}x{}", size.rows, size.columns));
        format!(
            "{} {}",
            Value::from(self.json.clone()),
            size.unwrap_or_default()
        )
    }

    /// The job that they ask for, with the points of this body.
    pub(super) fn job(self, bytes: &Bytes, config: &Config) -> Result<ReadJob<FileWords>, Problem> {
        let hints = file::hints(&self.json, self.reading, config.limits().points);
        let mut points = imported(bytes, &hints)?;
        let notices = std::mem::take(&mut points.notices);
        let (request, words) = file::read(self.json, points, &hints)?;
        Ok(ReadJob {
            request,
            words,
            notices,
        })
    }
}

/// The address with some of its parameters.
fn only(uri: &Uri, parameters: &[&str]) -> Uri {
    let text = format!("{}?{}", uri.path(), parameters.join("&"));
    // Its parts have been in an address before.
    text.parse().unwrap_or_default()
}

/// Takes a parameter that says how a file is read; returns true if it is one.
fn take(reading: &mut FileHints, name: &str, text: &str) -> Result<bool, Problem> {
    match name {
        SIZE => reading.size = Some(size(text)?),
        ORDER if ORDERS.contains(&text) => reading.ordered = true,
        ORDER => {
            let [given, nearest] = ORDERS;
            let detail = format!(
                "{} is no order; there are {given} and {nearest}",
                quoted(text)
            );
            return Err(Problem::at_parameter(ORDER, detail));
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Rows and columns, such as 40x60.
fn size(text: &str) -> Result<Grid, Problem> {
    let size = match Samples::of_text(text) {
        Some(Samples::Grid(rows, columns)) if rows >= 2 && columns >= 2 => {
            Some(Grid { rows, columns })
        }
        _ => None,
    };
    size.ok_or_else(|| {
        let detail = format!(
            "{} is no number of rows and columns, such as 40x60",
            quoted(text)
        );
        Problem::at_parameter(SIZE, detail)
    })
}
