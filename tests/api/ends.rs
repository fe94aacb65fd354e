//! How curves and surfaces with knots at the data end.

use serde_json::{Value, json};

use crate::data;
use crate::numbers::{largest_difference, numbers};
use crate::support::{Server, Story, problem};

/// Points of the helix of LBW05.
fn helix_points(count: usize) -> Vec<[f64; 3]> {
    let angle = |i| 6.0 * std::f64::consts::PI * i as f64 / (count - 1) as f64;
    let point = |angle: f64| [angle.cos(), angle.sin(), angle / 2.0];
    (0..count).map(|i| point(angle(i))).collect()
}

/// The helix of LBW05, with these end conditions and number of levels.
async fn helix(ends: Value, levels: usize) -> Story {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": helix_points(30), "ends": ends},
        "stop": {"tolerance": 0, "max_iterations": levels},
    });
    server.stream(&job).await
}

fn assert_near(value: f64, expected: f64, digits: i32) {
    let unit = 10f64.powi(expected.abs().log10().floor() as i32 + 1 - digits);
    assert!(
        (value - expected).abs() <= 0.501 * unit,
        "{value} is not {expected}"
    );
}

/// Errors of a helix with natural ends, and with derivatives, from an independent implementation.
#[tokio::test]
async fn levels_have_the_published_errors() {
    let natural = helix(json!("natural"), 40).await;
    for (level, expected, digits) in [
        (0, 0.06796898, 7),
        (5, 4.7584797e-4, 8),
        (10, 3.1985760e-5, 8),
        (20, 2.7727282e-7, 8),
    ] {
        assert_near(natural.error(level), expected, digits);
    }
    let second = numbers(&natural.iterations[40]["control_points"][1]);
    for (x, expected) in second
        .iter()
        .zip([0.9578963501, 0.2164356482, 0.1083307812])
    {
        assert_near(*x, expected, 10);
    }
    let norm = 1.25f64.sqrt();
    let derivative = json!({"derivative": [0.0, 1.0 / norm, 0.5 / norm]});
    let given = helix(json!({"start": derivative, "end": derivative}), 20).await;
    for (level, expected, digits) in [
        (0, 0.06796898, 7),
        (5, 5.0639751e-4, 8),
        (10, 3.1639631e-5, 8),
        (20, 2.7400166e-7, 8),
    ] {
        assert_near(given.error(level), expected, digits);
    }
}

/// The distance of a point from the helix (cos θ, sin θ, θ/2), by a search near its height.
fn from_helix(point: &[f64]) -> f64 {
    let squared = |angle: f64| {
        let there = [angle.cos(), angle.sin(), angle / 2.0];
        let differences = there.iter().zip(point).map(|(a, b)| (a - b).powi(2));
        differences.sum::<f64>()
    };
    let (mut low, mut high) = (2.0 * point[2] - 0.5, 2.0 * point[2] + 0.5);
    for _ in 0..100 {
        let third = (high - low) / 3.0;
        match squared(low + third) < squared(high - third) {
            true => high -= third,
            false => low += third,
        }
    }
    squared(low).sqrt()
}

/// How far limits are from what was sampled: the table of docs/explanation/methods.md.
#[tokio::test]
async fn regular_ends_are_near_to_what_was_sampled() {
    let server = Server::start().await;
    let circle = |count: usize| -> Vec<[f64; 3]> {
        let angle = |i: usize| 0.5 * std::f64::consts::PI * i as f64 / (count - 1) as f64;
        (0..count)
            .map(|i| [angle(i).cos(), angle(i).sin(), 0.0])
            .collect()
    };
    let from_circle = |point: &[f64]| (point[0].hypot(point[1]) - 1.0).abs();
    type Distance = fn(&[f64]) -> f64;
    let cases: [(Vec<[f64; 3]>, Distance, [f64; 3]); 4] = [
        (helix_points(30), from_helix, [3.0e-2, 2.1e-2, 7.8e-3]),
        (helix_points(60), from_helix, [7.3e-3, 5.1e-3, 8.5e-4]),
        (circle(5), from_circle, [1.0e-2, 7.6e-3, 6.5e-4]),
        (circle(10), from_circle, [2.2e-3, 1.5e-3, 2.5e-5]),
    ];
    for (points, distance, expected) in cases {
        for (ends, expected) in ["repeated", "natural", "estimated"]
            .into_iter()
            .zip(expected)
        {
            let curve = json!({"points": points, "ends": ends});
            let job = server
                .fit(&json!({"curve": curve, "method": "direct"}))
                .await;
            let path = job["links"]["result"].as_str().unwrap();
            let path = format!("{path}?view=samples&samples=4001");
            let samples = numbers(&server.json(&path).await["samples"]);
            let far = samples.chunks(3).map(distance).fold(0.0, f64::max);
            // Two digits are printed, and samples miss the furthest point by a little.
            assert!(
                (far / expected - 1.0).abs() < 0.02,
                "{ends}: {far:e} {expected:e}"
            );
        }
    }
}

/// Limits of curves and surfaces of many kinds are those of scipy (`tests/golden/ends.py`). Both
/// solve systems of a condition below 1e4, so that four digits of the sixteen can differ.
#[tokio::test]
async fn limits_equal_those_of_scipy() {
    let server = Server::start().await;
    let cases: Vec<Value> = serde_json::from_str(include_str!("../golden/ends.json")).unwrap();
    for case in cases {
        let mut job = case["job"].clone();
        job["method"] = json!("direct");
        job["stop"] = json!({"tolerance": 0, "max_iterations": 1});
        let job = server.fit(&job).await;
        let path = job["links"]["result"].as_str().unwrap();
        let result = server.json(path).await;
        let size = numbers(&case["control_points"])
            .iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let far = largest_difference(&result["control_points"], &case["control_points"]);
        assert!(far <= 1e-12 * size, "{}: {far:e}", case["name"]);
        if !case["weights"].is_null() {
            let far = largest_difference(&result["weights"], &case["weights"]);
            assert!(far <= 1e-12, "{}: {far:e}", case["name"]);
        }
    }
}

/// Ends that are estimated are what is usual, and what a job says of itself.
#[tokio::test]
async fn estimated_ends_are_usual() {
    let server = Server::start().await;
    let story = |job: Value| async move { Server::start().await.stream(&job).await };
    let points = helix_points(12);
    let usual = story(json!({"curve": {"points": points}})).await;
    let named = story(json!({"curve": {"points": points, "ends": "estimated"}})).await;
    let repeated = story(json!({"curve": {"points": points, "ends": "repeated"}})).await;
    assert_eq!(usual.iterations, named.iterations);
    assert_ne!(usual.iterations[0], repeated.iterations[0]);
    let estimated = json!({"start": "estimated", "end": "estimated"});
    assert_eq!(usual.job["ends"], estimated);
    // The matrix is that of repeated ends, and so is the rate.
    assert_eq!(
        usual.job["predicted"]["rate"],
        repeated.job["predicted"]["rate"]
    );
    // Where there is nothing to choose, nothing is said.
    for curve in [
        json!({"points": points, "closed": true}),
        json!({"points": points, "basis": "bernstein"}),
        json!({"points": points, "degree": 4}),
        json!({"points": points, "basis": {"kind": "bspline", "knots": "averaged"}}),
    ] {
        let job = server.stream(&json!({"curve": curve})).await.job;
        assert_eq!(job["ends"], Value::Null, "{curve}");
    }
    // Degree 1 has no copies.
    let line = |ends| story(json!({"curve": {"points": points, "degree": 1, "ends": ends}}));
    assert_eq!(
        line("estimated").await.iterations,
        line("repeated").await.iterations
    );
}

/// Odd degrees have their knots at the data, even ones averages, unless there are too few points.
#[tokio::test]
async fn even_degrees_have_averaged_knots() {
    let server = Server::start().await;
    let knots = |degree: usize, knots: Option<&str>, count: usize| {
        let mut basis = json!({"kind": "bspline", "degree": degree});
        if let Some(rule) = knots {
            basis["knots"] = json!(rule);
        }
        json!({"curve": {"points": helix_points(count), "basis": basis}})
    };
    for degree in 1..=6 {
        let usual = server.stream(&knots(degree, None, 20)).await;
        let rule = if degree % 2 == 0 { "averaged" } else { "data" };
        let named = server.stream(&knots(degree, Some(rule), 20)).await;
        assert_eq!(usual.iterations, named.iterations, "{degree}");
        assert_eq!(usual.job["warnings"], json!([]), "{degree}");
    }
    let even = server.stream(&knots(2, Some("data"), 20)).await;
    assert_eq!(even.job["warnings"][0]["code"], "even_degree");
    assert_eq!(even.job["warnings"][0]["pointer"], "/curve/basis/degree");
    // Averaged knots need more points than the degree.
    let few = server.stream(&knots(4, None, 3)).await;
    assert_ne!(few.job["ends"], Value::Null);
}

/// Every method ends at the same curve, whatever the ends are.
#[tokio::test]
async fn all_methods_end_at_the_same_curve() {
    let server = Server::start().await;
    let ends = json!({"start": {"tangent": [1, 0]}, "end": "natural"});
    let points: Vec<[f64; 2]> = (0..9)
        .map(|i| [f64::from(i), 0.1 * f64::from(i).powi(2)])
        .collect();
    let limit = |method: Value, ends: Value| {
        let server = &server;
        let job = json!({
            "curve": {"points": points, "ends": ends},
            "method": method,
            "stop": {"tolerance": 1e-12, "max_iterations": 100_000},
        });
        async move {
            let job = server.fit(&job).await;
            assert_eq!(job["state"], "converged", "{job}");
            let result = server.json(job["links"]["result"].as_str().unwrap()).await;
            result["control_points"].clone()
        }
    };
    for ends in [ends, json!("estimated")] {
        let expected = limit(json!("direct"), ends.clone()).await;
        for method in [
            json!("global"),
            json!("weighted"),
            json!({"kind": "adaptive", "threshold": 1e-13}),
            json!({"kind": "local", "indices": [0, 1, 2, 3, 4, 5, 6, 7, 8]}),
            json!("extended"),
            json!({"kind": "extended", "start": "data"}),
            json!("transpose"),
            json!("convex"),
            json!("chebyshev"),
        ] {
            let found = limit(method.clone(), ends.clone()).await;
            let far = largest_difference(&found, &expected);
            assert!(far < 1e-10, "{method}: {far:e}");
        }
    }
}

/// Views of a level agree: the complete net, what has changed of it, and points of the curve.
#[tokio::test]
async fn views_agree_at_the_ends() {
    let server = Server::start().await;
    for ends in ["natural", "estimated", "repeated"] {
        let surface = json!({
            "surface": {"points": data::peaks(7), "ends": ends},
            "method": {"kind": "local", "indices": [[0, 1], [1, 1], [3, 3], [5, 6]]},
            "stop": {"tolerance": 0, "max_iterations": 5},
        });
        let id = server.fit(&surface).await["id"]
            .as_str()
            .unwrap()
            .to_owned();
        let whole = server
            .get(&format!("/v1/jobs/{id}/events"))
            .send()
            .await
            .unwrap();
        let whole = Story::read(whole).await;
        let path = format!("/v1/jobs/{id}/events?changed=true");
        let changes = Story::read(server.get(&path).send().await.unwrap()).await;
        let mut net = whole.iterations[0]["control_points"].clone();
        for (level, changed) in whole.iterations.iter().zip(&changes.iterations).skip(1) {
            for change in changed["changed"].as_array().unwrap() {
                let at = |k: usize| change[0][k].as_u64().unwrap() as usize;
                net[at(0)][at(1)] = change[1].clone();
            }
            assert_eq!(net, level["control_points"], "{ends}");
        }
        // Points of the surface at its corners are control points.
        let path = format!("/v1/jobs/{id}/iterations/5?view=samples&samples=5x6");
        let samples = server.json(&path).await["samples"].clone();
        for (sample, control) in [([0, 0], [0, 0]), ([4, 5], [8, 8]), ([0, 5], [0, 8])] {
            let far =
                largest_difference(&samples[sample[0]][sample[1]], &net[control[0]][control[1]]);
            assert!(far < 1e-14, "{ends}");
        }
    }
}

/// An edit keeps the ends, and estimates them again from the points that it has moved.
#[tokio::test]
async fn edits_keep_the_ends() {
    let server = Server::start().await;
    let mut points = helix_points(12);
    for ends in [
        json!("estimated"),
        json!("natural"),
        json!({"start": {"tangent": [0, 2, 1]}, "end": {"derivatives": [[0, 1, 0.5]]}}),
    ] {
        let parameters: Vec<usize> = (0..12).collect();
        let curve = json!({"points": points, "parameters": parameters, "ends": ends});
        let stop = json!({"tolerance": 1e-13});
        let parent = server.fit(&json!({"curve": curve, "stop": stop})).await;
        points[1] = [0.5, 0.7, 0.2];
        let edit = json!({"points": [{"index": 1, "point": points[1]}]});
        let path = format!("/v1/jobs/{}/edits", parent["id"].as_str().unwrap());
        let request = server.post(&path).header("Prefer", "wait=10").json(&edit);
        let edited: Value = request.send().await.unwrap().json().await.unwrap();
        let mut curve = curve;
        curve["points"] = json!(points);
        let fresh = server.fit(&json!({"curve": curve, "stop": stop})).await;
        let mut nets = Vec::new();
        for job in [edited, fresh] {
            let result = server.json(job["links"]["result"].as_str().unwrap()).await;
            nets.push(result["control_points"].clone());
        }
        assert!(largest_difference(&nets[0], &nets[1]) < 1e-12, "{ends}");
    }
}

/// The request is returned unchanged, as JSON and as a message.
#[tokio::test]
async fn the_input_has_the_ends() {
    let server = Server::start().await;
    let vectors: Vec<[f64; 3]> = (0..5).map(|j| [1.0, 0.1, f64::from(j)]).collect();
    let jobs = [
        json!({"curve": {"points": helix_points(8), "ends": "natural"}}),
        json!({"curve": {"points": helix_points(8), "degree": 5, "ends": {"start": {"derivatives": [[0, 1, 2], [3, 4, 5]]}, "end": "repeated"}}}),
        json!({"surface": {"points": data::peaks(5), "ends": {"u": {"start": {"tangent": vectors}, "end": "natural"}, "v": "repeated"}}}),
        json!({"surface": {"points": data::peaks(6), "basis": {"u": {"kind": "bspline", "degree": 2}, "v": {"kind": "bspline", "degree": 3}}}}),
        json!({"surface": {"points": data::peaks(6), "closed": {"u": false, "v": true}, "ends": {"u": "natural"}}}),
    ];
    for job in jobs {
        let first = server.stream(&job).await;
        let id = first.job["id"].as_str().unwrap();
        let path = format!("/v1/jobs/{id}/input");
        let input = server.json(&path).await;
        // The schema knows no null here: a direction without a choice is left out.
        assert!(!input.to_string().contains("null"), "{input}");
        let again = server.stream(&input).await;
        assert_eq!(first.iterations, again.iterations, "{job}");
        let message = server.get(&path).header("Accept", "application/x-protobuf");
        let message = message.send().await.unwrap().bytes().await.unwrap();
        let made = server
            .post("/v1/jobs")
            .header("Content-Type", "application/x-protobuf")
            .header("Accept", "text/event-stream")
            .body(message);
        let again = Story::read(made.send().await.unwrap()).await;
        assert_eq!(first.iterations, again.iterations, "{job}");
    }
}

/// Errors name the field and a remedy.
#[tokio::test]
async fn ends_that_cannot_be_are_refused() {
    let server = Server::start().await;
    let points = json!([[0, 0], [1, 2], [3, 1], [4, 4], [6, 5]]);
    let curve = |more: Value| {
        let mut curve = json!({"points": points});
        for (name, value) in more.as_object().unwrap() {
            curve[name] = value.clone();
        }
        json!({"curve": curve})
    };
    for (more, pointer, reason) in [
        (
            json!({"ends": "natural", "degree": 5}),
            "/curve/ends",
            "natural ends are those of cubic",
        ),
        (
            json!({"ends": {"end": "natural"}, "degree": 1}),
            "/curve/ends/end",
            "degree 1",
        ),
        (
            json!({"ends": "estimated", "closed": true}),
            "/curve/ends",
            "this direction is closed",
        ),
        (
            json!({"ends": "repeated", "degree": 2}),
            "/curve/ends",
            "averaged knots",
        ),
        (
            json!({"ends": "repeated", "basis": "bernstein"}),
            "/curve/ends",
            "polynomial bases have none",
        ),
        (
            json!({"ends": "flat"}),
            "/curve/ends",
            "estimated, repeated, natural",
        ),
        (
            json!({"ends": {"begin": "natural"}}),
            "/curve/ends/begin",
            "start, end",
        ),
        (
            json!({"ends": {"start": {"derivative": [1, 2, 3]}}}),
            "/curve/ends/start/derivative",
            "3 coordinates",
        ),
        (
            json!({"ends": {"start": {"derivative": [[1, 2]]}}}),
            "/curve/ends/start",
            "expected [x, y, z]",
        ),
        (
            json!({"ends": {"start": {"derivative": [1, "2"]}}}),
            "/curve/ends/start/derivative/1",
            "found \"2\"",
        ),
        (
            json!({"ends": {"start": {"derivative": [1, [2]]}}}),
            "/curve/ends/start/derivative/1",
            "beside lists",
        ),
        (
            json!({"ends": {"start": {"derivatives": [[1, 2], [3, 4]]}}}),
            "/curve/ends/start/derivatives/1",
            "room for 1",
        ),
        (
            json!({"ends": {"start": {"derivative": [1, 2], "tangent": [1, 2]}}}),
            "/curve/ends/start",
            "one of derivative",
        ),
        (
            json!({"ends": {"end": {"tangent": [0, 0]}}}),
            "/curve/ends/end/tangent",
            "zero vector",
        ),
        (
            json!({"ends": {"end": {"tangent": []}}}),
            "/curve/ends/end/tangent",
            "empty",
        ),
        (
            json!({"ends": {"start": {"derivative": [1, null]}}}),
            "/curve/ends/start/derivative/1",
            "null",
        ),
        (
            json!({"ends": "estimated", "degree": 33}),
            "/curve/ends",
            "up to degree 31",
        ),
    ] {
        server.assert_refused(&curve(more), pointer, reason).await;
    }
    let least_squares = json!({"curve": {"points": points, "ends": "natural"}, "method": {"kind": "least_squares", "control_points": 4}});
    server
        .assert_refused(&least_squares, "/curve/ends", "least squares")
        .await;
    let surface = |ends: Value| json!({"surface": {"points": data::peaks(5), "ends": ends}});
    for (ends, pointer, reason) in [
        (
            json!({"u": {"start": {"derivative": [[1, 0, 0]]}}}),
            "/surface/ends/u/start/derivative",
            "5 are needed",
        ),
        (
            json!({"v": {"end": {"tangent": [1, 0, 0]}}}),
            "/surface/ends/v/end",
            "one for each data point",
        ),
        (
            json!({"v": {"end": {"tangent": [[1, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]]}}}),
            "/surface/ends/v/end/tangent/1",
            "zero vector",
        ),
        (
            json!({"v": {"end": {"derivative": [[1, 0, 0], [0, 0]]}}}),
            "/surface/ends/v/end/derivative/1",
            "2 entries",
        ),
    ] {
        server.assert_refused(&surface(ends), pointer, reason).await;
    }
    // Weights that natural ends do not go with.
    let weights = json!({"curve": {"points": points, "weights": [100, 1, 1, 1, 1, 1, 1], "ends": "natural"}, "rational": "fixed"});
    server
        .assert_refused(&weights, "/curve/ends", "no natural form")
        .await;
    // Numbers that leave their range.
    let far = json!({"curve": {
        "points": [[0, 0], [1, 2], [3, 1]],
        "parameters": [0, 1e10, 2e10],
        "ends": {"start": {"derivative": [1e300, 0]}},
    }});
    let (status, far) = problem(server.post("/v1/jobs").json(&far).send().await.unwrap()).await;
    assert_eq!(
        (status, &far["errors"][0]["pointer"]),
        (422, &json!("/curve/ends"))
    );
}
