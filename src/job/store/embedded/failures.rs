//! Disks that fail at each of their operations in turn: a job that was acknowledged is there, and one that was refused
//! is not; nor is its idempotency key, nor its usage of a quota.

use std::collections::BTreeSet;
use std::io;
use std::sync::Arc;

use futures_util::future::join_all;
use jiff::Timestamp;
use parking_lot::Mutex;
use redb::StorageBackend;
use redb::backends::InMemoryBackend;
use uuid::Uuid;

use super::Embedded;
use super::file::Bytes;
use crate::job::counters::Counters;
use crate::job::quota::Quota;
use crate::job::samples::{problem, queued};
use crate::job::state::{State, Status};
use crate::job::store::{IdempotencyKey, Insertion, Record, Selection, StoreError};

/// Bytes in memory whose operations fail for a while.
#[derive(Debug, Default)]
struct Failing {
    bytes: InMemoryBackend,
    plan: Mutex<Plan>,
}

/// The failing operations.
#[derive(Clone, Copy, Debug, Default)]
struct Plan {
    /// Operations until the first that fails.
    first: usize,
    /// The number of failures.
    count: usize,
    /// True if they are done nonetheless.
    done: bool,
    /// True if reads fail, too.
    reads: bool,
}

impl Failing {
    fn attempt(&self, work: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
        let mut plan = self.plan.lock();
        if plan.count == 0 {
            return work();
        }
        if plan.first > 0 {
            plan.first -= 1;
            return work();
        }
        plan.count -= 1;
        if plan.done {
            work()?;
        }
        Err(io::Error::other("a fault"))
    }

    fn reads_fail(&self) -> bool {
        self.plan.lock().reads
    }
}

impl StorageBackend for Failing {
    fn len(&self) -> io::Result<u64> {
        self.bytes.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        match self.reads_fail() {
            true => self.attempt(|| self.bytes.read(offset, out)),
            false => self.bytes.read(offset, out),
        }
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.attempt(|| self.bytes.set_len(length))
    }

    fn sync_data(&self) -> io::Result<()> {
        self.attempt(|| Ok(()))
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.attempt(|| self.bytes.write(offset, data))
    }
}

/// The answers.
#[derive(Default)]
struct Answers {
    kept: BTreeSet<Uuid>,
    /// Deletions that have failed may have been done.
    perhaps: BTreeSet<Uuid>,
    refused: Vec<(Uuid, IdempotencyKey)>,
}

impl Answers {
    /// Inserts some jobs at once.
    async fn insert(&mut self, store: &Embedded, count: usize) {
        let jobs: Vec<(Record, IdempotencyKey)> = (0..count).map(|_| (queued(), key())).collect();
        let insert = |(record, key): &(Record, IdempotencyKey)| {
            let (record, key) = (record.clone(), Some(key.clone()));
            store.insert(record, Arc::new(problem()), key, Quota::default())
        };
        let inserted = join_all(jobs.iter().map(insert)).await;
        for ((record, key), inserted) in jobs.into_iter().zip(inserted) {
            let id = record.outline.id;
            match inserted {
                Ok(Insertion::New) => drop(self.kept.insert(id)),
                Ok(other) => panic!("{other:?}"),
                Err(_) => self.refused.push((id, key)),
            }
        }
    }

    async fn remove_first(&mut self, store: &Embedded) {
        let Some(id) = self.kept.pop_first() else {
            return;
        };
        match store.remove(id).await {
            Ok(existed) => assert!(existed),
            Err(_) => drop(self.perhaps.insert(id)),
        }
    }

    async fn finish_last(&self, store: &Embedded) {
        let Some(&id) = self.kept.last() else { return };
        let status = Status {
            state: State::Converged,
            finished: Some(store.stamp()),
            ..Status::running()
        };
        if store.finish(id, status.clone(), None).await.is_ok()
            && let Ok(record) = store.get(id).await
        {
            assert_eq!(record.unwrap().status, status);
        }
    }

    /// The contents match the answers.
    async fn check(&mut self, store: &Embedded, plan: Plan) {
        let all = Selection {
            tenant: None,
            state: None,
            before: None,
            limit: usize::MAX,
        };
        let listed = store.list(all).await.unwrap();
        let listed: BTreeSet<Uuid> = listed.iter().map(|it| it.outline.id).collect();
        let sure: BTreeSet<Uuid> = listed.difference(&self.perhaps).copied().collect();
        assert_eq!(sure, self.kept, "{plan:?}");
        for (id, key) in &self.refused {
            assert_eq!(store.get(*id).await.unwrap(), None, "{plan:?}");
            let entry = store.idempotency_entry(&key.name).await.unwrap();
            assert_eq!(entry, None, "{plan:?}");
        }
    }
}

fn key() -> IdempotencyKey {
    IdempotencyKey::new(None, &Uuid::new_v4().to_string(), [7; 32])
}

/// Some changes while operations fail. Returns false if none has failed.
async fn attempt(plan: Plan) -> bool {
    let disk = Arc::new(Failing::default());
    let bytes = Arc::clone(&disk) as Bytes;
    let store = Embedded::in_bytes(Arc::clone(&bytes), Counters::default()).unwrap();
    *disk.plan.lock() = plan;
    let mut answers = Answers::default();
    for count in [1, 3, 1] {
        answers.insert(&store, count).await;
        answers.finish_last(&store).await;
        answers.remove_first(&store).await;
    }
    let has_failed = disk.plan.lock().count < plan.count;
    disk.plan.lock().count = 0;
    // The disk works again. Changes that were refused but done are removed by the next change.
    assert!(store.remove(Uuid::now_v7()).await.is_ok_and(|it| !it));
    answers.check(&store, plan).await;
    check_quota(&store, &answers, plan).await;
    answers.insert(&store, 2).await;
    answers.check(&store, plan).await;
    drop(store);
    let store = Embedded::in_bytes(bytes, Counters::default()).unwrap();
    answers.check(&store, plan).await;
    has_failed
}

/// The counted usage matches the jobs.
async fn check_quota(store: &Embedded, answers: &Answers, plan: Plan) {
    if !answers.perhaps.is_empty() {
        return;
    }
    let mut unfinished = 0;
    for id in &answers.kept {
        let record = store.get(*id).await.unwrap().unwrap();
        unfinished += u64::from(!record.status.state.is_final());
    }
    let insert = async |jobs: u64| {
        let quota = Quota {
            jobs: Some(jobs),
            ..Quota::default()
        };
        let record = queued();
        let id = record.outline.id;
        let inserted = store.insert(record, Arc::new(problem()), None, quota).await;
        store.remove(id).await.unwrap();
        inserted.unwrap()
    };
    assert!(
        matches!(insert(unfinished).await, Insertion::Refused(_)),
        "{plan:?}"
    );
    assert_eq!(insert(unfinished + 1).await, Insertion::New, "{plan:?}");
}

async fn fail_everywhere(count: usize, done: bool, reads: bool) {
    let mut first = 0;
    loop {
        let plan = Plan {
            first,
            count,
            done,
            reads,
        };
        if !attempt(plan).await {
            break;
        }
        first += 1;
    }
    assert!(first > 30, "{first}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_commit_that_was_not_done_is_refused() {
    for count in [1, 2, 9] {
        fail_everywhere(count, false, false).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_commit_that_was_done_and_says_that_it_failed_is_settled() {
    for count in [1, 2, 9] {
        fail_everywhere(count, true, false).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_disk_that_does_not_read_for_a_while_loses_nothing() {
    for count in [1, 4, 30] {
        fail_everywhere(count, true, true).await;
    }
}

#[tokio::test]
async fn errors_that_pass_are_those_of_a_store_that_is_opened_again() {
    let disk = Arc::new(Failing::default());
    let bytes = Arc::clone(&disk) as Bytes;
    let store = Embedded::in_bytes(bytes, Counters::default()).unwrap();
    let plan = Plan {
        count: usize::MAX,
        reads: true,
        ..Plan::default()
    };
    *disk.plan.lock() = plan;
    let record = queued();
    let id = record.outline.id;
    let inserted = store.insert(record, Arc::new(problem()), None, Quota::default());
    assert!(matches!(inserted.await, Err(StoreError::Failed(_))));
    assert!(store.get(id).await.is_err());
    disk.plan.lock().count = 0;
    assert_eq!(store.get(id).await.unwrap(), None);
    assert!(store.now() <= Timestamp::now());
}
