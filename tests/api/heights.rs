//! What need not be said: heights are a surface, explicit knots say how many control points there are, and
//! results have the parameters of the data.

use prost::Message;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::support::{Server, base, problem};

/// Heights with a spacing are points of space, so that their surface has a place in CAD systems.
#[tokio::test]
async fn heights_get_a_place() {
    let server = Server::start().await;
    let height = |i: usize, j: usize| (0.4 * i as f64).sin() + 0.1 * (j * j) as f64;
    let rows: Vec<Vec<f64>> = (0..7)
        .map(|i| (0..9).map(|j| height(i, j)).collect())
        .collect();
    let surface = json!({"points": rows, "spacing": [2.5, -10], "origin": [100, 70]});
    let job = server
        .fit(&json!({"surface": surface, "method": "direct"}))
        .await;
    assert_eq!(job["state"], "converged", "{job:#}");
    let path = base(&job).to_owned();
    // x and y are those of the plane at equal steps of the parameters, and the corners those of the grid.
    let samples = server
        .json(&format!("{path}/result?view=samples&samples=13x17"))
        .await;
    for i in 0..13 {
        for j in 0..17 {
            let point = &samples["samples"][i][j];
            let [x, y] = [0, 1].map(|c| point[c].as_f64().unwrap());
            assert!(
                (x - (100.0 + 20.0 * j as f64 / 16.0)).abs() < 1e-10,
                "{point}"
            );
            assert!(
                (y - (70.0 - 60.0 * i as f64 / 12.0)).abs() < 1e-10,
                "{point}"
            );
        }
    }
    let alone = server
        .fit(&json!({"surface": {"points": rows}, "method": "direct"}))
        .await;
    let alone = server
        .json(&format!(
            "{}/result?view=samples&samples=13x17",
            base(&alone)
        ))
        .await;
    let z = [&samples, &alone].map(|it| it["samples"][5][7].as_array().unwrap().last().cloned());
    let [placed, plain] = z.map(|z| z.unwrap().as_f64().unwrap());
    assert!((placed - plain).abs() < 1e-12);
    let step = server.get(&format!("{path}/result/step")).send().await;
    let step = step.unwrap().text().await.unwrap();
    assert!(step.contains("(100.0,70.0,"), "{step}");
    let shape = server.json(&format!("{path}/shape")).await;
    assert!(shape["area"].as_f64().unwrap() > 20.0 * 60.0);
    // The input has points, which ask for the same again.
    let input = server.json(&format!("{path}/input")).await;
    assert_eq!(input["surface"]["points"][1][1][1], 60.0);
    assert_eq!(input["surface"]["spacing"], Value::Null);
    assert_eq!(server.fit(&input).await["error"], job["error"]);
    // Missing heights stay missing.
    let mut holed = json!(rows);
    holed[2][3] = Value::Null;
    let holed = json!({
        "surface": {"points": holed, "spacing": [1, 1]},
        "method": {"kind": "least_squares", "control_points": 5},
    });
    assert_eq!(server.fit(&holed).await["state"], "converged");
}

/// The same by messages.
#[tokio::test]
async fn heights_get_a_place_in_messages() {
    let server = Server::start().await;
    let heights = |placement| pb::Surface {
        dimension: 1,
        rows: 4,
        columns: 5,
        points: (0..20).map(|i| f64::from(i * i % 7)).collect(),
        placement,
        ..pb::Surface::default()
    };
    let input = |placement| pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Surface(heights(placement))),
        ..pb::JobInput::default()
    };
    let post = async |placement| {
        let body = input(Some(placement)).encode_to_vec();
        let request = server
            .post("/v1/jobs")
            .header("content-type", "application/x-protobuf")
            .header("prefer", "wait=10");
        request.body(body).send().await.unwrap()
    };
    let place = pb::HeightPlacement {
        dx: 2.0,
        dy: 3.0,
        x: -1.0,
        y: 0.5,
    };
    let answer = post(place).await;
    assert_eq!(answer.status(), 201);
    let job: Value = answer.json().await.unwrap();
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(input["surface"]["points"][3][4], json!([7.0, 9.5, 4.0]));
    let flat = post(pb::HeightPlacement { dy: 0.0, ..place }).await;
    let (status, problem) = problem(flat).await;
    assert_eq!(
        (status, &problem["errors"][0]["field"]),
        (422, &json!("surface.placement.dy")),
        "{problem:#}"
    );
}

#[tokio::test]
async fn places_of_heights_are_checked() {
    let server = Server::start().await;
    let heights = json!([[0, 1, 3, 4], [1, 2, 4, 6], [3, 5, 9, 1]]);
    for (more, pointer, reason) in [
        (
            json!({"spacing": [0, 1]}),
            "/surface/spacing/0",
            "the step is 0",
        ),
        (json!({"spacing": [1]}), "/surface/spacing", "2"),
        (json!({"spacing": 1}), "/surface/spacing", ""),
        (json!({"origin": [1, 1]}), "/surface/origin", "is missing"),
        (
            json!({"spacing": [1, 1], "closed": {"u": true, "v": false}}),
            "/surface/spacing",
            "the surface is closed",
        ),
        (
            json!({"spacing": [1, 1], "points": data::peaks(5)}),
            "/surface/spacing",
            "these points have 3 coordinates",
        ),
        (
            json!({"spacing": [1e308, 1], "origin": [1.7e308, 0]}),
            "/surface/spacing",
            "range of numbers",
        ),
    ] {
        let mut surface = json!({"points": heights});
        for (name, value) in more.as_object().unwrap() {
            surface[name] = value.clone();
        }
        server
            .assert_refused(&json!({"surface": surface}), pointer, reason)
            .await;
    }
    let scattered = json!({
        "surface": {"scattered": [[0, 0, 1], [1, 0, 2], [1, 1, 4]], "parameters": "project", "spacing": [1, 1]},
        "method": {"kind": "least_squares", "control_points": 4},
    });
    server
        .assert_refused(&scattered, "/surface/spacing", "these points are scattered")
        .await;
}

/// Heights of m × n points are a surface of one coordinate at equal steps of the parameters.
#[tokio::test]
async fn heights_are_a_surface() {
    let server = Server::start().await;
    let height = |i: usize, j: usize| (0.4 * i as f64).sin() + 0.1 * j as f64;
    let rows = |wrap: &dyn Fn(f64) -> Value| -> Value {
        let row = |i| (0..9).map(|j| wrap(height(i, j))).collect::<Value>();
        (0..7).map(row).collect()
    };
    let job = |points: Value| json!({"surface": {"points": points}, "method": "direct"});
    let heights = server.fit(&job(rows(&|z| json!(z)))).await;
    assert_eq!(heights["state"], "converged", "{heights:#}");
    assert_eq!(
        (&heights["kind"], &heights["points"]),
        (&json!("surface"), &json!(63))
    );
    let result = server.json(&format!("{}/result", base(&heights))).await;
    assert_eq!(result["parameters"]["u"][3], 0.5);
    assert_eq!(result["control_points"][0][0].as_array().unwrap().len(), 1);
    // The same as points of one coordinate, and as it is given back.
    let lists = server.fit(&job(rows(&|z| json!([z])))).await;
    assert_eq!(lists["error"], heights["error"]);
    let input = server.json(&format!("{}/input", base(&heights))).await;
    assert_eq!(input["surface"]["parameters"], "uniform");
    assert_eq!(server.fit(&input).await["error"], heights["error"]);
    // Least squares leaves out what is missing.
    let mut missing = rows(&|z| json!(z));
    missing[2][3] = Value::Null;
    let holed = json!({"surface": {"points": missing}, "method": {"kind": "least_squares", "control_points": 5}});
    assert_eq!(server.fit(&holed).await["state"], "converged");
    // Other parameters if requested, with heights or points.
    let mut chords = job(json!([[0, 1, 3, 4], [1, 2, 4, 6], [3, 5, 9, 1]]));
    chords["surface"]["parameters"] = json!("chord_length");
    let chords = server.fit(&chords).await;
    let chords = server.json(&format!("{}/result", base(&chords))).await;
    assert_ne!(chords["parameters"]["u"][1], 0.5);
    let mixed = job(json!([[1, 2, 3, 4], [3, [4, 5], 6, 7]]));
    server
        .assert_refused(
            &mixed,
            "/surface/points/1/1",
            "this point has 2 coordinates, the first has 1",
        )
        .await;
    // A list of points is no surface.
    let list = job(json!([[1, 2, 3], [3, 4, 5]]));
    let detail = "a list of points is a curve";
    server
        .assert_refused(&list, "/surface/points/0", detail)
        .await;
    let few = server
        .fit(&job(json!([[[1], [2], [4]], [[3], [4], [9]]])))
        .await;
    assert_eq!(few["state"], "converged", "{few:#}");
    let curve = json!({"curve": {"points": [1, 2, 3]}});
    server
        .assert_refused(&curve, "/curve/points/0", "expected a point")
        .await;
}

/// In messages, too.
#[tokio::test]
async fn results_have_the_parameters_of_the_data() {
    let server = Server::start().await;
    let jobs = [
        json!({"curve": {"points": data::wave(30)}}),
        json!({"curve": {"points": data::wave(30), "closed": true}, "method": {"kind": "least_squares", "control_points": 9}}),
        json!({"surface": {"points": data::peaks(8)}, "method": "direct"}),
        json!({"curve": {"points": data::wave(60)}, "method": {
            "kind": "least_squares", "control_points": "auto", "correct_parameters": true,
        }, "stop": {"tolerance": 1e-3}}),
    ];
    for job in jobs {
        let story = server.stream(&job).await;
        let path = base(&story.job).to_owned();
        let result = server.json(&format!("{path}/result")).await;
        if job["method"]["correct_parameters"] != true {
            assert_eq!(result["parameters"], story.job["parameters"], "{job}");
        }
        let accept = server
            .get(&format!("{path}/result"))
            .header("accept", "application/x-protobuf");
        let message = accept.send().await.unwrap().bytes().await.unwrap();
        let message = pb::FitResult::decode(message).unwrap();
        let u = message.u.unwrap().parameters;
        match message.v {
            None => assert_eq!(json!(u), result["parameters"]),
            Some(v) => assert_eq!(json!({"u": u, "v": v.parameters}), result["parameters"]),
        }
    }
}

#[tokio::test]
async fn explicit_knots_imply_control_points() {
    let server = Server::start().await;
    let knots = json!([0, 0, 0, 0, 2, 5, 9, 9, 9, 9]);
    let job = |knots: &Value, method: Value| {
        let basis = json!({"kind": "bspline", "degree": 3, "knots": knots});
        let parameters: Vec<u32> = (0..=9).collect();
        json!({"curve": {"points": data::wave(10), "basis": basis, "parameters": parameters}, "method": method})
    };
    let implied = server.fit(&job(&knots, json!("least_squares"))).await;
    assert_eq!(implied["method"]["control_points"], 6, "{implied:#}");
    let method = json!({"kind": "least_squares", "control_points": 6});
    let given = server.fit(&job(&knots, method)).await;
    assert_eq!(implied["error"], given["error"]);
    let input = server.json(&format!("{}/input", base(&implied))).await;
    assert_eq!(input["method"]["control_points"], 6);

    let each = json!({"u": {"kind": "bspline", "degree": 3, "knots": [0, 0, 0, 0, 4, 7, 7, 7, 7]}, "v": {"kind": "bspline", "degree": 2, "knots": [0, 0, 0, 7, 7, 7]}});
    let parameters: Vec<u32> = (0..=7).collect();
    let mut surface = json!({
        "surface": {"points": data::peaks(8), "basis": each, "parameters": parameters},
        "method": {"kind": "least_squares", "variant": "direct"},
    });
    let fitted = server.fit(&surface).await;
    assert_eq!(
        fitted["method"]["control_points"],
        json!({"u": 5, "v": 3}),
        "{fitted:#}"
    );
    surface["surface"]["basis"]["v"] = json!("bspline");
    let detail = "least_squares needs control_points";
    server.assert_refused(&surface, "/method", detail).await;
    let without = json!({"curve": {"points": data::wave(10)}, "method": "least_squares"});
    server.assert_refused(&without, "/method", detail).await;
    let zero = json!({"curve": {"points": data::wave(10)}, "method": {"kind": "least_squares", "control_points": 0}});
    server
        .assert_refused(&zero, "/method/control_points", "give at least 2")
        .await;
}

/// Values that programs write for missing data are fitted, and warned of.
#[tokio::test]
async fn values_for_missing_data_are_warned_of() {
    let server = Server::start().await;
    let height = |i: usize, j: usize| match (i < 4, j < 4) {
        (true, true) => -9999.0,
        _ => 215.0 + (0.3 * i as f64).sin() + 0.1 * j as f64,
    };
    let rows = |value: &dyn Fn(usize, usize) -> Value| -> Value {
        (0..8)
            .map(|i| (0..16).map(|j| value(i, j)).collect::<Value>())
            .collect()
    };
    let heights = rows(&|i, j| json!(height(i, j)));
    let points = rows(&|i, j| json!([i, j, height(i, j)]));
    let method = json!({"kind": "least_squares", "control_points": 5});
    for points in [&heights, &points] {
        for method in [&json!("direct"), &method] {
            let job = json!({"surface": {"points": points}, "method": method});
            let warned = server.fit(&job).await;
            let warnings = warned["warnings"].as_array().unwrap();
            let found = warnings.iter().find(|it| it["code"] == "no_data_value");
            let found = found.unwrap_or_else(|| panic!("{warned:#}"));
            assert_eq!(found["pointer"], "/surface/points");
            let detail = found["detail"].as_str().unwrap();
            assert!(
                detail.starts_with("16 points have the value -9999"),
                "{detail}"
            );
        }
    }
    let missing = rows(&|i, j| match height(i, j) {
        -9999.0 => Value::Null,
        height => json!(height),
    });
    let job = json!({"surface": {"points": missing}, "method": method});
    let warnings = server.fit(&job).await["warnings"].to_string();
    assert!(!warnings.contains("no_data_value"), "{warnings}");
}
