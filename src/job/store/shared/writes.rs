//! Changes of a job: each is one statement, or one transaction where there are many bytes.
//!
//! Each is repeated if its answer is lost, so it must be idempotent. Changes of a job that this replica runs carry the
//! epoch of their claim: they change nothing once another replica has claimed the job.

use std::time::Instant;

use jiff::Timestamp;
use sqlx::Row;
use sqlx::postgres::PgRow;
use tracing::warn;
use uuid::Uuid;

use super::chunked_value::{Table, Value};
use super::connection::of_database;
use super::hints::Hint;
use super::reads::record_of;
use super::within::InsertWithinQuota;
use super::{Claim, Shared};
use crate::job::quota::{Amount, Quota};
use crate::job::state::{State, Status};
use crate::job::store::{
    FORGOTTEN_AT_ONCE, IdempotencyEntry, IdempotencyKey, Insertion, KEY_LIFETIME, LOOK_LIFETIME,
    Record, Retention, Spared, StoreError, record,
};

/// A new job, and its key if it is free. The first claim of a job that runs at once has epoch 1.
const INSERT: &str = "
WITH key AS (
    INSERT INTO keys (name, id, entry, created)
    SELECT $8, $1, $9, now() - make_interval(secs => $10) WHERE $8 IS NOT NULL
    ON CONFLICT (name) DO UPDATE
    SET id = excluded.id, entry = excluded.entry, created = excluded.created
    WHERE keys.created < now() - make_interval(secs => $11)
    RETURNING 1
), job AS (
    INSERT INTO jobs (id, outline, state, status, crashes, input_bytes, epoch, owner, lease_until, tenant, points)
    SELECT $1, $2, $3, $4, $5, $6, 1, $12, now() + make_interval(secs => $13), $14, $15
    WHERE $8 IS NULL OR EXISTS (SELECT FROM key)
    ON CONFLICT (id) DO NOTHING
    RETURNING id
), input AS (
    INSERT INTO inputs SELECT id, 0, $7 FROM job
)
SELECT id FROM job";

/// A claim of a job that waits, or progress of one that this replica has claimed. In the queue of the replica that has
/// accepted it it still waits.
const START: &str = "
UPDATE jobs SET state = 'running', status = $2, on_probation = $3,
    epoch = epoch + CASE state WHEN 'queued' THEN 1 ELSE 0 END,
    followed = followed OR owner IS DISTINCT FROM $4, owner = $4, lease_until = now() + make_interval(secs => $5)
WHERE id = $1 AND (state = 'queued' OR (state = 'running' AND epoch = $6 AND owner = $4))
RETURNING epoch, followed";

/// Back into the queue, at an orderly end of the replica.
const REQUEUE: &str = "
UPDATE jobs SET state = 'queued', status = $3, on_probation = false, crashes = 0,
    owner = NULL, lease_until = NULL
WHERE id = $1 AND epoch = $2 AND state = 'running'
RETURNING id";

/// The end of a job that this replica has claimed, or of one that waits.
const FINISH: &str = "
WITH job AS (
    UPDATE jobs SET state = $3, status = $4, on_probation = false, finished = now() - make_interval(secs => $5),
        result_bytes = $6, lease_until = NULL
    WHERE id = $1 AND CASE WHEN $2 IS NULL THEN state = 'queued' ELSE epoch = $2 END
    RETURNING id, followed OR owner IS DISTINCT FROM $8 AS others
), result AS (
    INSERT INTO results SELECT id, 0, $7 FROM job WHERE $7 IS NOT NULL ON CONFLICT DO NOTHING
)
SELECT others FROM job";

/// True if other replicas know of a job that has ended.
const REMOVE: &str = "
DELETE FROM jobs WHERE id = $1
RETURNING finished IS NULL AND (followed OR owner IS DISTINCT FROM $2) AS others";

/// The jobs that have ended last stay, up to the limits of number and bytes; of the others, those that are not in use
/// are removed, the first to end first. One replica at a time looks for them: the others find nothing.
const RETAIN: &str = "
WITH turn AS MATERIALIZED (
    SELECT pg_try_advisory_xact_lock(hashtext('piad retention'), hashtext(current_schema()::text)) AS mine
), surplus AS (
    SELECT id FROM (
        SELECT id, finished, row_number() OVER newest AS jobs,
            sum(input_bytes + result_bytes) OVER newest AS bytes
        FROM jobs WHERE finished IS NOT NULL
        WINDOW newest AS (ORDER BY finished DESC, id DESC)
    ) AS ended
    WHERE (SELECT mine FROM turn)
        AND (jobs > $1 OR bytes > $2 OR finished < now() - make_interval(secs => $3))
        AND id <> ALL($4)
        AND (finished <= to_timestamp($6) OR finished > to_timestamp($6) + make_interval(secs => $7))
    ORDER BY finished, id LIMIT $5
), gone AS (
    DELETE FROM jobs USING surplus WHERE jobs.id = surplus.id RETURNING jobs.id, jobs.finished
)
SELECT id FROM gone ORDER BY finished, id";

const FOLLOW: &str = "
UPDATE jobs SET followed = true WHERE id = $1 AND finished IS NULL
RETURNING id, outline, status, crashes, on_probation";

const FORGET_KEYS: &str = "DELETE FROM keys WHERE created < now() - make_interval(secs => $1)";

/// Seconds of a century: beyond it an interval may not fit into a timestamp.
const CENTURY: f64 = 3.2e9;

/// Seconds since a time. The clocks of replicas differ from that of the database, which decides ages: so an age is
/// passed, not a time.
fn age(at: Timestamp) -> f64 {
    let age = Timestamp::now().duration_since(at).as_secs_f64();
    age.clamp(-CENTURY, CENTURY)
}

impl Shared {
    /// Writes a new job, unless there is an entry for the same key, or it is beyond the quota of its tenant.
    pub(super) async fn write_job(
        &self,
        record: &Record,
        input: &[u8],
        key: Option<&IdempotencyKey>,
        quota: &Quota,
    ) -> Result<Insertion, StoreError> {
        let outline = &record.outline;
        let (id, created, tenant) = (outline.id, outline.created, outline.tenant);
        let written = record::write(outline)?;
        let status = record::write(&record.status)?;
        let entry = key.map(|key| IdempotencyEntry {
            id,
            digest: key.digest,
            created,
        });
        let entry = entry.map(|entry| record::write(&entry)).transpose()?;
        let name = key.map(|key| key.name.as_str());
        let runs = record.status.state == State::Running;
        let value = Value {
            table: Table::Inputs,
            id,
            bytes: input,
        };
        let insert = || {
            sqlx::query(INSERT)
                .bind(id)
                .bind(&written)
                .bind(record.status.state.name())
                .bind(&status)
                .bind(record.crashes as i32)
                .bind(input.len() as i64)
                .bind(value.first())
                .bind(name)
                .bind(&entry)
                .bind(age(created))
                .bind(KEY_LIFETIME.as_secs_f64())
                .bind(self.replica)
                .bind(runs.then_some(self.lease.as_secs_f64()))
                .bind(tenant.name())
                .bind(outline.grid.count() as i64)
        };
        let new = Amount {
            bytes: input.len() as u64,
            ..outline.amount()
        };
        let (connections, begin) = (&self.connections, Instant::now());
        let work = InsertWithinQuota {
            outline,
            quota,
            new,
            insert,
            value: &value,
        };
        let inserted = connections.work(input.len(), &work).await?;
        if inserted.as_ref().map_or(true, Vec::is_empty)
            // An attempt before may have succeeded without an answer.
            && self.is_gone(id).await?
        {
            let entry = match name {
                Some(name) => self.read_entry(name).await?,
                None => None,
            };
            return match (entry, inserted) {
                (Some(entry), _) => Ok(Insertion::Known(entry)),
                (None, Err(exceeded)) => Ok(Insertion::Refused(exceeded)),
                // The job of the key is gone by now.
                (None, Ok(_)) => Err(StoreError::Away("the key has just become free".to_owned())),
            };
        }
        if runs {
            self.claim(id, 1, begin);
        } else {
            self.tell(Hint::Queued);
        }
        Ok(Insertion::New)
    }

    /// Claims a job that waits, or notes the progress of one that was claimed; false if another replica has claimed it.
    pub(super) async fn write_start(
        &self,
        id: Uuid,
        status: &Status,
        on_probation: bool,
    ) -> Result<bool, StoreError> {
        let (status, epoch) = (record::write(status)?, self.epoch(id));
        let start = || {
            sqlx::query(START)
                .bind(id)
                .bind(&status)
                .bind(on_probation)
                .bind(self.replica)
                .bind(self.lease.as_secs_f64())
                .bind(epoch)
        };
        let begin = Instant::now();
        let started = self.connections.run(0, start).await?;
        let Some(row) = started.first() else {
            return self.is_gone(id).await;
        };
        let epoch = row.try_get("epoch").map_err(of_database)?;
        self.claim(id, epoch, begin);
        if row.try_get("followed").map_err(of_database)? {
            self.tell(Hint::Started(id));
        }
        Ok(true)
    }

    /// Puts a job that this replica has claimed back into the queue.
    pub(super) async fn write_requeue(&self, id: Uuid) -> Result<(), StoreError> {
        let Some(epoch) = self.epoch(id) else {
            return Ok(());
        };
        let status = record::write(&Status::QUEUED)?;
        let requeue = || sqlx::query(REQUEUE).bind(id).bind(epoch).bind(&status);
        let requeued = self.connections.run(0, requeue).await?;
        self.claims.lock().remove(&id);
        if !requeued.is_empty() {
            self.tell(Hint::Queued);
        }
        Ok(())
    }

    /// Writes the end of a job; false if another replica has claimed or ended it.
    pub(super) async fn write_end(
        &self,
        id: Uuid,
        status: &Status,
        result: Option<&[u8]>,
    ) -> Result<bool, StoreError> {
        if let Some(claim) = self.claims.lock().get_mut(&id) {
            claim.ends = true;
        }
        let (state, epoch) = (status.state.name(), self.epoch(id));
        let finished = status.finished;
        let status = record::write(status)?;
        let value = result.map(|bytes| Value {
            table: Table::Results,
            id,
            bytes,
        });
        let bytes = result.map_or(0, <[u8]>::len);
        let finish = || {
            sqlx::query(FINISH)
                .bind(id)
                .bind(epoch)
                .bind(state)
                .bind(&status)
                .bind(finished.map(age))
                .bind(bytes as i64)
                .bind(value.as_ref().map(Value::first))
                .bind(self.replica)
        };
        let finished = self
            .connections
            .run_with(bytes, finish, value.as_ref())
            .await?;
        self.claims.lock().remove(&id);
        if let Some(row) = finished.first() {
            self.tell_others(row, Hint::Ended(id))?;
            return Ok(true);
        }
        if self.is_gone(id).await? {
            return Ok(true);
        }
        if let Some(epoch) = epoch {
            self.counters.stale_writes.inc();
            warn!(job = %id, epoch, "the end of a job was refused, as another replica has claimed it");
        }
        Ok(false)
    }

    /// Deletes a job; returns true if there was one.
    pub(super) async fn delete(&self, id: Uuid) -> Result<bool, StoreError> {
        let deleted = self
            .connections
            .run(0, || sqlx::query(REMOVE).bind(id).bind(self.replica))
            .await?;
        self.claims.lock().remove(&id);
        let Some(row) = deleted.first() else {
            return Ok(false);
        };
        self.tell_others(row, Hint::Deleted(id))?;
        Ok(true)
    }

    /// The job of this id. If it has not ended, this replica is notified when it has.
    pub(crate) async fn follow(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        let follow = || sqlx::query(FOLLOW).bind(id);
        match self.connections.run(0, follow).await?.first() {
            Some(row) => record_of(row).map(Some),
            // It has ended meanwhile, or is gone.
            None => self.get(id).await,
        }
    }

    /// Sends a hint if the row says that it is for others.
    fn tell_others(&self, row: &PgRow, hint: Hint) -> Result<(), StoreError> {
        if row.try_get("others").map_err(of_database)? {
            self.tell(hint);
        }
        Ok(())
    }

    /// Deletes keys that have expired, and jobs that are beyond the retention; returns the ids of these.
    pub(super) async fn delete_surplus(
        &self,
        retention: Retention,
        spared: &Spared,
    ) -> Result<Vec<Uuid>, StoreError> {
        let held: Vec<Uuid> = spared.held.iter().copied().collect();
        let forget = || sqlx::query(FORGET_KEYS).bind(KEY_LIFETIME.as_secs_f64());
        self.connections.run(0, forget).await?;
        let retain = || {
            sqlx::query(RETAIN)
                .bind(i64::try_from(retention.jobs).unwrap_or(i64::MAX))
                .bind(i64::try_from(retention.bytes).unwrap_or(i64::MAX))
                .bind(retention.age.as_secs_f64().min(CENTURY))
                .bind(&held)
                .bind(FORGOTTEN_AT_ONCE as i64)
                .bind(spared.since.as_duration().as_secs_f64())
                .bind(LOOK_LIFETIME.as_secs_f64())
        };
        let gone = self.connections.run(0, retain).await?;
        gone.iter()
            .map(|row| row.try_get(0).map_err(of_database))
            .collect()
    }

    fn claim(&self, id: Uuid, epoch: i64, renewed: Instant) {
        let claim = Claim {
            epoch,
            renewed,
            lost: false,
            ends: false,
        };
        self.claims.lock().insert(id, claim);
    }

    /// The epoch of this replica's claim of a job.
    fn epoch(&self, id: Uuid) -> Option<i64> {
        self.claims.lock().get(&id).map(|claim| claim.epoch)
    }
}
