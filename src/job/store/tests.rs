//! Guarantees of the stores: in a file, in memory and in a database.

use std::sync::Arc;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::embedded::Embedded;
use super::{
    FORGOTTEN_AT_ONCE, IdempotencyKey, Insertion, Record, Retention, Selection, Spared, Store,
};
use crate::job::counters::Counters;
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::samples::{problem, queued};
use crate::job::state::{State, Status};
use crate::job::tenant::Tenant;
use piad_fit::data::Points;
use piad_fit::engine::{Bases, Problem};

mod constrained;
mod kinds;
mod quotas;
mod replicas;

/// Runs each case against a store in a file, one in memory, and one in a database.
macro_rules! for_each_store {
    ($($case:ident),+ $(,)?) => {
        mod in_a_file {
            $(#[tokio::test]
            async fn $case() {
                let directory = tempfile::tempdir().unwrap();
                let store = super::Embedded::open(directory.path(), super::Counters::default());
                super::$case(&super::Store::Embedded(store.unwrap())).await;
            })+
        }

        mod in_memory {
            $(#[tokio::test]
            async fn $case() {
                let store = super::Embedded::in_memory(super::Counters::default());
                super::$case(&super::Store::Embedded(store.unwrap())).await;
            })+
        }

        mod in_a_database {
            $(#[tokio::test]
            async fn $case() {
                let store = super::replicas::Schema::new().await.open().await;
                super::$case(&super::Store::Shared(store)).await;
            })+
        }
    };
}

for_each_store!(
    a_job_is_kept_as_it_was_inserted,
    every_kind_of_problem_is_kept_to_the_bit,
    chosen_knots_are_kept,
    writes_take_effect_in_the_order_of_their_calls,
    a_job_that_has_ended_has_its_state_and_result,
    a_job_that_is_gone_stays_gone,
    a_probation_ends_or_its_job_is_requeued,
    a_key_makes_one_job,
    a_key_that_is_sent_many_times_at_once_makes_one_job,
    a_key_is_forgotten_after_a_day,
    lists_begin_with_the_newest_job,
    lists_can_be_of_a_tenant,
    unfinished_jobs_begin_with_the_oldest,
    the_first_jobs_to_end_are_the_first_to_be_forgotten,
    jobs_are_forgotten_for_their_bytes_and_their_age,
    jobs_that_have_ended_since_are_not_forgotten,
    many_jobs_are_forgotten_in_several_goes,
    no_more_jobs_are_kept_than_a_quota_allows,
    what_jobs_take_is_given_back,
    the_first_secret_is_kept,
);

use quotas::{no_more_jobs_are_kept_than_a_quota_allows, what_jobs_take_is_given_back};

async fn the_first_secret_is_kept(store: &Store) {
    let (one, other) = tokio::join!(store.secret([1; 32]), store.secret([2; 32]));
    let kept = one.unwrap();
    assert!([[1; 32], [2; 32]].contains(&kept));
    assert_eq!(other.unwrap(), kept);
    assert_eq!(store.secret([3; 32]).await.unwrap(), kept);
}

/// Keeps everything.
const FOR_EVER: Retention = Retention {
    jobs: usize::MAX,
    bytes: u64::MAX,
    age: Duration::MAX,
};

/// Limits nothing.
const NONE: Quota = Quota {
    jobs: None,
    points: None,
    bytes: None,
    streams: None,
};

/// Lists everything.
const ALL: Selection = Selection {
    tenant: None,
    state: None,
    before: None,
    limit: usize::MAX,
};

/// Inserts a new job.
async fn insert(store: &Store) -> Record {
    let record = queued();
    insert_record(store, &record).await;
    record
}

async fn insert_record(store: &Store, record: &Record) {
    let inserted = store.insert(record.clone(), Arc::new(problem()), None, NONE);
    assert_eq!(inserted.await.unwrap(), Insertion::New);
}

/// Inserts a job with a key; returns the id of the job that was made for the key before.
async fn insert_with_key(store: &Store, record: &Record, name: &str) -> Option<Uuid> {
    let (problem, key) = (Arc::new(problem()), Some(key(name)));
    let inserted = store.insert(record.clone(), problem, key, NONE);
    match inserted.await.unwrap() {
        Insertion::Known(entry) => Some(entry.id),
        _ => None,
    }
}

fn key(name: &str) -> IdempotencyKey {
    IdempotencyKey {
        name: name.to_owned(),
        digest: [7; 32],
    }
}

/// The status of a job that converged this many seconds ago.
fn converged(seconds_ago: i64) -> Status {
    Status {
        state: State::Converged,
        finished: Some(Timestamp::now() - SignedDuration::from_secs(seconds_ago)),
        ..Status::running()
    }
}

fn control_points() -> Arc<Points> {
    let mut points = Points::new(2);
    (0..20).for_each(|i| points.push(&[f64::from(i), 0.1]));
    Arc::new(points)
}

/// Inserts a job that ended this many seconds ago.
async fn ended(store: &Store, seconds_ago: i64) -> Uuid {
    let id = insert(store).await.outline.id;
    let finished = store.finish(id, converged(seconds_ago), Some(control_points().into()));
    finished.await.unwrap();
    id
}

/// The ids of all jobs, the oldest first.
async fn ids(store: &Store) -> Vec<Uuid> {
    let records = store.list(ALL).await.unwrap();
    records.iter().rev().map(|it| it.outline.id).collect()
}

async fn a_job_is_kept_as_it_was_inserted(store: &Store) {
    let record = insert(store).await;
    let id = record.outline.id;
    assert_eq!(store.get(id).await.unwrap(), Some(record));
    let kept = store.problem(id).await.unwrap().unwrap();
    let (kept, requested) = (kept.request(), problem());
    assert_eq!(format!("{kept:?}"), format!("{:?}", requested.request()));
    assert!(store.result(id).await.unwrap().is_none());

    let unknown = Uuid::now_v7();
    assert_eq!(store.get(unknown).await.unwrap(), None);
    assert!(store.problem(unknown).await.unwrap().is_none());
    assert!(store.result(unknown).await.unwrap().is_none());
}

async fn every_kind_of_problem_is_kept_to_the_bit(store: &Store) {
    let problems = kinds::problems().into_iter().map(Arc::new);
    let jobs = problems.map(|problem| (kinds::record(&problem), problem));
    let jobs: Vec<(Record, Arc<Problem>)> = jobs.collect();
    let insert = |(record, problem): &(Record, Arc<Problem>)| {
        store.insert(record.clone(), Arc::clone(problem), None, NONE)
    };
    for inserted in futures_util::future::join_all(jobs.iter().map(insert)).await {
        assert_eq!(inserted.unwrap(), Insertion::New);
    }
    for (record, problem) in jobs {
        let id = record.outline.id;
        let kept = store.problem(id).await.unwrap().unwrap();
        let (kept, requested) = (kept.request(), problem.request());
        // Numbers are written with all of their digits, and with their signs.
        assert_eq!(format!("{kept:?}"), format!("{requested:?}"));
        assert_eq!(store.get(id).await.unwrap(), Some(record));
    }
}

/// Knots that a fit has chosen are kept with its control points.
async fn chosen_knots_are_kept(store: &Store) {
    let id = insert(store).await.outline.id;
    let bases = Bases {
        breaks: vec![
            Arc::new(vec![0.0, 0.1 + 0.2, 1.0]),
            Arc::new(vec![-1e-300, 1.0]),
        ],
        parameters: vec![Arc::new(vec![0.0, 0.7, 1.0])],
    };
    let geometry = LastGeometry {
        control_points: control_points(),
        bases: Some(Arc::new(bases.clone())),
    };
    let finished = store.finish(id, converged(0), Some(geometry));
    finished.await.unwrap();
    let kept = store.result(id).await.unwrap().unwrap();
    assert_eq!(kept.control_points.lanes(), control_points().lanes());
    assert_eq!(kept.bases.as_deref(), Some(&bases));
}

async fn writes_take_effect_in_the_order_of_their_calls(store: &Store) {
    let record = queued();
    let id = record.outline.id;
    let inserted = store.insert(record, Arc::new(problem()), None, NONE);
    let started = store.start(id, Status::running(), false);
    let end = converged(0);
    let finished = store.finish(id, end.clone(), None);
    // The last one first.
    finished.await.unwrap();
    started.await.unwrap();
    inserted.await.unwrap();
    assert_eq!(store.get(id).await.unwrap().unwrap().status, end);
    // Lists come after the writes that were called before them, whether anybody waits for these or not.
    let other = queued();
    let not_awaited = store.insert(other.clone(), Arc::new(problem()), None, NONE);
    assert_eq!(ids(store).await, [id, other.outline.id]);
    not_awaited.await.unwrap();
}

async fn a_job_that_has_ended_has_its_state_and_result(store: &Store) {
    let record = insert(store).await;
    let (id, end) = (record.outline.id, converged(0));
    let finished = store.finish(id, end.clone(), Some(control_points().into()));
    finished.await.unwrap();
    let kept = store.get(id).await.unwrap().unwrap();
    assert_eq!(kept.status, end);
    assert_eq!(kept.outline, record.outline);
    let result = store.result(id).await.unwrap().unwrap();
    assert_eq!(result.control_points.lanes(), control_points().lanes());
}

async fn a_job_that_is_gone_stays_gone(store: &Store) {
    let id = insert(store).await.outline.id;
    assert!(store.remove(id).await.unwrap());
    assert!(!store.remove(id).await.unwrap());
    store.start(id, Status::running(), true).await.unwrap();
    store.requeue(id).await.unwrap();
    let finished = store.finish(id, converged(0), Some(control_points().into()));
    finished.await.unwrap();
    assert_eq!(store.get(id).await.unwrap(), None);
    assert!(store.problem(id).await.unwrap().is_none());
    assert!(store.result(id).await.unwrap().is_none());
    assert!(ids(store).await.is_empty());
}

async fn a_probation_ends_or_its_job_is_requeued(store: &Store) {
    let mut record = queued();
    record.crashes = 2;
    insert_record(store, &record).await;
    let id = record.outline.id;
    let seen = async || {
        let record = store.get(id).await.unwrap().unwrap();
        (record.status.state, record.on_probation, record.crashes)
    };
    store.start(id, Status::running(), true).await.unwrap();
    assert_eq!(seen().await, (State::Running, true, 2));
    store.start(id, Status::running(), false).await.unwrap();
    assert_eq!(seen().await, (State::Running, false, 2));
    store.start(id, Status::running(), true).await.unwrap();
    store.requeue(id).await.unwrap();
    assert_eq!(seen().await, (State::Queued, false, 0));
}

async fn a_key_makes_one_job(store: &Store) {
    let (first, second) = (queued(), queued());
    let id = first.outline.id;
    assert_eq!(insert_with_key(store, &first, "key").await, None);
    assert_eq!(insert_with_key(store, &second, "key").await, Some(id));
    assert_eq!(ids(store).await, [id]);
    let entry = store.idempotency_entry("key").await.unwrap().unwrap();
    assert_eq!((entry.id, entry.digest), (id, key("key").digest));
    assert_eq!(entry.created, first.outline.created);
    assert_eq!(store.idempotency_entry("other").await.unwrap(), None);
    // The key goes with its job.
    store.remove(id).await.unwrap();
    assert_eq!(store.idempotency_entry("key").await.unwrap(), None);
    assert_eq!(insert_with_key(store, &second, "key").await, None);
}

async fn a_key_that_is_sent_many_times_at_once_makes_one_job(store: &Store) {
    let records: Vec<Record> = std::iter::repeat_with(queued).take(20).collect();
    let inserted = records
        .iter()
        .map(|record| insert_with_key(store, record, "key"));
    let before = futures_util::future::join_all(inserted).await;
    // Whichever came first.
    let [first] = ids(store).await[..] else {
        panic!("one job");
    };
    for (record, before) in records.iter().zip(before) {
        let made = record.outline.id == first;
        assert_eq!(before, (!made).then_some(first));
    }
}

async fn a_key_is_forgotten_after_a_day(store: &Store) {
    let (mut old, mut ahead) = (queued(), queued());
    old.outline.created -= SignedDuration::from_hours(25);
    ahead.outline.created += SignedDuration::from_hours(25);
    assert_eq!(insert_with_key(store, &old, "old").await, None);
    assert_eq!(insert_with_key(store, &ahead, "ahead").await, None);
    assert_eq!(store.idempotency_entry("old").await.unwrap(), None);
    // A job that a wrong clock has dated in the future is young.
    let again = insert_with_key(store, &queued(), "ahead").await;
    assert_eq!(again, Some(ahead.outline.id));
    // The key is free, and the job that had it first does not take it along.
    let new = queued();
    assert_eq!(insert_with_key(store, &new, "old").await, None);
    store.retain(FOR_EVER, but([])).await.unwrap();
    store.remove(old.outline.id).await.unwrap();
    let entry = store.idempotency_entry("old").await.unwrap().unwrap();
    assert_eq!(entry.id, new.outline.id);
}

async fn lists_begin_with_the_newest_job(store: &Store) {
    let mut jobs = Vec::new();
    for index in 0..6 {
        jobs.push(match index % 2 {
            0 => insert(store).await.outline.id,
            _ => ended(store, 0).await,
        });
    }
    let list = async |state, before, limit| {
        let selection = Selection {
            state,
            before,
            limit,
            ..ALL
        };
        let records = store.list(selection).await.unwrap();
        let ids = records.iter().map(|record| record.outline.id);
        ids.collect::<Vec<Uuid>>()
    };
    assert_eq!(list(None, None, 2).await, [jobs[5], jobs[4]]);
    assert_eq!(list(None, Some(jobs[2]), 10).await, [jobs[1], jobs[0]]);
    let queued = list(Some(State::Queued), None, 10).await;
    assert_eq!(queued, [jobs[4], jobs[2], jobs[0]]);
    let converged = list(Some(State::Converged), Some(jobs[5]), 1).await;
    assert_eq!(converged, [jobs[3]]);
    assert!(list(Some(State::Failed), None, 10).await.is_empty());
}

async fn lists_can_be_of_a_tenant(store: &Store) {
    let cad: Tenant = "cad".parse().unwrap();
    let mut jobs = [const { None }; 4];
    for (index, id) in jobs.iter_mut().enumerate() {
        let mut record = queued();
        if index % 2 == 1 {
            record.outline.tenant = cad;
        }
        insert_record(store, &record).await;
        *id = Some(record.outline.id);
    }
    for (tenant, [first, second]) in [(cad, [3, 1]), (Tenant::DEFAULT, [2, 0])] {
        let list = async |limit| {
            let tenant = Some(tenant);
            let selection = Selection {
                tenant,
                limit,
                ..ALL
            };
            let records = store.list(selection).await.unwrap();
            let ids = records.iter().map(|record| Some(record.outline.id));
            ids.collect::<Vec<_>>()
        };
        assert_eq!(list(9).await, [jobs[first], jobs[second]]);
        assert_eq!(list(1).await, [jobs[first]]);
    }
    let absent = Some("absent".parse().unwrap());
    let selection = Selection {
        tenant: absent,
        ..ALL
    };
    assert!(store.list(selection).await.unwrap().is_empty());
}

async fn unfinished_jobs_begin_with_the_oldest(store: &Store) {
    let first = insert(store).await;
    ended(store, 0).await;
    let second = insert(store).await;
    let status = Status::running();
    let id = second.outline.id;
    store.start(id, status.clone(), false).await.unwrap();
    let running = Record { status, ..second };
    assert_eq!(store.unfinished().await.unwrap(), [first, running]);
}

async fn the_first_jobs_to_end_are_the_first_to_be_forgotten(store: &Store) {
    let unfinished = insert(store).await.outline.id;
    let last = ended(store, 10).await;
    let first = ended(store, 30).await;
    let second = ended(store, 20).await;
    let retain = async |jobs| {
        let retained = store.retain(Retention { jobs, ..FOR_EVER }, but([]));
        retained.await.unwrap()
    };
    assert!(retain(3).await.is_empty());
    assert_eq!(retain(1).await, [first, second]);
    assert_eq!(ids(store).await, [unfinished, last]);
    // One that is spared stays, and no younger one goes for it.
    let spared = but([last]);
    let none = Retention {
        jobs: 0,
        ..FOR_EVER
    };
    assert!(store.retain(none, spared).await.unwrap().is_empty());
    assert!(store.problem(first).await.unwrap().is_none());
    assert!(store.result(first).await.unwrap().is_none());
    assert_eq!(retain(0).await, [last]);
    assert_eq!(ids(store).await, [unfinished]);
}

/// Jobs that end after the list of jobs in use may be in use.
async fn jobs_that_have_ended_since_are_not_forgotten(store: &Store) {
    let before = ended(store, 10).await;
    let since = ended(store, -5).await;
    let far_ahead = ended(store, -3600).await;
    let none = Retention {
        jobs: 0,
        ..FOR_EVER
    };
    assert_eq!(
        store.retain(none, but([])).await.unwrap(),
        [before, far_ahead]
    );
    assert_eq!(ids(store).await, [since]);
}

/// All jobs but these may be forgotten.
fn but<const N: usize>(held: [Uuid; N]) -> Spared {
    Spared {
        held: held.into(),
        since: Timestamp::now(),
    }
}

async fn jobs_are_forgotten_for_their_bytes_and_their_age(store: &Store) {
    let old = ended(store, 100).await;
    let young = ended(store, 10).await;
    let retain = async |retention| store.retain(retention, but([])).await.unwrap();
    let age = Duration::from_secs(50);
    assert_eq!(retain(Retention { age, ..FOR_EVER }).await, [old]);
    // The coordinates of a job and of its result alone are 640 bytes.
    let bytes = 640;
    assert_eq!(retain(Retention { bytes, ..FOR_EVER }).await, [young]);
    let bytes = 100_000;
    let ahead = ended(store, -1000).await;
    let age = Duration::ZERO;
    let within = retain(Retention {
        age,
        bytes,
        jobs: 1,
    });
    assert!(within.await.is_empty());
    assert_eq!(ids(store).await, [ahead]);
}

async fn many_jobs_are_forgotten_in_several_goes(store: &Store) {
    for _ in 0..FORGOTTEN_AT_ONCE + 1 {
        ended(store, 10).await;
    }
    let none = Retention {
        jobs: 0,
        ..FOR_EVER
    };
    let forgotten = store.retain(none, but([])).await.unwrap();
    assert_eq!(forgotten.len(), FORGOTTEN_AT_ONCE);
    assert_eq!(store.retain(none, but([])).await.unwrap().len(), 1);
    assert!(ids(store).await.is_empty());
}
