//! Options of the event streams of a job.
//!
//! - [`options`]: the resolved options of a stream; [`form`]: the form of an iteration; [`choices`]: the source of each
//!   choice;
//! - `words`, `samples`: its choices; `schema`: the schemas of these.

pub(crate) mod choices;
pub(crate) mod form;
pub(crate) mod options;
mod samples;
pub(crate) mod schema;
mod words;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::named::Named;
use super::serde_helpers::{AtMost, object, whole};
use schema::Milestone;

pub(crate) use samples::Samples;
pub(crate) use samples::{MOST_SAMPLES, not_samples};
pub(crate) use words::{Choice, Describe, Digits, Encoding, OnDisconnect, Pace, View};

/// The most milestones of a stream.
pub(crate) const MOST_MILESTONES: usize = 100;

/// The default options of the event streams of a job. Some choices exclude others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "StreamDefaults")]
#[schemars(extend("examples" = [{"view": "samples", "samples": 200, "every": 5}]))]
pub struct StreamSpec {
    /// The view of the events.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// The number of samples; with the view `samples`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<Samples>,
    /// Only iterations that are multiples of this number, and the last.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "whole"
    )]
    #[schemars(range(min = 1, max = u64::MAX), extend("default" = 1))]
    pub every: Option<usize>,
    /// Only the first iteration whose largest error is within each of these distances, which decrease.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "milestones"
    )]
    #[schemars(with = "Option<Vec<Milestone>>", length(max = MOST_MILESTONES))]
    #[schemars(extend("default" = []))]
    pub milestones: Option<Vec<f64>>,
    /// The iterations for a client that is slower than the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pace: Option<Pace>,
    /// After a first complete event only control points that moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub changed: Option<bool>,
    /// The contents of the `job` event.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub describe: Option<Describe>,
    /// The encoding of arrays of numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// The precision of coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub digits: Option<Digits>,
    /// What happens to the job when its client disconnects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_disconnect: Option<OnDisconnect>,
}

object!(StreamSpec, "an object");

fn milestones<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    let milestones: Option<AtMost<f64, MOST_MILESTONES>> = Option::deserialize(deserializer)?;
    Ok(milestones.map(|AtMost(milestones)| milestones))
}

impl StreamSpec {
    /// A choice as it would be written in a query, if it was made.
    pub fn text(&self, choice: Choice) -> Option<String> {
        let name = |name: &'static str| name.to_owned();
        match choice {
            Choice::View => self.view.map(Named::name).map(name),
            Choice::Samples => self.samples.map(|samples| samples.to_string()),
            Choice::Every => self.every.map(|every| every.to_string()),
            Choice::Milestones => self.milestones.as_ref().map(|milestones| {
                let milestones = milestones.iter().map(f64::to_string);
                milestones.collect::<Vec<_>>().join(",")
            }),
            Choice::Pace => self.pace.map(Named::name).map(name),
            Choice::Changed => self.changed.map(|changed| changed.to_string()),
            Choice::Describe => self.describe.map(Named::name).map(name),
            Choice::Encoding => self.encoding.map(Named::name).map(name),
            Choice::Digits => self.digits.map(Named::name).map(name),
            Choice::OnDisconnect => self.on_disconnect.map(Named::name).map(name),
        }
    }
}
