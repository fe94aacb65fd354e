//! Files of points as the bodies of requests: converted to JSON, or fitted directly.
//!
//! The other fields of the JSON are then in the query, by their path: `curve.degree=3` for `{"curve": {"degree": 3}}`.
//! They become that JSON, which is read as any other.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::Uri;
use axum::response::Response;
use bytes::Bytes;
use futures_util::{StreamExt, stream};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::answer::whole;
use super::body_limits::ReceivedBody;
use super::{body, negotiate};
use crate::api::app::App;
use crate::api::create_job::{self, ReadJob};
use crate::api::json::request::file::{
    self, COLUMNS, FileHints, FileLocator, ORDER, PART, PIECE, SECTIONS, SIZE,
};
use crate::api::json::request::path;
use crate::api::json::view::points::PointsView;
use crate::api::json::view::to_bytes;
use crate::api::media_type::JSON;
use crate::api::problem::Problem;
use crate::api::stream::sending::SENT_BYTES;
use crate::config::Config;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use piad_files::import::{self, Hints, Imported};
use piad_files::text::quoted;
use piad_fit::parameters::Scattered;

/// The JSON of points takes at most this many times the memory of their file, also while it grows: 1e15 has sixteen
/// digits there.
const JSON_OF_POINTS: usize = 12;

/// The fewest bytes of a point: two digits, a blank and the end of a line.
const SHORTEST: usize = 4;

/// The parameters of scattered points that a file can be read with.
const AUTO: &str = "auto";
const PROJECT: &str = "project";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointsQuery {
    #[serde(rename = "surface.size")]
    size: Option<String>,
    #[serde(rename = "surface.sections")]
    sections: Option<String>,
    #[serde(rename = "curve.order")]
    order: Option<String>,
    #[serde(rename = "curve.parameters")]
    curve: Option<String>,
    #[serde(rename = "surface.parameters")]
    surface: Option<String>,
    columns: Option<String>,
    part: Option<String>,
    piece: Option<String>,
}

/// `POST /v1/points`: the points of a file, as the JSON of a job has them.
pub(super) async fn show(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    negotiate::json(request.headers())?;
    let query: PointsQuery = negotiate::query(request.uri())?;
    let mut reading = FileHints::default();
    for (name, text) in [
        (SIZE, query.size),
        (SECTIONS, query.sections),
        (ORDER, query.order),
        (COLUMNS, query.columns),
        (PART, query.part),
        (PIECE, query.piece),
    ] {
        if let Some(text) = text {
            take(&mut reading, name, &text)?;
        }
    }
    let fields = job_fields(query.curve.as_deref(), query.surface.as_deref())?;
    let scattered = query.surface.map(|text| match text.as_str() {
        PROJECT => Scattered::Plane,
        _ => Scattered::Auto,
    });
    let body = body::read_points(&app, request, JSON_OF_POINTS).await?;
    let (length, most) = (body.bytes.len(), app.config.limits().points);
    let work = move || {
        let hints = file::hints(&fields, reading, most);
        let points = imported(&body.bytes, &hints)?;
        let has_shape =
            points.grid.is_some() || !points.sections.is_empty() || !points.triangles.is_empty();
        if scattered.is_some() && has_shape {
            let detail = "the points of the file have rows, sections or triangles, which give them parameters: leave it out";
            return Err(Problem::at_parameter("surface.parameters", detail));
        }
        let json = to_bytes(&PointsView::new(points, scattered));
        // Held until now: the file and its points take memory.
        drop(body);
        Ok(json)
    };
    let json = create_job::read(&app, length, work).await?;
    if json.len() <= SENT_BYTES {
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

/// The fields of a job that affect how its file is read: the parameters of a curve, or those of a surface.
fn job_fields(curve: Option<&str>, surface: Option<&str>) -> Result<Map<String, Value>, Problem> {
    let mut fields = Map::new();
    for (name, text, known) in [
        ("curve", curve, &[file::TIME][..]),
        ("surface", surface, &[AUTO, PROJECT]),
    ] {
        let Some(text) = text else { continue };
        if !known.contains(&text) {
            let known = known.join(" or ");
            let detail = format!("{} is not read from files; {known} is", quoted(text));
            return Err(Problem::at_parameter(format!("{name}.parameters"), detail));
        }
        fields.insert(name.to_owned(), json!({"parameters": text}));
    }
    Ok(fields)
}

/// A long body, which holds memory until its last part is sent.
fn in_parts(bytes: Bytes, room: Option<Permit>) -> Body {
    let parts = stream::unfold((bytes, room), |(mut bytes, room)| async move {
        let part = bytes.split_to(bytes.len().min(SENT_BYTES));
        (!part.is_empty()).then_some((Ok::<_, Infallible>(part), (bytes, room)))
    });
    Body::from_stream(parts.fuse())
}

/// The points of a body.
fn imported(bytes: &Bytes, hints: &Hints) -> Result<Imported, Problem> {
    import::read(bytes, hints).map_err(Problem::from)
}

/// The fields in the query of a job whose points are in the body.
#[derive(Clone, Debug, Default)]
pub(super) struct Fields {
    json: Map<String, Value>,
    reading: FileHints,
}

impl Fields {
    /// For a request whose body is a text with the points of a job: the choices of the answer, in parameters of these
    /// names, and the other fields of the job.
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
            // The order of points affects how the file is read, and is also a field of the job.
            if !take(&mut fields.reading, &name, &text)? || name == ORDER {
                path::insert(&mut fields.json, &name, &text)
                    .map_err(|detail| Problem::at_parameter(&name, detail))?;
            }
        }
        Ok((answer, fields))
    }

    /// The same text for the same fields.
    pub(super) fn text(&self) -> String {
        format!("{} {:?}", Value::from(self.json.clone()), self.reading)
    }

    /// The job of these fields, with the points of this body.
    pub(super) fn job(
        self,
        bytes: &Bytes,
        config: &Config,
    ) -> Result<ReadJob<FileLocator>, Problem> {
        let hints = file::hints(&self.json, self.reading, config.limits().points);
        let mut points = imported(bytes, &hints)?;
        let notices = std::mem::take(&mut points.notices);
        let (request, locator) = file::read(self.json, points, &hints)?;
        Ok(ReadJob {
            request,
            locator,
            notices,
        })
    }
}

/// The jobs of the parts of a file, a line of JSON each.
pub(super) struct PartJobs {
    /// The memory that the file and its lines take.
    body: ReceivedBody,
    lines: std::vec::IntoIter<Bytes>,
    /// Notices about each part.
    notices: Vec<Arc<[String]>>,
}

impl PartJobs {
    /// Reads a body with the common fields of all parts.
    pub(super) async fn read(app: &App, request: Request, fields: Fields) -> Result<Self, Problem> {
        let body = body::read_points(app, request, JSON_OF_POINTS).await?;
        let most = app.config.limits().points;
        let work = move || {
            // Each part has the limit of a job. All together may have more, but no more than their text can hold: sampled
            // curves of a small drawing have no end.
            let most = most.max(body.bytes.len() / SHORTEST);
            let hints = file::hints(&fields.json, fields.reading, most);
            let parts = import::read_parts(&body.bytes, &hints)?;
            let (mut lines, mut notices) = (Vec::with_capacity(parts.len()), Vec::new());
            for mut part in parts {
                add_notices(&mut notices, std::mem::take(&mut part.notices));
                let json = file::json(fields.json.clone(), part, &hints)?;
                lines.push([json, Bytes::from_static(b"\n")].concat().into());
            }
            Ok(Self {
                body,
                lines: lines.into_iter(),
                notices,
            })
        };
        create_job::read(app, 0, work).await
    }

    /// Takes the notices about each part.
    pub(super) fn take_notices(&mut self) -> Vec<Arc<[String]>> {
        std::mem::take(&mut self.notices)
    }

    /// The lines as the body of a batch.
    pub(super) fn into_body(self) -> Body {
        let lines = stream::iter(self.lines).map(move |line| {
            // Held until the last line is sent.
            let _ = &self.body;
            Ok::<_, Infallible>(line)
        });
        Body::from_stream(lines)
    }
}

/// Adds the notices of a part. Most are about the whole file: parts with the same ones share them.
fn add_notices(all: &mut Vec<Arc<[String]>>, notices: Vec<String>) {
    let same = all.last().filter(|last| ***last == *notices).cloned();
    all.push(same.unwrap_or_else(|| notices.into()));
}

/// The address with some of its parameters.
fn only(uri: &Uri, parameters: &[&str]) -> Uri {
    let text = format!("{}?{}", uri.path(), parameters.join("&"));
    // They were parts of an address before.
    text.parse().unwrap_or_default()
}

/// Takes a parameter about reading a file; returns true if it is one.
fn take(reading: &mut FileHints, name: &str, text: &str) -> Result<bool, Problem> {
    let taken = reading.take(name, text);
    taken.map_err(|detail| Problem::at_parameter(name, detail))
}
