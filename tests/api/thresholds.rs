//! Adaptive fits in which each point has a threshold of its own.

use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn peaks(threshold: &Value) -> Value {
    json!({
        "surface": {"points": data::peaks(11)},
        "method": {"kind": "adaptive", "threshold": threshold},
    })
}

/// Equal thresholds are one threshold, to the last bit.
#[tokio::test]
async fn equal_thresholds_are_one() {
    let server = Server::start().await;
    let one = server.stream(&peaks(&json!(1e-2))).await;
    let each = server.stream(&peaks(&json!(vec![[1e-2; 11]; 11]))).await;
    assert_eq!(one.state(), "converged");
    // Where there is one, forecasts may also go by the decay of errors.
    for (one, each) in one.iterations.iter().zip(&each.iterations) {
        for part in ["iteration", "error", "moved", "control_points"] {
            assert_eq!(one[part], each[part]);
        }
    }
    assert_eq!(one.end["iterations"], each.end["iterations"]);
    assert_eq!(each.state(), "converged");
    assert_eq!(one.job["stop"], each.job["stop"]);
}

/// Each point reaches its threshold, and the first level at which all do is the last.
#[tokio::test]
async fn each_point_is_within_its_own() {
    let server = Server::start().await;
    let points = data::helix();
    // Half of the helix is to be a hundred times as accurate.
    let thresholds: Vec<f64> = (0..30).map(|i| if i < 15 { 1e-2 } else { 1e-4 }).collect();
    let job = json!({
        "curve": {"points": points},
        "method": {"kind": "adaptive", "threshold": thresholds},
    });
    let story = server.stream(&job).await;
    assert_eq!(story.state(), "converged");
    // At the data the curve is `X + Δ`: a step of classical PIA from a level shows the differences.
    let path = base(&story.job).to_owned();
    let last = story.end["iterations"].as_u64().unwrap();
    let mut within = Vec::new();
    for k in [last - 1, last] {
        let step = json!({"iteration": k, "method": "global", "stop": {"max_iterations": 1}});
        let edits = server.post(&format!("{path}/edits"));
        let edited = edits.header("prefer", "wait=30").json(&step).send().await;
        let edited: Value = edited.unwrap().json().await.unwrap();
        let net = async |k: u64| -> Vec<Value> {
            let level = server
                .json(&format!("{}/iterations/{k}", base(&edited)))
                .await;
            level["control_points"].as_array().unwrap()[1..31].to_vec()
        };
        let (before, after) = (net(0).await, net(1).await);
        let moved = before.iter().zip(&after).map(|(a, b)| {
            let c = |p: &Value, c: usize| number(&p[c]);
            (0..3)
                .map(|i| (c(a, i) - c(b, i)).powi(2))
                .sum::<f64>()
                .sqrt()
        });
        within.push(
            moved
                .zip(&thresholds)
                .all(|(distance, threshold)| distance <= *threshold),
        );
    }
    assert_eq!(within, [false, true]);
    // The largest distance is that of the loose half.
    assert!(story.error(last as usize) > 1e-4 && story.error(last as usize) <= 1e-2);
    assert_eq!(number(&story.job["stop"]["tolerance"]), 1e-2);
    assert!(
        story
            .iterations
            .iter()
            .any(|it| number(&it["error"]["max"]) <= 1e-2
                && it["iteration"].as_u64().unwrap() < last)
    );
}

/// A tolerance that all points meet ends it, too.
#[tokio::test]
async fn a_tolerance_ends_it() {
    let server = Server::start().await;
    let mut grid = vec![[1e-9; 11]; 11];
    grid[0][0] = 1.0;
    let mut job = peaks(&json!(grid));
    job["stop"] = json!({"tolerance": 0.1});
    let story = server.stream(&job).await;
    assert_eq!(story.state(), "converged");
    let last = story.iterations.len() - 1;
    assert!(story.error(last) <= 0.1 && story.error(last - 1) > 0.1);
}

/// The request is returned unchanged in both encodings; outlines omit the thresholds.
#[tokio::test]
async fn thresholds_are_kept() {
    let server = Server::start().await;
    let grid: Vec<Vec<f64>> = (0..11)
        .map(|i| {
            (0..11)
                .map(|j| 0.01 + 0.001 * f64::from(i * 11 + j))
                .collect()
        })
        .collect();
    let asked = json!(grid);
    let job = server.fit(&peaks(&asked)).await;
    assert_eq!(job["state"], "converged");
    assert!(job["method"].get("threshold").is_none());
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["method"]["threshold"], asked);
    let again = server.fit(&input).await;
    assert_eq!(again["error"], job["error"]);
    // An edit keeps them.
    let edit = json!({"points": [{"index": [3, 3], "point": [0, 0, 0]}]});
    let edits = server.post(&format!("{}/edits", base(&job)));
    let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
    let edited: Value = edited.unwrap().json().await.unwrap();
    assert_eq!(edited["state"], "converged");
    let input = server.json(&format!("{}/input", base(&edited))).await;
    assert_eq!(input["method"]["threshold"], asked);
    // As messages.
    let mut client = connect(&server).await;
    let id = job["id"].as_str().unwrap().to_owned();
    let input = client
        .get_input(pb::GetInputRequest { id: id.clone() })
        .await;
    let input = input.unwrap().into_inner().input.unwrap();
    let Some(pb::method::Kind::Adaptive(adaptive)) = input.method.unwrap().kind else {
        panic!("another method");
    };
    assert_eq!(adaptive.thresholds, grid.concat());
    let job = client.get_job(pb::GetJobRequest { id }).await.unwrap();
    let Some(pb::method::Kind::Adaptive(adaptive)) =
        job.into_inner().job.unwrap().method.unwrap().kind
    else {
        panic!("another method");
    };
    assert!(adaptive.thresholds.is_empty() && adaptive.threshold == 0.0);
}

#[tokio::test]
async fn wrong_thresholds_are_named() {
    let server = Server::start().await;
    let curve = |threshold: Value| {
        json!({
            "curve": {"points": data::wave(4)},
            "method": {"kind": "adaptive", "threshold": threshold},
        })
    };
    let mut grid = vec![vec![0.1; 11]; 11];
    grid[2][5] = -1.0;
    let cases = [
        (
            curve(json!([0.1, 0.1, 0.1])),
            "/method/threshold",
            "3 thresholds for 4 points",
        ),
        (
            curve(json!([])),
            "/method/threshold",
            "0 thresholds for 4 points",
        ),
        (
            curve(json!([0.1, 0.1, 0, 0.1])),
            "/method/threshold/2",
            "threshold 2 is 0",
        ),
        (
            curve(json!([0.1, "x", 0.1, 0.1])),
            "/method/threshold/1",
            "number",
        ),
        (
            curve(json!([[0.1, 0.1], [0.1, 0.1]])),
            "/method/threshold",
            "of a curve are a list",
        ),
        (
            peaks(&json!([0.1, 0.1])),
            "/method/threshold",
            "rows of numbers",
        ),
        (
            peaks(&json!([[0.1, 0.1], [0.1]])),
            "/method/threshold/1",
            "same length",
        ),
        (
            peaks(&json!(vec![[0.1; 11]; 10])),
            "/method/threshold",
            "10 rows of 11 thresholds",
        ),
        (
            peaks(&json!(grid)),
            "/method/threshold/2/5",
            "threshold 27 is -1",
        ),
        (
            curve(json!("low")),
            "/method/threshold",
            "a number, or one for each point",
        ),
    ];
    for (job, pointer, reason) in cases {
        server.assert_refused(&job, pointer, reason).await;
    }
    // An edit of a method with another number of points.
    let job = server.fit(&data::small_job()).await;
    let edit = json!({"method": {"kind": "adaptive", "threshold": [1]}});
    let edits = server
        .post(&format!("{}/edits", base(&job)))
        .json(&edit)
        .send();
    let (status, answer) = problem(edits.await.unwrap()).await;
    assert_eq!(
        (status, &answer["errors"][0]["pointer"]),
        (422, &json!("/method/threshold"))
    );
    // In messages.
    let mut client = connect(&server).await;
    for (threshold, thresholds, field) in [
        (
            0.0,
            vec![0.1, 0.1, -1.0],
            "input.method.adaptive.thresholds[2]",
        ),
        (0.0, vec![0.1, 0.1], "input.method.adaptive.thresholds"),
        (0.5, vec![0.1; 3], "input.method.adaptive.thresholds"),
        (0.0, Vec::new(), "input.method.adaptive.threshold"),
    ] {
        let adaptive = pb::method::Adaptive {
            threshold,
            thresholds,
            omega: None,
        };
        let curve = pb::Curve {
            dimension: 1,
            points: vec![0.0, 1.0, 3.0],
            ..pb::Curve::default()
        };
        let input = pb::JobInput {
            geometry: Some(pb::job_input::Geometry::Curve(curve)),
            method: Some(pb::Method {
                kind: Some(pb::method::Kind::Adaptive(adaptive)),
            }),
            ..pb::JobInput::default()
        };
        let request = pb::CreateJobRequest {
            input: Some(input),
            ..Default::default()
        };
        let refused = client.create_job(request).await.unwrap_err();
        assert!(
            refused.message().starts_with(&format!("{field}: ")),
            "{refused:?} {field}"
        );
    }
}
