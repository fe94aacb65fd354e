//! Leases: how replicas publish which jobs they run, and take over those of a dead one.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use sqlx::Row;
use tracing::warn;
use uuid::Uuid;

use super::Shared;
use super::connection::of_database;
use super::hints::Hint;
use super::reads::record_of;
use crate::job::state::{State, Status};
use crate::job::store::{Record, StoreError, record};

const RENEW: &str = "
UPDATE jobs SET lease_until = now() + make_interval(secs => $3), status = coalesce(mine.status, jobs.status)
FROM unnest($1::uuid[], $2::bigint[], $4::bytea[]) AS mine (id, epoch, status)
WHERE jobs.id = mine.id AND jobs.epoch = mine.epoch AND jobs.state = 'running'
RETURNING jobs.id, jobs.cancel";

/// Back into the queue: jobs that this replica has, by the database, and does not know of. The answer that they were
/// stored was lost, or came after it was abandoned. Those whose answer is under way have a lease.
const RELEASE: &str = "
UPDATE jobs SET state = 'queued', status = $3, on_probation = false, owner = NULL, lease_until = NULL
WHERE owner = $1 AND state = 'running' AND lease_until < now() AND id <> ALL($2)
RETURNING id";

/// A dead replica, whose lease of a job has expired, with all the jobs that it ran. A replica with valid leases is
/// alive.
const ABANDONED: &str = "
SELECT id, outline, status, crashes, on_probation, cancel, epoch FROM jobs
WHERE state = 'running' AND lease_until < now() AND owner = (
    SELECT owner FROM jobs WHERE state = 'running'
    GROUP BY owner HAVING max(lease_until) < now() LIMIT 1
)";

/// Back into the queue, or failed, unless another replica was quicker.
const RECOVER: &str = "
UPDATE jobs SET state = $3, status = $4, crashes = $5, on_probation = false, epoch = epoch + 1,
    owner = NULL, lease_until = NULL, finished = CASE WHEN $6 THEN now() END
WHERE id = $1 AND epoch = $2 AND state = 'running' AND lease_until < now()
RETURNING followed";

const WAITING: &str = "
SELECT id, outline, status, crashes, on_probation FROM jobs
WHERE state = 'queued' ORDER BY id LIMIT $1";

const CANCEL: &str =
    "UPDATE jobs SET cancel = true WHERE id = $1 AND finished IS NULL RETURNING id";

impl Shared {
    /// The interval of renewing leases: after two failed renewals the jobs are still its own.
    pub(crate) fn heartbeat(&self) -> Duration {
        self.lease / 3
    }

    /// Renews the leases of all jobs that this replica runs, and writes their progress; returns those that a client of
    /// another replica wants to end.
    pub(crate) async fn renew(
        &self,
        running: impl Fn(Uuid) -> Option<Status>,
    ) -> Result<Vec<Uuid>, StoreError> {
        let (ids, epochs): (Vec<Uuid>, Vec<i64>) = {
            let claims = self.claims.lock();
            let held = claims.iter().filter(|(_, claim)| !claim.lost);
            held.map(|(&id, claim)| (id, claim.epoch)).unzip()
        };
        if ids.is_empty() {
            return Ok(Vec::new());
        }
        let written = |&id: &Uuid| running(id).map(|status| record::write(&status)).transpose();
        let statuses: Vec<Option<Vec<u8>>> = ids.iter().map(written).collect::<Result<_, _>>()?;
        let renew = || {
            sqlx::query(RENEW)
                .bind(&ids)
                .bind(&epochs)
                .bind(self.lease.as_secs_f64())
                .bind(&statuses)
        };
        let begin = Instant::now();
        let rows = self.connections.run(0, renew).await?;
        let (mut renewed, mut cancelled) = (HashSet::new(), Vec::new());
        for row in rows {
            let id: Uuid = row.try_get("id").map_err(of_database)?;
            renewed.insert(id);
            if row.try_get("cancel").map_err(of_database)? {
                cancelled.push(id);
            }
        }
        for id in self.lose(ids, &renewed, begin) {
            // One that was deleted is not computed any longer.
            match self.is_gone(id).await? {
                true => cancelled.push(id),
                false => warn!(job = %id, "another replica has claimed a job that this one runs"),
            }
        }
        Ok(cancelled)
    }

    /// Puts jobs back into the queue that this replica has without knowing it: others consider them its own as long as
    /// it renews some leases.
    pub(crate) async fn release_unknown(&self) -> Result<(), StoreError> {
        let known: Vec<Uuid> = self.claims.lock().keys().copied().collect();
        let status = record::write(&Status::QUEUED)?;
        let release = || {
            let release = sqlx::query(RELEASE).bind(self.replica);
            release.bind(&known).bind(&status)
        };
        let released = self.connections.run(0, release).await?;
        if !released.is_empty() {
            self.tell(Hint::Queued);
        }
        Ok(())
    }

    /// Notes which claims of these jobs were renewed; the others are lost, and are returned. Those that have ended
    /// meanwhile are not claimed any more. A lost claim is kept for its epoch, by which later writes of the job will be
    /// refused.
    fn lose(&self, ids: Vec<Uuid>, renewed: &HashSet<Uuid>, begin: Instant) -> Vec<Uuid> {
        let mut claims = self.claims.lock();
        let mut lost = ids;
        lost.retain(|id| match claims.get_mut(id) {
            Some(claim) => {
                claim.lost = !renewed.contains(id);
                claim.renewed = begin;
                claim.lost
            }
            None => false,
        });
        lost
    }

    /// Puts the jobs of dead replicas back into the queue, or fails those that have been in too many crashes. A replica
    /// that was only disconnected may continue its jobs, but writes nothing of them.
    pub(crate) async fn recover(&self) -> Result<(), StoreError> {
        loop {
            let rows = self.connections.run(0, || sqlx::query(ABANDONED)).await?;
            let jobs: Result<Vec<Record>, StoreError> = rows.iter().map(record_of).collect();
            let jobs = jobs?;
            if jobs.is_empty() {
                return Ok(());
            }
            let any_on_probation = jobs.iter().any(Record::was_on_probation);
            for (mut job, row) in jobs.into_iter().zip(&rows) {
                job.recover(any_on_probation);
                if row.try_get("cancel").map_err(of_database)? {
                    job.status.state = State::Cancelled;
                    job.status.finished = Some(Timestamp::now());
                }
                let epoch = row.try_get("epoch").map_err(of_database)?;
                self.write_recovered(&job, epoch).await?;
            }
        }
    }

    async fn write_recovered(&self, job: &Record, epoch: i64) -> Result<(), StoreError> {
        let (id, status) = (job.outline.id, record::write(&job.status)?);
        let recover = || {
            sqlx::query(RECOVER)
                .bind(id)
                .bind(epoch)
                .bind(job.status.state.name())
                .bind(&status)
                .bind(job.crashes as i32)
                .bind(job.status.finished.is_some())
        };
        if let Some(row) = self.connections.run(0, recover).await?.first() {
            self.counters.jobs_recovered.inc();
            if job.status.state == State::Queued {
                self.tell(Hint::Queued);
            } else if row.try_get("followed").map_err(of_database)? {
                self.tell(Hint::Ended(id));
            }
            warn!(job = %id, crashes = job.crashes, "the replica that ran a job is gone");
        }
        Ok(())
    }

    /// The first jobs that wait, at most `most`.
    pub(crate) async fn waiting(&self, most: usize) -> Result<Vec<Record>, StoreError> {
        let waiting = || sqlx::query(WAITING).bind(most as i64);
        let rows = self.connections.run(0, waiting).await?;
        rows.iter().map(record_of).collect()
    }

    /// Cancels a job that waits; asks the replica that runs it to end it, if one does.
    pub(crate) async fn cancel(&self, id: Uuid) -> Result<(), StoreError> {
        let status = Status {
            state: State::Cancelled,
            finished: Some(Timestamp::now()),
            ..Status::QUEUED
        };
        if !self.write_end(id, &status, None).await? {
            let cancel = || sqlx::query(CANCEL).bind(id);
            if !self.connections.run(0, cancel).await?.is_empty() {
                self.tell(Hint::Cancel(id));
            }
        }
        Ok(())
    }
}
