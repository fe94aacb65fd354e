//! The relaxation of local and adaptive fits.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, Story, base};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// A local fit of some points of the helix.
fn of_helix(indices: &[usize], omega: &Value) -> Value {
    let mut job = json!({
        "curve": {"points": data::helix()},
        "method": {"kind": "local", "indices": indices},
        "stop": {"tolerance": 1e-10},
    });
    if !omega.is_null() {
        job["method"]["omega"] = omega.clone();
    }
    job
}

fn iterations(story: &Story) -> u64 {
    assert_eq!(story.state(), "converged");
    story.end["iterations"].as_u64().unwrap()
}

/// A difference shrinks by |1 − ω B_l(t_l)| at each level, with B_l(t_l) = 2/3 of uniform cubic
/// B-splines; the best ω, 2/(1 + 2/3) = 1.2, is as far from both ends of [2/3, 1].
#[tokio::test]
async fn a_single_point_converges_with_its_relaxed_rate() {
    let server = Server::start().await;
    for (omega, used) in [
        (json!(0.5), 0.5),
        (json!(1), 1.0),
        (json!(1.4), 1.4),
        (json!(1.9), 1.9),
        (json!("auto"), 1.2),
    ] {
        let story = server
            .stream(&json!({
                "curve": {
                    "points": [[0, 0], [1, 2], [2, -1], [3, 4], [4, 0], [5, 1], [6, 0]],
                    "parameters": "uniform",
                },
                "method": {"kind": "local", "indices": [3], "omega": omega},
                "stop": {"tolerance": 1e-10},
            }))
            .await;
        let rate = (1.0_f64 - used * 2.0 / 3.0).abs();
        let method = &story.job["method"];
        assert!((number(&method["omega"]) - used).abs() < 1e-9, "{method}");
        assert!((number(&method["lambda_min"]) - 2.0 / 3.0).abs() < 1e-9);
        assert!((number(&story.job["predicted"]["rate"]) - rate).abs() < 1e-9);
        for iteration in &story.iterations[1..6] {
            let found = number(&iteration["rate"]);
            assert!((found - rate).abs() < 1e-5, "{omega}: {found} {rate}");
        }
        assert_eq!(
            story.job["predicted"]["iterations"],
            story.end["iterations"]
        );
    }
}

/// Of a block: 2/(1 + λ_min) is the one that is used, takes fewer iterations, and ends at the same
/// curve; the rate of the forecast is that of the last levels.
#[tokio::test]
async fn the_best_relaxation_is_that_of_the_block() {
    let server = Server::start().await;
    let adjusted = [3, 4, 5, 6, 7, 17, 22];
    let plain = server.stream(&of_helix(&adjusted, &Value::Null)).await;
    let best = server.stream(&of_helix(&adjusted, &json!("auto"))).await;
    assert!(4 * iterations(&best) < 3 * iterations(&plain));
    let (omega, least) = (
        &best.job["method"]["omega"],
        &best.job["method"]["lambda_min"],
    );
    assert!((number(omega) - 2.0 / (1.0 + number(least))).abs() < 1e-12);
    assert_eq!(plain.job["method"]["omega"], 1.0);
    for story in [&plain, &best] {
        let forecast = number(&story.job["predicted"]["rate"]);
        // Parts with both signs take turns.
        let k = story.iterations.len() - 1;
        let last = (story.error(k) / story.error(k - 8)).powf(0.125);
        assert!(
            last < 1.001 * forecast && last > 0.85 * forecast,
            "{last} {forecast}"
        );
    }
    let last = |story: &Story| story.iterations.last().unwrap()["control_points"].clone();
    let (plain, best) = (last(&plain), last(&best));
    let coordinates = |net: &Value| -> Vec<f64> {
        let points = net.as_array().unwrap().iter();
        points
            .flat_map(|point| point.as_array().unwrap().iter().map(number))
            .collect()
    };
    let pairs = coordinates(&plain).into_iter().zip(coordinates(&best));
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-9));
}

/// One is the default: the same numbers, to the last bit.
#[tokio::test]
async fn a_relaxation_of_one_changes_nothing() {
    let server = Server::start().await;
    let adaptive = |omega: Option<f64>| {
        let mut method = json!({"kind": "adaptive", "threshold": 1e-2});
        if let Some(omega) = omega {
            method["omega"] = json!(omega);
        }
        json!({"surface": {"points": data::peaks(11)}, "method": method})
    };
    for (with, without) in [
        (adaptive(Some(1.0)), adaptive(None)),
        (
            of_helix(&[3, 4, 9], &json!(1)),
            of_helix(&[3, 4, 9], &Value::Null),
        ),
    ] {
        let (with, without) = (server.stream(&with).await, server.stream(&without).await);
        assert_eq!(with.iterations, without.iterations);
        assert_eq!(with.job["method"], without.job["method"]);
    }
}

/// Where the data moves far, longer steps take fewer levels; all relaxations get there.
#[tokio::test]
async fn adaptive_fits_take_a_relaxation() {
    let server = Server::start().await;
    let mut levels = Vec::new();
    for omega in [0.5, 1.0, 1.5, 1.9] {
        let story = server
            .stream(&json!({
                "surface": {"points": data::peaks(11)},
                "method": {"kind": "adaptive", "threshold": 1e-4, "omega": omega},
            }))
            .await;
        assert_eq!(story.job["method"]["omega"], omega);
        let last = story.iterations.last().unwrap();
        assert!(number(&last["error"]["max"]) <= 1e-4);
        levels.push(iterations(&story));
    }
    assert!(levels[2] < levels[1] && levels[1] < levels[0], "{levels:?}");
}

/// Many points have λ_min of the whole matrix, which is less than that of their block.
#[tokio::test]
async fn many_points_have_the_relaxation_of_the_matrix() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..600)
        .map(|i| f64::from(i) / 50.0)
        .map(|t| [t, t.sin() + (7.0 * t).cos()])
        .collect();
    let job = |method: Value| json!({"curve": {"points": points}, "method": method});
    let indices: Vec<usize> = (100..400).collect();
    let local = json!({"kind": "local", "indices": indices, "omega": "auto"});
    let local = server.stream(&job(local)).await;
    let weighted = server.stream(&job(json!("weighted"))).await;
    assert_eq!(
        local.job["method"]["omega"],
        weighted.job["method"]["omega"]
    );
    assert!(iterations(&local) <= iterations(&weighted));
    // Row by row all points of a surface.
    let rows = server
        .stream(&json!({
            "surface": {"points": data::peaks(9)},
            "method": {"kind": "local", "sweeps": "rows", "omega": "auto"},
            "stop": {"tolerance": 1e-6, "max_iterations": 100_000},
        }))
        .await;
    assert!(number(&rows.job["method"]["omega"]) > 1.5);
    iterations(&rows);
}

/// The requested value is returned, stored, resumed and edited.
#[tokio::test]
async fn relaxations_are_kept_and_edited() {
    let server = Server::start().await;
    for omega in [json!("auto"), json!(1.25)] {
        let job = server.fit(&of_helix(&[2, 3], &omega)).await;
        let input = server.json(&format!("{}/input", base(&job))).await;
        assert_eq!(input["method"]["omega"], omega);
        let edit = json!({
            "points": [{"index": 9, "point": [1, 1, 5]}],
            "method": {"kind": "local", "indices": [8, 9, 10], "omega": omega},
        });
        let edits = format!("{}/edits", base(&job));
        let edited = server.post(&edits).header("prefer", "wait=30");
        let edited: Value = edited
            .json(&edit)
            .send()
            .await
            .unwrap()
            .json()
            .await
            .unwrap();
        assert_eq!(edited["state"], "converged", "{edited}");
        let input = server.json(&format!("{}/input", base(&edited))).await;
        assert_eq!(input["method"]["omega"], omega);
        assert!(number(&edited["method"]["omega"]) > 1.0);
    }
    let plain = server.fit(&of_helix(&[2, 3], &Value::Null)).await;
    let input = server.json(&format!("{}/input", base(&plain))).await;
    assert!(input["method"].get("omega").is_none());
}

#[tokio::test]
async fn wrong_relaxations_are_refused() {
    let server = Server::start().await;
    for omega in [
        json!(0),
        json!(2),
        json!(-0.5),
        json!(7),
        json!("best"),
        json!([1]),
    ] {
        let reason = if omega.is_number() {
            "between 0 and 2"
        } else {
            "\"auto\""
        };
        for kind in [
            json!({"kind": "local", "indices": [1], "omega": omega}),
            json!({"kind": "adaptive", "threshold": 0.1, "omega": omega}),
        ] {
            let job = json!({"curve": {"points": data::helix()}, "method": kind});
            server.assert_refused(&job, "/method/omega", reason).await;
        }
    }
    let job = |method: Value| json!({"curve": {"points": data::helix()}, "method": method});
    let auto = json!({"kind": "adaptive", "threshold": 0.1, "omega": "auto"});
    server
        .assert_refused(&job(auto), "/method/omega", "adaptive needs a number")
        .await;
    let other = json!({"kind": "global", "omega": 1});
    server
        .assert_refused(&job(other), "/method/omega", "unknown field")
        .await;
}
