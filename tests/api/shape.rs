//! Curvature, length, area and continuity of curves and surfaces.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, assert_query_refused, base, problem};

async fn shape(server: &Server, job: &Value, query: &str) -> Value {
    server.json(&format!("{}/shape{query}", base(job))).await
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn near(found: &Value, expected: f64, tolerance: f64) {
    let found = number(found);
    assert!((found - expected).abs() <= tolerance, "{found} {expected}");
}

/// A circle of radius 2 in four quarters: the data are its control points, which a start without steps keeps.
fn circle() -> Value {
    let corners = [
        [1, 0],
        [1, 1],
        [0, 1],
        [-1, 1],
        [-1, 0],
        [-1, -1],
        [0, -1],
        [1, -1],
        [1, 0],
    ];
    let points: Vec<Value> = corners.iter().map(|[x, y]| json!([2 * x, 2 * y])).collect();
    let weights: Vec<f64> = (0..9)
        .map(|i| if i % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 })
        .collect();
    json!({
        "curve": {
            "points": points, "weights": weights, "parameters": [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4],
            "basis": {"kind": "bspline", "degree": 2, "knots": [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]},
        },
        "rational": "fixed",
        "method": "global",
        "stop": {"max_iterations": 1},
    })
}

/// The weights of a rational curve count: its first iteration is a circle.
#[tokio::test]
async fn circles_have_one_curvature() {
    let server = Server::start().await;
    let job = server.fit(&circle()).await;
    let shape = shape(&server, &job, "?iteration=0&samples=37").await;
    assert_eq!(
        (&shape["kind"], &shape["iteration"]),
        (&json!("curve"), &json!(0))
    );
    near(&shape["length"], 4.0 * PI, 1e-11);
    let samples = &shape["samples"];
    assert_eq!(numbers(&samples["parameters"])[9], 1.0);
    for (point, curvature) in samples["points"]
        .as_array()
        .unwrap()
        .iter()
        .zip(numbers(&samples["curvature"]))
    {
        assert!((number(&point[0]).hypot(number(&point[1])) - 2.0).abs() < 1e-14);
        assert!((curvature - 0.5).abs() < 1e-12);
    }
    for name in ["smallest", "largest"] {
        near(&shape["curvature"][name]["value"], 0.5, 1e-12);
    }
    let continuity = &shape["continuity"];
    assert_eq!(continuity["count"], 3);
    for knot in continuity["knots"].as_array().unwrap() {
        assert_eq!(
            (
                &knot["multiplicity"],
                &knot["guaranteed"],
                &knot["geometric"]
            ),
            (&json!(2), &json!(0), &json!(2))
        );
    }
}

/// Two points are a line, and a polyline has corners.
#[tokio::test]
async fn lines_are_straight_and_polylines_have_corners() {
    let server = Server::start().await;
    let line = json!({"curve": {"points": [[1, 1], [4, 5]], "degree": 1}});
    let found = shape(&server, &server.fit(&line).await, "").await;
    assert_eq!(found["length"], 5.0);
    assert_eq!(found["samples"]["curvature"], json!(vec![0.0; 200]));
    assert_eq!(found["curvature"]["largest"]["value"], 0.0);
    assert_eq!(found["continuity"], json!({"count": 0, "knots": []}));

    let polyline = json!({"curve": {"points": [[0, 0], [2, 0], [2, 1], [2, 5]], "polyline": true}});
    let found = shape(
        &server,
        &server.fit(&polyline).await,
        "?by=length&samples=8",
    )
    .await;
    let points = found["samples"]["points"].as_array().unwrap();
    for (i, point) in points.iter().enumerate() {
        near(&point[0], (i as f64).min(2.0), 1e-12);
        near(&point[1], (i as f64 - 2.0).max(0.0), 1e-12);
    }
    let knots = &found["continuity"]["knots"];
    assert_eq!(knots[0]["geometric"], 0);
    near(&knots[0]["angle"], 90.0, 1e-9);
    assert_eq!(knots[0]["point"], json!([2.0, 0.0]));
    assert_eq!(found["continuity"]["count"], 1);
    let spaced = shape(&server, &server.fit(&polyline).await, "?spacing=0.5").await;
    assert_eq!(spaced["samples"]["points"].as_array().unwrap().len(), 15);
}

/// Closed curves are smooth where they return to their start, and those with zero derivatives at their ends have no
/// curvature there.
#[tokio::test]
async fn ends_are_measured_as_they_are() {
    let server = Server::start().await;
    let ring: Vec<[f64; 2]> = (0..40)
        .map(|i| 2.0 * PI * f64::from(i) / 40.0)
        .map(|a| [3.0 * a.cos(), 3.0 * a.sin()])
        .collect();
    let closed = json!({"curve": {"points": ring, "closed": true}, "method": "direct"});
    let found = shape(&server, &server.fit(&closed).await, "").await;
    near(&found["length"], 6.0 * PI, 1e-4);
    near(&found["curvature"]["largest"]["value"], 1.0 / 3.0, 1e-3);
    assert_eq!(found["continuity"]["count"], 40);
    for knot in found["continuity"]["knots"].as_array().unwrap() {
        assert_eq!(
            (&knot["guaranteed"], &knot["geometric"]),
            (&json!(2), &json!(2))
        );
        near(&knot["jump"], 0.0, 1e-10);
    }

    let still = json!({"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]], "ends": "repeated"}});
    let found = shape(&server, &server.fit(&still).await, "?samples=11").await;
    let curvature = found["samples"]["curvature"].as_array().unwrap();
    assert!(curvature[0].is_null() && curvature[10].is_null());
    assert!(curvature[1..10].iter().all(Value::is_number));
    assert_eq!(found["degenerate"].as_array().unwrap().len(), 2);
    assert!(found["curvature"]["largest"]["value"].is_number());
}

/// A helix has the same curvature all along, in each basis that a fit can have.
#[tokio::test]
async fn a_helix_bends_alike_in_each_basis() {
    let server = Server::start().await;
    let helix: Vec<[f64; 3]> = (0..25)
        .map(|i| f64::from(i) / 8.0)
        .map(|t| [2.0 * t.cos(), 2.0 * t.sin(), t])
        .collect();
    let parameters: Vec<i32> = (0..25).collect();
    for (basis, tolerance) in [
        (json!({"kind": "bspline", "degree": 5}), 1e-3),
        (json!("bernstein"), 1e-6),
        (json!("said_ball"), 1e-6),
        (json!("wang_ball"), 1e-6),
    ] {
        let curve = json!({"points": helix, "basis": basis, "parameters": parameters});
        let job = json!({"curve": curve, "method": "direct"});
        let found = shape(&server, &server.fit(&job).await, "?samples=21").await;
        near(&found["length"], 3.0 * 5_f64.sqrt(), 1e-4);
        for curvature in &numbers(&found["samples"]["curvature"])[5..16] {
            assert!((curvature - 0.4).abs() < tolerance, "{basis}: {curvature}");
        }
    }
}

/// A cylinder: 1/r around it, nothing along it.
#[tokio::test]
async fn surfaces_have_principal_curvatures() {
    let server = Server::start().await;
    let rows: Vec<Vec<[f64; 3]>> = (0..24)
        .map(|i| 2.0 * PI * f64::from(i) / 24.0)
        .map(|a| {
            let at = |z| [2.0 * a.cos(), 2.0 * a.sin(), f64::from(z)];
            (0..5).map(at).collect()
        })
        .collect();
    let surface = json!({"points": rows, "closed": {"u": true, "v": false}});
    let job = server
        .fit(&json!({"surface": surface, "method": "direct"}))
        .await;
    let found = shape(&server, &job, "?samples=13x7").await;
    assert_eq!(found["kind"], "surface");
    near(&found["area"], 16.0 * PI, 0.01);
    let samples = &found["samples"];
    assert_eq!(numbers(&samples["parameters"]["u"]).len(), 13);
    assert_eq!(numbers(&samples["parameters"]["v"]).len(), 7);
    assert_eq!(samples["points"][12][6].as_array().unwrap().len(), 3);
    for (name, expected) in [
        ("k1", 0.0),
        ("k2", -0.5),
        ("gaussian", 0.0),
        ("mean", -0.25),
    ] {
        for row in samples[name].as_array().unwrap() {
            assert_eq!(numbers(row).len(), 7);
            for curvature in numbers(row) {
                assert!((curvature - expected).abs() < 5e-3, "{name}: {curvature}");
            }
        }
        let extremes = &found["curvature"][name];
        for extreme in [&extremes["smallest"], &extremes["largest"]] {
            near(&extreme["value"], expected, 0.02);
            assert_eq!(extreme["parameter"].as_array().unwrap().len(), 2);
        }
    }
    let continuity = &found["continuity"];
    assert_eq!(continuity["u"]["count"], 24);
    for knot in continuity["u"]["knots"].as_array().unwrap() {
        assert_eq!(
            (&knot["guaranteed"], &knot["angle"]),
            (&json!(2), &Value::Null)
        );
    }
}

/// A fold of a surface of degree 1, and the usual number of samples.
#[tokio::test]
async fn folds_are_seen() {
    let server = Server::start().await;
    let rows = json!([
        [[0, 0, 0], [0, 5, 0]],
        [[1, 0, 1], [1, 5, 1]],
        [[2, 0, 0], [2, 5, 0]]
    ]);
    let job = server
        .fit(&json!({"surface": {"points": rows, "degree": 1}}))
        .await;
    let found = shape(&server, &job, "").await;
    near(&found["area"], 10.0 * 2_f64.sqrt(), 1e-12);
    near(&found["continuity"]["u"]["knots"][0]["angle"], 90.0, 1e-9);
    assert_eq!(found["samples"]["k1"].as_array().unwrap().len(), 40);
}

/// Angles of a robot are a curve of seven dimensions.
#[tokio::test]
async fn curves_of_many_coordinates_bend() {
    let server = Server::start().await;
    let point = |t: f64| {
        let (x, y) = (t.cos(), t.sin());
        [x, y, x, y, x, y, 1.0]
    };
    let points: Vec<[f64; 7]> = (0..30).map(|i| point(0.1 * f64::from(i))).collect();
    let job = json!({"curve": {"points": points}, "method": "direct"});
    let found = shape(&server, &server.fit(&job).await, "?samples=31").await;
    // A circle of radius √3.
    let curvature = numbers(&found["samples"]["curvature"])[15];
    assert!((curvature - 1.0 / 3_f64.sqrt()).abs() < 1e-3);
    assert_eq!(found["samples"]["points"][0].as_array().unwrap().len(), 7);
}

#[tokio::test]
async fn what_cannot_be_measured_is_refused() {
    let server = Server::start().await;
    let curve = server.fit(&data::small_job()).await;
    let path = format!("{}/shape", base(&curve));
    for (query, parameter, reason) in [
        ("iteration=-1", "iteration", "neither a number nor"),
        ("view=samples", "view", "no such parameter"),
        ("samples=1", "samples", "at least 2"),
        ("samples=20x20", "samples", "200 for a curve"),
        ("samples=1000001", "samples", "1000000 in all"),
        ("by=time", "by", "expected length"),
        ("spacing=0", "spacing", "more than 0"),
        ("spacing=x", "spacing", "not a distance"),
        ("spacing=1&samples=5", "spacing", "give one of them"),
    ] {
        assert_query_refused(&server, &path, query, parameter, reason).await;
    }
    let surface = json!({"surface": {"points": data::peaks(6)}});
    let surface = format!("{}/shape", base(&server.fit(&surface).await));
    for (query, parameter, reason) in [
        ("samples=20", "samples", "40x40 for a surface"),
        ("samples=2000x2000", "samples", "1000000 in all"),
        ("by=length", "spacing", "those of curves"),
    ] {
        assert_query_refused(&server, &surface, query, parameter, reason).await;
    }
    let values = json!({"curve": {"points": [[0], [2], [1], [3]], "parameters": "uniform"}});
    let values = format!("{}/shape", base(&server.fit(&values).await));
    let refused = [
        (values, 409, "no-shape", "one coordinate"),
        (
            format!("{path}?spacing=1e-9"),
            409,
            "no-shape",
            "choose a larger one",
        ),
        (
            format!("{path}?iteration=900000"),
            404,
            "no-such-iteration",
            "before 900000",
        ),
        (
            "/v1/jobs/019aa7a4-6a3c-7c5e-8a55-5b9d2c5f1f10/shape".to_owned(),
            404,
            "unknown-job",
            "",
        ),
    ];
    for (url, status, slug, reason) in refused {
        let (found, problem) = problem(server.get(&url).send().await.unwrap()).await;
        assert_eq!(
            (found, &problem["type"]),
            (status, &json!(format!("/problems/{slug}")))
        );
        assert!(
            problem["detail"].as_str().unwrap().contains(reason),
            "{problem}"
        );
    }
}

/// A job that was cancelled before it began has no iteration to be measured.
#[tokio::test]
async fn jobs_without_iterations_have_no_shape() {
    let server = Server::with(|config| config.memory = Some("128KiB".parse().unwrap())).await;
    server.create(&data::endless_job()).await;
    let queued = server.create(&data::endless_job()).await;
    let cancel = server.post(&format!("{}/cancel", base(&queued)));
    assert_eq!(cancel.send().await.unwrap().status(), 200);
    let url = format!("{}/shape", base(&queued));
    let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
    assert_eq!(
        (status, &problem["type"]),
        (404, &json!("/problems/no-such-iteration"))
    );
    assert!(
        problem["detail"]
            .as_str()
            .unwrap()
            .contains("no iteration yet")
    );
}
