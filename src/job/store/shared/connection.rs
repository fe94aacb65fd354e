//! Connections to the database, and retries when one breaks.
//!
//! The pool of sqlx asks the server after each use whether a connection is still good, without a time limit: dead
//! connections would fill it. Here a connection returns to the pool only after successful work, and is closed
//! otherwise.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use deadpool::Runtime;
use deadpool::managed::{Manager, Metrics, Object, Pool, PoolError, RecycleResult};
use sqlx::postgres::{PgArguments, PgConnectOptions, PgRow};
use sqlx::query::Query;
use sqlx::{Connection, PgConnection, Postgres};
use tokio::time::{sleep, timeout};
use tracing::{info, warn};

use super::chunked_value::Value;
use crate::job::counters::Counters;
use crate::job::store::StoreError;

/// The longest time to make a connection, and to wait for one.
const CONNECT: Duration = Duration::from_secs(5);

/// The time limit of a statement that moves few bytes.
const RUN: Duration = Duration::from_secs(5);

/// The least number of bytes transferred in a second.
const RATE: usize = 2 << 20;

/// For this long statements are retried if the database could not be reached.
const PATIENCE: Duration = Duration::from_secs(4);

/// The first pause before a retry; each is twice as long as the one before.
const PAUSE: Duration = Duration::from_millis(10);

/// A statement with its arguments.
pub(super) type Statement<'q> = Query<'q, Postgres, PgArguments>;

/// Work on a connection, perhaps repeated.
pub(super) trait Work: Sync {
    type Done: Send;

    /// Does it.
    fn run(
        &self,
        connection: &mut PgConnection,
    ) -> impl Future<Output = Result<Self::Done, sqlx::Error>> + Send;
}

/// A statement, with the pieces behind its row.
struct Plain<'a, F> {
    statement: F,
    value: Option<&'a Value<'a>>,
}

impl<'q, F: Fn() -> Statement<'q> + Sync> Work for Plain<'_, F> {
    type Done = Vec<PgRow>;

    async fn run(&self, connection: &mut PgConnection) -> Result<Vec<PgRow>, sqlx::Error> {
        execute(connection, (self.statement)(), self.value).await
    }
}

/// The connections of a replica.
pub(super) struct Connections {
    pool: Pool<Connector>,
    counters: Counters,
    away: AtomicBool,
}

/// Makes connections.
struct Connector(PgConnectOptions);

impl Manager for Connector {
    type Type = PgConnection;
    type Error = sqlx::Error;

    async fn create(&self) -> Result<PgConnection, sqlx::Error> {
        PgConnection::connect_with(&self.0).await
    }

    async fn recycle(&self, _: &mut PgConnection, _: &Metrics) -> RecycleResult<sqlx::Error> {
        Ok(())
    }
}

/// A connection that is in use, which is closed where it is dropped.
struct Lease(Option<Object<Connector>>);

impl Drop for Lease {
    fn drop(&mut self) {
        if let Some(connection) = self.0.take() {
            drop(Object::take(connection));
        }
    }
}

impl Connections {
    /// At most this many connections; none is made before it is needed.
    pub(super) fn new(
        options: PgConnectOptions,
        most: usize,
        counters: Counters,
    ) -> Result<Self, StoreError> {
        let pool = Pool::builder(Connector(options))
            .max_size(most)
            .runtime(Runtime::Tokio1)
            .wait_timeout(Some(CONNECT))
            .create_timeout(Some(CONNECT))
            .build();
        Ok(Self {
            pool: pool.map_err(|error| StoreError::Failed(error.to_string()))?,
            counters,
            away: AtomicBool::new(false),
        })
    }

    /// Returns true if the database could not be reached the last time.
    pub(super) fn is_away(&self) -> bool {
        self.away.load(Ordering::Relaxed)
    }

    /// Connections that are open, and those of them that are in use.
    pub(super) fn open(&self) -> (usize, usize) {
        let status = self.pool.status();
        (status.size, status.size.saturating_sub(status.available))
    }

    /// Runs a statement that moves this many bytes, and returns its rows. See [`Self::work`].
    pub(super) async fn run<'q>(
        &self,
        bytes: usize,
        statement: impl Fn() -> Statement<'q> + Sync,
    ) -> Result<Vec<PgRow>, StoreError> {
        self.run_with(bytes, statement, None).await
    }

    /// Runs a statement; if it returns rows and there are more pieces of a value to be written, all in one transaction.
    /// See [`Self::work`].
    pub(super) async fn run_with<'q>(
        &self,
        bytes: usize,
        statement: impl Fn() -> Statement<'q> + Sync,
        value: Option<&Value<'_>>,
    ) -> Result<Vec<PgRow>, StoreError> {
        self.work(bytes, &Plain { statement, value }).await
    }

    /// Does work that moves this many bytes. If the database cannot be reached, it is retried on another connection for
    /// a while, so it must be idempotent: the first attempt may have succeeded without an answer.
    pub(super) async fn work<W: Work>(
        &self,
        bytes: usize,
        work: &W,
    ) -> Result<W::Done, StoreError> {
        let limit = RUN + Duration::from_secs_f64(bytes as f64 / RATE as f64);
        let (begin, mut pause) = (Instant::now(), PAUSE);
        loop {
            // Boxed: a wait for a statement is a part of each request that may need one.
            let once = Box::pin(self.once(limit, work));
            let error = match once.await {
                Ok(done) => {
                    self.reached();
                    return Ok(done);
                }
                Err(error) => error,
            };
            let StoreError::Away(reason) = &error else {
                return Err(error);
            };
            self.counters.store_retries.inc();
            if begin.elapsed() + pause > PATIENCE {
                self.missed(reason);
                return Err(error);
            }
            sleep(pause).await;
            pause *= 2;
        }
    }

    async fn once<W: Work>(&self, limit: Duration, work: &W) -> Result<W::Done, StoreError> {
        let mut lease = match self.pool.get().await {
            Ok(connection) => Lease(Some(connection)),
            Err(PoolError::Backend(error)) => return Err(of_database(error)),
            Err(error) => return Err(StoreError::Away(error.to_string())),
        };
        let Some(connection) = lease.0.as_deref_mut() else {
            return Err(StoreError::Failed("the connection is gone".to_owned()));
        };
        self.counters.store_statements.inc();
        let outcome = match timeout(limit, work.run(connection)).await {
            Ok(outcome) => outcome.map_err(of_database),
            Err(_) => Err(StoreError::Away(format!("no answer within {limit:?}"))),
        };
        // After an error it is closed: it may be in the middle of a transaction.
        if outcome.is_ok() {
            drop(lease.0.take());
        }
        outcome
    }

    fn reached(&self) {
        if self.away.swap(false, Ordering::Relaxed) {
            info!("the database can be reached again");
        }
    }

    fn missed(&self, reason: &str) {
        if !self.away.swap(true, Ordering::Relaxed) {
            warn!(reason, "the database cannot be reached");
        }
    }
}

/// See [`Connections::run_with`].
pub(super) async fn execute(
    connection: &mut PgConnection,
    statement: Statement<'_>,
    value: Option<&Value<'_>>,
) -> Result<Vec<PgRow>, sqlx::Error> {
    let Some(value) = value.filter(|value| value.is_long()) else {
        return statement.fetch_all(connection).await;
    };
    let mut transaction = connection.begin().await?;
    let rows = statement.fetch_all(&mut *transaction).await?;
    if !rows.is_empty() {
        value.write_rest(&mut transaction).await?;
    }
    transaction.commit().await?;
    Ok(rows)
}

/// The kind of a database error: whether it is transient, by its SQLSTATE.
pub(super) fn of_database(error: sqlx::Error) -> StoreError {
    let text = error.to_string();
    match &error {
        sqlx::Error::Database(reason) => match reason.code().as_deref() {
            // disk_full
            Some("53100") => StoreError::Full(text),
            // Connections, resources, a shutdown, a lock or statement that took too long, a deadlock, and a read-only
            // server that has just become the standby.
            Some("57014" | "40001" | "40P01" | "55P03" | "25006") => StoreError::Away(text),
            Some(code) if ["08", "53", "57P"].iter().any(|it| code.starts_with(it)) => {
                StoreError::Away(text)
            }
            _ => StoreError::Failed(text),
        },
        sqlx::Error::Io(_) | sqlx::Error::Tls(_) | sqlx::Error::Protocol(_) => {
            StoreError::Away(text)
        }
        sqlx::Error::WorkerCrashed => StoreError::Away(text),
        _ => StoreError::Failed(text),
    }
}
