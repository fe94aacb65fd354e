//! Which jobs were made for idempotency keys, as protobuf messages.

use jiff::Timestamp;
use prost::Message;
use uuid::Uuid;

use super::super::{IdempotencyEntry, IdempotencyKey, StoreError};
use super::error::damaged;
use super::fields::{Time, time, uuid};

/// The entry of an idempotency key.
#[derive(Clone, PartialEq, Message)]
pub(super) struct EntryMessage {
    #[prost(bytes = "vec", tag = "1")]
    id: Vec<u8>,
    #[prost(bytes = "vec", tag = "2")]
    digest: Vec<u8>,
    #[prost(message, optional, tag = "3")]
    created: Option<Time>,
}

impl EntryMessage {
    /// The entry of a key, for which this job was made.
    pub(super) fn new(key: &IdempotencyKey, id: Uuid, created: Timestamp) -> Self {
        Self {
            id: id.as_bytes().to_vec(),
            digest: key.digest.to_vec(),
            created: Some(created.into()),
        }
    }

    /// The entry in these bytes.
    pub(super) fn read(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
        let message = Self::decode(bytes).map_err(damaged)?;
        let digest = message.digest.try_into();
        Ok(IdempotencyEntry {
            id: uuid(&message.id)?,
            digest: digest.map_err(|_| damaged("a digest is too short"))?,
            created: time(message.created)?,
        })
    }
}
