//! Surfaces trimmed to the outline of their data: the result has the loops and the area, files leave the rest out.

use prost::Message;
use serde_json::{Value, json};

use crate::messages as pb;
use crate::support::{Server, base, problem};

/// Points of a sheet of 2 × 2 where they are inside.
fn sheet(inside: impl Fn(f64, f64) -> bool) -> Value {
    let part = |k: usize, step: f64| 2.0 * (k as f64 * step).fract() - 1.0;
    let all = (0..3000).map(|k| [part(k, 0.754_877_666), part(k, 0.569_840_29)]);
    let kept = all.filter(|[x, y]| inside(*x, *y));
    kept.map(|[x, y]| json!([x, y, 0.2 * x * x])).collect()
}

fn ring(x: f64, y: f64) -> bool {
    (0.35..0.9).contains(&x.hypot(y))
}

fn job(points: &Value, trim: &Value) -> Value {
    json!({
        "surface": {"scattered": points, "parameters": {"project": "xy"}, "trim": trim},
        "method": {"kind": "least_squares", "control_points": 6},
    })
}

fn length(list: &Value) -> usize {
    list.as_array().unwrap().len()
}

#[tokio::test]
async fn results_have_the_outline_of_a_ring() {
    let server = Server::start().await;
    let points = sheet(ring);
    let done = server.fit(&job(&points, &json!(true))).await;
    let path = base(&done);
    let result = server.json(&format!("{path}/result")).await;
    let trim = &result["trim"];
    assert_eq!(trim["faces"], json!([{"outer": 0, "holes": [1]}]));
    assert_eq!(length(&trim["loops"]), 2);
    for it in trim["loops"].as_array().unwrap() {
        assert_eq!(it["degree"], 3);
        let (knots, net) = (&it["knots"], it["control_points"].as_array().unwrap());
        assert_eq!(length(knots), net.len() + 4);
        assert_eq!((&knots[0], &net[0]), (&knots[3], &net[net.len() - 1]));
    }
    let area = trim["area"].as_f64().unwrap();
    let whole = server.fit(&job(&points, &json!(false))).await;
    let shape = server.json(&format!("{}/shape", base(&whole))).await;
    let all = shape["area"].as_f64().unwrap();
    let part = std::f64::consts::PI * (0.81 - 0.1225) / 3.24;
    assert!((area / all / part - 1.0).abs() < 0.08, "{area} {all}");
    // The fit is the same.
    let untrimmed = server.json(&format!("{}/result", base(&whole))).await;
    assert_eq!(untrimmed["control_points"], result["control_points"]);
    assert_eq!(untrimmed["trim"], Value::Null);
    // The request is returned and can be repeated.
    let input = server.json(&format!("{path}/input")).await;
    assert_eq!(input["surface"]["trim"], true);
    let again = server.fit(&input).await;
    let again = server.json(&format!("{}/result", base(&again))).await;
    assert_eq!(&again["trim"], trim);
}

#[tokio::test]
async fn files_omit_the_outside() {
    let server = Server::start().await;
    let done = server.fit(&job(&sheet(ring), &json!(true))).await;
    let result = format!("{}/result", base(&done));
    let file = async |format: &str| {
        let answer = server
            .get(&format!("{result}/{format}"))
            .send()
            .await
            .unwrap();
        assert_eq!(answer.status(), 200, "{format}");
        answer.bytes().await.unwrap()
    };
    let text = async |format: &str| String::from_utf8(file(format).await.to_vec()).unwrap();
    let step = text("step").await;
    let count = |text: &str, word: &str| text.matches(word).count();
    assert_eq!(count(&step, "ADVANCED_FACE"), 1);
    assert_eq!(
        (
            count(&step, "FACE_OUTER_BOUND"),
            count(&step, "FACE_BOUND(")
        ),
        (1, 1)
    );
    assert_eq!(
        (count(&step, "EDGE_LOOP"), count(&step, "OPEN_SHELL")),
        (2, 1)
    );
    assert_eq!(count(&step, "=PCURVE("), count(&step, "=EDGE_CURVE("));
    let iges = text("iges").await;
    let entries = iges.lines().filter(|line| line.get(72..73) == Some("D"));
    let kinds: Vec<&str> = entries.step_by(2).map(|line| line[..8].trim()).collect();
    for (kind, expected) in [("128", 1), ("142", 2), ("144", 1)] {
        assert_eq!(
            kinds.iter().filter(|it| **it == kind).count(),
            expected,
            "{kinds:?}"
        );
    }
    let obj = text("obj").await;
    assert_eq!(
        (
            count(&obj, "\ntrim "),
            count(&obj, "\nhole "),
            count(&obj, "\ncurv2 ")
        ),
        (1, 1, 2)
    );
    assert!(text("svg").await.contains("class=\"curve\""));
    // No triangle has its middle in the hole.
    let stl = file("stl").await;
    let number = |at: usize| f64::from(f32::from_le_bytes(stl[at..at + 4].try_into().unwrap()));
    let triangles = (stl.len() - 84) / 50;
    assert!(triangles > 1000);
    for start in (0..triangles).map(|k| 84 + 50 * k + 12) {
        let [x, y] = [0, 4].map(|c| (0..3).map(|k| number(start + 12 * k + c)).sum::<f64>() / 3.0);
        assert!((0.27..0.98).contains(&x.hypot(y)), "{x} {y}");
    }
    file("gltf").await;
    file("ply").await;
    let dxf = server.get(&format!("{result}/dxf")).send().await.unwrap();
    let (status, problem) = problem(dxf).await;
    assert_eq!(status, 409);
    assert!(
        problem["detail"].as_str().unwrap().contains("trimmed"),
        "{problem:#}"
    );
}

#[tokio::test]
async fn distances_islands_and_whole_rectangles() {
    let server = Server::start().await;
    let trim = async |points: &Value, trim: &Value| {
        let done = server.fit(&job(points, trim)).await;
        server.json(&format!("{}/result", base(&done))).await["trim"].clone()
    };
    let wide = trim(&sheet(ring), &json!({"distance": 0.2})).await;
    assert_eq!(wide["distance"], 0.2);
    let islands = sheet(|x, y| (x - 0.5).hypot(y) < 0.3 || (x + 0.5).hypot(y) < 0.3);
    let islands = trim(&islands, &json!(true)).await;
    assert_eq!(
        (length(&islands["loops"]), length(&islands["faces"])),
        (2, 2)
    );
    let all = trim(&sheet(|_, _| true), &json!(true)).await;
    assert_eq!((length(&all["loops"]), length(&all["faces"])), (0, 0));
    assert!(all["area"].as_f64().unwrap() > 3.9);
}

#[tokio::test]
async fn grids_with_gaps_are_trimmed() {
    let server = Server::start().await;
    let height = |i: usize, j: usize| {
        let is_gap = (8..16).contains(&i) && (10..18).contains(&j);
        if is_gap {
            Value::Null
        } else {
            json!((0.2 * i as f64).sin())
        }
    };
    let row = |i| (0..30).map(|j| height(i, j)).collect::<Value>();
    let rows: Value = (0..25).map(row).collect();
    let job = |surface: Value| json!({"surface": surface, "method": {"kind": "least_squares", "control_points": 8}});
    let done = server
        .fit(&job(
            json!({"points": rows, "spacing": [1, 1], "trim": true}),
        ))
        .await;
    let result = server.json(&format!("{}/result", base(&done))).await;
    let trim = &result["trim"];
    assert_eq!(trim["faces"], json!([{"outer": 0, "holes": [1]}]));
    let area = trim["area"].as_f64().unwrap();
    let shape = server.json(&format!("{}/shape", base(&done))).await;
    let left = area / shape["area"].as_f64().unwrap();
    assert!((left - (1.0 - 64.0 / 696.0)).abs() < 0.02, "{left}");
    // Values of a function have parameters, and no distances in space.
    let done = server
        .fit(&job(json!({"points": rows, "trim": true})))
        .await;
    let result = server.json(&format!("{}/result", base(&done))).await;
    assert_eq!(length(&result["trim"]["loops"]), 2);
    assert_eq!(result["trim"]["area"], Value::Null);
    server
        .assert_refused(
            &job(json!({"points": rows, "trim": {"distance": 2}})),
            "/surface/trim/distance",
            "no distances in space",
        )
        .await;
}

#[tokio::test]
async fn what_cannot_be_trimmed_is_refused() {
    let server = Server::start().await;
    let points = sheet(ring);
    for (trim, pointer, reason) in [
        (
            json!({"distance": 0}),
            "/surface/trim/distance",
            "greater than 0",
        ),
        (
            json!({"distance": -1.5}),
            "/surface/trim/distance",
            "greater than 0",
        ),
        (
            json!({"distance": 1e-6}),
            "/surface/trim/distance",
            "it is at least",
        ),
        (json!({"distance": "far"}), "/surface/trim/distance", "far"),
        (json!({"reach": 1}), "/surface/trim/reach", "unknown field"),
        (json!("yes"), "/surface/trim", "true, false or an object"),
        (json!({}), "/surface/trim", "distance"),
    ] {
        server
            .assert_refused(&job(&points, &trim), pointer, reason)
            .await;
    }
    let curve = json!({"curve": {"points": [[0, 0], [1, 1], [2, 0], [3, 1]], "trim": true}});
    server
        .assert_refused(&curve, "/curve/trim", "unknown field")
        .await;
}

#[tokio::test]
async fn messages_have_the_outline() {
    let server = Server::start().await;
    let points = sheet(ring);
    let flat = points.as_array().unwrap().iter();
    let flat = flat.flat_map(|it| it.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()));
    let surface = |distance| pb::Surface {
        dimension: 3,
        points: flat.clone().collect(),
        scattered: Some(pb::ScatteredParameters::default()),
        trim: Some(pb::Trim { distance }),
        ..pb::Surface::default()
    };
    let least_squares = pb::method::LeastSquares {
        control_points_u: 6,
        control_points_v: 6,
        ..pb::method::LeastSquares::default()
    };
    let post = async |distance| {
        let input = pb::JobInput {
            geometry: Some(pb::job_input::Geometry::Surface(surface(distance))),
            method: Some(pb::Method {
                kind: Some(pb::method::Kind::LeastSquares(least_squares.clone())),
            }),
            ..pb::JobInput::default()
        };
        let request = server
            .post("/v1/jobs")
            .header("content-type", "application/x-protobuf")
            .header("prefer", "wait=10");
        request.body(input.encode_to_vec()).send().await.unwrap()
    };
    let done: Value = post(Some(0.1)).await.json().await.unwrap();
    let request = server.get(&format!("{}/result", base(&done)));
    let request = request.header("accept", "application/x-protobuf");
    let bytes = request.send().await.unwrap().bytes().await.unwrap();
    let result = pb::FitResult::decode(bytes).unwrap();
    let trim = result.trim.unwrap();
    assert_eq!(
        (trim.distance, trim.loops.len(), trim.faces.len()),
        (0.1, 2, 1)
    );
    assert_eq!((trim.faces[0].outer, &trim.faces[0].holes), (0, &vec![1]));
    assert!(trim.area.unwrap() > 1.5);
    for it in &trim.loops {
        assert_eq!(2 * (it.knots.len() - 4), it.control_points.len());
    }
    for distance in [f64::NAN, 0.0, f64::INFINITY] {
        let (status, problem) = problem(post(Some(distance)).await).await;
        let field = &problem["errors"][0]["field"];
        assert_eq!(
            (status, field),
            (422, &json!("surface.trim.distance")),
            "{problem:#}"
        );
    }
}
