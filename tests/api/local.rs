//! Local and adaptive fits: what does not move stays, and what it costs.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// Distance of two points given as JSON.
fn distance(a: &Value, b: &Value) -> f64 {
    let pairs = a.as_array().unwrap().iter().zip(b.as_array().unwrap());
    pairs
        .map(|(a, b)| (number(a) - number(b)).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[tokio::test]
async fn fixed_points_do_not_move_and_limits_follow_the_theorem() {
    let server = Server::start().await;
    let points = data::helix();
    let adjusted = [3, 4, 5, 17, 22];
    let story = server
        .stream(&json!({
            "curve": {"points": points, "basis": {"kind": "bspline", "degree": 3, "knots": "data"}, "ends": "repeated"},
            "method": {"kind": "local", "indices": adjusted},
            "stop": {"tolerance": 1e-13},
        }))
        .await;
    assert_eq!(story.state(), "converged");
    let last = story.iterations.last().unwrap();
    for (i, point) in points.as_array().unwrap().iter().enumerate() {
        // One end copy in front.
        let control_point = &last["control_points"][i + 1];
        assert_eq!(control_point == point, !adjusted.contains(&i), "{i}");
    }
    assert!(story.iterations[1..].iter().all(|it| it["moved"] == 5));
    // Δ_J = Δ_J⁰ − B_JI B_II⁻¹ Δ_I⁰ (Lin 2010, Theorem 2).
    let path = story.job["links"]["limit"].as_str().unwrap();
    let limit = server.json(path).await;
    assert_eq!(limit["points"].as_array().unwrap().len(), 25);
    let expected = number(&limit["max"]);
    assert!((number(&last["error"]["fixed_max"]) - expected).abs() < 1e-12);
    // At the data the curve is there: samples at the parameters are data minus differences.
    let result = story.job["links"]["result"].as_str().unwrap();
    let first = server
        .json(&format!("{result}?view=samples&samples=2"))
        .await;
    let k = limit["points"]
        .as_array()
        .unwrap()
        .iter()
        .position(|i| *i == 0)
        .unwrap();
    let origin = json!([0, 0, 0]);
    let at_start = distance(&first["samples"][0], &points[0]);
    assert!((at_start - distance(&limit["differences"][k], &origin)).abs() < 1e-12);
}

/// One free point l: its difference shrinks by 1 − B_l(t_l) at each level.
#[tokio::test]
async fn a_single_point_converges_with_its_own_rate() {
    let server = Server::start().await;
    let story = server
        .stream(&json!({
            "curve": {
                "points": [[0, 0], [1, 2], [2, -1], [3, 4], [4, 0], [5, 1], [6, 0]],
                "parameters": "uniform",
            },
            "method": {"kind": "local", "indices": [3]},
            "stop": {"tolerance": 1e-10},
        }))
        .await;
    // Uniform cubic: B_l(t_l) = 2/3.
    for iteration in &story.iterations[1..15] {
        assert!((number(&iteration["rate"]) - 1.0 / 3.0).abs() < 1e-5);
    }
}

/// Lin 2010, Fig. 5: `peaks(11)`, threshold 1e-2: 18 levels, with these numbers of active points.
#[tokio::test]
async fn adaptive_peaks_take_the_published_levels() {
    let active = [
        117, 117, 115, 113, 109, 85, 69, 58, 47, 35, 30, 26, 16, 14, 13, 6, 2, 1,
    ];
    let server = Server::start().await;
    let story = server
        .stream(&json!({
            "surface": {"points": data::peaks(11), "ends": "repeated"},
            "method": {"kind": "adaptive", "threshold": 1e-2},
        }))
        .await;
    assert_eq!(story.state(), "converged");
    assert_eq!(story.end["iterations"], 18);
    assert!((story.error(0) - 1.8680).abs() <= 1e-4);
    assert!(story.error(18) <= 1e-2 && story.error(17) > 1e-2);
    let moved: Vec<u64> = story.iterations[1..]
        .iter()
        .map(|it| it["moved"].as_u64().unwrap())
        .collect();
    assert_eq!(moved, active);
}

/// `peaks(101)`: the sum of moved points is less than half of what global PIA moves to the same error.
#[tokio::test]
async fn adaptive_fits_touch_less_than_half_of_the_points() {
    let server = Server::start().await;
    let threshold = 1e-4;
    let mut moved = Vec::new();
    for method in [
        json!({"kind": "adaptive", "threshold": threshold}),
        json!({"kind": "global"}),
    ] {
        let job = json!({
            "surface": {"points": data::peaks(101)},
            "method": method,
            "stop": {"tolerance": threshold},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged");
        let total: u64 = story
            .iterations
            .iter()
            .map(|it| it["moved"].as_u64().unwrap())
            .sum();
        moved.push(total);
    }
    assert!(2 * moved[0] < moved[1], "{moved:?}");
}

#[tokio::test]
async fn local_surfaces_adjust_pairs_and_rows() {
    let server = Server::start().await;
    let pairs = json!([[2, 3], [2, 4], [5, 5], [7, 1]]);
    for (row_by_row, indices) in [(false, true), (true, true), (true, false)] {
        let mut method = json!({"kind": "local"});
        if row_by_row {
            method["sweeps"] = json!("rows");
        }
        if indices {
            method["indices"] = pairs.clone();
        }
        let story = server
            .stream(&json!({
                "surface": {"points": data::peaks(9)},
                "method": method,
                "stop": {"tolerance": 1e-8, "max_iterations": 100_000},
            }))
            .await;
        assert_eq!(story.state(), "converged");
        let limit = server
            .get(story.job["links"]["limit"].as_str().unwrap())
            .send()
            .await
            .unwrap();
        let limit: Value = limit.json().await.unwrap();
        let expected = if indices { 81 - 4 } else { 0 };
        assert_eq!(limit["points"].as_array().unwrap().len(), expected);
        let last = story.iterations.last().unwrap();
        let fixed = number(&last["error"]["fixed_max"]);
        assert!((fixed - number(&limit["max"])).abs() < 1e-7);
        if row_by_row {
            // Only one row moves at a time.
            assert!(
                story.iterations[1..]
                    .iter()
                    .all(|it| it["moved"].as_u64().unwrap() <= 9)
            );
        }
    }
}

#[tokio::test]
async fn only_local_fits_have_a_limit() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let path = job["links"]["limit"].as_str().unwrap();
    let (status, answer) = problem(server.get(path).send().await.unwrap()).await;
    assert_eq!(status, 409);
    assert_eq!(answer["type"], "/problems/no-limit");
}
