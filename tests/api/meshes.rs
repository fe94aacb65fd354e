//! Parameters of the vertices of triangle meshes: from jobs, messages and files.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

/// The points and triangles of a grid of rows and columns, of which the last row meets the first one if it goes around.
fn grid(
    (rows, columns): (u32, u32),
    is_closed: bool,
    place: impl Fn(f64, f64) -> [f64; 3],
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let spans = if is_closed { rows } else { rows - 1 };
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..rows {
        for j in 0..columns {
            let s = f64::from(i) / f64::from(spans);
            points.push(place(s, f64::from(j) / f64::from(columns - 1)));
        }
    }
    for i in 0..spans {
        for j in 0..columns - 1 {
            let at = |di: u32, dj: u32| (i + di) % rows * columns + j + dj;
            triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
            triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
    (points, triangles)
}

/// A strip that goes over itself, so that no simple surface unfolds it.
fn spiral(s: f64, t: f64) -> [f64; 3] {
    let (sin, cos) = (3.0 * PI * s).sin_cos();
    let out = 4.0 + 8.0 * s;
    [out * cos, out * sin, 9.0 * t]
}

/// A tube that is bent by more than a right angle.
fn bent(s: f64, t: f64) -> [f64; 3] {
    let ((sin, cos), bend) = ((TAU * s).sin_cos(), 2.5 * t);
    let out = 10.0 + 3.0 * cos;
    [out * bend.cos(), out * bend.sin(), 3.0 * sin]
}

fn cap(s: f64, t: f64) -> [f64; 3] {
    let [x, y] = [2.0 * s - 1.0, 2.0 * t - 1.0];
    [
        30.0 * x,
        20.0 * y,
        10.0 * (1.0 - x * x) * (1.0 - 0.5 * y * y),
    ]
}

fn job((points, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>), tolerance: f64) -> Value {
    json!({
        "surface": {"scattered": points, "parameters": {"triangles": triangles}},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": tolerance},
    })
}

async fn result(server: &Server, job: &Value) -> Value {
    server.json(job["links"]["result"].as_str().unwrap()).await
}

fn notices(job: &Value) -> String {
    job["notices"].to_string()
}

/// A cap is unfolded by its plane, with few control points.
#[tokio::test]
async fn simple_meshes_have_simple_parameters() {
    let server = Server::start().await;
    let fitted = server.fit(&job(grid((25, 25), false, cap), 1e-3)).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    assert!(
        notices(&fitted).contains("the plane nearest to them"),
        "{fitted:#}"
    );
    let result = result(&server, &fitted).await;
    let rows = result["control_points"].as_array().unwrap();
    assert!(rows.len() <= 12 && rows[0].as_array().unwrap().len() <= 12);
}

/// What no simple surface unfolds has mean value coordinates; the input of the job makes the same one again.
#[tokio::test]
async fn meshes_have_mean_values() {
    let server = Server::start().await;
    let mut asked = job(grid((40, 9), false, spiral), 0.05);
    let fitted = server.fit(&asked).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    assert!(
        notices(&fitted).contains("mean value coordinates on the mesh"),
        "{fitted:#}"
    );
    let input = server.json(&format!("{}/input", base(&fitted))).await;
    assert_eq!(
        input["surface"]["parameters"],
        asked["surface"]["parameters"]
    );
    asked["surface"]["parameters"]["unfolding"] = json!("mean_value");
    let again = server.fit(&asked).await;
    let input = server.json(&format!("{}/input", base(&again))).await;
    assert_eq!(input["surface"]["parameters"]["unfolding"], "mean_value");
    let [first, second] = [&fitted, &again].map(|it| result(&server, it));
    let [first, second] = [first.await, second.await];
    assert_eq!(first["control_points"], second["control_points"]);
    // An edit keeps the parameters.
    let edit = json!({"points": [{"index": 7, "point": [4.5, 0, 7.9]}]});
    let edits = server.post(&format!("{}/edits", base(&fitted)));
    let edited = edits.header("prefer", "wait=30").json(&edit).send().await;
    let edited: Value = edited.unwrap().json().await.unwrap();
    assert_eq!(edited["state"], "converged", "{edited:#}");
}

/// A tube with two loops is closed in u, also with outliers.
#[tokio::test]
async fn tubes_are_closed() {
    let server = Server::start().await;
    let mut mesh = grid((24, 30), true, bent);
    for robust in [false, true] {
        let mut asked = job(mesh.clone(), 0.05);
        if robust {
            asked["method"]["robust"] = json!(true);
        }
        let fitted = server.fit(&asked).await;
        assert_eq!(fitted["state"], "converged", "{fitted:#}");
        let found = result(&server, &fitted).await;
        assert_eq!(found["closed"], json!({"u": true, "v": false}));
        mesh.0[407][2] += 5.0;
    }
}

/// Messages have triangles.
#[tokio::test]
async fn messages_have_triangles() {
    let server = Server::start().await;
    let mesh = grid((24, 30), true, bent);
    let triangles: Vec<u32> = mesh.1.iter().flatten().copied().collect();
    let fitted = server.fit(&job(mesh, 0.5)).await;
    let mut client = connect(&server).await;
    let id = fitted["id"].as_str().unwrap().to_owned();
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let mut input = input.into_inner().input.unwrap();
    let scattered = |input: &mut pb::JobInput| match &mut input.geometry {
        Some(pb::job_input::Geometry::Surface(surface)) => surface.scattered.clone().unwrap(),
        _ => panic!("no surface"),
    };
    assert_eq!(scattered(&mut input).triangles, triangles);
    for (change, expected) in [
        (
            pb::ScatteredParameters {
                triangles: vec![0, 1],
                ..Default::default()
            },
            "2 indices are no triangles",
        ),
        (
            pb::ScatteredParameters {
                unfolding: 2,
                ..Default::default()
            },
            "an unfolding is that of triangles",
        ),
        (
            pb::ScatteredParameters {
                unfolding: 9,
                triangles: vec![0, 1, 2],
                ..Default::default()
            },
            "9 is no value",
        ),
        (
            pb::ScatteredParameters {
                projection: 1,
                triangles: vec![0, 1, 2],
                ..Default::default()
            },
            "nothing else",
        ),
    ] {
        let mut input = input.clone();
        if let Some(pb::job_input::Geometry::Surface(surface)) = &mut input.geometry {
            surface.scattered = Some(change);
        }
        let request = pb::CreateJobRequest {
            input: Some(input),
            ..Default::default()
        };
        let refused = client.create_job(request).await.unwrap_err();
        assert!(
            refused.message().contains(expected),
            "{expected}: {refused:?}"
        );
    }
}

/// Errors have locations.
#[tokio::test]
async fn wrong_meshes_are_refused() {
    let server = Server::start().await;
    let (points, triangles) = grid((6, 6), false, cap);
    let with = |change: &dyn Fn(&mut Vec<[u32; 3]>)| {
        let mut triangles = triangles.clone();
        change(&mut triangles);
        json!({"triangles": triangles})
    };
    let closed = grid((6, 6), true, bent).1;
    for (parameters, place, expected) in [
        (
            with(&|it| it[4][1] = 36),
            "/surface/parameters/triangles/4",
            "point 36, and there are 36",
        ),
        (
            with(&|it| it[4][1] = it[4][0]),
            "/surface/parameters/triangles/4",
            "has a point twice",
        ),
        (
            with(&|it| it.push([0, 7, 35])),
            "/surface/parameters/triangles/50",
            "the third one on the edge",
        ),
        (
            with(&|it| it.truncate(48)),
            "/surface/scattered/35",
            "in no triangle",
        ),
        (
            with(&|it| it.retain(|it| !it.contains(&14) && !it.contains(&15))),
            "/surface/scattered/14",
            "in no triangle",
        ),
        (
            with(&|it| it.clear()),
            "/surface/parameters",
            "has no triangles",
        ),
        (
            with(&|it| {
                it.truncate(40);
                it.extend([[30, 31, 32], [33, 34, 35]]);
            }),
            "/surface/parameters",
            "pieces of",
        ),
        (
            json!({"triangles": [[0, 1]]}),
            "/surface/parameters/triangles/0",
            "length 2",
        ),
        (
            json!({"triangles": [[0, 1, -2]]}),
            "/surface/parameters/triangles/0/2",
            "-2",
        ),
        (
            json!({"triangles": closed, "unfolding": "harmonic"}),
            "/surface/parameters/unfolding",
            "harmonic",
        ),
        (
            json!({"unfolding": "auto"}),
            "/surface/parameters",
            "that of triangles",
        ),
        (
            json!({"triangles": closed, "project": "plane"}),
            "/surface/parameters",
            "or triangles",
        ),
    ] {
        let mut asked = job((points.clone(), Vec::new()), 0.1);
        asked["surface"]["parameters"] = parameters;
        let response = server.post("/v1/jobs").json(&asked).send().await.unwrap();
        let (status, found) = problem(response).await;
        assert!(status == 422 || status == 400, "{found:#}");
        let pointer = found["errors"][0]["pointer"].as_str().unwrap();
        assert!(pointer == place, "{expected}: {found:#}");
        let detail = found["detail"].as_str().unwrap();
        assert!(detail.contains(expected), "{expected}: {found:#}");
    }
}

fn off((points, triangles): &(Vec<[f64; 3]>, Vec<[u32; 3]>)) -> String {
    let mut text = format!("OFF\n{} {} 0\n", points.len(), triangles.len());
    points
        .iter()
        .for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    triangles
        .iter()
        .for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
    text
}

/// A file with faces is a surface without more words; `piece` chooses one of several.
#[tokio::test]
async fn files_have_meshes() {
    let server = Server::start().await;
    let mut mesh = grid((40, 9), false, spiral);
    let count = mesh.0.len() as u32;
    let (points, triangles) = grid((25, 25), true, bent);
    mesh.0.extend(points);
    mesh.1
        .extend(triangles.iter().map(|it| it.map(|index| index + count)));
    mesh.0.push([0.0; 3]);
    let send = async |query: &str| {
        let request = server.post(&format!("/v1/jobs?stop.tolerance=0.1{query}"));
        let request = request.header("content-type", "application/octet-stream");
        let request = request.header("prefer", "wait=30").body(off(&mesh));
        request.send().await.unwrap()
    };
    for (query, closed, expected) in [
        ("", true, "the 625 vertices of the largest one"),
        ("&piece=2", false, "the 360 vertices of piece 2"),
        (
            "&piece=2&surface.parameters.unfolding=mean_value",
            false,
            "mean value coordinates",
        ),
    ] {
        let fitted: Value = send(query).await.json().await.unwrap();
        assert_eq!(fitted["state"], "converged", "{fitted:#}");
        assert!(notices(&fitted).contains(expected), "{fitted:#}");
        assert!(notices(&fitted).contains("are left out"), "{fitted:#}");
        let found = result(&server, &fitted).await;
        assert_eq!(found["closed"]["u"], closed, "{query}");
    }
    for (query, parameter, expected) in [
        ("&piece=3", "piece", "pieces 1 to 2"),
        ("&piece=x", "piece", "not the number of a piece"),
        (
            "&surface.parameters.unfolding=flat",
            "surface.parameters.unfolding",
            "flat",
        ),
    ] {
        let (_, found) = problem(send(query).await).await;
        assert_eq!(found["errors"][0]["parameter"], parameter, "{found:#}");
        assert!(
            found["detail"].as_str().unwrap().contains(expected),
            "{found:#}"
        );
    }
}

/// A plate with a hole: the trimmed surface ends where the mesh does, and has its area. Points of a file have their triangles,
/// and need no method.
#[tokio::test]
async fn trimmed_meshes_end_at_their_boundary() {
    let server = Server::start().await;
    let plate = |s: f64, t: f64| {
        let ((sin, cos), out) = ((TAU * s).sin_cos(), 8.0 + 22.0 * t);
        [out * cos, out * sin, 4.0 - 0.004 * out * out]
    };
    let (points, triangles) = grid((80, 24), true, plate);
    let area = |[a, b, c]: &[u32; 3]| {
        let at = |vertex: u32| points[vertex as usize];
        let to = |vertex: u32| [0, 1, 2].map(|k| at(vertex)[k] - at(*a)[k]);
        let (u, v) = (to(*b), to(*c));
        let cross =
            [0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
        0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let area: f64 = triangles.iter().map(area).sum();
    let mut obj = String::new();
    for [x, y, z] in &points {
        writeln!(obj, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in &triangles {
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let request = server.post("/v1/points").body(obj);
    let request = request.header("content-type", "application/octet-stream");
    let read: Value = request.send().await.unwrap().json().await.unwrap();
    let mut surface = read["surface"].clone();
    assert_eq!(surface["parameters"]["triangles"], json!(triangles));
    surface["trim"] = true.into();
    let fitted = server
        .fit(&json!({"surface": surface, "stop": {"tolerance": 0.01}}))
        .await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    let trim = result(&server, &fitted).await["trim"].clone();
    assert_eq!(trim["loops"].as_array().unwrap().len(), 2);
    let ratio = trim["area"].as_f64().unwrap() / area;
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    // Scattered points need a method or a tolerance.
    let cloud = json!({"surface": {"scattered": points}, "stop": {"tolerance": 0.01}});
    assert_eq!(server.fit(&cloud).await["state"], "converged");
    let cloud = json!({"surface": {"scattered": points}});
    server
        .assert_refused(&cloud, "/method", "fit a surface with least_squares")
        .await;
}
