//! The `stream` object of a job: the parameters of its event streams, in JSON.

use std::fmt;
use std::sync::Arc;

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::StreamParameters;
use crate::api::numbers::Number;
use crate::api::problem::{Kind, Problem};
use crate::api::strict::Count;
use crate::fit::problem as fit;
use crate::job::outline::Label;

/// The parameters of all event streams of a job that do not say it themselves.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StreamObject {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) view: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) samples: Option<SampleCount>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) every: Option<Count>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) milestones: Option<Vec<Number>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) pace: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) changed: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) encoding: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) digits: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::api) on_disconnect: Option<String>,
}

impl StreamObject {
    /// The object of a job, as [`Self::text`] has written it.
    pub fn of(label: &Label) -> Result<Option<Self>, Problem> {
        let broken = |error| {
            let detail = format!("the stream object of the job cannot be read: {error}");
            Problem::new(Kind::Internal, detail)
        };
        let text = label.stream.as_deref();
        text.map(serde_json::from_str).transpose().map_err(broken)
    }

    /// The object as JSON, if streams of `problem` can go like that.
    pub fn text(&self, problem: &fit::Problem) -> Result<Arc<str>, Problem> {
        let query = StreamParameters::default();
        query.options(Some(self), problem.v().is_some())?;
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

impl<'de> Deserialize<'de> for SampleCount {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SampleCountVisitor)
    }
}

impl Serialize for SampleCount {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.parse() {
            Ok(count) => serializer.serialize_u64(count),
            Err(_) => serializer.serialize_str(&self.0),
        }
    }
}

struct SampleCountVisitor;

impl Visitor<'_> for SampleCountVisitor {
    type Value = SampleCount;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a whole number for a curve, or \"40x40\" for a surface")
    }

    fn visit_u64<E: Error>(self, count: u64) -> Result<SampleCount, E> {
        Ok(SampleCount(count.to_string()))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<SampleCount, E> {
        if text.contains('x') {
            Ok(SampleCount(text.to_owned()))
        } else {
            Err(E::invalid_value(Unexpected::Str(text), &self))
        }
    }
}
