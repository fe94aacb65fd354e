//! Jobs that are in the store only, as after a refusal while the disk failed: all requests for them are answered.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::timeout;

use super::{JobLimits, Jobs};
use crate::job::counters::Counters;
use crate::job::outline::Label;
use crate::job::quota::Quota;
use crate::job::resources::Resources;
use crate::job::samples::{problem, queued};
use crate::job::scheduler::Scheduler;
use crate::job::service::refused::Refused;
use crate::job::slots::PerPeer;
use crate::job::store::{
    IdempotencyKey, Insertion, Retention, Selection, Store, StoreError, StorePlace,
};

const PATIENCE: Duration = Duration::from_secs(60);

async fn jobs() -> Arc<Jobs> {
    let store = Store::open(StorePlace::Memory, Counters::default()).await;
    let scheduler = Scheduler::new(1).unwrap();
    let resources = Resources::new(scheduler, 1 << 30, 1 << 20);
    let retention = Retention {
        jobs: 100,
        bytes: 1 << 30,
        age: Duration::from_secs(3600),
    };
    let limits = JobLimits {
        recent: 1 << 20,
        jobs: 100,
        jobs_of_a_peer: PerPeer::Fair,
        retention,
    };
    let store = Arc::new(store.unwrap());
    Arc::new(Jobs::new(store, Arc::new(resources), limits))
}

#[tokio::test]
async fn a_job_that_is_only_in_the_store_is_not_waited_for() {
    let jobs = jobs().await;
    let (record, key) = (queued(), IdempotencyKey::new(None, "key", [7; 32]));
    let id = record.outline.id;
    let (problem_of_job, with_key) = (Arc::new(problem()), Some(key.clone()));
    let inserted = jobs
        .store
        .insert(record, problem_of_job, with_key, Quota::default());
    assert_eq!(inserted.await.unwrap(), Insertion::New);

    let found = timeout(PATIENCE, jobs.find(id)).await.unwrap();
    assert!(found.unwrap().is_none());
    let all = Selection {
        tenant: None,
        state: None,
        before: None,
        limit: 10,
    };
    let listed = timeout(PATIENCE, jobs.list(all)).await.unwrap();
    assert!(listed.unwrap().is_empty());
    let again = jobs.create(Label::default(), problem(), None, Some(key.clone()));
    let refused = timeout(PATIENCE, again).await.unwrap().unwrap_err();
    assert!(
        matches!(refused, Refused::Store(StoreError::Unusable(_))),
        "{refused}"
    );
    assert!(timeout(PATIENCE, jobs.delete(id)).await.unwrap().unwrap());
    let created = jobs.create(Label::default(), problem(), None, Some(key));
    assert!(!created.await.unwrap().replayed);
}
