//! Fields that several messages have.
//!
//! The messages of the store are protobuf messages, so that fields can be added: a new field gets a new tag,
//! and has a sensible meaning where it is absent; tags are never changed.

use jiff::Timestamp;
use prost::Message;
use uuid::Uuid;

use super::super::StoreError;
use super::error::damaged;
use crate::fit::points::Grid;

/// A point in time.
#[derive(Clone, Copy, PartialEq, Message)]
pub(super) struct Time {
    #[prost(int64, tag = "1")]
    seconds: i64,
    #[prost(int32, tag = "2")]
    nanoseconds: i32,
}

impl From<Timestamp> for Time {
    fn from(at: Timestamp) -> Self {
        Self {
            seconds: at.as_second(),
            nanoseconds: at.subsec_nanosecond(),
        }
    }
}

/// The time of a field, which must be there.
pub(super) fn time(message: Option<Time>) -> Result<Timestamp, StoreError> {
    let Time {
        seconds,
        nanoseconds,
    } = message.ok_or_else(|| damaged("no time"))?;
    Timestamp::new(seconds, nanoseconds).map_err(damaged)
}

/// The id of a field.
pub(super) fn uuid(bytes: &[u8]) -> Result<Uuid, StoreError> {
    Uuid::from_slice(bytes).map_err(damaged)
}

/// A count; larger than this machine can have is damage.
pub(super) fn number(value: u64) -> Result<usize, StoreError> {
    usize::try_from(value).map_err(damaged)
}

/// The arrangement of points: there are some, and they can be counted.
pub(super) fn grid(rows: u64, columns: u64) -> Result<Grid, StoreError> {
    let (rows, columns) = (number(rows)?, number(columns)?);
    match rows.checked_mul(columns) {
        Some(1..) => Ok(Grid { rows, columns }),
        _ => Err(damaged("there are no points, or more than can be")),
    }
}

/// The code of a value, of a table that has all values.
pub(super) fn code<T: PartialEq, C: Copy + Default>(table: &[(T, C)], value: &T) -> C {
    let entry = table.iter().find(|(known, _)| known == value);
    entry.map_or(C::default(), |(_, code)| *code)
}

/// The value of a code.
pub(super) fn meaning<T: Copy, C: PartialEq>(table: &[(T, C)], code: C) -> Result<T, StoreError> {
    let entry = table.iter().find(|(_, known)| *known == code);
    entry
        .map(|(value, _)| *value)
        .ok_or_else(|| damaged("a code is not known"))
}
