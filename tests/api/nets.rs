//! Control nets of many sizes, in every form: where rows end has nothing to do with where the parts
//! of an answer end.

use serde_json::{Value, json};

use crate::encodings::assert_same;
use crate::numbers::flat;
use crate::support::{Server, base, thinned};

/// Rows and columns of data points, most of them co-prime with each other and with every size of a
/// part: just below, at and above some hundreds and thousands of control points.
const SIZES: [(usize, usize); 15] = [
    (2, 769),
    (3, 257),
    (7, 113),
    (13, 61),
    (16, 48),
    (23, 34),
    (27, 37),
    (28, 28),
    (29, 31),
    (61, 13),
    (67, 71),
    (113, 7),
    (113, 109),
    (383, 2),
    (769, 2),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Polynomial,
    Homogeneous,
    Fixed,
}

fn weight(i: usize, j: usize) -> f64 {
    1.0 + ((i * 7 + j * 3) % 5) as f64 / 8.0
}

fn grid<T>(rows: usize, columns: usize, item: impl Fn(usize, usize) -> T) -> Vec<Vec<T>> {
    let row = |i| (0..columns).map(|j| item(i, j)).collect();
    (0..rows).map(row).collect()
}

fn job(rows: usize, columns: usize, kind: Kind) -> Value {
    let point = |i: usize, j: usize| [i as f64, j as f64, (0.3 * (i + 2 * j) as f64).sin()];
    let degree = |count: usize| json!({"kind": "bspline", "degree": if count > 3 { 3 } else { 1 }});
    let mut job = json!({
        "surface": {
            "points": grid(rows, columns, point),
            "basis": {"u": degree(rows), "v": degree(columns)},
            "parameters": "uniform",
        },
        "stop": {"tolerance": 0, "max_iterations": 2},
    });
    // Some with copies at the ends, others with estimated ends.
    if rows % 2 == 1 {
        job["surface"]["ends"] = json!("repeated");
    }
    match kind {
        Kind::Polynomial => {}
        Kind::Homogeneous => job["surface"]["weights"] = json!(grid(rows, columns, weight)),
        Kind::Fixed => {
            let along = |count| (0..count).map(|i| weight(i, 0)).collect::<Vec<_>>();
            job["surface"]["weights"] = json!({"u": along(rows), "v": along(columns)});
            job["rational"] = json!("fixed");
        }
    }
    job
}

/// The places of the net are those of the data, with the ends repeated equally often.
fn expected_weights(shape: &Value, rows: usize, columns: usize) -> Value {
    let [u, v] = [0, 1].map(|axis| shape[axis].as_u64().unwrap() as usize);
    let index = |place: usize, places: usize, count: usize| {
        place.saturating_sub((places - count) / 2).min(count - 1)
    };
    json!(grid(u, v, |i, j| {
        weight(index(i, u, rows), index(j, v, columns))
    }))
}

/// Checks that an answer is another one but for coordinates that are rounded.
fn assert_rounded(short: &Value, full: &Value, field: &str) {
    let bound = 0.01 * full["error"]["max"].as_f64().unwrap();
    let (coordinates, expected) = (flat(&short[field]), flat(&full[field]));
    assert_eq!(coordinates.len(), expected.len());
    let pairs = coordinates.iter().zip(&expected);
    assert!(pairs.into_iter().all(|(x, y)| (x - y).abs() <= bound));
    let (mut short, mut full) = (short.clone(), full.clone());
    short[field].take();
    full[field].take();
    assert_eq!(short, full);
}

/// Checks that what has changed, put into the net before, makes the net after; where all has changed
/// there is the whole net.
fn assert_changed(event: &Value, before: &Value, after: &Value) {
    let Some(changed) = event.get("changed") else {
        return assert!(event == after);
    };
    let mut net = before["control_points"].clone();
    let mut weights = before.get("weights").cloned();
    for changed in changed.as_array().unwrap() {
        let [i, j] = [0, 1].map(|axis| changed[0][axis].as_u64().unwrap() as usize);
        net[i][j] = changed[1].clone();
        if let Some(weights) = &mut weights {
            weights[i][j] = changed[2].clone();
        }
    }
    assert!(net == after["control_points"]);
    assert!(weights.as_ref() == after.get("weights"));
}

/// Streams, single iterations and results of a job in every form.
async fn assert_every_form(server: &Server, base: &str) {
    for (view, field) in [
        ("view=control_points", "control_points"),
        ("view=samples&samples=29x31", "samples"),
    ] {
        let events = format!("{base}/events?{view}");
        let (plain, _) = thinned(server, &events, None).await;
        let result = server.json(&format!("{base}/result?{view}")).await;
        let single = server.json(&format!("{base}/iterations/1?{view}")).await;
        assert!(single == plain[1]);
        assert!(
            result[field] == plain[2][field] && result.get("weights") == plain[2].get("weights")
                || result["rational"] == "fixed"
        );
        for encoding in ["base64", "base64_f32"] {
            let form = format!("{view}&encoding={encoding}");
            let (binary, _) = thinned(server, &format!("{base}/events?{form}"), None).await;
            assert_eq!(binary.len(), plain.len());
            for (binary, plain) in binary.iter().zip(&plain) {
                assert_same(binary, plain, field);
            }
            let answer = server.json(&format!("{base}/iterations/1?{form}")).await;
            assert_same(&answer, &single, field);
            let answer = server.json(&format!("{base}/result?{form}")).await;
            assert_same(&answer, &result, field);
        }
        let (rounded, _) = thinned(server, &format!("{events}&digits=auto"), None).await;
        for (rounded, plain) in rounded.iter().zip(&plain) {
            assert_rounded(rounded, plain, field);
        }
        let answer = server
            .json(&format!("{base}/iterations/1?{view}&digits=auto"))
            .await;
        assert!(answer == rounded[1]);
        if field == "control_points" {
            let (changed, _) = thinned(server, &format!("{events}&changed=true"), None).await;
            assert!(changed[0] == plain[0]);
            for k in 1..plain.len() {
                assert_changed(&changed[k], &plain[k - 1], &plain[k]);
            }
        }
    }
    let (errors, _) = thinned(server, &format!("{base}/events?view=errors"), None).await;
    assert_eq!(errors.len(), 3);
}

async fn assert_surfaces(kind: Kind) {
    let server = Server::start().await;
    for (rows, columns) in SIZES {
        let story = server.stream(&job(rows, columns, kind)).await;
        let first = &story.iterations[0];
        if kind == Kind::Homogeneous {
            let places = &story.job["control_points"];
            let shape = json!([places["u"], places["v"]]);
            if rows % 2 == 1 {
                let expected = expected_weights(&shape, rows, columns);
                assert!(first["weights"] == expected, "{rows} × {columns}");
            }
        }
        assert_every_form(&server, base(&story.job)).await;
        // Some control points stay.
        let mut adaptive = job(rows, columns, kind);
        adaptive["method"] = json!({"kind": "adaptive", "threshold": 0.1});
        let story = server.stream(&adaptive).await;
        let path = format!("{}/events?changed=true", base(&story.job));
        let (changed, _) = thinned(&server, &path, None).await;
        assert!(changed[0] == story.iterations[0]);
        for (k, levels) in story.iterations.windows(2).enumerate() {
            assert_changed(&changed[k + 1], &levels[0], &levels[1]);
        }
    }
}

#[tokio::test]
async fn polynomial_surfaces_of_many_sizes() {
    assert_surfaces(Kind::Polynomial).await;
}

#[tokio::test]
async fn homogeneous_surfaces_of_many_sizes() {
    assert_surfaces(Kind::Homogeneous).await;
}

#[tokio::test]
async fn surfaces_with_fixed_weights_of_many_sizes() {
    assert_surfaces(Kind::Fixed).await;
}

/// Values, curves with weights, and closed surfaces: the other shapes of arrays.
#[tokio::test]
async fn other_nets_of_many_sizes() {
    let server = Server::start().await;
    let height = |i: usize, j: usize| [(0.7 * (i + j) as f64).cos()];
    let knot = |i: usize| [i as f64, (0.1 * i as f64).sin()];
    let around = |i: usize, j: usize| {
        let a = std::f64::consts::TAU * j as f64 / 31.0;
        [
            a.cos() * (3.0 + i as f64),
            a.sin() * (3.0 + i as f64),
            i as f64,
        ]
    };
    let curve = (0..1531).map(knot).collect::<Vec<_>>();
    let weights = (0..1531).map(|i| weight(i, 0)).collect::<Vec<_>>();
    for mut job in [
        json!({"surface": {"points": grid(29, 31, height), "parameters": "uniform"}}),
        json!({"surface": {
            "points": grid(29, 31, around),
            "weights": grid(29, 31, weight),
            "closed": {"u": false, "v": true},
        }}),
        json!({"curve": {"points": curve}}),
        json!({"curve": {"points": curve, "weights": weights}}),
    ] {
        job["stop"] = json!({"tolerance": 0, "max_iterations": 2});
        let story = server.stream(&job).await;
        let base = base(&story.job);
        let (binary, _) = thinned(&server, &format!("{base}/events?encoding=base64"), None).await;
        for (binary, plain) in binary.iter().zip(&story.iterations) {
            assert_same(binary, plain, "control_points");
        }
    }
}
