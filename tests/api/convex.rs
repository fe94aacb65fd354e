//! Convexity-preserving fits (LWD04, Algorithm 1).

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, Story, base};

/// The signs of the turns of the control polygon, end copies left out.
fn turns(iteration: &Value) -> Vec<i8> {
    let mut points: Vec<[f64; 2]> = iteration["control_points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| [point[0].as_f64().unwrap(), point[1].as_f64().unwrap()])
        .collect();
    points.dedup();
    points
        .windows(3)
        .map(|p| {
            let cross = (p[1][0] - p[0][0]) * (p[2][1] - p[1][1])
                - (p[1][1] - p[0][1]) * (p[2][0] - p[1][0]);
            if cross > 0.0 { 1 } else { -1 }
        })
        .collect()
}

async fn fit(points: &[[f64; 2]], method: &str, ends: &str) -> Story {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": points, "ends": ends},
        "method": {"kind": method},
        "stop": {"tolerance": 1e-6},
    });
    server.stream(&job).await
}

/// Five points of an ellipse over three quarters of a half turn. The interpolant's control polygon
/// is not convex, so that the fit ends with the error that convexity costs.
#[tokio::test]
async fn a_fit_that_cannot_continue_has_a_reason() {
    let points: Vec<[f64; 2]> = (0..5)
        .map(|i| 0.75 * PI * f64::from(i) / 4.0)
        .map(|a| [2.0 * a.cos(), a.sin()])
        .collect();
    let plain = fit(&points, "global", "repeated").await;
    let signs = turns(&plain.iterations[0]);
    assert_ne!(turns(plain.iterations.last().unwrap()), signs);
    let story = fit(&points, "convex", "repeated").await;
    assert_eq!(story.state(), "stalled");
    assert_eq!(story.end["reason"], "convexity");
    let reached = story.end["error"]["max"].as_f64().unwrap();
    assert!((reached - 2.167e-2).abs() < 2e-5, "{reached}");
    assert!(
        story
            .iterations
            .iter()
            .all(|iteration| turns(iteration) == signs)
    );
    assert!(story.iterations.len() < 500);
}

/// Points of a parabola and a long chord: plain PIA loses convexity on the way, this keeps it.
#[tokio::test]
async fn convexity_is_kept_at_every_level() {
    let mut lost = 0;
    for (k, ends) in (5..30).flat_map(|k| [(k, "repeated"), (k, "estimated")]) {
        let n = 12;
        let points: Vec<[f64; 2]> = (0..n)
            .map(|i| f64::from(i) / f64::from(n - 1))
            .map(|s| PI * 2.0 * (f64::from(k) / 40.0) * s.powf(1.5))
            .map(|a| [3.0 * a.cos(), a.sin()])
            .collect();
        let plain = fit(&points, "global", ends).await;
        let signs = turns(&plain.iterations[0]);
        let convex = fit(&points, "convex", ends).await;
        assert!(
            convex
                .iterations
                .iter()
                .all(|iteration| turns(iteration) == signs)
        );
        if plain
            .iterations
            .iter()
            .any(|iteration| turns(iteration) != signs)
        {
            lost += 1;
        } else {
            // Where nothing is in the way the two are the same.
            assert_eq!(convex.iterations, plain.iterations);
            assert_eq!(convex.state(), "converged");
        }
    }
    assert!(lost > 0);
}

/// Five points of an ellipse whose interpolant has a control polygon that is not convex.
fn elliptic(method: &Value) -> Value {
    let points: Vec<[f64; 2]> = (0..5)
        .map(|i| 0.75 * PI * f64::from(i) / 4.0)
        .map(|a| [2.0 * a.cos(), a.sin()])
        .collect();
    json!({
        "curve": {"points": points, "ends": "repeated"},
        "method": method,
        "stop": {"tolerance": 1e-6},
    })
}

/// The length of the step to level `k`, by the first coordinate that it changes.
fn step(story: &Story, k: usize) -> f64 {
    let x = |k: usize, i: usize| {
        let point = &story.iterations[k]["control_points"][i];
        point[0].as_f64().unwrap()
    };
    (x(k, 2) - x(k - 1, 2)).abs()
}

/// The first step that is cut short, as a part of the plain one, falls short of the longest one that
/// keeps the turns by no more than the tolerance. The default is 1e-6.
#[tokio::test]
async fn a_threshold_says_how_near_bisection_goes() {
    let server = Server::start().await;
    let plain = server.stream(&elliptic(&json!("global"))).await;
    let with = async |threshold: f64| {
        let method = json!({"kind": "convex", "step_tolerance": threshold});
        server.stream(&elliptic(&method)).await
    };
    let exact = with(1e-15).await;
    let same = |k: &usize| {
        exact.iterations[*k]["control_points"] == plain.iterations[*k]["control_points"]
    };
    let cut = (1..).find(|k| !same(k)).unwrap();
    let longest = step(&exact, cut) / step(&plain, cut);
    assert!(longest < 1.0);
    let signs = turns(&plain.iterations[0]);
    for threshold in [0.9, 0.3, 0.1, 1e-2, 1e-4] {
        let story = with(threshold).await;
        assert_eq!(story.job["method"]["step_tolerance"], threshold);
        assert_eq!(story.state(), "stalled");
        assert!(story.iterations.iter().all(|it| turns(it) == signs));
        let part = step(&story, cut) / step(&plain, cut);
        let short = longest - part;
        assert!(
            short > -1e-9 && short <= threshold + 1e-9,
            "{threshold}: {short}"
        );
    }
    let (default, given) = (
        server.stream(&elliptic(&json!("convex"))).await,
        with(1e-6).await,
    );
    assert_eq!(default.iterations, given.iterations);
    assert_eq!(default.job["method"], given.job["method"]);
}

/// The request is returned unchanged; edits accept it, too.
#[tokio::test]
async fn a_threshold_is_kept() {
    let server = Server::start().await;
    let method = json!({"kind": "convex", "step_tolerance": 0.125});
    let job = server.fit(&elliptic(&method)).await;
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["method"], method);
    let edits = server.post(&format!("{}/edits", base(&job)));
    let edit = json!({"method": {"kind": "convex", "step_tolerance": 0.25}});
    let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
    let edited: Value = edited.unwrap().json().await.unwrap();
    assert_eq!(edited["method"]["step_tolerance"], 0.25);
    let usual = server.fit(&elliptic(&json!("convex"))).await;
    let input = server.json(&format!("{}/input", base(&usual))).await;
    assert_eq!(input["method"], json!({"kind": "convex"}));
    let mut client = connect(&server).await;
    let id = job["id"].as_str().unwrap().to_owned();
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let method = input.into_inner().input.unwrap().method.unwrap();
    let step_tolerance = Some(0.125);
    let expected = pb::method::Kind::Convex(pb::method::Convex { step_tolerance });
    assert_eq!(method.kind, Some(expected));
}

#[tokio::test]
async fn wrong_thresholds_are_refused() {
    let server = Server::start().await;
    for (threshold, reason) in [
        (json!(0), "greater than 0 and less than 1"),
        (json!(1), "less than 1"),
        (json!(-0.5), "less than 1"),
        (json!([0.1, 0.1, 0.1, 0.1, 0.1]), "expected a number"),
        (json!("small"), "number"),
    ] {
        let method = json!({"kind": "convex", "step_tolerance": threshold});
        server
            .assert_refused(&elliptic(&method), "/method/step_tolerance", reason)
            .await;
    }
    let mut client = connect(&server).await;
    let step_tolerance = Some(2.0);
    let kind = pb::method::Kind::Convex(pb::method::Convex { step_tolerance });
    let curve = pb::Curve {
        dimension: 2,
        points: vec![0.0, 0.0, 1.0, 1.0, 2.0, 0.0],
        ..pb::Curve::default()
    };
    let input = pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Curve(curve)),
        method: Some(pb::Method { kind: Some(kind) }),
        ..pb::JobInput::default()
    };
    let request = pb::CreateJobRequest {
        input: Some(input),
        ..Default::default()
    };
    let refused = client.create_job(request).await.unwrap_err();
    let field = "input.method.convex.step_tolerance";
    assert!(refused.message().contains(field), "{refused:?}");
}
