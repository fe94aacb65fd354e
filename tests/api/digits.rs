//! Coordinates with as many digits as the current error deserves.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::data;
use crate::numbers::numbers;
use crate::support::{Server, Story, assert_query_refused, base, events, thinned};
use futures_util::StreamExt;

/// Checks that an event is another but for coordinates that are rounded by a hundredth of the error.
fn assert_rounded(short: &Value, full: &Value, coordinates: &str) {
    let bound = 0.01 * full["error"]["max"].as_f64().unwrap();
    for (name, expected) in full.as_object().unwrap() {
        if name != coordinates {
            assert_eq!(&short[name], expected, "{name}");
            continue;
        }
        let (short, full) = (numbers(&short[name]), numbers(expected));
        assert_eq!(short.len(), full.len());
        for (short, full) in short.iter().zip(&full) {
            assert!((short - full).abs() <= bound, "{short} {full} {bound}");
        }
    }
}

fn helix() -> Value {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/helix.json");
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[tokio::test]
async fn a_helix_takes_a_third_fewer_bytes() {
    let server = Server::start().await;
    let story = server.stream(&helix()).await;
    let path = format!("{}/events", base(&story.job));
    let (short, end) = thinned(&server, &format!("{path}?digits=auto"), None).await;
    assert_eq!(end, story.end);
    let (last, others) = short.split_last().unwrap();
    assert_eq!(last, story.iterations.last().unwrap());
    assert_eq!(others.len() + 1, story.iterations.len());
    for (short, full) in others.iter().zip(&story.iterations) {
        assert_rounded(short, full, "control_points");
        let k = &full["iteration"];
        let single = format!("{}/iterations/{k}?digits=auto", base(&story.job));
        assert_eq!(&server.json(&single).await, short);
    }
    let size = async |query: &str| {
        let response = server.get(&format!("{path}?{query}")).send().await;
        response.unwrap().text().await.unwrap().len()
    };
    let (auto, full) = (size("digits=auto").await, size("digits=full").await);
    assert!(auto * 3 < full * 2, "{auto} of {full} bytes");
    // The last one is exact for each kind of request.
    let single = format!("{}/iterations/last?digits=auto", base(&story.job));
    assert_eq!(&server.json(&single).await, last);
}

#[tokio::test]
async fn surfaces_samples_weights_and_units() {
    let server = Server::start().await;
    let points = |scale: f64| {
        let points = numbers(&data::wave(30)).into_iter().map(|x| x * scale);
        let points: Vec<f64> = points.collect();
        points.chunks(2).map(<[f64]>::to_vec).collect::<Vec<_>>()
    };
    let weights: Vec<f64> = (0..30).map(|i| 1.0 + f64::from(i % 3) / 3.0).collect();
    for (job, view) in [
        (
            json!({"surface": {"points": data::peaks(8)}}),
            "control_points",
        ),
        (json!({"surface": {"points": data::peaks(8)}}), "samples"),
        (
            json!({"curve": {"points": points(1.0), "weights": weights}}),
            "control_points",
        ),
        (json!({"curve": {"points": points(1e12)}}), "control_points"),
        (json!({"curve": {"points": points(1e-200)}}), "samples"),
        (json!({"curve": {"points": points(1e200)}}), "samples"),
    ] {
        let job = server.fit(&job).await;
        let path = format!("{}/events?view={view}", base(&job));
        let (full, _) = thinned(&server, &path, None).await;
        let (short, _) = thinned(&server, &format!("{path}&digits=auto"), None).await;
        assert_eq!(short.len(), full.len());
        assert_ne!(short, full);
        for (short, full) in short.iter().zip(&full) {
            assert_rounded(short, full, view);
        }
        assert_eq!(short.last(), full.last());
    }
}

/// While it ran, this was not known to be the last level.
#[tokio::test]
async fn the_last_level_of_a_cancelled_job_is_full() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": data::wave(100)},
        "method": {"kind": "transpose"},
        "stop": {"tolerance": 0, "max_iterations": 1_000_000_000},
    });
    let request = server
        .post("/v1/jobs?digits=auto")
        .header("accept", "text/event-stream");
    let mut stream = events(request.json(&job).send().await.unwrap());
    let created = stream.next().await.unwrap().data;
    for _ in 0..20 {
        stream.next().await.unwrap();
    }
    let cancel = server.post(&format!("{}/cancel", base(&created)));
    let cancelled: Value = cancel.send().await.unwrap().json().await.unwrap();
    drop(stream);
    let last = cancelled["iteration"].as_u64().unwrap();
    let path = |digits: &str| format!("{}/iterations/{last}?digits={digits}", base(&created));
    assert_eq!(
        server.json(&path("auto")).await,
        server.json(&path("full")).await
    );
    // From a reader's own run, too.
    let seen = last.saturating_sub(2).to_string();
    let events = format!("{}/events?digits=auto", base(&created));
    let request = server.get(&events).header("last-event-id", seen);
    let story = Story::read(request.send().await.unwrap()).await;
    assert_eq!(
        story.iterations.last().unwrap(),
        &server.json(&path("full")).await
    );
}

#[tokio::test]
async fn digits_that_make_no_sense_are_refused() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let base = base(&job);
    for resource in ["events", "iterations/3"] {
        let path = format!("{base}/{resource}");
        let refused = async |query: &str, parameter: &str, reason: &str| {
            assert_query_refused(&server, &path, query, parameter, reason).await;
        };
        refused("digits=3", "digits", "full, auto").await;
        refused("digits=auto&view=errors", "digits", "without geometry").await;
        refused("digits=auto&encoding=base64_f32", "digits", "binary").await;
    }
    let result = format!("{base}/result");
    assert_query_refused(&server, &result, "digits=auto", "digits", "all digits").await;
    let full = server.json(&format!("{result}?digits=full")).await;
    assert_eq!(full, server.json(&result).await);
}
