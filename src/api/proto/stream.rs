//! What a stream is like: the options of a message and the `stream` object of a job.

use super::messages as pb;
use super::names::known;
use super::request::check_count;
use crate::api::json::read::values::{Count, Number};
use crate::api::problem::Problem;
use crate::api::stream::options::object::{SampleCount, StreamObject};
use crate::api::stream::options::{MOST_MILESTONES, StreamParameters};

const VIEWS: [(&str, pb::View); 3] = [
    ("control_points", pb::View::ControlPoints),
    ("samples", pb::View::Samples),
    ("errors", pb::View::Errors),
];

const PACES: [(&str, pb::Pace); 2] = [("all", pb::Pace::All), ("latest", pb::Pace::Latest)];

const DISCONNECTS: [(&str, pb::OnDisconnect); 2] = [
    ("continue", pb::OnDisconnect::Continue),
    ("cancel", pb::OnDisconnect::Cancel),
];

const ENCODINGS: [(&str, pb::JsonEncoding); 3] = [
    ("json", pb::JsonEncoding::Json),
    ("base64", pb::JsonEncoding::Base64),
    ("base64_f32", pb::JsonEncoding::Base64F32),
];

const DIGITS: [(&str, pb::JsonDigits); 2] = [
    ("full", pb::JsonDigits::Full),
    ("auto", pb::JsonDigits::Auto),
];

/// The options as the `stream` object of a job. Fields of errors are relative to the options.
pub fn object(options: pb::StreamOptions) -> Result<StreamObject, Problem> {
    let every = options.every.map(|every| {
        let detail = "it is larger than any number of iterations";
        let every = usize::try_from(every).map_err(|_| Problem::at_field("every", detail));
        every.map(Count)
    });
    let count = options
        .milestones
        .as_ref()
        .map_or(0, |it| it.distances.len());
    check_count(count, MOST_MILESTONES, "milestones", "milestones.distances")?;
    Ok(StreamObject {
        view: name(&VIEWS, options.view, "view")?,
        samples: samples(options.samples_u, options.samples_v)?,
        every: every.transpose()?,
        milestones: options
            .milestones
            .map(|milestones| milestones.distances.into_iter().map(Number).collect()),
        pace: name(&PACES, options.pace, "pace")?,
        changed: options.changed,
        encoding: name(&ENCODINGS, options.json_encoding, "json_encoding")?,
        digits: name(&DIGITS, options.json_digits, "json_digits")?,
        on_disconnect: name(&DISCONNECTS, options.on_disconnect, "on_disconnect")?,
    })
}

/// The options of a call, as a query would say them. What is about JSON is ignored.
pub fn parameters(options: Option<pb::StreamOptions>) -> Result<StreamParameters, Problem> {
    let options = pb::StreamOptions {
        json_encoding: 0,
        json_digits: 0,
        ..options.unwrap_or_default()
    };
    let object = object(options).map_err(|problem| problem.within("stream"))?;
    Ok(object.parameters())
}

/// The `stream` object of a job as options.
pub fn options(object: &StreamObject) -> pb::StreamOptions {
    let (samples_u, samples_v) = object.samples.as_ref().map_or((0, 0), sample_counts);
    let distances = object.milestones.as_ref().map(|milestones| {
        let distances = milestones.iter().map(|Number(distance)| *distance);
        pb::Milestones {
            distances: distances.collect(),
        }
    });
    pb::StreamOptions {
        view: value(&VIEWS, object.view.as_deref()).into(),
        samples_u,
        samples_v,
        every: object.every.map(|Count(every)| every as u64),
        milestones: distances,
        pace: value(&PACES, object.pace.as_deref()).into(),
        changed: object.changed,
        on_disconnect: value(&DISCONNECTS, object.on_disconnect.as_deref()).into(),
        json_encoding: value(&ENCODINGS, object.encoding.as_deref()).into(),
        json_digits: value(&DIGITS, object.digits.as_deref()).into(),
    }
}

fn samples(u: u32, v: u32) -> Result<Option<SampleCount>, Problem> {
    match (u, v) {
        (0, 0) => Ok(None),
        (u, 0) => Ok(Some(SampleCount(u.to_string()))),
        (0, _) => {
            let detail = "samples_v is given, so samples_u is needed as well";
            Err(Problem::at_field("samples_u", detail))
        }
        (u, v) => Ok(Some(SampleCount(format!("{u}x{v}")))),
    }
}

/// `200` or `40x40`, as they were accepted.
fn sample_counts(SampleCount(text): &SampleCount) -> (u32, u32) {
    let (u, v) = text.split_once('x').unwrap_or((text, "0"));
    (u.parse().unwrap_or(0), v.parse().unwrap_or(0))
}

/// The name of a value; none if it is not specified.
fn name<E: Copy + PartialEq + TryFrom<i32>>(
    names: &[(&str, E)],
    value: i32,
    field: &str,
) -> Result<Option<String>, Problem> {
    let value: E = known(value, field)?;
    let found = names.iter().find(|(_, known)| *known == value);
    Ok(found.map(|(name, _)| (*name).to_owned()))
}

/// The value of a name; unspecified without one.
fn value<E: Copy + Default>(names: &[(&str, E)], name: Option<&str>) -> E {
    let found = names.iter().find(|(known, _)| Some(*known) == name);
    found.map_or(E::default(), |(_, value)| *value)
}
