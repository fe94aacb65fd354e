//! Scattered points with the parameters of their foot points on the surface of another job.

use serde_json::{Value, json};
use tonic_types::StatusExt;

use crate::data;
use crate::messages as pb;
use crate::numbers::flat;
use crate::program::Program;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

/// A least-squares surface of scattered points on the surface of a job.
fn on(job: &Value, points: &Value, method: Value) -> Value {
    json!({
        "surface": {
            "scattered": points,
            "parameters": {"foot_points": {"job": job["id"]}},
        },
        "method": method,
        "stop": {"tolerance": 1e-3},
    })
}

fn few() -> Value {
    json!({"kind": "least_squares", "variant": "direct", "control_points": 5})
}

/// The points of a grid, one after the other.
fn listed(grid: &Value) -> Value {
    let rows = grid.as_array().unwrap().iter();
    let points = rows.flat_map(|row| row.as_array().unwrap());
    points.cloned().collect()
}

/// Points of the surface of a job, and their parameters.
async fn samples(server: &Server, job: &Value, grid: &str) -> (Value, Vec<[f64; 2]>) {
    let result = job["links"]["result"].as_str().unwrap();
    let samples = server
        .json(&format!("{result}?view=samples&samples={grid}"))
        .await;
    let points = listed(&samples["samples"]);
    let [u, v] = ["u", "v"].map(|axis| flat(&samples["parameters"][axis]));
    let pairs = u.iter().flat_map(|&u| v.iter().map(move |&v| [u, v]));
    (points, pairs.collect())
}

/// The parameters that a job says its points have.
async fn parameters(server: &Server, job: &Value) -> Vec<[f64; 2]> {
    let input = server.json(&format!("{}/input", base(job))).await;
    let parameters = &input["surface"]["parameters"];
    // Those of closed surfaces have periods beside them.
    let pairs = parameters.get("pairs").unwrap_or(parameters);
    let pairs = pairs.as_array().unwrap().iter();
    pairs
        .map(|pair| [0, 1].map(|k| pair[k].as_f64().unwrap()))
        .collect()
}

/// A tube, or a half of it: rows are along it.
fn tube(rows: usize, columns: usize, part: f64) -> Value {
    let point = |i: usize, j: usize| {
        let (x, angle) = (
            i as f64 / 2.0,
            part * std::f64::consts::TAU * j as f64 / columns as f64,
        );
        let r = 2.0 + 0.2 * x.sin();
        json!([x, r * angle.cos(), r * angle.sin()])
    };
    (0..rows)
        .map(|i| (0..columns).map(|j| point(i, j)).collect::<Value>())
        .collect()
}

/// Whatever the basis: points of a surface have the parameters at which they are.
#[tokio::test]
async fn points_of_the_surface_come_back() {
    let server = Server::start().await;
    let half = tube(9, 8, 0.45);
    let weights: Value = (0..9)
        .map(|i| {
            (0..8)
                .map(|j| 1.0 + 0.3 * f64::from((i * j) % 3))
                .collect::<Value>()
        })
        .collect();
    let surfaces = [
        json!({"points": half}),
        json!({"points": half, "ends": "natural"}),
        json!({"points": half, "degree": {"u": 2, "v": 5}}),
        json!({"points": half, "basis": "bernstein"}),
        json!({"points": half, "basis": {"u": "said_ball", "v": "wang_ball"}}),
        json!({"points": half, "weights": weights}),
        json!({"points": data::peaks(13)}),
    ];
    for (i, surface) in surfaces.into_iter().enumerate() {
        let job = json!({"surface": surface, "stop": {"max_iterations": 20}});
        let job = server.fit(&job).await;
        let (points, expected) = samples(&server, &job, "14x11").await;
        let fitted = server.fit(&on(&job, &points, few())).await;
        let found = parameters(&server, &fitted).await;
        assert_eq!(found.len(), 14 * 11, "{fitted}");
        for (found, expected) in found.iter().zip(&expected) {
            for k in 0..2 {
                assert!(
                    (found[k] - expected[k]).abs() < 1e-11,
                    "{i}: {found:?} {expected:?}"
                );
            }
        }
    }
}

/// Around a closed surface the seam has one parameter.
#[tokio::test]
async fn closed_surfaces_have_foot_points() {
    let server = Server::start().await;
    let closed = json!({"points": tube(9, 12, 1.0), "closed": {"u": false, "v": true}});
    let job = server.fit(&json!({"surface": closed})).await;
    let (points, expected) = samples(&server, &job, "9x25").await;
    let fitted = server.fit(&on(&job, &points, few())).await;
    let found = parameters(&server, &fitted).await;
    let period = expected.last().unwrap()[1] - expected[0][1];
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found[0] - expected[0]).abs() < 1e-11);
        let turns = (found[1] - expected[1]) / period;
        assert!(
            (turns - turns.round()).abs() < 1e-12,
            "{found:?} {expected:?}"
        );
        assert!(found[1] < period);
    }
}

/// An iteration of the other job is another surface.
#[tokio::test]
async fn an_iteration_can_be_chosen() {
    let server = Server::start().await;
    let job = json!({"surface": {"points": data::peaks(12)}, "stop": {"max_iterations": 9}});
    let job = server.fit(&job).await;
    let points = listed(&data::peaks(9));
    let mut found = Vec::new();
    for iteration in [json!(0), json!(9), json!("last")] {
        let mut body = on(&job, &points, few());
        body["surface"]["parameters"]["foot_points"]["iteration"] = iteration;
        let fitted = server.fit(&body).await;
        found.push(parameters(&server, &fitted).await);
    }
    assert_ne!(found[0], found[1]);
    assert_eq!(found[1], found[2]);
}

/// A rough surface of a scan is enough for parameters with which the errors are nearly distances.
#[tokio::test]
async fn a_scan_in_a_surface_out() {
    let server = Server::start().await;
    // Half a tube, from the side: above the plane nearest to it its borders stand upright.
    let scan: Value = (0..4000)
        .map(|i| {
            let i = f64::from(i);
            let (x, a) = (
                4.0 * (0.618_034 * i).fract(),
                2.8 * (0.754_878 * i).fract() + 0.17,
            );
            let r = 2.0 + 0.1 * (2.0 * x).sin() + 1e-3 * (i * 12.9898).sin();
            json!([x, r * a.cos(), r * a.sin()])
        })
        .collect();
    let rough = json!({
        "surface": {"scattered": scan, "parameters": "project"},
        "method": {"kind": "least_squares", "variant": "direct", "control_points": 8},
    });
    let rough = server.fit(&rough).await;
    let fine = json!({
        "surface": {"scattered": scan, "parameters": {"foot_points": {"job": rough["id"]}}},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": 4e-3},
    });
    let fine = server.fit(&fine).await;
    assert_eq!(
        (&fine["state"], &fine["reason"]),
        (&json!("converged"), &Value::Null),
        "{fine}"
    );
    assert!(fine["error"]["max"].as_f64().unwrap() <= 4e-3);
}

/// The new job has parameters of its own: nothing changes when the other one is deleted.
#[tokio::test]
async fn the_other_job_can_go() {
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    let rough = json!({"surface": {"points": data::peaks(10)}});
    let rough = program.fit(&rough).await;
    let points = listed(&data::peaks(15));
    let body = on(
        &rough,
        &points,
        json!({"kind": "least_squares", "control_points": 6}),
    );
    let post = || {
        program
            .post("/v1/jobs")
            .header("idempotency-key", "a scan")
            .json(&body)
            .send()
    };
    let job: Value = post().await.unwrap().json().await.unwrap();
    let path = base(&job).to_owned();
    let ended = |program: &Program| program.get(&format!("{path}?wait=20")).send();
    ended(&program).await.unwrap();
    program.delete(base(&rough)).send().await.unwrap();
    let answer = post().await.unwrap();
    assert_eq!(answer.headers()["idempotency-replayed"], "true");
    assert_eq!(answer.json::<Value>().await.unwrap()["id"], job["id"]);
    let seen = async |program: &Program| {
        let input = program.json(&format!("{path}/input")).await;
        let events = program.get(&format!("{path}/events")).send().await.unwrap();
        (input, events.text().await.unwrap())
    };
    let before = seen(&program).await;
    let edit = json!({"points": [{"index": 7, "point": [0.5, 0.5, 9.0]}]});
    let edit = program
        .post(&format!("{path}/edits"))
        .json(&edit)
        .send()
        .await
        .unwrap();
    assert_eq!(edit.status(), 201);
    drop(program);
    let program = Program::start(directory.path());
    assert!(seen(&program).await == before);
}

/// The same in messages.
#[tokio::test]
async fn messages_say_it_too() {
    let server = Server::start().await;
    let rough = server
        .fit(&json!({"surface": {"points": data::peaks(10)}}))
        .await;
    let points = json!([
        [0, 0, 1],
        [1, 0, 2],
        [0, 1, 3],
        [1, 1, 1],
        [-1, 0, 2],
        [0, -1, 0.5]
    ]);
    let mut body = on(
        &rough,
        &points,
        json!({"kind": "least_squares", "control_points": 2}),
    );
    body["surface"]["degree"] = json!(1);
    let job = server.fit(&body).await;
    let mut client = connect(&server).await;
    let id = job["id"].as_str().unwrap().to_owned();
    let input = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    let input = input.into_inner().input.unwrap();
    let request = |job: &str, iteration, values: &[f64]| {
        let mut input = input.clone();
        let Some(pb::job_input::Geometry::Surface(surface)) = &mut input.geometry else {
            panic!("{input:?}");
        };
        surface.scattered = Some(pb::ScatteredParameters {
            foot_points: Some(pb::FootPoints {
                job: job.to_owned(),
                iteration,
            }),
            values: values.to_vec(),
            ..pb::ScatteredParameters::default()
        });
        pb::CreateJobRequest {
            input: Some(input),
            ..pb::CreateJobRequest::default()
        }
    };
    let rough = rough["id"].as_str().unwrap();
    let created = client.create_job(request(rough, None, &[])).await.unwrap();
    let id = created.into_inner().job.unwrap().id;
    let again = client.get_input(pb::GetInputRequest { id }).await.unwrap();
    assert_eq!(again.into_inner().input.unwrap(), input);
    for (request, field) in [
        (request(rough, Some(1_000_000), &[]), ".iteration"),
        (request(rough, None, &[1.0, 2.0]), ""),
        (request("none", None, &[]), ".job"),
    ] {
        let refused = client.create_job(request).await.unwrap_err();
        let violations = refused.get_details_bad_request().unwrap().field_violations;
        let field = format!("input.surface.scattered.foot_points{field}");
        assert_eq!(violations[0].field, field, "{violations:?}");
    }
}

/// Errors have locations.
#[tokio::test]
async fn what_cannot_be_is_refused() {
    let server = Server::start().await;
    let surface = server
        .fit(&json!({"surface": {"points": data::peaks(8)}}))
        .await;
    let curve = server
        .fit(&json!({"curve": {"points": data::helix()}}))
        .await;
    let points = json!([[0, 0, 1], [1, 0, 2], [0, 1, 3], [1, 1, 1], [-1, 0, 2]]);
    let at = |foot_points: Value, points: &Value| {
        json!({
            "surface": {"scattered": points, "parameters": {"foot_points": foot_points}, "degree": 1},
            "method": {"kind": "least_squares", "control_points": 2},
        })
    };
    let id = &surface["id"];
    let root = "/surface/parameters/foot_points";
    let unknown = "01900000-0000-7000-8000-000000000000";
    for (foot_points, pointer, reason) in [
        (json!({"job": unknown}), "/job", "there is no job"),
        (
            json!({"job": "a surface"}),
            "/job",
            "there is no job \"a surface\"",
        ),
        (json!({"job": curve["id"]}), "/job", "fits a curve"),
        (
            json!({"job": id, "iteration": 900}),
            "/iteration",
            "before 900",
        ),
        (
            json!({"job": id, "iteration": -1}),
            "/iteration",
            "expected the number of an iteration",
        ),
        (json!({"iteration": 1}), "", "\"job\" is missing"),
        (
            json!({"job": id, "level": 1}),
            "/level",
            "unknown field \"level\"",
        ),
        (json!(id), "", "expected an object with a job"),
    ] {
        let pointer = format!("{root}{pointer}");
        server
            .assert_refused(&at(foot_points, &points), &pointer, reason)
            .await;
    }
    let plane = json!([[0, 0], [1, 0], [0, 1], [1, 1], [2, 1]]);
    let reason = "3 coordinates, and these points have 2";
    server
        .assert_refused(
            &at(json!({"job": id}), &plane),
            &format!("{root}/job"),
            reason,
        )
        .await;
    let on_grid =
        json!({"surface": {"points": data::peaks(8), "parameters": {"foot_points": {"job": id}}}});
    let reason = "are parameters of scattered points";
    server
        .assert_refused(&on_grid, "/surface/parameters", reason)
        .await;
    // Together with other errors.
    let mut both = at(json!({"job": unknown}), &points);
    both["rational"] = json!("fixed");
    let answer = server.post("/v1/jobs").json(&both).send().await.unwrap();
    let (status, problem) = problem(answer).await;
    assert_eq!(
        (status, problem["errors"].as_array().unwrap().len()),
        (422, 2),
        "{problem}"
    );
}

/// The last surface of a job is known when it has ended; before, an iteration has to be named.
#[tokio::test]
async fn a_running_job_has_no_last_surface() {
    let server = Server::start().await;
    let endless = json!({
        "surface": {"points": data::peaks(12)},
        "method": {"kind": "weighted", "omega": 1e-9},
        "stop": {"tolerance": 0, "max_iterations": 1_000_000_000},
    });
    let job = server.create(&endless).await;
    let points = listed(&data::peaks(9));
    let pointer = "/surface/parameters/foot_points/job";
    let reason = "wait until it has ended, or name an iteration";
    server
        .assert_refused(&on(&job, &points, few()), pointer, reason)
        .await;
    let frame = server
        .get(&format!("{}/iterations/3", base(&job)))
        .send()
        .await
        .unwrap();
    assert_eq!(frame.status(), 200);
    let mut named = on(&job, &points, few());
    named["surface"]["parameters"]["foot_points"]["iteration"] = json!(3);
    let fitted = server.fit(&named).await;
    assert_eq!(parameters(&server, &fitted).await.len(), 81);
}
