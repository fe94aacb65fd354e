//! Points of a curve that equal the one before them.

use serde_json::{Value, json};

use crate::support::{Server, base, problem};

const POINTS: [[f64; 2]; 7] = [
    [0.0, 0.0],
    [1.0, 2.0],
    [1.0, 2.0],
    [1.0, 2.0],
    [3.0, 3.0],
    [5.0, 2.0],
    [6.0, 0.0],
];

/// The same, each once.
fn once() -> Vec<[f64; 2]> {
    let mut points = POINTS.to_vec();
    points.dedup();
    points
}

/// The fit of merged points is that of each of them once: with explicit parameters that of the first, closed without the
/// copy of the first point, with knots that are chosen, and after points were put in order.
#[tokio::test]
async fn merged_points_are_fitted_once() {
    let server = Server::start().await;
    let t = [0.0, 0.2, 0.25, 0.3, 0.5, 0.8, 1.0];
    let closed: Vec<[f64; 2]> = POINTS.into_iter().chain([[0.0, 0.0]; 2]).collect();
    let auto = json!({"kind": "least_squares", "control_points": "auto"});
    let cases = [
        (
            json!({"points": POINTS}),
            json!({"points": once()}),
            json!("direct"),
        ),
        (
            json!({"points": POINTS, "parameters": t}),
            json!({"points": once(), "parameters": [0.0, 0.2, 0.5, 0.8, 1.0]}),
            json!("global"),
        ),
        (
            json!({"points": closed, "closed": true}),
            json!({"points": once(), "closed": true}),
            json!("direct"),
        ),
        (json!({"points": POINTS}), json!({"points": once()}), auto),
        (
            json!({"points": POINTS, "order": "nearest"}),
            json!({"points": once(), "order": "nearest"}),
            json!("direct"),
        ),
    ];
    for (repeated, kept, method) in cases {
        let mut merging = repeated.clone();
        merging["repeated_points"] = json!("merge");
        let fit = async |curve: Value| {
            let job = server.fit(&json!({"curve": curve, "method": method})).await;
            let input = server.json(&format!("{}/input", base(&job))).await;
            assert_eq!(input["curve"]["points"].as_array().unwrap().len(), 5);
            assert!(input["curve"].get("repeated_points").is_none(), "{input}");
            let result = server.json(&format!("{}/result", base(&job))).await;
            result["control_points"].clone()
        };
        assert_eq!(fit(merging).await, fit(kept).await, "{repeated}");
    }
}

#[tokio::test]
async fn what_cannot_be_merged_is_refused_by_name() {
    let server = Server::start().await;
    let all_equal = [[1.0, 1.0]; 4];
    for (job, pointer, reason) in [
        (
            json!({"curve": {"points": POINTS}}),
            "/curve/points/2",
            "repeated_points",
        ),
        (
            json!({"curve": {"points": POINTS, "repeated_points": "refuse"}}),
            "/curve/points/2",
            "equals point 1",
        ),
        (
            json!({"curve": {"points": POINTS, "repeated_points": "drop"}}),
            "/curve/repeated_points",
            "merge",
        ),
        (
            json!({"curve": {"points": POINTS, "repeated_points": "merge", "weights": [1, 1, 1, 1, 1, 1, 1]}}),
            "/curve/repeated_points",
            "weights",
        ),
        (
            json!({"curve": {"points": POINTS, "repeated_points": "merge", "corners": [3]}}),
            "/curve/repeated_points",
            "corners",
        ),
        (
            json!({"curve": {"points": all_equal, "repeated_points": "merge"}}),
            "/curve/points",
            "at least 2",
        ),
        (
            json!({"surface": {"points": [[[0], [1]], [[0], [1]]], "repeated_points": "merge"}}),
            "/surface/repeated_points",
            "",
        ),
    ] {
        let answer = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (status, problem) = problem(answer).await;
        assert!([400, 422].contains(&status), "{job}");
        let error = &problem["errors"][0];
        assert_eq!(error["pointer"], pointer, "{problem:#}");
        let detail = error["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{error}");
    }
}
