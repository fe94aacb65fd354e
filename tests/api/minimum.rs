//! `converged` with a tolerance that was requested means within it; a least-squares minimum above
//! it is `stalled`.

use prost::Message;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::support::{Server, base};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// A curve that eight control points are far from.
fn job(method: Value, stop: Option<Value>) -> Value {
    let mut job = json!({"curve": {"points": data::wave(60)}, "method": method});
    if let Some(stop) = stop {
        job["stop"] = stop;
    }
    job
}

fn least_squares(variant: &str) -> Value {
    json!({"kind": "least_squares", "control_points": 8, "variant": variant})
}

fn ended(job: &Value) -> (&str, Option<&str>) {
    (job["state"].as_str().unwrap(), job["reason"].as_str())
}

#[tokio::test]
async fn a_minimum_above_the_tolerance_is_stalled() {
    let server = Server::start().await;
    for variant in ["cg", "direct", "diagonal", "lspia"] {
        let stop = |tolerance: f64| Some(json!({"tolerance": tolerance, "max_iterations": 50_000}));
        let method = least_squares(variant);
        let above = server.fit(&job(method.clone(), stop(1e-4))).await;
        assert_eq!(ended(&above), ("stalled", Some("minimum")), "{variant}");
        let left = number(&above["error"]["max"]);
        assert!(left > 1e-4, "{left}");
        let detail = above["detail"].as_str().unwrap();
        let said = format!("a distance of {left:.3e} is left, the tolerance is 1.000e-4");
        assert!(detail.contains(&said), "{detail}");
        assert!(
            detail.contains("use more control points, or \"auto\""),
            "{detail}"
        );
        // The end event says the same, and so does the message.
        let events = server.stream(&job(method.clone(), stop(1e-4))).await;
        assert_eq!(ended(&events.end), ("stalled", Some("minimum")));
        assert_eq!(events.end["detail"], above["detail"]);
        let relative = Some(json!({"relative_tolerance": 1e-9, "max_iterations": 50_000}));
        let relative = server.fit(&job(method.clone(), relative)).await;
        assert_eq!(ended(&relative), ("stalled", Some("minimum")), "{variant}");
        let within = server.fit(&job(method.clone(), stop(10.0))).await;
        assert_eq!(ended(&within), ("converged", None), "{variant}");
    }
}

#[tokio::test]
async fn without_a_tolerance_the_minimum_converges() {
    let server = Server::start().await;
    for stop in [None, Some(json!({"max_iterations": 500}))] {
        let found = server.fit(&job(least_squares("cg"), stop)).await;
        assert_eq!(ended(&found), ("converged", Some("minimum")));
        let detail = found["detail"].as_str().unwrap();
        assert!(detail.contains("no tolerance was requested"), "{detail}");
        // Its input is the same, also as a message, and edits keep it.
        let input = server.json(&format!("{}/input", base(&found))).await;
        assert_eq!(input["stop"].get("tolerance"), None);
        assert_eq!(input["stop"].get("relative_tolerance"), None);
        let again = server.fit(&input).await;
        assert_eq!(ended(&again), ("converged", Some("minimum")));
        let edit = |edit: Value| {
            let request = server.post(&format!("{}/edits", base(&found)));
            request.header("prefer", "wait=60").json(&edit).send()
        };
        let moved = json!({"points": [{"index": 20, "point": [9.0, 3.0]}]});
        let moved: Value = edit(moved).await.unwrap().json().await.unwrap();
        assert_eq!(ended(&moved), ("converged", Some("minimum")));
        let asked = json!({"stop": {"tolerance": 1e-5}});
        let asked: Value = edit(asked).await.unwrap().json().await.unwrap();
        assert_eq!(ended(&asked), ("stalled", Some("minimum")));
    }
}

#[tokio::test]
async fn messages_say_the_same() {
    let server = Server::start().await;
    for (stop, state) in [
        (None, pb::JobState::Converged),
        (Some(json!({"tolerance": 1e-5})), pb::JobState::Stalled),
    ] {
        let found = server.fit(&job(least_squares("direct"), stop)).await;
        let path = base(&found);
        let accept = |path: String| server.get(&path).header("accept", "application/x-protobuf");
        let message = accept(path.to_owned()).send().await.unwrap();
        let message = pb::Job::decode(message.bytes().await.unwrap()).unwrap();
        assert_eq!(message.state(), state);
        assert_eq!(message.reason(), pb::EndReason::Minimum);
        assert_eq!(json!(message.detail), found["detail"]);
        let input = accept(format!("{path}/input")).send().await.unwrap();
        let input = pb::JobInput::decode(input.bytes().await.unwrap()).unwrap();
        let asked = input.stop.unwrap().rule.is_some();
        assert_eq!(asked, state == pb::JobState::Stalled);
    }
}

/// Automatic numbers of control points have a tolerance, even if none was requested.
#[tokio::test]
async fn automatic_fits_that_cannot_get_there_are_stalled() {
    let server = Server::start().await;
    for stop in [None, Some(json!({"tolerance": 1e-6}))] {
        let method = json!({"kind": "least_squares", "control_points": "auto", "fairness": 1e3});
        let found = server.fit(&job(method, stop)).await;
        assert_eq!(ended(&found), ("stalled", Some("minimum")), "{found:#}");
        let detail = found["detail"].as_str().unwrap();
        assert!(
            detail.contains("use a larger tolerance, or less fairness"),
            "{detail}"
        );
    }
}

/// Heights of a rough landscape, which `diagonal` does not get to the minimum of.
fn landscape(rows: usize, columns: usize) -> Vec<Vec<[f64; 3]>> {
    let height = |i: usize, j: usize| {
        let (x, y) = (i as f64 * 0.11, j as f64 * 0.13);
        let hills = 300.0 * (x.sin() * (0.7 * y).cos() + 0.5 * (2.3 * x + 1.9 * y).sin());
        let rough = ((i * 7919 + j * 104_729) % 1009) as f64 / 1009.0;
        [30.0 * j as f64, 30.0 * i as f64, hills + 40.0 * rough]
    };
    let row = |i| (0..columns).map(|j| height(i, j)).collect();
    (0..rows).map(row).collect()
}

/// The default variant ends on ordinary surfaces: an elevation grid of 86 × 101 heights with 30 × 30
/// control points was exhausted after 1000 iterations of `diagonal`.
#[tokio::test]
async fn the_default_variant_ends_on_surfaces() {
    let server = Server::start().await;
    let fit = |method: Value| {
        let job = json!({"surface": {"points": landscape(86, 101)}, "method": method});
        let server = &server;
        async move { server.fit(&job).await }
    };
    let found = fit(json!({"kind": "least_squares", "control_points": 30})).await;
    assert_eq!(found["method"]["variant"], "cg");
    assert_eq!(ended(&found), ("converged", Some("minimum")));
    assert!(
        number(&found["iteration"]) < 200.0,
        "{}",
        found["iteration"]
    );
    let method = json!({"kind": "least_squares", "control_points": 30, "variant": "direct"});
    let least = number(&fit(method).await["error"]["rms"]);
    let rms = number(&found["error"]["rms"]);
    assert!(rms / least - 1.0 < 0.5e-6, "{rms} {least}");
    // The variant of messages is the same.
    let settings = pb::method::LeastSquares {
        control_points_u: 8,
        ..pb::method::LeastSquares::default()
    };
    let input = pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Curve(pb::Curve {
            dimension: 1,
            points: (0..40).map(|i| (f64::from(i) * 0.3).sin()).collect(),
            ..pb::Curve::default()
        })),
        method: Some(pb::Method {
            kind: Some(pb::method::Kind::LeastSquares(settings)),
        }),
        ..pb::JobInput::default()
    };
    let request = server.post("/v1/jobs").header("prefer", "wait=60");
    let request = request.header("content-type", "application/x-protobuf");
    let created = request.body(input.encode_to_vec()).send().await.unwrap();
    let created: Value = created.json().await.unwrap();
    assert_eq!(created["method"]["variant"], "cg", "{created:#}");
}
