//! Many readers and slow readers of one job: what is computed and encoded once, what is buffered.

use futures_util::future::join_all;
use futures_util::{Stream, StreamExt};
use serde_json::{Value, json};
use tokio::io::AsyncReadExt;

use crate::data;
use crate::program::Program;
use crate::support::{Event, Server, Story, base, events};

/// A job of 40 iterations.
fn forty_iterations() -> Value {
    let points: Vec<_> = (0..300)
        .map(|i| {
            let t = f64::from(i) / 10.0;
            json!([t.cos(), t.sin(), t])
        })
        .collect();
    json!({"curve": {"points": points}, "stop": {"tolerance": 0, "max_iterations": 40}})
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_thousand_clients_share_one_computation_and_one_encoding() {
    let server = Server::start().await;
    let job = server.create(&forty_iterations()).await;
    let path = format!("{}/events", base(&job));
    let connect = || async {
        let response = server.get(&path).send().await.unwrap();
        assert_eq!(response.status(), 200);
        Story::read(response).await
    };
    let stories = join_all((0..1000).map(|_| connect())).await;
    let first = &stories[0];
    assert_eq!(first.iterations.len(), 41);
    for story in &stories {
        assert!(story.iterations == first.iterations, "all get the same");
    }
    let counted = server.metrics().await;
    assert_eq!(counted["piad_iterations_total"], 41.0);
    assert_eq!(counted["piad_encodings_total"], 41.0);
    // The job, its iterations and its end, for each of them.
    assert_eq!(counted["piad_events_total"], 43_000.0);
}

/// The events of a response that was read with its head.
fn events_of(received: Vec<u8>) -> impl Stream<Item = Event> + Unpin {
    let head = received.windows(4).position(|four| four == b"\r\n\r\n");
    let body = received[head.unwrap() + 4..].to_vec();
    events(axum::http::Response::new(body).into())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_reads_slowly_does_not_affect_others() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::with(data.path(), &["--ring", "16MiB", "--recent", "0B"]);
    let points: Vec<_> = (0..100_000)
        .map(|i| {
            let t = f64::from(i) / 100.0;
            json!([t.cos(), t.sin(), t])
        })
        .collect();
    let large = json!({"curve": {"points": points}, "method": {"kind": "weighted", "omega": 0.3},
        "stop": {"tolerance": 0, "max_iterations": 5}});
    let path = format!("{}/events", base(&program.fit(&large).await));
    let before = program.memory();
    program.forget_most_memory();
    let mut slow = program.stalled_client(&path).await;
    let mut received = Vec::new();
    // Others get their work done between two of its kilobytes.
    for _ in 0..30 {
        let mut kilobyte = [0; 1024];
        slow.read_exact(&mut kilobyte).await.unwrap();
        received.extend_from_slice(&kilobyte);
        let job = program.fit(&data::small_job()).await;
        assert_eq!(job["state"], "converged");
    }
    let most = program.most_memory();
    // The job itself takes 24 bytes a point for its data, control points and residual each, 36 for
    // its matrix, 16 for parameters and knots; a frame as text 60. With the ring that is:
    let bound = before + 100_000 * (3 * 24 + 36 + 16 + 2 * 60) + (16 << 20);
    assert!(most < bound, "{most} bytes, {before} before, bound {bound}");

    slow.read_to_end(&mut received).await.unwrap();
    let mut events = events_of(received);
    assert_eq!(events.next().await.unwrap().name, "job");
    for k in 0..=5 {
        assert_eq!(events.next().await.unwrap().id, k.to_string());
    }
    assert_eq!(events.next().await.unwrap().name, "end");
}
