//! The method `custom`: any transform, given as a matrix. Other methods are its special cases.

use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::support::{Server, base, problem};

/// Distances of control points that are the same but for the rounding of another order of sums.
const ROUNDING: f64 = 1e-12;

fn diagonal(entries: &[f64]) -> Value {
    let row = |i| (0..entries.len()).map(move |j| if i == j { entries[i] } else { 0.0 });
    (0..entries.len())
        .map(|i| row(i).collect::<Value>())
        .collect()
}

fn identity(n: usize) -> Value {
    diagonal(&vec![1.0; n])
}

fn custom(transform: &Value) -> Value {
    json!({"kind": "custom", "transform": transform})
}

fn with(job: &Value, method: Value) -> Value {
    let mut job = job.clone();
    job["method"] = method;
    job["stop"] = json!({"tolerance": 0, "max_iterations": 12});
    job
}

/// All coordinates of a list or grid of points.
fn coordinates(points: &Value) -> Vec<f64> {
    match points {
        Value::Array(values) => values.iter().flat_map(coordinates).collect(),
        value => vec![value.as_f64().unwrap()],
    }
}

/// Both methods have the same control points at every iteration, within the rounding.
async fn assert_alike(server: &Server, job: &Value, one: Value, other: Value, tolerance: f64) {
    let (one, other) = (with(job, one), with(job, other));
    let (first, second) = (server.stream(&one).await, server.stream(&other).await);
    assert!(first.iterations.len() > 2);
    for (a, b) in first.iterations.iter().zip(&second.iterations) {
        let points = |it: &Value| coordinates(&it["control_points"]);
        let (a, b) = (points(a), points(b));
        assert_eq!(a.len(), b.len());
        let differ = a.iter().zip(&b).map(|(x, y)| (x - y).abs());
        let worst = differ.fold(0.0, f64::max);
        assert!(worst <= tolerance, "{worst:e}");
    }
}

#[tokio::test]
async fn other_methods_are_special_cases() {
    let server = Server::start().await;
    let points = data::helix();
    let n = points.as_array().unwrap().len();
    let curve = json!({"curve": {"points": points}});
    let global = json!("global");
    assert_alike(
        &server,
        &curve,
        custom(&identity(n)),
        global.clone(),
        ROUNDING,
    )
    .await;
    let weighted = json!({"kind": "weighted", "omega": 1.3});
    let scaled = custom(&diagonal(&vec![1.3; n]));
    assert_alike(&server, &curve, scaled, weighted, ROUNDING).await;
    let some: Vec<f64> = (0..n)
        .map(|i| f64::from(u8::from(i == 2 || i == 5)))
        .collect();
    let local = json!({"kind": "local", "indices": [2, 5]});
    assert_alike(&server, &curve, custom(&diagonal(&some)), local, ROUNDING).await;

    // Sides of different lengths need a matrix each.
    let rows: Vec<Vec<[f64; 3]>> = (0..7)
        .map(|i| {
            let place = |j: usize| [i as f64, j as f64, ((i * 3 + j * 5) % 7) as f64 / 4.0];
            (0..5).map(place).collect()
        })
        .collect();
    let surface = json!({"surface": {"points": rows}});
    let each = json!({"u": identity(7), "v": identity(5)});
    assert_alike(&server, &surface, custom(&each), global.clone(), ROUNDING).await;
    let square = json!({"surface": {"points": data::peaks(6)}});
    assert_alike(&server, &square, custom(&identity(6)), global, ROUNDING).await;
}

/// The matrix of three points and a parabola, by hand: with its inverse iteration 1 is the limit.
#[tokio::test]
async fn the_inverse_solves() {
    let server = Server::start().await;
    // Bernstein of degree 2 at 0, 1/2 and 1: the rows 1 0 0, 1/4 1/2 1/4, 0 0 1.
    let inverse = json!([[1, 0, 0], [-0.5, 2, -0.5], [0, 0, 1]]);
    let job = json!({
        "curve": {"points": [[0, 0], [1, 3], [2, 1]], "basis": "bernstein", "parameters": "uniform"},
        "method": custom(&inverse),
    });
    let job = server.fit(&job).await;
    assert_eq!(
        (&job["state"], &job["iteration"]),
        (&json!("converged"), &json!(1))
    );
    let result = server.json(&format!("{}/result", base(&job))).await;
    assert_eq!(
        coordinates(&result["control_points"]),
        [0.0, 0.0, 1.0, 5.5, 2.0, 1.0]
    );
}

/// Deng & Lin 2013, Theorem 2.1: it converges to the interpolant where ρ(I − U B) < 1, whatever U is.
#[tokio::test]
async fn any_transform_converges_or_is_refused() {
    let server = Server::start().await;
    let curve =
        json!({"points": [[0, 0], [1, 3], [2, 1]], "basis": "bernstein", "parameters": "uniform"});
    let fit = |transform: Value| json!({"curve": curve, "method": custom(&transform)});
    let upper = json!([[0.9, 0.1, -0.2], [0, 1.1, 0.3], [0.05, 0, 0.8]]);
    let job = server.fit(&fit(upper)).await;
    assert_eq!(job["state"], "converged");
    assert_eq!(job["method"], json!({"kind": "custom"}));
    let result = server.json(&format!("{}/result", base(&job))).await;
    for (x, expected) in coordinates(&result["control_points"])
        .iter()
        .zip([0.0, 0.0, 1.0, 5.5, 2.0, 1.0])
    {
        assert!((x - expected).abs() < 1e-4, "{x}");
    }
    for (transform, pointer, reason) in [
        (diagonal(&[3.0; 3]), "/method", "spectral radius"),
        (identity(2), "/method/transform", "3 control points"),
        (
            json!([[1, 0, 0], [0, 1], [0, 0, 1]]),
            "/method/transform/1",
            "2 entries",
        ),
        (
            json!([[1, 0, 0], [0, "a", 0], [0, 0, 1]]),
            "/method/transform/1/1",
            "a number",
        ),
        (
            json!([[1, 0, 0], 5, [0, 0, 1]]),
            "/method/transform/1",
            "expected a list, found 5",
        ),
        (json!("identity"), "/method/transform", "expected a list"),
        (json!([]), "/method/transform", "0 rows"),
        (
            json!({"u": identity(3), "v": identity(3)}),
            "/method/transform/v",
            "one direction",
        ),
        (
            json!(vec![json!([]); 501]),
            "/method/transform/500",
            "at most 500",
        ),
    ] {
        server
            .assert_refused(&fit(transform), pointer, reason)
            .await;
    }
    let without = json!({"curve": curve, "method": "custom"});
    server
        .assert_refused(&without, "/method", "needs a transform")
        .await;
    let other = json!({"curve": curve, "method": {"kind": "global", "transform": identity(3)}});
    let reason = "unknown field \"transform\"";
    server
        .assert_refused(&other, "/method/transform", reason)
        .await;
    let surface = json!({
        "surface": {"points": data::peaks(4)},
        "method": custom(&json!({"u": identity(4), "v": [[1, 0], [0, 1]]})),
    });
    server
        .assert_refused(&surface, "/method/transform/v", "4 control points")
        .await;
}

/// The largest matrices, edits, and what others see of the job.
#[tokio::test]
async fn jobs_with_a_transform_are_jobs() {
    let server = Server::start().await;
    let sine = |count: usize| {
        let points = (0..count).map(|i| i as f64 / 20.0).map(|t| [t, t.sin()]);
        let points: Vec<[f64; 2]> = points.collect();
        json!({"curve": {"points": points}, "method": custom(&identity(count))})
    };
    assert_eq!(server.fit(&sine(500)).await["state"], "converged");
    // What diverges is found out beforehand where that takes no time, and otherwise when it does.
    let mut diverging = sine(150);
    diverging["method"] = custom(&diagonal(&[3.0; 150]));
    let failed = server.fit(&diverging).await;
    assert_eq!(failed["state"], "failed");
    let reason = failed["problem"]["detail"].as_str().unwrap();
    assert!(reason.contains("diverged"), "{reason}");
    let job = server.fit(&sine(100)).await;
    let input = server.json(&format!("{}/input", base(&job))).await;
    assert_eq!(
        coordinates(&input["method"]["transform"])
            .iter()
            .sum::<f64>(),
        100.0
    );
    assert_eq!(server.fit(&input).await["state"], "converged");

    let small = json!({"curve": {"points": data::helix()}});
    let n = data::helix().as_array().unwrap().len();
    let parent = server.fit(&with(&small, json!("global"))).await;
    let edits = format!("{}/edits", base(&parent));
    let edit = json!({"method": custom(&diagonal(&vec![1.2; n]))});
    let response = server.post(&edits).json(&edit).send().await.unwrap();
    assert_eq!(response.status(), 201);
    let edit = json!({"method": custom(&identity(n - 1))});
    let (status, problem) = problem(server.post(&edits).json(&edit).send().await.unwrap()).await;
    assert_eq!(
        (status, &problem["errors"][0]["pointer"]),
        (422, &json!("/method/transform"))
    );
    let capabilities = server.json("/v1/capabilities").await;
    let methods = capabilities["methods"].as_array().unwrap();
    let found = methods.iter().find(|it| it["kind"] == "custom").unwrap();
    assert_eq!(found["settings"], json!(["transform"]));
}

/// The same in messages, over gRPC: entries row by row, and errors at the entry.
#[tokio::test]
async fn messages_have_transforms() {
    let server = Server::start().await;
    let mut client = crate::rpc::connect(&server).await;
    let input = |u: Vec<f64>, v: Vec<f64>| pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Curve(pb::Curve {
            dimension: 2,
            points: vec![0.0, 0.0, 1.0, 3.0, 2.0, 1.0],
            ..pb::Curve::default()
        })),
        method: Some(pb::Method {
            kind: Some(pb::method::Kind::Custom(pb::method::Custom {
                transform_u: u,
                transform_v: v,
            })),
        }),
        ..pb::JobInput::default()
    };
    let request = |u: &[f64], v: &[f64]| pb::CreateJobRequest {
        input: Some(input(u.to_vec(), v.to_vec())),
        ..pb::CreateJobRequest::default()
    };
    let unit = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let job = client.create_job(request(&unit, &[])).await.unwrap();
    let id = job.into_inner().job.unwrap().id;
    let asked = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let method = asked
        .into_inner()
        .input
        .unwrap()
        .method
        .unwrap()
        .kind
        .unwrap();
    let pb::method::Kind::Custom(custom) = method else {
        panic!("another method: {method:?}");
    };
    assert_eq!(
        (custom.transform_u.as_slice(), custom.transform_v.len()),
        (&unit[..], 0)
    );
    let mut wrong = unit;
    wrong[5] = f64::NAN;
    for (u, v, field) in [
        (&wrong[..], &[][..], "input.method.custom.transform_u[5]"),
        (&unit[..8], &[], "input.method.custom.transform_u"),
        (&[], &[], "input.method.custom.transform_u"),
        (&unit, &unit, "input.method.custom.transform_v"),
        (&unit, &unit[..2], "input.method.custom.transform_v"),
        (&[2.0; 4], &[], "input.method.custom.transform_u"),
    ] {
        let status = client.create_job(request(u, v)).await.unwrap_err();
        assert_eq!(status.code(), tonic::Code::InvalidArgument);
        assert!(
            status.message().contains(&format!("{field}:")),
            "{status:?}"
        );
    }
}
