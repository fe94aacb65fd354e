//! Points of a curve that come in any order.

use serde_json::{Value, json};

use crate::support::{Server, base, problem};

/// Points of a spiral, mixed by steps.
fn mixed(count: usize) -> Vec<[f64; 2]> {
    let at = |i: usize| {
        let t = 1.0 + (i * (7 * count / 20 + 1) % count) as f64 / count as f64 * 5.0;
        [t * t.cos(), t * t.sin()]
    };
    (0..count).map(at).collect()
}

/// They are fitted as the same points in their order, however they come: as JSON, or in a file.
#[tokio::test]
async fn points_are_put_in_order() {
    let server = Server::start().await;
    let points = mixed(200);
    let mut sorted = points.clone();
    sorted.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
    let fit = async |points: &[[f64; 2]], order: Value| {
        let job = json!({"curve": {"points": points, "order": order}, "method": "direct"});
        let job = server.fit(&job).await;
        assert_eq!(job["warnings"], json!([]), "{job}");
        let result = server.json(&format!("{}/result", base(&job))).await;
        (result["control_points"].clone(), job)
    };
    let (expected, _) = fit(&sorted, json!("given")).await;
    let (found, job) = fit(&points, json!("nearest")).await;
    let reversed: Vec<Value> = expected.as_array().unwrap().iter().rev().cloned().collect();
    let first = |net: &Value| net[0].clone();
    assert!(first(&found) == first(&expected) || first(&found) == reversed[0]);
    // The input has the points in their order.
    let input = server.json(&format!("{}/input", base(&job))).await;
    let given = input["curve"]["points"].as_array().unwrap();
    let in_order: Vec<Value> = sorted.iter().map(|it| json!(it)).collect();
    assert!(*given == in_order || given.iter().rev().eq(in_order.iter()));
    assert!(
        input["curve"].get("order").is_none(),
        "{}",
        input["curve"]["order"]
    );
    let text: String = points.iter().map(|[x, y]| format!("{x},{y}\n")).collect();
    let request = server.post("/v1/jobs?curve.order=nearest&method=direct");
    let request = request.header("content-type", "text/csv").body(text);
    let job: Value = request.send().await.unwrap().json().await.unwrap();
    server.until_state(base(&job), "converged").await;
    let result = server.json(&format!("{}/result", base(&job))).await;
    assert_eq!(result["control_points"], found);
}

#[tokio::test]
async fn what_has_no_order_is_refused_by_name() {
    let server = Server::start().await;
    let points = mixed(30);
    let arm = |k: usize| [[k as f64, 0.0], [0.0, k as f64], [-(k as f64), 0.0]];
    let star: Vec<[f64; 2]> = std::iter::once([0.0, 0.0])
        .chain((1..9).flat_map(arm))
        .collect();
    let weights = vec![1.0; 30];
    let auto = json!({"kind": "least_squares", "control_points": 9, "data_weights": weights});
    for (job, pointer, reason) in [
        (
            json!({"curve": {"points": star, "order": "nearest"}}),
            "/curve/points/0",
            "branch",
        ),
        (
            json!({"curve": {"points": points, "order": "nearest", "weights": weights}}),
            "/curve/order",
            "weights",
        ),
        (
            json!({"curve": {"points": points, "order": "nearest", "corners": [4]}}),
            "/curve/order",
            "corners",
        ),
        (
            json!({"curve": {"points": points, "order": "nearest"}, "method": auto}),
            "/curve/order",
            "method",
        ),
        (
            json!({"curve": {"points": points, "order": "any"}}),
            "/curve/order",
            "nearest",
        ),
    ] {
        let answer = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (status, problem) = problem(answer).await;
        assert_eq!(status, 422, "{job}");
        let error = &problem["errors"][0];
        assert_eq!(error["pointer"], pointer, "{problem:#}");
        assert!(
            error["detail"].as_str().unwrap().contains(reason),
            "{error}"
        );
    }
}
