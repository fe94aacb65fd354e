//! Opens the database: connections, and migration of the schema.

use std::str::FromStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use sqlx::migrate::{MigrateError, Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::{ConnectOptions, SqlSafeStr};
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};
use tracing::warn;
use uuid::Uuid;

use super::connection::{Connections, of_database};
use super::{Settings, Shared, notifications};
use crate::job::counters::Counters;
use crate::job::store::{OpenError, StoreError};
use crate::redact::redacted;

/// How long a database that cannot be reached is waited for, as it may be starting, too.
const STARTING: Duration = Duration::from_secs(60);

/// The interval between attempts.
const AGAIN: Duration = Duration::from_secs(1);

/// The time limit of an attempt, and of its migrations.
const ATTEMPT: Duration = Duration::from_secs(300);

/// Statements that take longer than this are ended by the server, with their locks; and transactions whose replica is
/// silent for this long.
const LIMITS: [(&str, &str); 3] = [
    ("statement_timeout", "120s"),
    ("idle_in_transaction_session_timeout", "30s"),
    ("lock_timeout", "10s"),
];

/// The migrations from an empty database to the schema of this version, which are only ever appended. A version of the
/// program must work with the schema of the next one: replicas are replaced one at a time.
const MIGRATIONS: [(i64, &str, &str); 2] = [
    (1, "jobs", include_str!("migrations/0001_jobs.sql")),
    (2, "secrets", include_str!("migrations/0002_secrets.sql")),
];

impl Shared {
    /// Connects to a database, and migrates its schema.
    pub(crate) async fn open(
        url: &str,
        settings: Settings,
        counters: Counters,
    ) -> Result<Arc<Self>, OpenError> {
        let options = PgConnectOptions::from_str(url);
        let options =
            options.map_err(|error| OpenError::Url(redacted(&error.to_string()).into_owned()))?;
        let options = options
            .application_name("piad")
            .options(LIMITS)
            .disable_statement_logging();
        let begin = Instant::now();
        while let Err(error) = migrate(&options).await {
            match error {
                StoreError::Away(reason) if begin.elapsed() < STARTING => {
                    warn!(reason, "waiting for the database");
                    sleep(AGAIN).await;
                }
                error => return Err(OpenError::Database(error)),
            }
        }
        let open = Connections::new(options.clone(), settings.connections, counters.clone());
        let (hint_sender, hints) = mpsc::channel(notifications::MAX_HINTS);
        let store = Arc::new(Self {
            hint_sender,
            connections: open.map_err(OpenError::Database)?,
            options,
            lease: settings.lease,
            replica: Uuid::now_v7(),
            claims: Default::default(),
            order: Default::default(),
            counters,
        });
        tokio::spawn(notifications::send_hints(Arc::downgrade(&store), hints));
        Ok(store)
    }
}

/// Migrates the schema, one replica at a time.
async fn migrate(options: &PgConnectOptions) -> Result<(), StoreError> {
    let migrations = MIGRATIONS.map(|(version, name, sql)| {
        let kind = MigrationType::Simple;
        Migration::new(version, name.into(), kind, sql.into_sql_str(), false)
    });
    let mut migrator = Migrator::with_migrations(migrations.into());
    // A later version of the program may have migrated it.
    migrator.set_ignore_missing(true);
    let migrated = async {
        // Locks are waited for, and indexes of large tables take their time.
        let patient = options
            .clone()
            .options([("lock_timeout", "0"), ("statement_timeout", "0")]);
        let pool = PgPoolOptions::new().max_connections(1);
        let pool = pool.connect_with(patient).await?;
        migrator.run(&pool).await?;
        pool.close().await;
        Ok(())
    };
    match timeout(ATTEMPT, migrated).await {
        Ok(Err(MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _))) => {
            Err(of_attempt(error))
        }
        Ok(Err(error)) => Err(StoreError::Failed(error.to_string())),
        Ok(Ok(())) => Ok(()),
        Err(_) => Err(StoreError::Away(format!("no answer within {ATTEMPT:?}"))),
    }
}

/// Why a connection could not be made. Waiting does not help with an untrusted certificate.
fn of_attempt(error: sqlx::Error) -> StoreError {
    match &error {
        sqlx::Error::Io(reason) if reason.get_ref().is_some_and(|it| it.is::<rustls::Error>()) => {
            StoreError::Failed(error.to_string())
        }
        _ => of_database(error),
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use rustls::CertificateError;

    use super::*;

    #[test]
    fn certificates_are_not_waited_for() {
        let of = |reason: io::Error| of_attempt(sqlx::Error::Io(reason));
        let refused = rustls::Error::InvalidCertificate(CertificateError::UnknownIssuer);
        let refused = of(io::Error::new(io::ErrorKind::InvalidData, refused));
        assert!(matches!(refused, StoreError::Failed(_)), "{refused}");
        let away = of(io::ErrorKind::ConnectionRefused.into());
        assert!(matches!(away, StoreError::Away(_)), "{away}");
    }
}
