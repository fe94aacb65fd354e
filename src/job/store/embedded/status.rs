//! What has become of a job, as protobuf messages.

use prost::{Enumeration, Message};

use super::super::StoreError;
use super::error::damaged;
use super::fields::{Time, code, meaning, number, time};
use crate::fit::iteration::Level;
use crate::fit::norms::FitError;
use crate::fit::system::Forecast;
use crate::job::codes;
use crate::job::state::{Failure, Levels, Status};
use crate::proto::messages as pb;

/// The status of a job.
#[derive(Clone, PartialEq, Message)]
pub(super) struct StatusMessage {
    #[prost(enumeration = "pb::JobState", tag = "1")]
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
    #[prost(enumeration = "pb::EndReason", tag = "7")]
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
    #[prost(double, optional, tag = "14")]
    transformed: Option<f64>,
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum FailureCode {
    None = 0,
    Overflow = 1,
    Defect = 2,
    Crashes = 3,
}

const FAILURES: [(Option<Failure>, FailureCode); 4] = [
    (None, FailureCode::None),
    (Some(Failure::Overflow), FailureCode::Overflow),
    (Some(Failure::Defect), FailureCode::Defect),
    (Some(Failure::Crashes), FailureCode::Crashes),
];

impl From<&Status> for StatusMessage {
    fn from(status: &Status) -> Self {
        Self {
            state: codes::state(status.state).into(),
            started: status.started.map(Time::from),
            finished: status.finished.map(Time::from),
            first: status.levels.map(|levels| levels.first.into()),
            last: status.levels.map(|levels| levels.last.into()),
            forecast: status.levels.map(|levels| levels.forecast.into()),
            reason: codes::reason(status.reason).into(),
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
        let state = codes::state_of(message.state());
        Ok(Self {
            state: state.ok_or_else(|| damaged("no state"))?,
            levels,
            started: message.started.map(|at| time(Some(at))).transpose()?,
            finished: message.finished.map(|at| time(Some(at))).transpose()?,
            reason: codes::reason_of(message.reason()),
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
            transformed: error.transformed,
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
                transformed: message.transformed,
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
