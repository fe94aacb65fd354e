//! New jobs within the quota of their tenant, over all replicas.

use sqlx::postgres::PgRow;
use sqlx::{Connection, PgConnection, Row};

use super::chunked_value::Value;
use super::connection::{Statement, Work, execute};
use crate::job::outline::Outline;
use crate::job::quota::{Amount, Exceeded, Quota};

/// Insertions of jobs of a tenant with a quota wait for each other.
const LOCK: &str = "SELECT pg_advisory_xact_lock(hashtext('piad quota'), hashtext($1))";

/// The usage by the jobs of a tenant, without this one, which may be there already.
const AMOUNT: &str = "
SELECT count(*) FILTER (WHERE finished IS NULL) AS jobs,
    coalesce(sum(points) FILTER (WHERE finished IS NULL), 0)::bigint AS points,
    coalesce(sum(input_bytes + result_bytes), 0)::bigint AS bytes
FROM jobs WHERE tenant = $1 AND id <> $2";

/// The insertion of a job within the quota of its tenant.
pub(super) struct InsertWithinQuota<'a, F> {
    pub(super) outline: &'a Outline,
    pub(super) quota: &'a Quota,
    /// The usage by the job.
    pub(super) new: Amount,
    pub(super) insert: F,
    pub(super) value: &'a Value<'a>,
}

impl<'q, F: Fn() -> Statement<'q> + Sync> Work for InsertWithinQuota<'_, F> {
    type Done = Result<Vec<PgRow>, Exceeded>;

    async fn run(&self, connection: &mut PgConnection) -> Result<Self::Done, sqlx::Error> {
        if !self.quota.limits_jobs() {
            let rows = execute(connection, (self.insert)(), Some(self.value));
            return Ok(Ok(rows.await?));
        }
        let mut transaction = connection.begin().await?;
        let has = self.has(&mut transaction).await?;
        if let Err(exceeded) = self.quota.admit(self.outline.tenant, has, self.new) {
            transaction.rollback().await?;
            return Ok(Err(exceeded));
        }
        let rows = execute(&mut transaction, (self.insert)(), Some(self.value)).await?;
        transaction.commit().await?;
        Ok(Ok(rows))
    }
}

impl<F> InsertWithinQuota<'_, F> {
    /// The usage of the tenant, while no other transaction inserts a job for it.
    async fn has(&self, transaction: &mut PgConnection) -> Result<Amount, sqlx::Error> {
        let tenant = self.outline.tenant.name();
        let lock = sqlx::query(LOCK).bind(tenant);
        lock.execute(&mut *transaction).await?;
        let amount = sqlx::query(AMOUNT).bind(tenant).bind(self.outline.id);
        let row = amount.fetch_one(transaction).await?;
        let number = |name| row.try_get(name).map(|it: i64| it as u64);
        Ok(Amount {
            jobs: number("jobs")?,
            points: number("points")?,
            bytes: number("bytes")?,
        })
    }
}
