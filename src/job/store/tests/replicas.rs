//! Several replicas with one database.

use std::env;
use std::sync::Arc;
use std::time::Duration;

use sqlx::{AssertSqlSafe, Connection, PgConnection, raw_sql};
use tokio::sync::mpsc::Receiver;
use tokio::time::sleep;
use uuid::Uuid;

use super::{control_points, converged, insert_record};
use crate::job::counters::Counters;
use crate::job::samples::{problem, queued};
use crate::job::state::{Failure, Levels, State, Status};
use crate::job::store::crash_recovery::MOST_CRASHES;
use crate::job::store::shared::hints::Hint;
use crate::job::store::shared::{Settings, Shared};
use crate::job::store::{Record, Store};
use piad_fit::engine::{Iteration, System};

/// A part of the database of the tests.
pub(super) struct Schema {
    url: String,
    name: String,
}

impl Schema {
    pub(super) async fn new() -> Self {
        let url = env::var("PIAD_TEST_DATABASE");
        let url = url.expect("PIAD_TEST_DATABASE: these tests run in tests/postgres");
        let name = format!("test_{}", Uuid::new_v4().simple());
        let schema = Self { url, name };
        schema.run(&format!("CREATE SCHEMA {}", schema.name)).await;
        schema
    }

    /// A replica.
    pub(super) async fn open(&self) -> Arc<Shared> {
        let url = format!("{}&options[search_path]={}", self.url, self.name);
        let settings = Settings {
            connections: 5,
            lease: Duration::from_secs(15),
        };
        Shared::open(&url, settings, Counters::default())
            .await
            .unwrap()
    }

    async fn run(&self, statement: &str) {
        let mut connection = PgConnection::connect(&self.url).await.unwrap();
        let statement = raw_sql(AssertSqlSafe(statement.to_owned()));
        statement.execute(&mut connection).await.unwrap();
    }

    /// Lets all leases expire.
    async fn run_out(&self) {
        let statement = format!(
            "UPDATE {}.jobs SET lease_until = now() - interval '1 s'",
            self.name
        );
        self.run(&statement).await;
    }
}

/// Two replicas of one database.
async fn two() -> (Schema, Store, Store) {
    let schema = Schema::new().await;
    let (one, other) = (schema.open().await, schema.open().await);
    (schema, Store::Shared(one), Store::Shared(other))
}

/// A job that the replica of this store runs.
async fn running(store: &Store) -> Uuid {
    let record = Record::new(queued().outline, Status::running());
    insert_record(store, &record).await;
    record.outline.id
}

async fn state(store: &Store, id: Uuid) -> State {
    store.get(id).await.unwrap().unwrap().status.state
}

#[tokio::test]
async fn a_job_is_claimed_by_one_replica() {
    let (_schema, one, other) = two().await;
    let record = queued();
    insert_record(&one, &record).await;
    let id = record.outline.id;
    let start = |store: &Store| store.start(id, Status::running(), false);
    let (first, second) = tokio::join!(start(&one), start(&other));
    let (first, second) = (first.unwrap(), second.unwrap());
    assert!(first != second, "{first} {second}");
    let (owner, reader) = if first {
        (&one, &other)
    } else {
        (&other, &one)
    };
    // A replica that does not run it cannot end it.
    assert!(!reader.finish(id, converged(0), None).await.unwrap());
    assert_eq!(state(reader, id).await, State::Running);
    assert!(
        owner
            .finish(id, converged(0), Some(control_points().into()))
            .await
            .unwrap()
    );
    assert_eq!(state(reader, id).await, State::Converged);
    assert!(reader.result(id).await.unwrap().is_some());
}

#[tokio::test]
async fn what_a_replica_writes_that_was_away_is_refused() {
    let (schema, paused, other) = two().await;
    let id = running(&paused).await;
    // It is paused for longer than its lease.
    schema.run_out().await;
    other.shared().unwrap().recover().await.unwrap();
    assert_eq!(state(&other, id).await, State::Queued);
    let refused = async || {
        let finished = paused.finish(id, converged(0), None).await.unwrap();
        !finished && paused.requeue(id).await.is_ok()
    };
    assert!(refused().await);
    assert_eq!(state(&other, id).await, State::Queued);
    assert!(other.start(id, Status::running(), false).await.unwrap());
    assert!(!paused.finish(id, converged(0), None).await.unwrap());
    assert_eq!(state(&other, id).await, State::Running);
    assert!(other.finish(id, converged(0), None).await.unwrap());
}

#[tokio::test]
async fn a_lease_is_renewed_and_a_lost_one_is_not() {
    let (schema, one, other) = two().await;
    let (kept, lost, deleted) = (
        running(&one).await,
        running(&one).await,
        running(&one).await,
    );
    let replica = one.shared().unwrap();
    schema.run_out().await;
    // The job was not taken over meanwhile: it is still its own.
    assert!(replica.renew(silent).await.unwrap().is_empty());
    other.shared().unwrap().recover().await.unwrap();
    for id in [kept, lost, deleted] {
        assert_eq!(state(&other, id).await, State::Running);
    }
    let take = format!(
        "UPDATE {}.jobs SET epoch = epoch + 1 WHERE id = '{lost}'",
        schema.name
    );
    schema.run(&take).await;
    other.shared().unwrap().cancel(kept).await.unwrap();
    assert!(other.remove(deleted).await.unwrap());
    let mut ended = replica.renew(silent).await.unwrap();
    ended.sort_unstable();
    assert_eq!(ended, [kept, deleted]);
    // Reported once.
    assert_eq!(replica.renew(silent).await.unwrap(), [kept]);
    assert!(!one.finish(lost, converged(0), None).await.unwrap());
    assert!(one.finish(kept, converged(0), None).await.unwrap());
}

/// A replica that reports no progress of its jobs.
fn silent(_: Uuid) -> Option<Status> {
    None
}

#[tokio::test]
async fn leases_report_progress() {
    let (_schema, one, other) = two().await;
    let (reported, ended) = (running(&one).await, running(&one).await);
    let mut iteration = Iteration::start(System::new(problem().into()).into());
    let first = iteration.level();
    iteration.steps(7, &mut |_| {});
    let levels = Levels {
        first,
        last: iteration.level(),
        forecast: iteration.system().forecast(),
    };
    let status = |_| {
        Some(Status {
            levels: Some(levels),
            ..Status::running()
        })
    };
    assert!(one.finish(ended, converged(0), None).await.unwrap());
    one.shared().unwrap().renew(status).await.unwrap();
    let levels_of = async |id| other.get(id).await.unwrap().unwrap().status.levels;
    assert_eq!(levels_of(reported).await, Some(levels));
    assert_eq!(levels_of(ended).await, None);
    // Without news the last ones stay.
    one.shared().unwrap().renew(silent).await.unwrap();
    assert_eq!(levels_of(reported).await, Some(levels));
}

#[tokio::test]
async fn a_job_that_its_replica_does_not_know_of_goes_back() {
    let (schema, one, other) = two().await;
    let (known, unknown) = (running(&one).await, running(&other).await);
    let take = format!(
        "UPDATE {0}.jobs SET owner = (SELECT owner FROM {0}.jobs WHERE id = '{known}')",
        schema.name
    );
    schema.run(&take).await;
    let replica = one.shared().unwrap();
    // Its answer may be under way.
    replica.release_unknown().await.unwrap();
    assert_eq!(state(&one, unknown).await, State::Running);
    schema.run_out().await;
    replica.renew(silent).await.unwrap();
    // Others consider it running.
    other.shared().unwrap().recover().await.unwrap();
    assert_eq!(state(&one, unknown).await, State::Running);
    replica.release_unknown().await.unwrap();
    assert_eq!(state(&one, known).await, State::Running);
    let released = one.get(unknown).await.unwrap().unwrap();
    assert_eq!(released.status.state, State::Queued);
    assert_eq!(released.crashes, 0);
    assert!(
        other
            .start(unknown, Status::running(), false)
            .await
            .unwrap()
    );
}

#[tokio::test]
async fn a_job_whose_replicas_go_fails_in_the_end() {
    let (schema, one, other) = two().await;
    let id = running(&one).await;
    for crash in 1..=MOST_CRASHES {
        schema.run_out().await;
        other.shared().unwrap().recover().await.unwrap();
        let record = other.get(id).await.unwrap().unwrap();
        assert_eq!(record.crashes, crash);
        match crash {
            MOST_CRASHES => assert_eq!(record.status.failure, Some(Failure::Crashes)),
            // It is on probation, as after every crash.
            _ => assert!(one.start(id, Status::running(), true).await.unwrap()),
        }
    }
    assert!(!one.finish(id, converged(0), None).await.unwrap());
    assert_eq!(state(&one, id).await, State::Failed);
}

#[tokio::test]
async fn a_job_is_cancelled_from_any_replica() {
    let (schema, one, other) = two().await;
    let waiting = queued();
    insert_record(&one, &waiting).await;
    let runs = running(&one).await;
    let cancel = async |id| other.shared().unwrap().cancel(id).await.unwrap();
    cancel(waiting.outline.id).await;
    assert_eq!(state(&one, waiting.outline.id).await, State::Cancelled);
    assert!(
        !one.start(waiting.outline.id, Status::running(), false)
            .await
            .unwrap()
    );
    cancel(runs).await;
    assert_eq!(state(&one, runs).await, State::Running);
    // Its replica dies before it can cancel it.
    schema.run_out().await;
    other.shared().unwrap().recover().await.unwrap();
    assert_eq!(state(&one, runs).await, State::Cancelled);
    // A job that has ended is unchanged.
    cancel(runs).await;
    assert_eq!(state(&one, runs).await, State::Cancelled);
}

/// The hints about these jobs, to the last of them. Other tests use the same database.
async fn heard(hints: &mut Receiver<Hint>, of: &[Uuid], last: Hint) -> Vec<Hint> {
    let mut heard = Vec::new();
    while heard.last() != Some(&last) {
        let hint = hints.recv().await.unwrap();
        let id = match hint {
            Hint::Queued => continue,
            Hint::Started(id) | Hint::Ended(id) | Hint::Deleted(id) | Hint::Cancel(id) => id,
        };
        heard.extend(of.contains(&id).then_some(hint));
    }
    heard
}

#[tokio::test]
async fn replicas_hear_of_jobs_that_they_wait_for() {
    let (_schema, one, other) = two().await;
    let mut hints = other.shared().unwrap().hints();
    // Until it listens.
    sleep(Duration::from_millis(500)).await;
    let ids = [queued(), queued(), queued(), queued()].map(|record| record.outline.id);
    for id in ids {
        let mut record = queued();
        record.outline.id = id;
        insert_record(&one, &record).await;
    }
    while hints.recv().await.unwrap() != Hint::Queued {}
    let [unread, read, taken, deleted] = ids;
    let start = async |store: &Store, id| store.start(id, Status::running(), false).await.unwrap();
    let finish = async |store: &Store, id| store.finish(id, converged(0), None).await.unwrap();
    other.shared().unwrap().follow(read).await.unwrap();
    for id in [unread, read] {
        assert!(start(&one, id).await && finish(&one, id).await);
        // It is abandoned.
        assert!(one.remove(id).await.unwrap());
    }
    let said = heard(&mut hints, &ids, Hint::Ended(read)).await;
    assert_eq!(said, [Hint::Started(read), Hint::Ended(read)]);
    // The replica that has accepted a job waits for it until it has ended.
    assert!(start(&other, taken).await && finish(&other, taken).await);
    let said = heard(&mut hints, &ids, Hint::Ended(taken)).await;
    assert_eq!(said, [Hint::Started(taken), Hint::Ended(taken)]);
    assert!(start(&one, deleted).await);
    other.shared().unwrap().cancel(deleted).await.unwrap();
    assert!(other.remove(deleted).await.unwrap());
    let said = heard(&mut hints, &ids, Hint::Deleted(deleted)).await;
    assert_eq!(said, [Hint::Cancel(deleted), Hint::Deleted(deleted)]);
}

#[tokio::test]
async fn watchers_read_the_current_state() {
    let (_schema, one, other) = two().await;
    let id = running(&one).await;
    let follow = async || other.shared().unwrap().follow(id).await.unwrap();
    assert_eq!(follow().await, one.get(id).await.unwrap());
    assert!(one.finish(id, converged(3), None).await.unwrap());
    assert_eq!(follow().await.unwrap().status.state, State::Converged);
    assert!(one.remove(id).await.unwrap());
    assert_eq!(follow().await, None);
}

#[tokio::test]
async fn large_problems_are_kept_in_pieces() {
    let store = Store::Shared(Schema::new().await.open().await);
    let record = queued();
    let id = record.outline.id;
    let points: Vec<f64> = (0..1_500_000).map(|i| f64::from(i).sin()).collect();
    let large = piad_fit::data::Points::from_lanes([points.as_slice()]);
    insert_record(&store, &record).await;
    let geometry = Arc::new(large.clone()).into();
    assert!(
        store
            .finish(id, converged(0), Some(geometry))
            .await
            .unwrap()
    );
    let kept = store.result(id).await.unwrap().unwrap();
    assert_eq!(kept.control_points.lanes(), large.lanes());
    assert_eq!(
        store.problem(id).await.unwrap().unwrap().grid(),
        problem().grid()
    );
}
