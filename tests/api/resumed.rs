//! Readers that disconnect and resume while a job takes several steps at a time: each gets every iteration.

use std::time::{Duration, Instant};

use futures_util::StreamExt;
use futures_util::future::join_all;
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, base, events};

/// How long each of the two kinds of readers tries.
const STRESS: Duration = Duration::from_secs(10);

/// A job whose frames are too large to be kept unread, and whose steps take about a millisecond.
fn large_job() -> Value {
    json!({
        "curve": {"points": data::wave(40_000)},
        "stop": {"tolerance": 0, "max_iterations": 300},
        "method": {"kind": "transpose"},
    })
}

/// Reads one or a few iterations of a stream after another, resuming each time, to the end of the job; returns
/// how many streams that took.
async fn resume_to_the_end(server: &Server, path: &str, until: Instant) -> usize {
    let (mut last, mut streams): (Option<u64>, usize) = (None, 0);
    while Instant::now() < until {
        let mut request = server.get(&format!("{path}/events?view=errors"));
        if let Some(last) = last {
            request = request.header("last-event-id", last.to_string());
        }
        let mut stream = events(request.send().await.unwrap());
        streams += 1;
        let mut left = 1 + streams % 3;
        while left > 0 {
            let event = stream.next().await.expect("an event before the end");
            match event.name.as_str() {
                "end" => return streams,
                "iteration" => {
                    let k = event.data["iteration"].as_u64();
                    assert_eq!(k, Some(last.map_or(0, |last| last + 1)), "stream {streams}");
                    (last, left) = (k, left - 1);
                }
                _ => {}
            }
        }
    }
    streams
}

#[tokio::test(flavor = "multi_thread")]
async fn streams_that_resume_skip_no_iteration() {
    let server = Server::start().await;
    let until = Instant::now() + STRESS;
    while Instant::now() < until {
        let job = server.create(&large_job()).await;
        let streams = (0..2).map(|_| resume_to_the_end(&server, base(&job), until));
        assert!(join_all(streams).await.iter().all(|&count| count > 1));
        server.delete(base(&job)).send().await.unwrap();
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn single_iterations_are_the_requested_ones() {
    let server = Server::start().await;
    let until = Instant::now() + STRESS;
    while Instant::now() < until {
        let job = server.create(&large_job()).await;
        let path = base(&job);
        let ask = async |ahead: u64| {
            for count in 0.. {
                let now = server.json(path).await;
                if now["state"] != "running" || Instant::now() > until {
                    return;
                }
                let k = now["iteration"].as_u64().unwrap_or(0) + 1 + (count * ahead) % 9;
                let request = server.get(&format!("{path}/iterations/{k}?view=errors"));
                let response = request.header("prefer", "wait=10").send().await.unwrap();
                if response.status() == 200 {
                    let body: Value = response.json().await.unwrap();
                    assert_eq!(body["iteration"], json!(k));
                }
            }
        };
        join_all([1, 3].map(ask)).await;
        server.delete(path).send().await.unwrap();
    }
    server.stop().await;
}
