//! Reads of jobs, and the secret of all replicas.

use jiff::{SignedDuration, Timestamp};
use sqlx::Row;
use sqlx::postgres::PgRow;
use uuid::Uuid;

use super::Shared;
use super::chunked_value::{PIECE, Table};
use super::connection::of_database;
use crate::job::store::{
    IdempotencyEntry, IdempotencyKey, KEY_LIFETIME, Record, Secret, Selection, StoreError, record,
};
use crate::job::tenant::Tenant;

/// The columns that [`record_of`] reads.
const RECORD: &str = "
SELECT id, outline, status, crashes, on_probation FROM jobs WHERE id = ANY($1)";

const LIST: &str = "
SELECT id, outline, status, crashes, on_probation FROM jobs
WHERE id < $1 AND ($2::text IS NULL OR state = $2) AND ($4::text IS NULL OR tenant = $4)
ORDER BY id DESC LIMIT $3";

const UNFINISHED: &str = "
SELECT id, outline, status, crashes, on_probation FROM jobs WHERE finished IS NULL ORDER BY id";

const ENTRY: &str = "
SELECT entry FROM keys WHERE name = $1 AND created >= now() - make_interval(secs => $2)";

const KEY: &str = "
SELECT name, entry FROM keys WHERE id = $1 AND created >= now() - make_interval(secs => $2)";

/// In seconds.
const NOW: &str = "SELECT extract(epoch FROM clock_timestamp())::float8";

const IN_USE: &str = "
SELECT 1 FROM jobs WHERE state = 'running' AND lease_until > now() LIMIT 1";

/// Stores a secret unless there is one, and returns the stored one. Replicas that do it at the same time get the same.
const SECRET: &str = "
INSERT INTO secrets (name, bytes) VALUES ('tickets', $1)
ON CONFLICT (name) DO UPDATE SET name = excluded.name RETURNING bytes";

const EXISTS: &str = "SELECT 1 FROM jobs WHERE id = $1";

impl Shared {
    /// A value, if it is there.
    pub(super) async fn value(
        &self,
        table: Table,
        id: Uuid,
    ) -> Result<Option<Vec<u8>>, StoreError> {
        let selection = match table {
            Table::Inputs => "SELECT bytes FROM inputs WHERE id = $1 AND piece = $2",
            Table::Results => "SELECT bytes FROM results WHERE id = $1 AND piece = $2",
        };
        let mut value = Vec::new();
        for piece in 0_i32.. {
            let select = || sqlx::query(selection).bind(id).bind(piece);
            let rows = self.connections.run(PIECE, select).await?;
            // Without a row it is not there, or was deleted meanwhile.
            let Some(row) = rows.first() else {
                return Ok(None);
            };
            let bytes: &[u8] = row.try_get(0).map_err(of_database)?;
            value.extend_from_slice(bytes);
            if bytes.len() < PIECE {
                break;
            }
        }
        Ok(Some(value))
    }

    /// The existing ones of these jobs.
    pub(crate) async fn records(&self, ids: &[Uuid]) -> Result<Vec<Record>, StoreError> {
        let rows = self
            .connections
            .run(0, || sqlx::query(RECORD).bind(ids))
            .await?;
        rows.iter().map(record_of).collect()
    }

    pub(super) async fn read_list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        let list = || {
            sqlx::query(LIST)
                .bind(selection.before.unwrap_or(Uuid::max()))
                .bind(selection.state.map(|state| state.name()))
                .bind(i64::try_from(selection.limit).unwrap_or(i64::MAX))
                .bind(selection.tenant.map(Tenant::name))
        };
        let rows = self.connections.run(0, list).await?;
        rows.iter().map(record_of).collect()
    }

    pub(super) async fn read_unfinished(&self) -> Result<Vec<Record>, StoreError> {
        let rows = self.connections.run(0, || sqlx::query(UNFINISHED)).await?;
        rows.iter().map(record_of).collect()
    }

    /// The time of the database.
    pub(crate) async fn now(&self) -> Result<Timestamp, StoreError> {
        let rows = self.connections.run(0, || sqlx::query(NOW)).await?;
        let seconds = rows.first().map(|row| row.try_get(0)).transpose();
        let seconds: Option<f64> = seconds.map_err(of_database)?;
        let since = SignedDuration::try_from_secs_f64(seconds.unwrap_or_default());
        let at = since.and_then(Timestamp::from_duration);
        at.map_err(|error| StoreError::Failed(error.to_string()))
    }

    /// The entry of an idempotency key, unless it has expired.
    pub(super) async fn read_entry(
        &self,
        name: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        let lifetime = KEY_LIFETIME.as_secs_f64();
        let rows = self
            .connections
            .run(0, || sqlx::query(ENTRY).bind(name).bind(lifetime))
            .await?;
        let bytes = rows.first().map(|row| row.try_get(0)).transpose();
        let bytes: Option<&[u8]> = bytes.map_err(of_database)?;
        bytes.map(record::entry).transpose()
    }

    /// The idempotency key of the request that made a job, unless it has expired.
    pub(super) async fn read_key(&self, id: Uuid) -> Result<Option<IdempotencyKey>, StoreError> {
        let lifetime = KEY_LIFETIME.as_secs_f64();
        let rows = self
            .connections
            .run(0, || sqlx::query(KEY).bind(id).bind(lifetime))
            .await?;
        let Some(row) = rows.first() else {
            return Ok(None);
        };
        let entry = record::entry(row.try_get("entry").map_err(of_database)?)?;
        let name = row.try_get("name").map_err(of_database)?;
        let digest = entry.digest;
        Ok(Some(IdempotencyKey { name, digest }))
    }

    /// The stored secret; if there is none, this one, which is then stored.
    pub(super) async fn keep_secret(&self, new: Secret) -> Result<Secret, StoreError> {
        let rows = self
            .connections
            .run(0, || sqlx::query(SECRET).bind(new.as_slice()))
            .await?;
        let kept = rows.first().map(|row| row.try_get(0)).transpose();
        let kept: Option<&[u8]> = kept.map_err(of_database)?;
        kept.and_then(|bytes| bytes.try_into().ok())
            .ok_or_else(|| StoreError::Failed("the secret of the database is not one".to_owned()))
    }

    /// Returns true if there are jobs that replicas run now.
    pub(crate) async fn is_in_use(&self) -> Result<bool, StoreError> {
        let rows = self.connections.run(0, || sqlx::query(IN_USE)).await?;
        Ok(!rows.is_empty())
    }

    /// Returns true if there is no such job.
    pub(super) async fn is_gone(&self, id: Uuid) -> Result<bool, StoreError> {
        let rows = self
            .connections
            .run(0, || sqlx::query(EXISTS).bind(id))
            .await?;
        Ok(rows.is_empty())
    }
}

/// The job in a row.
pub(super) fn record_of(row: &PgRow) -> Result<Record, StoreError> {
    let id = row.try_get("id").map_err(of_database)?;
    let outline: &[u8] = row.try_get("outline").map_err(of_database)?;
    let status: &[u8] = row.try_get("status").map_err(of_database)?;
    let crashes: i32 = row.try_get("crashes").map_err(of_database)?;
    Ok(Record {
        outline: record::outline(id, outline)?,
        status: record::status(id, status)?,
        crashes: crashes as u32,
        on_probation: row.try_get("on_probation").map_err(of_database)?,
    })
}
