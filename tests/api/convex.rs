//! Convexity-preserving fits (LWD04, Algorithm 1).

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::support::{Server, Story};

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

async fn fit(points: &[[f64; 2]], method: &str) -> Story {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": points},
        "method": {"kind": method},
        "stop": {"tolerance": 1e-6},
    });
    server.stream(&job).await
}

/// Five points of an ellipse over three quarters of a half turn. The interpolant's control polygon
/// is not convex, so that the fit ends with the error that convexity costs.
#[tokio::test]
async fn a_fit_that_cannot_go_on_says_so() {
    let points: Vec<[f64; 2]> = (0..5)
        .map(|i| 0.75 * PI * f64::from(i) / 4.0)
        .map(|a| [2.0 * a.cos(), a.sin()])
        .collect();
    let plain = fit(&points, "global").await;
    let signs = turns(&plain.iterations[0]);
    assert_ne!(turns(plain.iterations.last().unwrap()), signs);
    let story = fit(&points, "convex").await;
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
    for k in 5..30 {
        let n = 12;
        let points: Vec<[f64; 2]> = (0..n)
            .map(|i| f64::from(i) / f64::from(n - 1))
            .map(|s| PI * 2.0 * (f64::from(k) / 40.0) * s.powf(1.5))
            .map(|a| [3.0 * a.cos(), a.sin()])
            .collect();
        let plain = fit(&points, "global").await;
        let signs = turns(&plain.iterations[0]);
        let convex = fit(&points, "convex").await;
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
