//! Streams of jobs that a program of another arithmetic has accepted.

use std::future::ready;

use futures_util::StreamExt;
use piad_fit::engine::KERNEL;
use prost::Message;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::replicas::Replicas;
use crate::support::events;

/// Programs with different arithmetic do not continue each other's iterations: a stream restarts, and ids identify the
/// program of an iteration.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn iterations_of_another_kernel_come_again() {
    let all = Replicas::start(2).await;
    let [owner, reader] = &all.replicas[..] else {
        panic!("two replicas");
    };
    let done = owner.program.fit(&data::small_job()).await;
    // A program of kernel 1 has accepted it: the number behind the name, in MessagePack.
    all.cluster.run(
        "UPDATE jobs SET outline =
         overlay(outline PLACING '\\x01' FROM position('\\xa66b65726e656c' IN outline) + 7)",
    );
    let path = format!("{}/events", done["links"]["self"].as_str().unwrap());
    let read = async |last: &str| {
        let request = reader.program.get(&path).header("last-event-id", last);
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 200, "{last}");
        let resumed = response.headers().get("piad-resumed-after").cloned();
        let mut stream = events(response);
        let job = stream.next().await.unwrap().data;
        let iterations = stream.filter(|event| ready(event.name == "iteration"));
        let ids: Vec<String> = iterations.map(|event| event.id).collect().await;
        (resumed, job["resumed"].clone(), ids)
    };
    let (_, resumed, all_ids) = read("").await;
    assert_eq!(resumed, Value::Null);
    assert!(all_ids.len() > 3);
    let expected = (0..all_ids.len()).map(|k| format!("{k}@{KERNEL}"));
    assert!(expected.eq(all_ids.iter().cloned()), "{all_ids:?}");
    // It continues after its own iterations.
    let (after, resumed, ids) = read(&format!("2@{KERNEL}")).await;
    assert_eq!(
        (after.unwrap(), resumed),
        ("2".parse().unwrap(), Value::Null)
    );
    assert_eq!(ids, all_ids[3..]);
    // Iterations of other programs are sent again.
    for last in ["2", "2@1", &format!("2@{}", KERNEL + 1)] {
        let (after, resumed, ids) = read(last).await;
        assert_eq!((after, resumed), (None, json!("restarted")), "{last}");
        assert_eq!(ids, all_ids, "{last}");
    }
    for last in ["2@", "2@x", "@2", "2@1@2", "2@-1"] {
        let request = reader.program.get(&path).header("last-event-id", last);
        assert_eq!(request.send().await.unwrap().status(), 400, "{last}");
    }
    let request = reader.program.get(&format!("{path}?last_event_id=2"));
    let lines = request.header("accept", "application/x-ndjson");
    let lines = lines.send().await.unwrap().text().await.unwrap();
    let lines: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines[0]["data"]["resumed"], "restarted");
    assert_eq!(lines[1]["id"], format!("0@{KERNEL}"));
    let request = reader.program.get(&format!("{path}?last_event_id=2"));
    let messages = request.header("accept", "application/x-protobuf");
    let messages = messages.send().await.unwrap().bytes().await.unwrap();
    let first = pb::WatchJobResponse::decode_length_delimited(messages).unwrap();
    assert!(first.restarted);
}
