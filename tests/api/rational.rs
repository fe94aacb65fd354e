//! Rational fits: homogeneous, where weights evolve, and with fixed weights.

use serde_json::{Value, json};

use crate::support::Server;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// A quarter circle: three points on it, weights of its homogeneous form `(1−t², 2t, 1+t²)` at
/// t = 0, 1/2, 1, Bernstein, degree 2. The result is the arc itself.
#[tokio::test]
async fn an_arc_comes_out_exact() {
    let server = Server::start().await;
    for method in ["direct", "global", "chebyshev", "extended"] {
        let job = server
            .fit(&json!({
                "curve": {
                    "points": [[1, 0], [0.6, 0.8], [0, 1]],
                    "weights": [1, 1.25, 2],
                    "basis": {"kind": "bernstein"},
                    "parameters": [0, 0.5, 1],
                },
                "method": {"kind": method},
                "stop": {"tolerance": 1e-14, "max_iterations": 10_000},
            }))
            .await;
        assert_eq!(job["state"], "converged", "{method}");
        let result = job["links"]["result"].as_str().unwrap();
        let sampled = server
            .json(&format!("{result}?view=samples&samples=50"))
            .await;
        for point in sampled["samples"].as_array().unwrap() {
            let radius = number(&point[0]).hypot(number(&point[1]));
            assert!((radius - 1.0).abs() < 1e-14, "{method}: {radius}");
        }
        // Control points (1, 0), (1, 1), (0, 1) with weights 1, 1, 2.
        let geometry = server.json(result).await;
        let expected = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 2.0]];
        for (i, [x, y, w]) in expected.into_iter().enumerate() {
            assert!((number(&geometry["control_points"][i][0]) - x).abs() < 1e-13);
            assert!((number(&geometry["control_points"][i][1]) - y).abs() < 1e-13);
            assert!((number(&geometry["weights"][i]) - w).abs() < 1e-13);
        }
    }
}

#[tokio::test]
async fn homogeneous_fits_stream_weights_and_both_errors() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..12)
        .map(f64::from)
        .map(|x| [x, (x * 0.8).sin()])
        .collect();
    let weights: Vec<f64> = (0..12)
        .map(f64::from)
        .map(|x| 1.0 + 0.5 * (x * 1.3).cos())
        .collect();
    for method in [
        json!({"kind": "global"}),
        json!({"kind": "local", "indices": [3, 4, 5]}),
        json!({"kind": "adaptive", "threshold": 1e-9}),
    ] {
        let story = server
            .stream(&json!({
                "curve": {"points": points, "weights": weights},
                "rational": "homogeneous",
                "method": method,
                "stop": {"tolerance": 1e-9},
            }))
            .await;
        assert_eq!(story.state(), "converged");
        assert_eq!(story.job["rational"], "homogeneous");
        let last = story.iterations.last().unwrap();
        assert!(number(&last["error"]["max"]) <= 1e-9);
        assert!(number(&last["error"]["homogeneous"]) < 1e-7);
        assert_eq!(last["weights"].as_array().unwrap().len(), 14);
        assert_eq!(last["control_points"].as_array().unwrap().len(), 14);
        assert_ne!(last["weights"], story.iterations[0]["weights"]);
    }
}

/// Weights that vary wildly have negative control weights on the way, which is said, not hidden.
#[tokio::test]
async fn weights_that_turn_negative_are_reported() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..9).map(f64::from).map(|x| [x, x * x * 0.1]).collect();
    let weights: Vec<f64> = (0..9).map(|i| if i == 4 { 0.01 } else { 10.0 }).collect();
    let story = server
        .stream(&json!({
            "curve": {"points": points, "weights": weights},
            "stop": {"tolerance": 1e-9},
        }))
        .await;
    let last = story.iterations.last().unwrap();
    assert_eq!(last["bad_weight"]["control_point"], 4);
    assert!(number(&last["bad_weight"]["weight"]) <= 0.0);
    assert!(story.iterations[0].get("bad_weight").is_none());
    let result = server
        .json(story.job["links"]["result"].as_str().unwrap())
        .await;
    assert_eq!(result["bad_weight"]["control_point"], 4);
}

/// Fixed weights per data point, per control point with copies, per direction, or as a product grid.
#[tokio::test]
async fn fixed_weights_come_in_several_forms() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..8)
        .map(f64::from)
        .map(|x| [x, (x * 0.8).sin()])
        .collect();
    let per_point: Vec<f64> = (1..=8).map(f64::from).collect();
    let mut complete = vec![1.0];
    complete.extend(&per_point);
    complete.push(8.0);
    let mut results = Vec::new();
    for weights in [per_point, complete] {
        let story = server
            .stream(&json!({
                "curve": {"points": points, "weights": weights},
                "rational": "fixed",
                "stop": {"tolerance": 1e-10, "max_iterations": 10_000},
            }))
            .await;
        assert_eq!(story.state(), "converged");
        assert_eq!(story.job["weights"].as_array().unwrap().len(), 10);
        assert!(story.iterations[0].get("weights").is_none());
        results.push(story.iterations);
    }
    assert_eq!(results[0], results[1]);

    let (u, v) = ([1.0, 2.0, 3.0, 2.0, 1.0], [2.0, 1.0, 4.0, 1.0]);
    let grid: Vec<Vec<f64>> = u
        .iter()
        .map(|u| v.iter().map(|v| u * v).collect())
        .collect();
    let rows: Vec<Vec<[f64; 3]>> = (0..5)
        .map(|i| {
            (0..4)
                .map(|j| [f64::from(i), f64::from(j), f64::from(i * j % 3)])
                .collect()
        })
        .collect();
    let mut finals: Vec<Value> = Vec::new();
    for weights in [json!({"u": u, "v": v}), json!(grid)] {
        let story = server
            .stream(&json!({
                "surface": {"points": rows, "weights": weights},
                "rational": "fixed",
                "stop": {"tolerance": 1e-10, "max_iterations": 10_000},
            }))
            .await;
        assert_eq!(story.state(), "converged");
        finals.push(story.iterations.last().unwrap()["error"]["max"].clone());
    }
    assert_eq!(finals.len(), 2);
}

#[tokio::test]
async fn wrong_weights_are_refused() {
    let server = Server::start().await;
    let curve = |weights: Value, rational: &str| {
        json!({
            "curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 4]], "weights": weights},
            "rational": rational,
        })
    };
    let surface = |weights: Value, rational: &str| {
        json!({
            "surface": {"points": [[[0, 0], [0, 1]], [[1, 0], [1, 2]]], "weights": weights},
            "rational": rational,
        })
    };
    let cases = [
        (
            curve(json!([1, 1, 1]), "homogeneous"),
            "/curve/weights",
            "3 weights for 4 points",
        ),
        (
            curve(json!([1, 0, 1, 1]), "homogeneous"),
            "/curve/weights/1",
            "greater than 0",
        ),
        (
            curve(json!([1, 1, -2, 1]), "fixed"),
            "/curve/weights/2",
            "greater than 0",
        ),
        (
            curve(json!([1, 1, 1, 1, 1]), "fixed"),
            "/curve/weights",
            "4 are needed",
        ),
        (
            curve(json!([1, null, 1, 1]), "fixed"),
            "/curve/weights/1",
            "null",
        ),
        (
            curve(json!([[1, 1], [1, 1]]), "fixed"),
            "/curve/weights",
            "list of numbers",
        ),
        (curve(Value::Null, "fixed"), "/rational", "no weights"),
        (
            curve(json!([1, 1, 1, 1]), "both"),
            "/rational",
            "unknown use of weights",
        ),
        (
            surface(json!([1, 1]), "fixed"),
            "/surface/weights",
            "rows of numbers",
        ),
        (
            surface(json!([[1, 1], [1]]), "fixed"),
            "/surface/weights/1",
            "same length",
        ),
        (
            surface(json!([[1, 1]]), "homogeneous"),
            "/surface/weights",
            "1 rows of 2",
        ),
        (
            surface(json!([[1, 1], [1, 2]]), "fixed"),
            "/surface/weights",
            "not a product",
        ),
        (
            surface(json!([[1, 1], [1, 0]]), "homogeneous"),
            "/surface/weights/1/1",
            "greater than 0",
        ),
        (
            surface(json!({"u": [1, 1], "v": [1]}), "homogeneous"),
            "/surface/weights/v",
            "1 weights for 2",
        ),
        (
            surface(json!({"u": [1, 1], "v": [1, -1]}), "fixed"),
            "/surface/weights/v/1",
            "greater than 0",
        ),
    ];
    for (job, pointer, reason) in cases {
        server.assert_refused(&job, pointer, reason).await;
    }
}
