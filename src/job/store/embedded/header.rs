//! Records and keys as protobuf messages.
//!
//! Tags stay what they are for ever; new fields get new tags and have a sensible meaning when absent.

use std::sync::Arc;

use jiff::Timestamp;
use prost::{Enumeration, Message};
use uuid::Uuid;

use super::super::{Key, Made, Record, StoreError};
use super::error::damaged;
use super::input::MethodMessage;
use super::warning::WarningMessage;
use crate::fit::iteration::Level;
use crate::fit::norms::FitError;
use crate::fit::outcome::Stall;
use crate::fit::points::Grid;
use crate::fit::system::Forecast;
use crate::job::outline::{Label, Outline, Parent};
use crate::job::state::{Failure, Levels, Reason, State, Status};
use crate::model::stream::StreamSpec;

/// A job without its points.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Header {
    #[prost(bytes = "vec", tag = "1")]
    id: Vec<u8>,
    #[prost(string, optional, tag = "2")]
    name: Option<String>,
    #[prost(bytes = "vec", optional, tag = "3")]
    parent: Option<Vec<u8>>,
    #[prost(uint64, tag = "4")]
    parent_iteration: u64,
    #[prost(string, optional, tag = "5")]
    stream: Option<String>,
    #[prost(message, optional, tag = "6")]
    created: Option<Time>,
    #[prost(bool, tag = "7")]
    surface: bool,
    #[prost(uint64, tag = "8")]
    rows: u64,
    #[prost(uint64, tag = "9")]
    columns: u64,
    #[prost(message, optional, tag = "10")]
    method: Option<MethodMessage>,
    #[prost(uint64, optional, tag = "11")]
    adjusted: Option<u64>,
    #[prost(double, tag = "12")]
    tolerance: f64,
    #[prost(uint64, tag = "13")]
    max_iterations: u64,
    #[prost(uint64, tag = "14")]
    memory: u64,
    #[prost(uint64, tag = "15")]
    step_cost: u64,
    #[prost(message, optional, tag = "16")]
    status: Option<StatusMessage>,
    #[prost(uint32, tag = "17")]
    pub(super) crashes: u32,
    /// Bytes of the input and of the result.
    #[prost(uint64, tag = "18")]
    pub(super) bytes: u64,
    /// The key of the request that made the job.
    #[prost(string, optional, tag = "19")]
    pub(super) key: Option<String>,
    /// It runs under watch, as it may be to blame for a crash.
    #[prost(bool, tag = "20")]
    pub(super) watched: bool,
    #[prost(message, repeated, tag = "21")]
    warnings: Vec<WarningMessage>,
    #[prost(bool, tag = "22")]
    bases_differ: bool,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Time {
    #[prost(int64, tag = "1")]
    seconds: i64,
    #[prost(int32, tag = "2")]
    nanoseconds: i32,
}

#[derive(Clone, PartialEq, Message)]
struct StatusMessage {
    #[prost(enumeration = "StateCode", tag = "1")]
    state: i32,
    #[prost(message, optional, tag = "2")]
    started: Option<Time>,
    #[prost(message, optional, tag = "3")]
    finished: Option<Time>,
    #[prost(message, optional, tag = "4")]
    first: Option<LevelMessage>,
    #[prost(message, optional, tag = "5")]
    last: Option<LevelMessage>,
    #[prost(message, optional, tag = "6")]
    forecast: Option<ForecastMessage>,
    #[prost(enumeration = "ReasonCode", tag = "7")]
    reason: i32,
    #[prost(enumeration = "FailureCode", tag = "8")]
    failure: i32,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct LevelMessage {
    #[prost(uint64, tag = "1")]
    iteration: u64,
    #[prost(double, tag = "2")]
    max: f64,
    #[prost(uint64, tag = "3")]
    at: u64,
    #[prost(double, tag = "4")]
    rms: f64,
    #[prost(double, tag = "5")]
    sum: f64,
    #[prost(double, optional, tag = "6")]
    fixed_max: Option<f64>,
    #[prost(double, optional, tag = "7")]
    homogeneous: Option<f64>,
    #[prost(double, optional, tag = "8")]
    gradient: Option<f64>,
    #[prost(double, optional, tag = "9")]
    rate: Option<f64>,
    #[prost(uint64, tag = "10")]
    moved: u64,
    #[prost(uint64, optional, tag = "11")]
    bad_weight_at: Option<u64>,
    #[prost(double, tag = "12")]
    bad_weight: f64,
    #[prost(uint64, optional, tag = "13")]
    predicted: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct ForecastMessage {
    #[prost(double, optional, tag = "1")]
    lambda_min: Option<f64>,
    #[prost(double, optional, tag = "2")]
    omega: Option<f64>,
    #[prost(double, optional, tag = "3")]
    rate: Option<f64>,
    #[prost(uint64, optional, tag = "4")]
    exact_after: Option<u64>,
    #[prost(double, optional, tag = "5")]
    rounding: Option<f64>,
    #[prost(double, optional, tag = "6")]
    interval: Option<f64>,
    #[prost(double, optional, tag = "7")]
    block: Option<f64>,
    #[prost(uint64, tag = "8")]
    without_data: u64,
}

/// Which job was made for a key.
#[derive(Clone, PartialEq, Message)]
pub(super) struct KeyMessage {
    #[prost(bytes = "vec", tag = "1")]
    id: Vec<u8>,
    #[prost(bytes = "vec", tag = "2")]
    digest: Vec<u8>,
    #[prost(message, optional, tag = "3")]
    at: Option<Time>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum StateCode {
    Unknown = 0,
    Queued = 1,
    Running = 2,
    Converged = 3,
    Exhausted = 4,
    Stalled = 5,
    Failed = 6,
    Cancelled = 7,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum ReasonCode {
    None = 0,
    Stationary = 1,
    Convexity = 2,
    Nilpotent = 3,
    Rounding = 4,
    Diverging = 5,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum FailureCode {
    None = 0,
    Overflow = 1,
    Defect = 2,
    Crashes = 3,
}

const STATES: [(State, StateCode); 7] = [
    (State::Queued, StateCode::Queued),
    (State::Running, StateCode::Running),
    (State::Converged, StateCode::Converged),
    (State::Exhausted, StateCode::Exhausted),
    (State::Stalled, StateCode::Stalled),
    (State::Failed, StateCode::Failed),
    (State::Cancelled, StateCode::Cancelled),
];

const REASONS: [(Option<Reason>, ReasonCode); 6] = [
    (None, ReasonCode::None),
    (Some(Reason::Stationary), ReasonCode::Stationary),
    (
        Some(Reason::Stalled(Stall::Convexity)),
        ReasonCode::Convexity,
    ),
    (
        Some(Reason::Stalled(Stall::Nilpotent)),
        ReasonCode::Nilpotent,
    ),
    (Some(Reason::Stalled(Stall::Rounding)), ReasonCode::Rounding),
    (
        Some(Reason::Stalled(Stall::Diverging)),
        ReasonCode::Diverging,
    ),
];

const FAILURES: [(Option<Failure>, FailureCode); 4] = [
    (None, FailureCode::None),
    (Some(Failure::Overflow), FailureCode::Overflow),
    (Some(Failure::Defect), FailureCode::Defect),
    (Some(Failure::Crashes), FailureCode::Crashes),
];

/// The code of a value; the tables above have all values.
fn code<T: PartialEq, C: Copy + Default>(table: &[(T, C)], value: &T) -> C {
    let entry = table.iter().find(|(known, _)| known == value);
    entry.map_or(C::default(), |(_, code)| *code)
}

fn meaning<T: Copy, C: PartialEq>(table: &[(T, C)], code: C) -> Result<T, StoreError> {
    let entry = table.iter().find(|(_, known)| *known == code);
    entry
        .map(|(value, _)| *value)
        .ok_or_else(|| damaged("a code is not known"))
}

impl Header {
    /// The header of a record.
    pub(super) fn new(record: &Record, bytes: u64, key: Option<String>) -> Self {
        let outline = &record.outline;
        let label = &outline.label;
        Self {
            id: outline.id.as_bytes().to_vec(),
            name: label.name.clone(),
            parent: label.parent.map(|parent| parent.id.as_bytes().to_vec()),
            parent_iteration: label.parent.map_or(0, |parent| parent.iteration as u64),
            stream: label
                .stream
                .as_deref()
                .and_then(|it| serde_json::to_string(it).ok()),
            created: Some(outline.created.into()),
            surface: outline.surface,
            rows: outline.grid.rows as u64,
            columns: outline.grid.columns as u64,
            method: Some((&outline.method).into()),
            adjusted: outline.adjusted.map(|count| count as u64),
            tolerance: outline.tolerance,
            max_iterations: outline.max_iterations as u64,
            memory: outline.memory as u64,
            step_cost: outline.step_cost as u64,
            status: Some((&record.status).into()),
            crashes: record.crashes,
            bytes,
            key,
            watched: record.watched,
            warnings: outline
                .warnings
                .iter()
                .filter_map(WarningMessage::new)
                .collect(),
            bases_differ: outline.bases_differ,
        }
    }

    /// The state of the job is another one now.
    pub(super) fn set_status(&mut self, status: &Status) {
        self.status = Some(status.into());
    }

    /// The job was running in a crash, after which this is its record.
    pub(super) fn recover(&mut self, record: &Record) {
        self.set_status(&record.status);
        (self.crashes, self.watched) = (record.crashes, record.watched);
    }

    /// The record of a header.
    pub(super) fn into_record(self) -> Result<Record, StoreError> {
        let iteration = number(self.parent_iteration)?;
        let parent = self.parent.map(|id| {
            Ok::<_, StoreError>(Parent {
                id: uuid(&id)?,
                iteration,
            })
        });
        Ok(Record {
            outline: Outline {
                id: uuid(&self.id)?,
                label: Label {
                    name: self.name,
                    parent: parent.transpose()?,
                    stream: self.stream.map(|text| stream(&text)).transpose()?,
                },
                created: time(self.created)?,
                surface: self.surface,
                grid: Grid {
                    rows: number(self.rows)?,
                    columns: number(self.columns)?,
                },
                method: self
                    .method
                    .ok_or_else(|| damaged("no method"))?
                    .try_into()?,
                adjusted: self.adjusted.map(number).transpose()?,
                tolerance: self.tolerance,
                max_iterations: number(self.max_iterations)?,
                memory: number(self.memory)?,
                step_cost: number(self.step_cost)?,
                warnings: self
                    .warnings
                    .iter()
                    .filter_map(WarningMessage::meaning)
                    .collect(),
                bases_differ: self.bases_differ,
            },
            status: self
                .status
                .ok_or_else(|| damaged("no status"))?
                .try_into()?,
            crashes: self.crashes,
            watched: self.watched,
        })
    }
}

impl From<&Status> for StatusMessage {
    fn from(status: &Status) -> Self {
        Self {
            state: code(&STATES, &status.state) as i32,
            started: status.started.map(Time::from),
            finished: status.finished.map(Time::from),
            first: status.levels.map(|levels| levels.first.into()),
            last: status.levels.map(|levels| levels.last.into()),
            forecast: status.levels.map(|levels| levels.forecast.into()),
            reason: code(&REASONS, &status.reason) as i32,
            failure: code(&FAILURES, &status.failure) as i32,
        }
    }
}

impl TryFrom<StatusMessage> for Status {
    type Error = StoreError;

    fn try_from(message: StatusMessage) -> Result<Self, StoreError> {
        let levels = match (message.first, message.last, message.forecast) {
            (Some(first), Some(last), forecast) => Some(Levels {
                first: first.try_into()?,
                last: last.try_into()?,
                forecast: forecast.unwrap_or_default().try_into()?,
            }),
            _ => None,
        };
        Ok(Self {
            state: meaning(&STATES, message.state())?,
            levels,
            started: message.started.map(|at| time(Some(at))).transpose()?,
            finished: message.finished.map(|at| time(Some(at))).transpose()?,
            reason: meaning(&REASONS, message.reason())?,
            failure: meaning(&FAILURES, message.failure())?,
        })
    }
}

impl From<Level> for LevelMessage {
    fn from(level: Level) -> Self {
        let error = level.error;
        Self {
            iteration: level.iteration as u64,
            max: error.max,
            at: error.at as u64,
            rms: error.rms,
            sum: error.sum,
            fixed_max: error.fixed_max,
            homogeneous: error.homogeneous,
            gradient: error.gradient,
            rate: level.rate,
            moved: level.moved as u64,
            bad_weight_at: level.bad_weight.map(|(index, _)| index as u64),
            bad_weight: level.bad_weight.map_or(0.0, |(_, weight)| weight),
            predicted: level.predicted.map(|count| count as u64),
        }
    }
}

impl TryFrom<LevelMessage> for Level {
    type Error = StoreError;

    fn try_from(message: LevelMessage) -> Result<Self, StoreError> {
        let bad = message.bad_weight_at.map(number).transpose()?;
        Ok(Self {
            iteration: number(message.iteration)?,
            error: FitError {
                max: message.max,
                at: number(message.at)?,
                rms: message.rms,
                sum: message.sum,
                fixed_max: message.fixed_max,
                homogeneous: message.homogeneous,
                gradient: message.gradient,
            },
            rate: message.rate,
            moved: number(message.moved)?,
            bad_weight: bad.map(|index| (index, message.bad_weight)),
            predicted: message.predicted.map(number).transpose()?,
        })
    }
}

impl From<Forecast> for ForecastMessage {
    fn from(forecast: Forecast) -> Self {
        Self {
            lambda_min: forecast.lambda_min,
            omega: forecast.omega,
            rate: forecast.rate,
            exact_after: forecast.exact_after.map(|count| count as u64),
            rounding: forecast.rounding,
            interval: forecast.interval,
            block: forecast.block,
            without_data: forecast.without_data as u64,
        }
    }
}

impl TryFrom<ForecastMessage> for Forecast {
    type Error = StoreError;

    fn try_from(message: ForecastMessage) -> Result<Self, StoreError> {
        Ok(Self {
            lambda_min: message.lambda_min,
            omega: message.omega,
            rate: message.rate,
            exact_after: message.exact_after.map(number).transpose()?,
            rounding: message.rounding,
            interval: message.interval,
            block: message.block,
            without_data: number(message.without_data)?,
        })
    }
}

impl KeyMessage {
    /// The entry of a key.
    pub(super) fn new(key: &Key, id: Uuid, at: Timestamp) -> Self {
        Self {
            id: id.as_bytes().to_vec(),
            digest: key.digest.to_vec(),
            at: Some(at.into()),
        }
    }

    /// What the entry says.
    pub(super) fn into_made(self) -> Result<Made, StoreError> {
        let digest = self.digest.try_into();
        Ok(Made {
            id: uuid(&self.id)?,
            digest: digest.map_err(|_| damaged("a digest is too short"))?,
            at: time(self.at)?,
        })
    }
}

impl From<Timestamp> for Time {
    fn from(at: Timestamp) -> Self {
        Self {
            seconds: at.as_second(),
            nanoseconds: at.subsec_nanosecond(),
        }
    }
}

fn time(message: Option<Time>) -> Result<Timestamp, StoreError> {
    let Time {
        seconds,
        nanoseconds,
    } = message.ok_or_else(|| damaged("no time"))?;
    Timestamp::new(seconds, nanoseconds).map_err(damaged)
}

fn stream(text: &str) -> Result<Arc<StreamSpec>, StoreError> {
    serde_json::from_str(text).map(Arc::new).map_err(damaged)
}

fn uuid(bytes: &[u8]) -> Result<Uuid, StoreError> {
    Uuid::from_slice(bytes).map_err(damaged)
}

/// A count; larger than this machine can have is damage.
pub(super) fn number(value: u64) -> Result<usize, StoreError> {
    usize::try_from(value).map_err(damaged)
}
