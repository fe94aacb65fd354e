//! Geometry as base64: the same numbers as in JSON, in less space.

use base64_simd::STANDARD;
use serde_json::{Value, json};

use crate::data;
use crate::numbers::flat;
use crate::support::{Server, Story, assert_query_refused, base, thinned};

/// The numbers of nested lists, in order.
/// The lengths of nested lists.
fn shape(array: &Value) -> Vec<usize> {
    match array {
        Value::Array(items) => [vec![items.len()], shape(&items[0])].concat(),
        _ => Vec::new(),
    }
}

/// The numbers of a base64 string of 32 or 64 bits each.
fn decoded(text: &Value, encoding: &Value) -> Vec<f64> {
    let bytes = STANDARD.decode_to_vec(text.as_str().unwrap()).unwrap();
    match encoding.as_str().unwrap() {
        "base64" => {
            let numbers = bytes.as_chunks().0.iter();
            numbers.map(|bytes| f64::from_le_bytes(*bytes)).collect()
        }
        "base64_f32" => {
            let numbers = bytes.as_chunks().0.iter();
            let numbers = numbers.map(|bytes| f32::from_le_bytes(*bytes));
            numbers.map(f64::from).collect()
        }
        other => panic!("{other} is not known"),
    }
}

/// Checks that an array in an encoding holds the numbers of the one in JSON; arrays of directions, too.
fn assert_array(found: &Value, expected: &Value, encoding: &Value, name: &str) {
    match expected {
        // A basis that has no such array.
        Value::Null => assert!(found.is_null(), "{name}: {found}"),
        Value::Object(each) => {
            assert_eq!(found.as_object().unwrap().len(), each.len(), "{name}");
            for (direction, expected) in each {
                assert_array(&found[direction], expected, encoding, name);
            }
        }
        _ => {
            let found = decoded(found, encoding);
            let expected = flat(expected);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.into_iter().zip(expected) {
                if encoding == "base64" {
                    assert_eq!(found.to_bits(), expected.to_bits(), "{name}");
                } else {
                    assert_eq!(found, f64::from(expected as f32), "{name}");
                }
            }
        }
    }
}

/// Checks that an answer in an encoding holds the numbers of the one in JSON. Knots, and beside them the
/// parameters of the data, always have 64 bits.
pub fn assert_same(binary: &Value, plain: &Value, main: &str) {
    assert_eq!(binary["shape"], json!(shape(&plain[main])));
    for (name, expected) in plain.as_object().unwrap() {
        let found = &binary[name];
        match name.as_str() {
            "knots" => assert_array(found, expected, &json!("base64"), name),
            "parameters" if main == "control_points" => {
                assert_array(found, expected, &json!("base64"), name);
            }
            "control_points" | "weights" | "samples" | "parameters" => {
                assert_array(found, expected, &binary["encoding"], name);
            }
            _ => assert_eq!(found, expected, "{name}"),
        }
    }
}

/// Checks that a `job` event in base64 is the one in JSON.
fn assert_same_job(binary: &Value, plain: &Value) {
    assert_eq!(binary["encoding"], "base64");
    for (name, expected) in plain.as_object().unwrap() {
        let found = &binary[name];
        match name.as_str() {
            "knots" | "weights" | "parameters" => {
                assert_array(found, expected, &binary["encoding"], name);
            }
            _ => assert_eq!(found, expected, "{name}"),
        }
    }
}

fn shapes() -> Vec<Value> {
    let weights: Vec<f64> = (0..100).map(|i| 1.0 + f64::from(i % 3)).collect();
    let arc = json!({"points": [[1, 0], [0.6, 0.8], [0, 1]], "weights": [1, 1.25, 2]});
    let mut fixed = arc.clone();
    fixed["basis"] = json!({"kind": "bspline", "degree": 2});
    let fixed_surface = json!({
        "points": data::peaks(5),
        "weights": {"u": [1, 2, 1, 2, 1], "v": [1, 1, 3, 1, 1]},
    });
    vec![
        json!({"curve": {"points": data::wave(100)}}),
        json!({"curve": {"points": [[1], [2], [4]], "closed": true, "basis": {"kind": "bspline", "degree": 2}}}),
        json!({"curve": {"points": data::wave(100), "weights": weights}}),
        json!({"curve": fixed, "rational": "fixed"}),
        json!({"curve": {"points": data::wave(12), "basis": {"kind": "said_ball"}}}),
        json!({"surface": {"points": data::peaks(8), "closed": {"u": true, "v": false}}}),
        json!({"surface": {"points": data::peaks(5), "basis": {"u": {"kind": "bernstein"}, "v": {"kind": "bspline"}}}}),
        json!({"surface": fixed_surface, "rational": "fixed"}),
    ]
}

#[tokio::test]
async fn base64_holds_the_numbers_of_json() {
    let server = Server::start().await;
    for mut job in shapes() {
        job["stop"] = json!({"max_iterations": 3});
        let story = server.stream(&job).await;
        let base = base(&story.job);
        for (view, main) in [("control_points", "control_points"), ("samples", "samples")] {
            let events = format!("{base}/events?view={view}");
            let (plain, _) = thinned(&server, &events, None).await;
            assert!(plain[0].get("encoding").is_none() && plain[0].get("shape").is_none());
            for encoding in ["base64", "base64_f32"] {
                let path = format!("{events}&encoding={encoding}");
                let reported = Story::read(server.get(&path).send().await.unwrap()).await;
                assert_same_job(&reported.job, &story.job);
                let binary = reported.iterations;
                assert_eq!(binary.len(), plain.len());
                for (binary, plain) in binary.iter().zip(&plain) {
                    assert_eq!(binary["encoding"], encoding);
                    assert_same(binary, plain, main);
                }
                let query = format!("view={view}&encoding={encoding}");
                let single = server.json(&format!("{base}/iterations/1?{query}")).await;
                assert_eq!(single, binary[1]);
                let result = server.json(&format!("{base}/result?{query}")).await;
                let plain = server.json(&format!("{base}/result?view={view}")).await;
                assert_same(&result, &plain, main);
            }
        }
    }
}

#[tokio::test]
async fn the_job_event_describes_the_shape() {
    let server = Server::start().await;
    for job in shapes() {
        let story = server.stream(&job).await;
        let shape = shape(&story.iterations[0]["control_points"]);
        assert_eq!(story.job["dimension"], shape[shape.len() - 1]);
        let expected = match shape[..] {
            [count, _] => json!(count),
            [rows, columns, _] => json!({"u": rows, "v": columns}),
            _ => panic!("{shape:?}"),
        };
        assert_eq!(story.job["control_points"], expected);
    }
}

/// The numbers as they are, a third of them, a sixth.
#[tokio::test]
async fn base64_is_shorter() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let mut lengths = Vec::new();
    for encoding in ["json", "base64", "base64_f32"] {
        let path = format!("{}/events?encoding={encoding}", base(&story.job));
        let text = server
            .get(&path)
            .send()
            .await
            .unwrap()
            .text()
            .await
            .unwrap();
        lengths.push(text.len());
    }
    assert!(lengths[1] * 3 < lengths[0] * 2, "{lengths:?}");
    assert!(lengths[2] * 5 < lengths[1] * 3, "{lengths:?}");
}

fn scaled_wave(scale: f64) -> Value {
    let points = flat(&data::wave(20));
    let points: Vec<[f64; 2]> = points
        .as_chunks()
        .0
        .iter()
        .map(|[x, y]| [x * scale, y * scale])
        .collect();
    json!({"curve": {"points": points}})
}

#[tokio::test]
async fn data_beyond_32_bits_are_refused() {
    let server = Server::start().await;
    for (scale, reason) in [(1e36, "too large"), (1e-39, "too small")] {
        let mut job = scaled_wave(scale);
        let created = server.fit(&job).await;
        assert_eq!(created["state"], "converged");
        let base = base(&created);
        for resource in ["events", "iterations/0", "result"] {
            let path = format!("{base}/{resource}");
            assert_query_refused(&server, &path, "encoding=base64_f32", "encoding", reason).await;
            let plain = server
                .get(&format!("{path}?encoding=base64"))
                .send()
                .await
                .unwrap();
            assert_eq!(plain.status(), 200);
        }
        job["stream"] = json!({"encoding": "base64_f32"});
        server
            .assert_refused(&job, "/stream/encoding", reason)
            .await;
    }
    // Homogeneous coordinates are larger than the points.
    let mut job = scaled_wave(1e34);
    job["curve"]["weights"] = json!(vec![1e6; 20]);
    job["stream"] = json!({"encoding": "base64_f32"});
    let story = server.stream(&job).await;
    assert_eq!(story.iterations[0]["encoding"], "base64_f32");
}

/// Control points can grow beyond 32 bits while the data are within: such an event has 64, and
/// says so.
#[tokio::test]
async fn events_beyond_32_bits_have_64() {
    let server = Server::start().await;
    let points = flat(&data::lemniscate());
    let points: Vec<[f64; 2]> = points
        .as_chunks()
        .0
        .iter()
        .map(|[x, y]| [x * 9e34, y * 9e34])
        .collect();
    let job = json!({
        "curve": {"points": points, "parameters": "uniform", "basis": {"kind": "wang_ball"}},
        "method": {"kind": "extended", "start": "data"},
        "stream": {"encoding": "base64_f32"},
    });
    let story = server.stream(&job).await;
    let path = format!("{}/events?encoding=json", base(&story.job));
    let (plain, _) = thinned(&server, &path, None).await;
    let mut wide = 0;
    for (binary, plain) in story.iterations.iter().zip(&plain) {
        let largest = flat(&plain["control_points"])
            .into_iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        let expected = match largest > f64::from(f32::MAX) {
            true => "base64",
            false => "base64_f32",
        };
        wide += usize::from(expected == "base64");
        assert_eq!(binary["encoding"], expected);
        assert_same(binary, plain, "control_points");
    }
    assert!(wide > 0 && wide < plain.len(), "{wide}");
}

#[tokio::test]
async fn encodings_that_make_no_sense_are_refused() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let base = base(&job);
    for resource in ["events", "iterations/0", "result"] {
        let path = format!("{base}/{resource}");
        let refused = async |query: &str, parameter: &str, reason: &str| {
            assert_query_refused(&server, &path, query, parameter, reason).await;
        };
        refused("encoding=base32", "encoding", "json, base64, base64_f32").await;
        refused("encoding=", "encoding", "unknown choice").await;
        let query = "encoding=base64&view=errors";
        refused(query, "encoding", "without geometry").await;
        let query = "digits=auto&encoding=base64";
        refused(query, "digits", "do not go together").await;
    }
}
