//! Least squares of scattered points, against scipy.

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

/// Points of Franke's function, and the surfaces near them, by `tests/golden/scattered.py`.
fn golden() -> Value {
    serde_json::from_str(include_str!("../golden/scattered.json")).unwrap()
}

/// A job with the golden points, or those with these indices, by their x and y.
fn franke(golden: &Value, indices: Option<&Value>, variant: &str, levels: usize) -> Value {
    let points = match indices.and_then(Value::as_array) {
        None => golden["points"].clone(),
        Some(indices) => {
            let of = |index: &Value| golden["points"][index.as_u64().unwrap() as usize].clone();
            indices.iter().map(of).collect()
        }
    };
    json!({
        "surface": {
            "scattered": points,
            "parameters": {"project": "xy"},
            "basis": {"kind": "bspline", "degree": 3, "knots": golden["knots"]},
        },
        "method": {"kind": "least_squares", "control_points": 14, "variant": variant},
        "stop": {"tolerance": 0, "max_iterations": levels},
    })
}

/// The result of a job.
async fn result(server: &Server, job: &Value) -> Value {
    let path = job["links"]["result"].as_str().unwrap();
    server.json(path).await
}

/// The largest difference of the heights of control points from those of scipy.
fn difference(result: &Value, coefficients: &Value) -> f64 {
    let rows = result["control_points"].as_array().unwrap().iter();
    let heights = rows.flat_map(|row| row.as_array().unwrap());
    let pairs = heights.zip(coefficients.as_array().unwrap());
    let differences = pairs.map(|(point, c)| point[2].as_f64().unwrap() - c.as_f64().unwrap());
    differences.fold(0.0, |most, x| x.abs().max(most))
}

/// The minimum, solved for, is that of scipy's LSQBivariateSpline.
#[tokio::test]
async fn the_minimum_is_that_of_scipy() {
    let (server, golden) = (Server::start().await, golden());
    for (indices, expected) in [(None, "whole"), (Some(&golden["far"]), "hole")] {
        let expected = &golden[expected];
        let job = server.fit(&franke(&golden, indices, "direct", 10)).await;
        assert_eq!(job["reason"], "minimum", "{job:#}");
        let largest = job["error"]["max"].as_f64().unwrap();
        assert!((largest - expected["largest"].as_f64().unwrap()).abs() < 1e-13);
        assert_eq!(job["error"]["at"], expected["at"]);
        let result = result(&server, &job).await;
        assert!(difference(&result, &expected["coefficients"]) < 1e-12);
    }
}

/// Errors of levels by conjugate gradients, from an independent implementation.
#[tokio::test]
async fn levels_have_the_published_errors() {
    let (server, golden) = (Server::start().await, golden());
    let story = server.stream(&franke(&golden, None, "cg", 100)).await;
    for (level, expected) in [(10, 0.00748446), (30, 0.00669980)] {
        let error = story.error(level);
        assert!((error - expected).abs() < 0.51e-8, "{level}: {error}");
    }
    let last = story.iterations.last().unwrap()["error"]["max"]
        .as_f64()
        .unwrap();
    assert!((last - 0.00668680).abs() < 1e-6, "{last}");
    assert_eq!(story.iterations[0]["error"]["at"].as_array(), None);
}

/// All variants go to the same minimum, and the first step of `diagonal` leads to weighted means.
#[tokio::test]
async fn all_variants_approach_the_minimum() {
    let (server, golden) = (Server::start().await, golden());
    let expected = &golden["whole"]["coefficients"];
    let job = server.fit(&franke(&golden, None, "cg", 1000)).await;
    assert_eq!(job["reason"], "minimum", "{job:#}");
    assert!(difference(&result(&server, &job).await, expected) < 1e-3);
    for (variant, most) in [("diagonal", 0.008), ("lspia", 0.05)] {
        let story = server.stream(&franke(&golden, None, variant, 200)).await;
        let rms = |k: usize| story.iterations[k]["error"]["rms"].as_f64().unwrap();
        assert!((1..=200).all(|k| rms(k) <= rms(k - 1)), "{variant}");
        let largest = story.error(200);
        assert!(largest < most, "{variant}: {largest}");
    }
    let story = server.stream(&franke(&golden, None, "diagonal", 1)).await;
    let corner = &story.iterations[1]["control_points"][0][0];
    // The function of the corner is (1 − 11 u)³ (1 − 11 v)³.
    let (mut sum, mut weights) = (0.0, 0.0);
    for point in golden["points"].as_array().unwrap() {
        let factor = |t: &Value| (1.0 - 11.0 * t.as_f64().unwrap()).max(0.0).powi(3);
        let weight = factor(&point[0]) * factor(&point[1]);
        sum += weight * point[2].as_f64().unwrap();
        weights += weight;
    }
    assert!((corner[2].as_f64().unwrap() - sum / weights).abs() < 1e-14);
}

/// Parameters as pairs, in a plane, and by default knots that are spread; the input repeats them.
#[tokio::test]
async fn parameters_are_given_or_projected() {
    let (server, golden) = (Server::start().await, golden());
    let pairs: Value = golden["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| json!([point[0], point[1]]))
        .collect();
    let mut job = franke(&golden, None, "direct", 10);
    job["surface"]["parameters"] = pairs.clone();
    let given = server.fit(&job).await;
    assert_eq!(given["points"], 1500);
    let given_result = result(&server, &given).await;
    assert!(difference(&given_result, &golden["whole"]["coefficients"]) < 1e-12);
    let input = server.json(given["links"]["input"].as_str().unwrap()).await;
    assert_eq!(input["surface"]["scattered"], job["surface"]["scattered"]);
    assert_eq!(input["surface"]["parameters"], pairs);
    let again = server.fit(&input).await;
    assert_eq!(
        result(&server, &again).await["control_points"],
        given_result["control_points"]
    );
    // Less steep, so that the nearest plane is nearly that of x and y.
    for point in job["surface"]["scattered"].as_array_mut().unwrap() {
        point[2] = json!(0.1 * point[2].as_f64().unwrap());
    }
    for parameters in [
        json!("project"),
        json!({"project": "plane"}),
        json!({"project": "xy"}),
    ] {
        job["surface"]["parameters"] = parameters.clone();
        job["surface"]["basis"] = json!("bspline");
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["reason"], "minimum", "{fitted:#}");
        let largest = fitted["error"]["max"].as_f64().unwrap();
        assert!(largest < 0.002, "{parameters}: {largest}");
        let input = server
            .json(fitted["links"]["input"].as_str().unwrap())
            .await;
        let expected = match parameters == json!({"project": "plane"}) {
            true => json!("project"),
            false => parameters,
        };
        assert_eq!(input["surface"]["parameters"], expected);
        assert_eq!(input["surface"]["basis"]["knots"], "spread");
    }
}

/// A small job: 5 × 5 points of a saddle, without an order.
fn saddle() -> Value {
    let points: Value = (0..25)
        .map(|i| {
            let (x, y) = (f64::from(i * 7 % 25 / 5), f64::from(i * 7 % 5));
            json!([x, y, 0.1 * (x - 2.0) * (y - 2.0)])
        })
        .collect();
    json!({
        "surface": {"scattered": points, "parameters": {"project": "xy"}},
        "method": {"kind": "least_squares", "control_points": 4, "variant": "direct"},
    })
}

#[tokio::test]
async fn errors_name_the_field_and_the_index() {
    let server = Server::start().await;
    let changes: [(&str, Value, &str, &str); 24] = [
        ("/method", json!("global"), "/method", "least_squares"),
        (
            "/method",
            json!({"kind": "weighted"}),
            "/method",
            "have no order",
        ),
        (
            "/method",
            json!({"kind": "local", "indices": [3]}),
            "/method",
            "have no order",
        ),
        (
            "/surface/parameters",
            json!("chord_length"),
            "/surface/parameters",
            "no rows and columns",
        ),
        (
            "/surface/parameters",
            json!([1, 2, 3]),
            "/surface/parameters",
            "no rows and columns",
        ),
        (
            "/surface/parameters",
            json!([[1, 2], [3, 4]]),
            "/surface/parameters",
            "2 parameters for 25 points",
        ),
        (
            "/surface/parameters",
            json!([[1, 2], [3]]),
            "/surface/parameters/1",
            "1 entries, the first of its kind has 2",
        ),
        (
            "/surface/parameters",
            json!([[1, 2], 3]),
            "/surface/parameters/1",
            "a number stands here where others have lists",
        ),
        (
            "/surface/parameters",
            json!([[1, 2], null]),
            "/surface/parameters/1",
            "a list of numbers, found null",
        ),
        (
            "/surface/parameters",
            json!([[1, 2], [1, "NaN"]]),
            "/surface/parameters/1/1",
            "number",
        ),
        (
            "/surface/parameters",
            json!(vec![[1, 2]; 25]),
            "/surface/parameters",
            "the same parameter",
        ),
        (
            "/surface/parameters",
            json!({"project": "zx"}),
            "/surface/parameters/project",
            "zx",
        ),
        (
            "/surface/parameters",
            json!({"u": "uniform", "v": "uniform"}),
            "/surface/parameters",
            "no rows",
        ),
        (
            "/surface/closed",
            json!(true),
            "/surface/closed",
            "goes around a cylinder",
        ),
        (
            "/surface/closed",
            json!({"u": false, "v": true}),
            "/surface/closed/v",
            "goes around a cylinder",
        ),
        (
            "/surface/basis",
            json!({"kind": "bspline", "knots": "averaged"}),
            "/surface/basis/knots",
            "spread",
        ),
        (
            "/surface/basis",
            json!({"kind": "bspline", "knots": "data"}),
            "/surface/basis/knots",
            "spread",
        ),
        (
            "/surface/basis",
            json!({"kind": "bspline", "knots": [0, 0, 0, 0, 3, 3, 3, 3]}),
            "/surface/parameters/",
            "outside",
        ),
        ("/surface/ends", json!("natural"), "/surface/ends", "ends"),
        (
            "/method/control_points",
            json!(6),
            "/surface/scattered",
            "6 × 6",
        ),
        (
            "/method/control_points",
            json!({"u": 6, "v": 4}),
            "/method/control_points/u",
            "different parameters",
        ),
        (
            "/method/end_points",
            json!("interpolated"),
            "/method/end_points",
            "scattered",
        ),
        (
            "/method/data_weights",
            json!([1, 2]),
            "/method/data_weights",
            "25",
        ),
        (
            "/surface/points",
            json!([[[0], [1]], [[2], [3]]]),
            "/surface/scattered",
            "as well",
        ),
    ];
    for (place, value, pointer, reason) in changes {
        let mut job = saddle();
        let (parent, name) = place.rsplit_once('/').unwrap();
        job.pointer_mut(parent).unwrap()[name] = value;
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (status, problem) = problem(response).await;
        assert_eq!(status, 422, "{place}: {problem:#}");
        let found = problem["errors"][0]["pointer"].as_str().unwrap();
        assert!(found.starts_with(pointer), "{place}: {problem:#}");
        let detail = problem["errors"][0]["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{place}: {problem:#}");
    }
}

/// Few points, points on a line, and weights of a rational surface.
#[tokio::test]
async fn invalid_surfaces_are_rejected() {
    let server = Server::start().await;
    let job = |points: Value, control_points: usize| {
        json!({
            "surface": {"scattered": points, "parameters": "project", "degree": 1},
            "method": {"kind": "least_squares", "control_points": control_points, "variant": "cg"},
        })
    };
    let corners = json!([[0, 0, 0], [1, 0, 1], [0, 1, 1], [1, 1, 0], [0.5, 0.4, 0.5]]);
    for count in [0, 1, 2, 3] {
        let points: Value = corners.as_array().unwrap()[..count]
            .iter()
            .cloned()
            .collect();
        server
            .assert_refused(&job(points, 2), "/surface/scattered", "points")
            .await;
    }
    let fitted = server.fit(&job(corners.clone(), 2)).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    let line: Value = (0..9).map(|i| json!([i, 2 * i, 3])).collect();
    server
        .assert_refused(&job(line, 2), "/surface/parameters", "on a line")
        .await;
    let values: Value = (0..9).map(|i| json!([i])).collect();
    server
        .assert_refused(&job(values, 2), "/surface/parameters", "one coordinate")
        .await;
    let mut weighted = job(corners, 2);
    weighted["surface"]["weights"] = json!([[1], [1], [1], [1], [2]]);
    server
        .assert_refused(&weighted, "/surface/weights", "scattered")
        .await;
    let mut curve = weighted;
    curve["curve"] = curve["surface"].take();
    curve.as_object_mut().unwrap().remove("surface");
    let response = server.post("/v1/jobs").json(&curve).send().await.unwrap();
    assert_eq!(problem(response).await.0, 422);
}

/// A hole as wide as whole functions: their control points stay beside those that have points.
#[tokio::test]
async fn control_points_at_holes_do_not_move() {
    let (server, golden) = (Server::start().await, golden());
    let points = golden["points"].as_array().unwrap();
    let outside = |point: &&Value| {
        let (x, y) = (point[0].as_f64().unwrap(), point[1].as_f64().unwrap());
        (x - 0.5).hypot(y - 0.5) > 0.35
    };
    let ring: Vec<Value> = points.iter().filter(outside).cloned().collect();
    for variant in ["diagonal", "cg", "direct"] {
        let mut job = franke(&golden, None, variant, 400);
        job["surface"]["scattered"] = json!(ring);
        let job = server.fit(&job).await;
        assert_eq!(job["warnings"][0]["code"], "without_data", "{job:#}");
        let result = result(&server, &job).await;
        let middle = &result["control_points"][6][6];
        for (c, (low, high)) in [(0, (0.1, 0.9)), (1, (0.1, 0.9)), (2, (0.0, 1.3))] {
            let x = middle[c].as_f64().unwrap();
            assert!((low..high).contains(&x), "{variant}: {middle}");
        }
    }
}

/// Moved points have single indices, and keep their parameters.
#[tokio::test]
async fn points_are_moved_by_their_index() {
    let server = Server::start().await;
    let parent = server.fit(&saddle()).await;
    assert!(
        parent["error"]["max"].as_f64().unwrap() < 1e-12,
        "{parent:#}"
    );
    let path = format!("{}/edits", parent["links"]["self"].as_str().unwrap());
    let edit = json!({"points": [{"index": 7, "point": [1, 1, 5]}]});
    let response = server
        .post(&path)
        .header("prefer", "wait=100")
        .json(&edit)
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 201);
    let child: Value = response.json().await.unwrap();
    assert!(child["error"]["at"].is_u64(), "{child:#}");
    assert!(child["error"]["max"].as_f64().unwrap() > 0.1, "{child:#}");
    let input = server.json(child["links"]["input"].as_str().unwrap()).await;
    assert_eq!(input["surface"]["scattered"][7], json!([1.0, 1.0, 5.0]));
    assert_eq!(input["surface"]["parameters"][7], json!([4.0, 4.0]));
    for (index, reason) in [(json!(25), "25"), (json!([0, 1]), "single")] {
        let edit = json!({"points": [{"index": index, "point": [1, 1, 5]}]});
        let response = server.post(&path).json(&edit).send().await.unwrap();
        let (status, problem) = problem(response).await;
        assert_eq!(
            (status, &problem["errors"][0]["pointer"]),
            (422, &json!("/points/0/index"))
        );
        assert!(
            problem["detail"].as_str().unwrap().contains(reason),
            "{problem:#}"
        );
    }
    let edit = json!({"method": "global"});
    let response = server.post(&path).json(&edit).send().await.unwrap();
    assert_eq!(problem(response).await.0, 422);
}

/// Every view of an iteration, and every file of the result.
#[tokio::test]
async fn views_and_files_show_scattered_fits() {
    let server = Server::start().await;
    let job = server.fit(&saddle()).await;
    let this = job["links"]["self"].as_str().unwrap();
    for view in ["control_points", "errors", "samples"] {
        server
            .json(&format!("{this}/iterations/1?view={view}"))
            .await;
    }
    for format in ["step", "iges", "obj", "glb", "stl", "dxf", "svg", "csv"] {
        let path = format!("{this}/result/{format}");
        let response = server.get(&path).send().await.unwrap();
        assert_eq!(response.status(), 200, "{format}");
        let bytes = response.bytes().await.unwrap();
        if format == "svg" {
            let dots = String::from_utf8_lossy(&bytes).matches("<circle").count();
            assert!(dots >= 25, "{dots}");
        }
    }
}

/// The same job as a message, and back.
#[tokio::test]
async fn messages_ask_for_the_same() {
    let server = Server::start().await;
    let fitted = server.fit(&saddle()).await;
    let mut client = connect(&server).await;
    let id = fitted["id"].as_str().unwrap().to_owned();
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let input = input.into_inner().input.unwrap();
    let Some(pb::job_input::Geometry::Surface(surface)) = &input.geometry else {
        panic!("no surface");
    };
    assert_eq!((surface.rows, surface.columns), (25, 1));
    let scattered = surface.scattered.as_ref().unwrap();
    assert_eq!(scattered.projection(), pb::Projection::Xy);
    let values = surface
        .points
        .chunks(3)
        .flat_map(|point| [point[0], point[1]]);
    let values: Vec<f64> = values.collect();
    let request = |change: &dyn Fn(&mut pb::Surface)| {
        let mut input = input.clone();
        if let Some(pb::job_input::Geometry::Surface(surface)) = &mut input.geometry {
            change(&mut *surface);
        }
        pb::CreateJobRequest {
            input: Some(input),
            ..pb::CreateJobRequest::default()
        }
    };
    let given = |values: &[f64]| {
        let values = values.to_vec();
        Some(pb::ScatteredParameters {
            values,
            ..pb::ScatteredParameters::default()
        })
    };
    let pairs = request(&|surface| {
        (surface.rows, surface.columns) = (0, 0);
        surface.scattered = given(&values);
    });
    let made = client
        .create_job(pairs)
        .await
        .unwrap()
        .into_inner()
        .job
        .unwrap();
    let end = server
        .get(&format!("/v1/jobs/{}?wait=100", made.id))
        .send()
        .await
        .unwrap();
    assert!(end.status().is_success());
    let wrong = [
        request(&|surface| surface.scattered = given(&values[1..])),
        request(&|surface| surface.scattered = given(&values[2..])),
        request(&|surface| (surface.rows, surface.columns) = (5, 5)),
        request(&|surface| surface.scattered.as_mut().unwrap().values.push(1.0)),
        request(&|surface| {
            surface.scattered = given(&values);
            surface.scattered.as_mut().unwrap().values[9] = f64::NAN;
        }),
    ];
    let fields = [
        "input.surface.scattered.values",
        "input.surface.scattered",
        "input.surface.columns",
        "input.surface.scattered.values",
        "input.surface.scattered.values[9]",
    ];
    for (request, field) in wrong.into_iter().zip(fields) {
        let error = client.create_job(request).await.unwrap_err();
        assert_eq!(error.code(), tonic::Code::InvalidArgument);
        let details = String::from_utf8_lossy(error.details()).into_owned();
        assert!(details.contains(field), "{field}: {details}");
    }
}

/// Planes of coordinates are those of the points as they stand.
#[tokio::test]
async fn every_plane_of_coordinates_serves() {
    let server = Server::start().await;
    let saddle = saddle();
    let points = saddle["surface"]["scattered"].as_array().unwrap();
    let with = |plane: &str, order: [usize; 3]| {
        let point = |it: &Value| order.map(|c| it[c].clone());
        let mut job = saddle.clone();
        job["surface"]["scattered"] = json!(points.iter().map(point).collect::<Vec<_>>());
        job["surface"]["parameters"] = json!({"project": plane});
        job
    };
    let expected = server.fit(&with("xy", [0, 1, 2])).await;
    for (plane, order) in [("xz", [0, 2, 1]), ("yz", [2, 0, 1])] {
        let job = with(plane, order);
        let fitted = server.fit(&job).await;
        let [found, known] = [&fitted, &expected].map(|it| it["error"]["max"].as_f64().unwrap());
        assert!((found - known).abs() < 1e-12, "{plane}: {fitted:#}");
        let input = server.json(&format!("{}/input", base(&fitted))).await;
        assert_eq!(input["surface"]["parameters"], json!({"project": plane}));
    }
    let flat: Vec<Value> = points.iter().map(|it| json!([it[0], it[1]])).collect();
    let mut job = with("xz", [0, 1, 2]);
    job["surface"]["scattered"] = json!(flat);
    server
        .assert_refused(&job, "/surface/parameters", "have no z")
        .await;
}

/// Half of a pipe with noise over a plane, on which its points are dense at both sides: if parameters follow the
/// surface, fewer control points suffice, and errors are distances. The result is reproduced from its input.
#[tokio::test]
async fn parameters_follow_the_surface() {
    let server = Server::start().await;
    let at = |i: u32, step: f64| (0.5 + f64::from(i) * step).fract();
    let points: Vec<[f64; 3]> = (0..2_000)
        .map(|i| {
            let angle = 0.05 + (PI - 0.1) * at(i, 0.754_877_666);
            let radius = 1.0 + 0.003 * (2.0 * at(i, 0.466) - 1.0);
            let along = 2.0 * at(i, 0.569_840_291);
            [radius * angle.cos(), along, radius * angle.sin()]
        })
        .collect();
    let mut counts = Vec::new();
    for is_corrected in [false, true] {
        let job = json!({
            "surface": {"scattered": points, "parameters": {"project": "xy"}},
            "method": {"kind": "least_squares", "control_points": "auto", "correct_parameters": is_corrected},
            "stop": {"tolerance": 0.01},
        });
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["state"], "converged", "{fitted:#}");
        let fit = result(&server, &fitted).await;
        let rows = fit["control_points"].as_array().unwrap();
        counts.push(rows.len() * rows[0].as_array().unwrap().len());
        let has_moved = fit["parameters"]["u"][7].as_f64().unwrap() != points[7][0];
        assert_eq!(has_moved, is_corrected, "{}", fit["parameters"]["u"][7]);
        if is_corrected {
            let deviation = server.get(&format!("{}/deviation", base(&fitted)));
            let deviation: Value = deviation.send().await.unwrap().json().await.unwrap();
            let (nearest, error) = (&deviation["max"], &fitted["error"]["max"]);
            let ratio = nearest.as_f64().unwrap() / error.as_f64().unwrap();
            assert!((0.8..=1.0).contains(&ratio), "{nearest} {error}");
            let input = server.json(&format!("{}/input", base(&fitted))).await;
            let again = result(&server, &server.fit(&input).await).await;
            for field in ["control_points", "knots", "parameters"] {
                assert_eq!(again[field], fit[field]);
            }
        }
    }
    assert!(5 * counts[1] < counts[0], "{counts:?}");
    let grid = json!({
        "surface": {"points": [[[0, 0, 0], [0, 1, 1]], [[1, 0, 1], [1, 1, 0]]], "degree": 1},
        "method": {"kind": "least_squares", "control_points": "auto", "correct_parameters": true},
        "stop": {"tolerance": 0.004},
    });
    let pointer = "/method/correct_parameters";
    server
        .assert_refused(&grid, pointer, "and for scattered points")
        .await;
    let mut robust = json!({
        "surface": {"scattered": points},
        "method": {"kind": "least_squares", "control_points": "auto", "correct_parameters": true},
        "stop": {"tolerance": 0.004},
    });
    robust["method"]["robust"] = true.into();
    server
        .assert_refused(&robust, pointer, "without constraints")
        .await;
}
