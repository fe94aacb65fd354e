//! What the event streams of a job are like, as far as a client says it.
//!
//! - [`options`]: how a stream goes; [`form`]: what is shown of an iteration; [`choices`]: who has chosen it;
//! - `schema`: the schemas of its choices.

pub(crate) mod choices;
pub(crate) mod form;
pub(crate) mod options;
pub(crate) mod schema;

use std::fmt;

use schemars::JsonSchema;
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::either::{AtMost, Whole, object, whole};
use super::named::{Named, named};
use crate::fit::points::Grid;
use form::not_samples;
use schema::Milestone;

/// The most milestones of a stream.
pub(crate) const MOST_MILESTONES: usize = 100;

/// The most points that are sampled.
pub(crate) const MOST_SAMPLES: usize = 1_000_000;

named!(
    /// What is shown of an iteration.
    View, "choice" {
        /// Its complete control points.
        ControlPoints = "control_points",
        /// Points of the curve or surface.
        Samples = "samples",
        /// Its errors alone.
        Errors = "errors",
    }
);

named!(
    /// How arrays of numbers are written in JSON.
    Encoding, "choice" {
        /// Lists of numbers.
        Json = "json",
        /// Little-endian numbers of 64 bits in base64.
        Base64 = "base64",
        /// Little-endian numbers of 32 bits in base64.
        Base64F32 = "base64_f32",
    }
);

named!(
    /// How many digits coordinates have in JSON.
    Digits, "choice" {
        /// All.
        Full = "full",
        /// As many as the largest distance deserves; the last iteration has all.
        Auto = "auto",
    }
);

named!(
    /// What a client gets that is slower than the fit.
    Pace, "choice" {
        /// All iterations.
        All = "all",
        /// The newest iteration.
        Latest = "latest",
    }
);

named!(
    /// What becomes of a job when the client of its stream goes away.
    OnDisconnect, "choice" {
        /// It goes on.
        Continue = "continue",
        /// It is cancelled.
        Cancel = "cancel",
    }
);

named!(
    /// What the `job` event says of the job.
    Describe, "choice" {
        /// All.
        Full = "full",
        /// Nothing that is as long as the data: no knots, parameters or fixed weights.
        None = "none",
    }
);

named!(
    /// One of the choices of a stream.
    Choice, "choice" {
        /// See [`StreamSpec::view`].
        View = "view",
        /// See [`StreamSpec::samples`].
        Samples = "samples",
        /// See [`StreamSpec::every`].
        Every = "every",
        /// See [`StreamSpec::milestones`].
        Milestones = "milestones",
        /// See [`StreamSpec::pace`].
        Pace = "pace",
        /// See [`StreamSpec::changed`].
        Changed = "changed",
        /// See [`StreamSpec::describe`].
        Describe = "describe",
        /// See [`StreamSpec::encoding`].
        Encoding = "encoding",
        /// See [`StreamSpec::digits`].
        Digits = "digits",
        /// See [`StreamSpec::on_disconnect`].
        OnDisconnect = "on_disconnect",
    }
);

/// A number of samples, as it was asked for: of a curve one number, of a surface one for each
/// direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// So many points of a curve.
    Count(usize),
    /// So many rows and columns of points of a surface.
    Grid(usize, usize),
}

/// What the event streams of a job are like if they do not say it themselves. Some choices rule others out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "StreamDefaults")]
#[schemars(extend("examples" = [{"view": "samples", "samples": 200, "every": 5}]))]
pub struct StreamSpec {
    /// What the events show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// How many samples they have; with the view `samples`.
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
    /// What a client gets that is slower than the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pace: Option<Pace>,
    /// After a first complete event only control points that moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub changed: Option<bool>,
    /// What the `job` event says of the job.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub describe: Option<Describe>,
    /// How arrays of numbers are written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// How many digits coordinates have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub digits: Option<Digits>,
    /// What becomes of the job when its client goes away.
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

impl Samples {
    /// Reads `200` or `40x40`.
    pub fn of_text(text: &str) -> Option<Self> {
        match text.split_once('x') {
            None => text.parse().ok().map(Self::Count),
            Some((rows, columns)) => {
                let rows = rows.parse().ok()?;
                Some(Self::Grid(rows, columns.parse().ok()?))
            }
        }
    }

    /// The grid of samples of a curve or a surface, if this is a number of samples for it: at least 2 in
    /// each direction and [`MOST_SAMPLES`] in all.
    pub fn grid(self, surface: bool) -> Option<Grid> {
        let grid = match (self, surface) {
            (Self::Count(rows), false) => Grid { rows, columns: 1 },
            (Self::Grid(rows, columns), true) if columns >= 2 => Grid { rows, columns },
            _ => return None,
        };
        let count = grid.rows.saturating_mul(grid.columns);
        (grid.rows >= 2 && count <= MOST_SAMPLES).then_some(grid)
    }
}

/// As it is written: `200` or `40x40`.
impl fmt::Display for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => write!(f, "{count}"),
            Self::Grid(rows, columns) => write!(f, "{rows}x{columns}"),
        }
    }
}

impl Serialize for Samples {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Count(count) => count.serialize(serializer),
            Self::Grid(..) => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Samples {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SamplesVisitor;

        impl Visitor<'_> for SamplesVisitor {
            type Value = Samples;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number for a curve, or \"40x40\" for a surface")
            }

            fn visit_u64<E: Error>(self, count: u64) -> Result<Samples, E> {
                let count = usize::try_from(count).unwrap_or(usize::MAX);
                Ok(Samples::Count(count))
            }

            fn visit_f64<E: Error>(self, count: f64) -> Result<Samples, E> {
                Whole::of(count, &self).map(Samples::Count)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Samples, E> {
                if !text.contains('x') {
                    return Err(E::invalid_type(Unexpected::Str(text), &self));
                }
                Samples::of_text(text).ok_or_else(|| E::custom(not_samples(text, true)))
            }
        }

        deserializer.deserialize_any(SamplesVisitor)
    }
}
