//! Parameters of scattered points on cylinders and spheres: closed directions, poles, and what is chosen.

use std::f64::consts::{PI, TAU};

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

/// Points of a surface over the unit square, in no order.
fn scan(count: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Value {
    let at = |i: u32, step: f64| (0.5 + f64::from(i) * step).fract();
    let points = (0..count).map(|i| json!(place(at(i, 0.754_877_666), at(i, 0.569_840_291))));
    points.collect()
}

fn tube(s: f64, t: f64) -> [f64; 3] {
    let radius = 15.0 + 1.5 * (3.0 * TAU * s).sin();
    let (sin, cos) = (TAU * s).sin_cos();
    [3.0 + radius * cos, radius * sin - 2.0, 60.0 * t]
}

fn ball(s: f64, t: f64) -> [f64; 3] {
    let ((sin, cos), height) = ((TAU * s).sin_cos(), 2.0 * t - 1.0);
    let out = (1.0 - height * height).max(0.0).sqrt();
    [25.0 * out * cos, 25.0 * out * sin, 25.0 * height]
}

fn automatic(scattered: Value, tolerance: f64) -> Value {
    json!({
        "surface": {"scattered": scattered},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": tolerance},
    })
}

/// Returns true if the surface of a job is closed in u and open in v.
async fn is_closed(server: &Server, job: &Value) -> bool {
    let result = server.json(job["links"]["result"].as_str().unwrap()).await;
    result["closed"] == json!({"u": true, "v": false})
}

/// Without parameters a tube is unrolled and closed, and that is reported; the same job is made again of its input.
#[tokio::test]
async fn tubes_are_closed() {
    let server = Server::start().await;
    let job = automatic(scan(1_500, tube), 0.05);
    let fitted = server.fit(&job).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    assert!(is_closed(&server, &fitted).await, "{fitted:#}");
    let notice = fitted["notices"][0].as_str().unwrap();
    assert!(notice.contains("a cylinder along (0.00"), "{notice}");
    let result = server
        .json(fitted["links"]["result"].as_str().unwrap())
        .await;
    let input = server.json(&format!("{}/input", base(&fitted))).await;
    assert_eq!(input["surface"]["parameters"], "auto");
    let again = server.fit(&input).await;
    let second = server
        .json(again["links"]["result"].as_str().unwrap())
        .await;
    assert_eq!(second["control_points"], result["control_points"]);
    // The radius is that of the tube, in the middle.
    let u = &result["knots"]["u"];
    let knots: Vec<f64> = u
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it.as_f64().unwrap())
        .collect();
    let period = knots[knots.len() - 4] - knots[3];
    assert!((period / TAU - 15.0).abs() < 0.3, "{period}");
    let step = server.get(&format!("{}/result/step", base(&fitted)));
    let step = step.send().await.unwrap().text().await.unwrap();
    assert!(step.contains("B_SPLINE_SURFACE"));
}

/// A cylinder that is known, with the parameters that come of it given as pairs: the same surface.
#[tokio::test]
async fn given_pairs_have_periods() {
    let server = Server::start().await;
    let mut job = automatic(scan(900, tube), 0.1);
    job["surface"]["parameters"] =
        json!({"project": "cylinder", "axis": [0, 0, 1], "center": [3, -2, 0]});
    let fitted = server.fit(&job).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    let result = server
        .json(fitted["links"]["result"].as_str().unwrap())
        .await;
    let [u, v] = ["u", "v"].map(|axis| result["parameters"][axis].as_array().unwrap());
    let pairs: Value = u.iter().zip(v).map(|(u, v)| json!([u, v])).collect();
    let knots = result["knots"]["u"].as_array().unwrap();
    let [start, end] = [&knots[3], &knots[knots.len() - 4]].map(|it| it.as_f64().unwrap());
    let parameters = json!({"pairs": pairs, "domains": {"u": {"period": end - start}}});
    job["surface"]["parameters"] = parameters.clone();
    let given = server.fit(&job).await;
    assert!(is_closed(&server, &given).await, "{given:#}");
    let error = |job: &Value| job["error"]["max"].as_f64().unwrap();
    assert!((error(&given) - error(&fitted)).abs() < 1e-6 * error(&fitted));
    let input = server.json(&format!("{}/input", base(&given))).await;
    assert_eq!(input["surface"]["parameters"], parameters);
    // An edit keeps the parameters, and with them the period.
    let edit = json!({"points": [{"index": 7, "point": [18, -2, 30]}]});
    let edits = server.post(&format!("{}/edits", base(&given)));
    let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
    let edited: Value = edited.unwrap().json().await.unwrap();
    assert!(is_closed(&server, &edited).await, "{edited:#}");
}

/// With a number of control points a tube is closed as well, by all variants.
#[tokio::test]
async fn tubes_with_given_numbers_are_closed() {
    let server = Server::start().await;
    let mut found = Vec::new();
    for variant in ["direct", "cg", "diagonal"] {
        let mut job = automatic(scan(900, tube), 0.0);
        job["surface"]["parameters"] = json!({"project": "cylinder"});
        job["method"] = json!({"kind": "least_squares", "control_points": {"u": 12, "v": 5}, "variant": variant});
        job["stop"] = json!({"tolerance": 1e-9, "max_iterations": 300});
        let fitted = server.fit(&job).await;
        assert!(is_closed(&server, &fitted).await, "{fitted:#}");
        found.push(fitted["error"]["rms"].as_f64().unwrap());
    }
    assert!(
        found
            .iter()
            .all(|rms| (rms - found[0]).abs() < 1e-3 * found[0]),
        "{found:?}"
    );
    assert!(found[0] < 0.1, "{found:?}");
}

/// A ball has poles, at which all control points are one.
#[tokio::test]
async fn balls_have_poles() {
    let server = Server::start().await;
    let fitted = server.fit(&automatic(scan(2_000, ball), 0.01)).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    let notice = fitted["notices"][0].as_str().unwrap();
    assert!(notice.contains("a sphere around ("), "{notice}");
    let result = server
        .json(fitted["links"]["result"].as_str().unwrap())
        .await;
    let rows = result["control_points"].as_array().unwrap();
    let pole = |row: &Value, at: usize| row[at].clone();
    let last = rows[0].as_array().unwrap().len() - 1;
    for row in rows {
        assert_eq!(pole(row, 0), pole(&rows[0], 0));
        assert_eq!(pole(row, last), pole(&rows[0], last));
    }
    let knots = result["knots"]["v"].as_array().unwrap();
    let end = knots[knots.len() - 1].as_f64().unwrap();
    assert!((end - 25.0 * PI / 2.0).abs() < 1e-6, "{end}");
}

/// Messages say the same.
#[tokio::test]
async fn messages_have_cylinders_and_periods() {
    let server = Server::start().await;
    let mut job = automatic(scan(300, tube), 0.5);
    job["surface"]["parameters"] = json!({"project": "sphere", "center": [3, -2, 30]});
    let fitted = server.fit(&job).await;
    let mut client = connect(&server).await;
    let id = fitted["id"].as_str().unwrap().to_owned();
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let input = input.into_inner().input.unwrap();
    let Some(pb::job_input::Geometry::Surface(surface)) = input.geometry else {
        panic!("no surface");
    };
    let scattered = surface.scattered.unwrap();
    assert_eq!(scattered.projection(), pb::Projection::Sphere);
    assert_eq!(scattered.center, [3.0, -2.0, 30.0]);
}

/// A place that ends in a slash is that of one of the numbers there.
async fn assert_refused(server: &Server, job: &Value, place: &str, expected: &str) {
    let response = server.post("/v1/jobs").json(job).send().await.unwrap();
    let (status, found) = problem(response).await;
    assert!(status == 422 || status == 400, "{job}");
    let pointer = found["errors"][0]["pointer"].as_str().unwrap();
    assert!(
        pointer == place || place.ends_with('/') && pointer.starts_with(place),
        "{found:#}"
    );
    let detail = found["detail"].as_str().unwrap();
    assert!(detail.contains(expected), "{found:#}");
}

/// Errors have locations.
#[tokio::test]
async fn wrong_surfaces_are_refused() {
    let server = Server::start().await;
    let points = scan(60, tube);
    let pairs: Value = (0..60)
        .map(|i| json!([0.1 * f64::from(i), f64::from(i * 7 % 60)]))
        .collect();
    let with = |domains: Value| json!({"pairs": pairs, "domains": domains});
    for (parameters, place, expected) in [
        (
            json!({"project": "xy", "axis": [0, 0, 1]}),
            "/surface/parameters",
            "only a cylinder",
        ),
        (
            json!({"project": "cylinder", "axis": [0, 0]}),
            "/surface/parameters/axis",
            "3",
        ),
        (
            json!({"project": "cylinder", "axis": [0, 0, 0]}),
            "/surface/parameters",
            "direction",
        ),
        (
            json!({"project": "cone"}),
            "/surface/parameters/project",
            "cone",
        ),
        (json!({"axis": [0, 0, 1]}), "/surface/parameters", "project"),
        (json!({"domains": {}}), "/surface/parameters", "pairs"),
        (
            with(json!({"u": {"period": 3}})),
            "/surface/parameters",
            "greater than the range",
        ),
        (
            with(json!({"u": {"period": 9, "ends": [0, 9]}})),
            "/surface/parameters",
            "neither ends nor poles",
        ),
        (
            with(json!({"v": {"ends": [0, 30]}})),
            "/surface/parameters/",
            "outside",
        ),
        (
            with(json!({"v": {"ends": [90, -1]}})),
            "/surface/parameters",
            "less than",
        ),
        (
            with(json!({"u": {"ends": [-1, 9], "poles": [true, false]}})),
            "/surface/parameters",
            "ends of v",
        ),
        (
            with(json!({"v": {"poles": [true, false]}})),
            "/surface/parameters",
            "both ends",
        ),
        (
            with(json!({"w": {}})),
            "/surface/parameters/domains/w",
            "unknown",
        ),
    ] {
        let mut job = automatic(points.clone(), 0.5);
        job["surface"]["parameters"] = parameters;
        assert_refused(&server, &job, place, expected).await;
    }
    let flat = scan(60, |s, t| [s, t, 0.0]);
    let mut job = automatic(flat, 0.5);
    for (surface, expected) in [("cylinder", "no cylinder"), ("sphere", "no sphere")] {
        job["surface"]["parameters"] = json!({"project": surface});
        assert_refused(&server, &job, "/surface/parameters", expected).await;
    }
}
