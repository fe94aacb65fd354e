//! Data of any magnitude, equal points, extreme weights: the same fit in other units.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, Story};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// Points times a power of ten.
fn scaled(points: &[[f64; 2]], exponent: i32) -> Value {
    let factor = 10f64.powi(exponent);
    let points: Vec<[f64; 2]> = points
        .iter()
        .map(|[x, y]| [x * factor, y * factor])
        .collect();
    json!(points)
}

fn zigzag() -> Vec<[f64; 2]> {
    let y = [0.0, 1.0, 4.0, 4.0, 1.0, 0.0, 1.0, 4.0, 4.0];
    y.iter().enumerate().map(|(x, y)| [x as f64, *y]).collect()
}

/// Every method ends in the same state after about the same iterations, with the scaled error.
#[tokio::test]
async fn every_method_is_independent_of_the_unit() {
    let server = Server::start().await;
    let convex = vec![[0.0, 0.0], [1.0, 2.0], [3.0, 3.0], [5.0, 2.5], [6.0, 0.5]];
    let methods = [
        json!({"kind": "global"}),
        json!({"kind": "weighted"}),
        json!({"kind": "chebyshev"}),
        json!({"kind": "direct"}),
        json!({"kind": "extended"}),
        json!({"kind": "transpose"}),
        json!({"kind": "convex"}),
        json!({"kind": "local", "indices": [1, 2]}),
        json!({"kind": "least_squares", "control_points": 4, "variant": "cg"}),
        json!({"kind": "least_squares", "control_points": 4, "variant": "diagonal"}),
    ];
    for method in methods {
        for weights in [false, true] {
            // Homogeneous least squares minimizes coordinates and weights together, and only the
            // coordinates have a unit.
            let kind = method["kind"].as_str().unwrap();
            if weights && ["convex", "least_squares"].contains(&kind) {
                continue;
            }
            let points = if method["kind"] == "convex" {
                convex.clone()
            } else {
                zigzag()
            };
            let mut results: Vec<Story> = Vec::new();
            for exponent in [0, -200, 200] {
                let mut curve = json!({"points": scaled(&points, exponent)});
                if weights {
                    let weights: Vec<f64> = (0..points.len())
                        .map(|i| 1.0 + (i % 3) as f64 * 0.2)
                        .collect();
                    curve["weights"] = json!(weights);
                }
                let story = server
                    .stream(&json!({
                        "curve": curve, "method": method, "stop": {"relative_tolerance": 1e-7},
                    }))
                    .await;
                let unit = 10f64.powi(exponent);
                let last = story.iterations.last().unwrap();
                if let Some(first) = results.first() {
                    assert_eq!(story.state(), first.state(), "{method} at 1e{exponent}");
                    assert_eq!(
                        story.end["iterations"], first.end["iterations"],
                        "{method} at 1e{exponent}"
                    );
                    let expected = first.iterations.last().unwrap();
                    for norm in ["max", "rms", "sum"] {
                        let found = number(&last["error"][norm]) / unit;
                        let expected = number(&expected["error"][norm]);
                        assert!(
                            (found - expected).abs() < 1e-9,
                            "{method} at 1e{exponent}: {found} {expected}"
                        );
                    }
                    if let Some(gradient) = expected["error"].get("gradient") {
                        let found = number(&last["error"]["gradient"]);
                        assert!(
                            (found - number(gradient)).abs() < 1e-9,
                            "{method} at 1e{exponent}"
                        );
                    }
                }
                results.push(story);
            }
        }
    }
}

#[tokio::test]
async fn large_weights_do_not_hide_errors() {
    let server = Server::start().await;
    let points = json!([[0, 0], [1, 2], [3, 1], [4, 4]]);
    let mut ended = Vec::new();
    for weight in [1.0, 1e175, 1e200] {
        let story = server
            .stream(&json!({
                "curve": {"points": points, "weights": vec![weight; 4], "ends": "repeated"},
                "stop": {"tolerance": 1e-6},
            }))
            .await;
        assert_eq!(story.state(), "converged");
        assert!((story.error(0) - 0.82).abs() < 0.01, "{}", story.error(0));
        ended.push(story.iterations.len());
    }
    assert!(ended.iter().all(|count| *count == ended[0]), "{ended:?}");
}

/// There is nothing to fit, and rounding does not keep the fit from saying so.
#[tokio::test]
async fn equal_points_converge() {
    let server = Server::start().await;
    for method in [
        "global",
        "weighted",
        "chebyshev",
        "transpose",
        "convex",
        "direct",
        "extended",
    ] {
        let story = server
            .stream(&json!({
                "curve": {"points": vec![[0.1, 0.7]; 6], "parameters": "uniform"},
                "method": {"kind": method},
            }))
            .await;
        assert_eq!(story.state(), "converged", "{method}");
        assert!(story.iterations.len() <= 7, "{method}");
    }
}

/// A step that is too long makes least squares diverge, and that is what it says.
#[tokio::test]
async fn a_step_that_is_too_long_is_not_called_convergence() {
    let server = Server::start().await;
    for (mu, expected) in [(100.0, "stalled"), (5.0, "stalled"), (0.2, "converged")] {
        let story = server
            .stream(&json!({
                "curve": {"points": data::wave(30)},
                "method": {"kind": "least_squares", "control_points": 8, "variant": "lspia", "mu": mu},
                "stop": {"max_iterations": 100_000},
            }))
            .await;
        assert_eq!(story.state(), expected, "{mu}");
        let reason = if expected == "stalled" {
            "diverging"
        } else {
            "minimum"
        };
        assert_eq!(story.end["reason"], reason);
    }
}
