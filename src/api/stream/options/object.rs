//! The `stream` object of a job: the parameters of its event streams, in JSON.

use std::sync::Arc;

use schemars::{JsonSchema, json_schema};
use serde::{Serialize, Serializer};

use super::form::{DIGITS, ENCODINGS, MOST_SAMPLES, SAMPLE_GRID, VIEWS};
use super::{DISCONNECTS, MOST_MILESTONES, PACES, StreamParameters};
use crate::api::json::read;
use crate::api::json::read::values::{Count, Element, LONGEST_TEXT, Number};
use crate::api::json::read::{Limits, Numeral, Of, Reader, Reading, object};
use crate::api::json::schema::{names, schema_of};
use crate::api::problem::{Kind, Problem};
use crate::api::short::{cut, quoted};
use crate::fit::problem as fit;
use crate::job::outline::Label;

/// What the event streams of a job are like if they do not say it themselves. Some choices rule
/// others out.
#[derive(Clone, Debug, Default, JsonSchema, Serialize)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "StreamDefaults", extend("examples" = [{"view": "samples", "samples": 200, "every": 5}]))]
pub struct StreamObject {
    /// What the events show.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<View>")]
    pub(in crate::api) view: Option<String>,
    /// How many samples they have; with the view `samples`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) samples: Option<SampleCount>,
    /// Only iterations that are multiples of this number, and the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1), extend("default" = 1))]
    pub(in crate::api) every: Option<Count>,
    /// Only the first iteration whose largest error is within each of these distances, which decrease.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = MOST_MILESTONES), with = "Option<Vec<Milestone>>", extend("default" = []))]
    pub(in crate::api) milestones: Option<Vec<Number>>,
    /// What a client gets that is slower than the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Pace>")]
    pub(in crate::api) pace: Option<String>,
    /// After a first complete event only control points that moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub(in crate::api) changed: Option<bool>,
    /// How arrays of numbers are written.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Encoding>")]
    pub(in crate::api) encoding: Option<String>,
    /// How many digits coordinates have.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Digits>")]
    pub(in crate::api) digits: Option<String>,
    /// What becomes of the job when its client goes away.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Disconnect>")]
    pub(in crate::api) on_disconnect: Option<String>,
}

impl StreamObject {
    /// The object of a job, as [`Self::text`] has written it.
    pub fn of(label: &Label) -> Result<Option<Self>, Problem> {
        let broken = |problem: Problem| {
            let detail = problem.detail();
            let detail = format!("the stream object of the job cannot be read: {detail}");
            Problem::new(Kind::Internal, detail)
        };
        // It has no lists of data.
        let limits = Limits { points: 0 };
        let text = label.stream.as_deref();
        let object = text.map(|text| read::parse::<Self>(text.as_bytes(), limits));
        object.transpose().map_err(broken)
    }

    /// Checks that streams of a curve or a surface can go like that.
    pub fn check(&self, surface: bool) -> Result<(), Problem> {
        let query = StreamParameters::default();
        query.options(Some(self), surface).map(|_| ())
    }

    /// The object as JSON, if streams of `problem` can go like that.
    pub fn text(&self, problem: &fit::Problem) -> Result<Arc<str>, Problem> {
        self.check(problem.v().is_some())?;
        let query = StreamParameters::default();
        query.check_range(Some(self), problem)?;
        serde_json::to_string(self)
            .map(Arc::from)
            .map_err(|error| Problem::new(Kind::Internal, error.to_string()))
    }

    /// The same as a query would say it, so that there is one way to understand it.
    pub(in crate::api) fn parameters(&self) -> StreamParameters {
        let list = |numbers: &Vec<Number>| {
            let numbers = numbers.iter().map(|Number(x)| format!("{x:?}"));
            numbers.collect::<Vec<_>>().join(",")
        };
        StreamParameters {
            last_event_id: None,
            view: self.view.clone(),
            samples: self.samples.as_ref().map(|SampleCount(text)| text.clone()),
            every: self.every.map(|Count(every)| every.to_string()),
            milestones: self.milestones.as_ref().map(list),
            pace: self.pace.clone(),
            changed: self.changed.map(|changed| changed.to_string()),
            encoding: self.encoding.clone(),
            digits: self.digits.clone(),
            on_disconnect: self.on_disconnect.clone(),
        }
    }
}

/// A number of samples: `200` for a curve, `"40x40"` for a surface.
#[derive(Clone, Debug)]
pub(in crate::api) struct SampleCount(pub(in crate::api) String);

impl Serialize for SampleCount {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.parse() {
            Ok(count) => serializer.serialize_u64(count),
            Err(_) => serializer.serialize_str(&self.0),
        }
    }
}

impl Reader for Of<SampleCount> {
    type Value = SampleCount;

    fn expected(&self) -> String {
        "a whole number for a curve, or \"40x40\" for a surface".to_owned()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<SampleCount> {
        let count = value.whole();
        if count.is_none() {
            at.mismatch(&self.expected(), &value.to_string());
        }
        count.map(|count| SampleCount(count.to_string()))
    }

    fn text(self, text: &str, at: &mut Reading) -> Option<SampleCount> {
        // What is longer is wrong, whatever it says.
        let text = cut(text, LONGEST_TEXT);
        if text.contains('x') {
            return Some(SampleCount(text.into_owned()));
        }
        at.mismatch(&self.expected(), &quoted(&text));
        None
    }
}

object!(
    StreamObject,
    "an object",
    [
        view,
        samples,
        every,
        milestones,
        pace,
        changed,
        encoding,
        digits,
        on_disconnect,
    ]
);

/// Of the lists of numbers whose length is not that of the data there is one.
impl Element for Number {
    const MANY: &'static str = "milestones";

    fn most(_: Limits) -> usize {
        MOST_MILESTONES
    }
}

schema_of!(
    SampleCount,
    "Samples",
    json_schema!({
        "description": "A number of samples for a curve, \"rows x columns\" for a surface: at least 2 in each direction and 1,000,000 in all. Without it 200, or 40x40.",
        "anyOf": [
            {"type": "integer", "minimum": 2, "maximum": MOST_SAMPLES},
            {"type": "string", "pattern": SAMPLE_GRID},
        ],
        "examples": [200, "40x40"],
    })
);

/// What an event shows.
pub enum View {}
/// How arrays of numbers are written.
pub enum Encoding {}
/// How many digits coordinates have.
pub enum Digits {}
/// What a slow client gets.
pub enum Pace {}
/// What a client that goes away leaves behind.
pub enum Disconnect {}
/// A distance to be reached.
pub enum Milestone {}

schema_of!(
    View,
    "View",
    names(
        "What is shown of an iteration: its complete control points, points of the curve or surface, or its errors alone.",
        "control_points",
        &VIEWS,
    )
);
schema_of!(
    Encoding,
    "Encoding",
    names(
        "How arrays of numbers are written: as JSON, or as little-endian numbers of 64 or 32 bits in base64.",
        "json",
        &ENCODINGS,
    )
);
schema_of!(
    Digits,
    "Digits",
    names(
        "How many digits coordinates have: all, or as many as the current error deserves, rounded by at most 1 % of it.",
        "full",
        &DIGITS,
    )
);
schema_of!(
    Pace,
    "Pace",
    names(
        "What a client gets that is slower than the fit: all iterations, or the latest.",
        "all",
        &PACES,
    )
);
schema_of!(
    Disconnect,
    "OnDisconnect",
    names(
        "What becomes of the job when the client goes away that made it with a stream.",
        "continue",
        &DISCONNECTS,
    )
);
schema_of!(
    Milestone,
    "Milestone",
    json_schema!({
        "description": "A distance in data units; milestones decrease.",
        "type": "number",
        "exclusiveMinimum": 0,
        "examples": [0.01],
    })
);
