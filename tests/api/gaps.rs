//! Grids with missing points whose knots the fit chooses.

use serde_json::{Value, json};

use crate::support::{Server, base};

const ROWS: usize = 23;
const COLUMNS: usize = 30;

/// Heights of hills on a plane, 215 to 621 metres as those of a real model, except where a gap is.
fn heights(is_gap: impl Fn(usize, usize) -> bool) -> Value {
    let height = |i: usize, j: usize| {
        let hill = |a: f64, b: f64| {
            (-0.02 * ((i as f64 - a).powi(2) + (j as f64 - b).powi(2))).exp() * 300.0
        };
        250.0 + 2.0 * i as f64 + hill(5.0, 8.0) + hill(17.0, 22.0)
    };
    let row = |i| {
        let all = (0..COLUMNS).map(|j| match is_gap(i, j) {
            true => Value::Null,
            false => json!(height(i, j)),
        });
        all.collect::<Value>()
    };
    (0..ROWS).map(row).collect()
}

fn gap(i: usize, j: usize) -> bool {
    (7..13).contains(&i) && (10..19).contains(&j) || (i, j) == (0, 0)
}

fn job(surface: Value, tolerance: f64) -> Value {
    json!({"surface": surface, "stop": {"tolerance": tolerance}})
}

fn numbers(list: &Value) -> Vec<f64> {
    let all = list.as_array().unwrap().iter();
    all.map(|it| it.as_f64().unwrap()).collect()
}

/// Within the tolerance at the points that are there, with fewer control points than these, and in the range of their
/// heights, give or take 3 %, where there are none.
#[tokio::test]
async fn surfaces_stay_near_their_data_in_gaps() {
    let server = Server::start().await;
    let surface = json!({"points": heights(gap), "spacing": [90, 74]});
    let done = server.fit(&job(surface.clone(), 0.5)).await;
    assert_eq!(done["state"], "converged", "{done:#}");
    assert!(done["error"]["max"].as_f64().unwrap() <= 0.5);
    let path = base(&done);
    let result = server.json(&format!("{path}/result")).await;
    let net = result["control_points"].as_array().unwrap();
    let count = net.len() * net[0].as_array().unwrap().len();
    assert!(count < ROWS * COLUMNS / 2, "{count} control points");
    let samples = server
        .json(&format!("{path}/result?view=samples&samples=90x120"))
        .await;
    for sample in samples["samples"].as_array().unwrap() {
        for place in sample.as_array().unwrap() {
            let z = numbers(place)[2];
            assert!((240.0..610.0).contains(&z), "{z}");
        }
    }
    // Distances are those of the grid, without the missing points.
    let deviation = server.json(&format!("{path}/deviation?list=true")).await;
    let rows = deviation["distances"].as_array().unwrap();
    assert_eq!(rows.len(), ROWS);
    assert_eq!(rows[8][11], Value::Null);
    // The method is what is usual.
    let mut named = job(surface.clone(), 0.5);
    named["method"] = json!({"kind": "least_squares", "control_points": "auto"});
    let named = server.fit(&named).await;
    assert_eq!(named["error"], done["error"]);
    // With an outline.
    let mut trimmed = surface;
    trimmed["trim"] = json!(true);
    let trimmed = server.fit(&job(trimmed, 0.5)).await;
    let result = server.json(&format!("{}/result", base(&trimmed))).await;
    assert_eq!(result["trim"]["faces"][0]["holes"], json!([1]));
}

/// A direction goes as far as all of its lines, also where the first has no point; a closed one stays closed.
#[tokio::test]
async fn lines_without_a_point_count() {
    let server = Server::start().await;
    let first = |i: usize, j: usize| i == 0 || gap(i, j);
    let surface = json!({"points": heights(first), "spacing": [90, 74]});
    let done = server.fit(&job(surface, 0.5)).await;
    assert_eq!(done["state"], "converged", "{done:#}");
    let result = server
        .json(&format!("{}/result?view=samples&samples=5x5", base(&done)))
        .await;
    assert!(numbers(&result["samples"][0][0])[1].abs() < 1.0);
    let ring = |i: usize, j: usize| {
        let angle = j as f64 * std::f64::consts::TAU / 24.0;
        let radius = 10.0 + (0.4 * i as f64).sin();
        match (3..6).contains(&i) && (20..24).contains(&j) {
            true => Value::Null,
            false => json!([radius * angle.cos(), radius * angle.sin(), i]),
        }
    };
    let row = |i| (0..24).map(|j| ring(i, j)).collect::<Value>();
    let points: Value = (0..12).map(row).collect();
    let closed = json!({"points": points, "closed": {"u": false, "v": true}});
    let done = server.fit(&job(closed, 0.01)).await;
    assert_eq!(done["state"], "converged", "{done:#}");
    let samples = server
        .json(&format!("{}/result?view=samples&samples=7x9", base(&done)))
        .await;
    for row in samples["samples"].as_array().unwrap() {
        let [start, end] = [0, 8].map(|j| numbers(&row[j]));
        for (a, b) in start.into_iter().zip(end) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
}

/// Other settings of a fit apply to the existing points.
#[tokio::test]
async fn constraints_and_weights_are_those_of_the_grid() {
    let server = Server::start().await;
    let surface = json!({"points": heights(gap), "spacing": [1, 1]});
    let with = |more: Value| {
        let mut job = job(surface.clone(), 0.5);
        job["method"] = json!({"kind": "least_squares", "control_points": "auto"});
        let method = job["method"].as_object_mut().unwrap();
        method.extend(more.as_object().unwrap().clone());
        job
    };
    let done = server
        .fit(&with(json!({"constraints": [{"index": [22, 29]}]})))
        .await;
    assert_eq!(done["state"], "converged", "{done:#}");
    let deviation = server
        .json(&format!("{}/deviation?list=true", base(&done)))
        .await;
    let at = deviation["distances"][22][29].as_f64().unwrap();
    assert!(at < 1e-9, "{at}");
    for (more, pointer, reason) in [
        (
            json!({"constraints": [{"index": [8, 11]}]}),
            "/method/constraints/0",
            "missing",
        ),
        (
            json!({"end_points": "interpolated"}),
            "/method/end_points",
            "missing points",
        ),
        (
            json!({"correct_parameters": true}),
            "/method/correct_parameters",
            "scattered points",
        ),
        (
            json!({"robust": true}),
            "/method/robust",
            "pass those of the grid as scattered points",
        ),
        (
            json!({"data_weights": vec![vec![1.0; COLUMNS]; ROWS - 1]}),
            "/method/data_weights",
            "",
        ),
    ] {
        server.assert_refused(&with(more), pointer, reason).await;
    }
}
