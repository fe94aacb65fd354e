//! Clocks that were ahead, or are behind now.

use std::sync::Arc;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use piad::job::counters::Counters;
use piad::job::store::{IdempotencyKey, Record, Store};
use serde_json::json;
use uuid::Uuid;

use crate::data;
use crate::program::Program;
use crate::support::problem;

/// Keeps a copy of an ended job as if the clock had shown this time then; gives its path.
async fn keep_copy(store: &Store, id: Uuid, at: Timestamp, key: &str) -> String {
    let original = store.get(id).await.unwrap().unwrap();
    let input = store.problem(id).await.unwrap().unwrap();
    let result = store.result(id).await.unwrap();
    let mut copy: Record = original;
    copy.outline.id = Uuid::now_v7();
    copy.outline.created = at;
    copy.status.finished = Some(at);
    let (id, status) = (copy.outline.id, copy.status.clone());
    // The client's address comes first.
    let key = IdempotencyKey {
        name: format!("127.0.0.1\n{key}"),
        digest: [0; 32],
    };
    let inserted = store.insert(copy, input, Some(key)).await.unwrap();
    assert_eq!(inserted, None);
    store.finish(id, status, result).await.unwrap();
    format!("/v1/jobs/{id}")
}

#[tokio::test(flavor = "multi_thread")]
async fn what_was_dated_by_a_clock_that_was_ahead_is_young() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let job = program.fit(&data::small_job()).await;
    program.signal("-TERM");
    program.wait();

    let store = Arc::new(Store::open(data.path(), Counters::default()).unwrap());
    let id = job["id"].as_str().unwrap().parse().unwrap();
    let (now, days) = (Timestamp::now(), SignedDuration::from_hours(8 * 24));
    let ahead = keep_copy(&store, id, now + days, "ahead").await;
    let old = keep_copy(&store, id, now - days, "old").await;
    drop(store);

    let program = Program::start(data.path());
    // What is old is forgotten soon; what is young is not forgotten with it.
    while program.get(&old).send().await.unwrap().status() != 404 {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(program.json(&ahead).await["state"], "converged");
    let post = async |key: &str| {
        let request = program.post("/v1/jobs").header("idempotency-key", key);
        request.json(&data::small_job()).send().await.unwrap()
    };
    let (status, taken) = problem(post("ahead").await).await;
    assert_eq!(
        (status, &taken["type"]),
        (422, &json!("/problems/key-taken"))
    );
    assert_eq!(post("old").await.status(), 201);
}
