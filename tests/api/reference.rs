//! Random problems over all methods, with the errors that an independent numpy implementation found.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::data;
use crate::support::Server;

/// Each case is a job and the largest distance at its first levels. Both programs round, and λ_min
/// and ρ come from iterations that end at 1e-13.
#[tokio::test]
async fn errors_equal_those_of_numpy() {
    const TOLERANCE: f64 = 1e-11;
    let text = include_str!("../golden/reference.json");
    let cases: Vec<Value> = serde_json::from_str(text).unwrap();
    assert!(cases.len() >= 200);
    let server = Server::start().await;
    let mut worst: BTreeMap<&str, f64> = BTreeMap::new();
    for case in &cases {
        let name = case["name"].as_str().unwrap();
        let story = server.stream(&with_repeated_ends(&case["job"])).await;
        let expected: Vec<f64> = case["errors"]
            .as_array()
            .unwrap()
            .iter()
            .map(|error| error.as_f64().unwrap())
            .collect();
        let scale = expected.iter().copied().fold(0.0, f64::max);
        // Adaptive and exact fits can end before the last of the levels.
        let levels = story.iterations.len().min(expected.len());
        assert!(
            levels == expected.len() || story.state() == "converged",
            "{name}"
        );
        for (k, expected) in expected.iter().take(levels).enumerate() {
            let deviation = (story.error(k) - expected).abs() / scale;
            assert!(deviation < TOLERANCE, "{name}, level {k}: {deviation}");
            let worst = worst.entry(name).or_default();
            *worst = worst.max(deviation);
        }
    }
    assert!(worst.len() >= 40, "methods and bases: {worst:?}");
}

/// Has the knots of B-splines that are not chosen at the data.
fn name_knots(basis: &mut Value) {
    match basis {
        Value::Object(fields) if fields.contains_key("u") => {
            let each = fields.values_mut();
            each.for_each(name_knots);
        }
        Value::Object(fields) if fields["kind"] == "bspline" => {
            fields.entry("knots").or_insert(json!("data"));
        }
        _ => {}
    }
}

/// The job as the papers have it: with knots at the data where they are not chosen, and copies of the
/// end points there; those of least squares by Piegl & Tiller (9.68)–(9.69), with free end points.
fn with_repeated_ends(job: &Value) -> Value {
    let mut job = job.clone();
    let kind = if job["curve"].is_null() {
        "surface"
    } else {
        "curve"
    };
    let least_squares = job["method"]["kind"] == "least_squares";
    let shape = &mut job[kind];
    if least_squares {
        if shape["closed"] != true {
            let number = |value: &Value| value.as_u64().unwrap() as usize;
            let t: Vec<f64> = serde_json::from_value(shape["parameters"].clone()).unwrap();
            let degree = number(&shape["basis"]["degree"]);
            let count = number(&job["method"]["control_points"]);
            job[kind]["basis"]["knots"] = json!(data::piegl_tiller(&t, degree, count));
        }
        job["method"]["end_points"] = json!("free");
        return job;
    }
    name_knots(&mut shape["basis"]);
    let has_ends = |axis: &str| {
        let of = |field: &str| shape[field].get(axis).unwrap_or(&shape[field]).clone();
        of("basis")["knots"] == "data" && of("closed") != true
    };
    shape["ends"] = match (kind, has_ends("u"), has_ends("v")) {
        ("curve", true, _) => json!("repeated"),
        ("surface", u, v) if u || v => {
            let end = |has: bool| has.then_some("repeated");
            json!({"u": end(u), "v": end(v)})
        }
        _ => return job,
    };
    job
}
