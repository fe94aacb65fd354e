//! Surfaces that turn across lines of their points.

use serde_json::{Value, json};
use tonic::Code;

use crate::messages as pb;
use crate::numbers::flat;
use crate::rpc::connect;
use crate::support::{Server, base};

/// Heights of a roof whose ridge is the row 12 of 31, with a gutter along column 5 of 17.
fn roof() -> Value {
    let height = |i: i32, j: i32| {
        let x = f64::from((i - 12).abs());
        let y = f64::from(j - 5);
        -0.3 * x + 0.1 * y.abs()
    };
    (0..31)
        .map(|i| (0..17).map(|j| json!([i, j, height(i, j)])).collect())
        .collect::<Vec<Value>>()
        .into()
}

fn creases() -> Value {
    json!({"u": [12], "v": [5]})
}

fn job(surface: Value, method: Value) -> Value {
    json!({"surface": surface, "method": method, "stop": {"tolerance": 1e-9, "max_iterations": 5000}})
}

/// With them the roof is straight everywhere, by interpolation and by few control points; without them it swings.
#[tokio::test]
async fn a_roof_is_straight_between_its_creases() {
    let server = Server::start().await;
    let surface = json!({"points": roof(), "parameters": "uniform", "creases": creases()});
    for method in [
        json!("direct"),
        json!("global"),
        json!({"kind": "least_squares", "control_points": {"u": 5, "v": 5}, "variant": "direct"}),
        json!({"kind": "least_squares", "control_points": {"u": 3, "v": 3}}),
        json!({"kind": "least_squares", "control_points": {"u": 9, "v": 7}, "fairness": 1e-12, "variant": "direct"}),
    ] {
        let fitted = server.fit(&job(surface.clone(), method.clone())).await;
        assert_eq!(fitted["state"], "converged", "{method}: {fitted:#}");
        let path = base(&fitted);
        let result = server.json(&format!("{path}/result")).await;
        let ridge = flat(&result["parameters"]["u"])[12];
        let knots = flat(&result["knots"]["u"]);
        let times = knots.iter().filter(|knot| **knot == ridge).count();
        assert_eq!(times, 3, "{method}");
        let samples = server
            .json(&format!("{path}/result?view=samples&samples=61x49"))
            .await;
        for point in flat(&samples["samples"]).chunks(3) {
            let height = -0.3 * (point[0] - 12.0).abs() + 0.1 * (point[1] - 5.0).abs();
            assert!((point[2] - height).abs() < 1e-6, "{method}: {point:?}");
        }
        let step = server.get(&format!("{path}/result/step")).send().await;
        assert!(step.unwrap().status().is_success());
        // As it is given back.
        let input = server.json(&format!("{path}/input")).await;
        assert_eq!(input["surface"]["creases"], creases());
        assert_eq!(server.fit(&input).await["error"], fitted["error"]);
        let moved = json!({"points": [{"index": [3, 4], "point": [3, 4, 0.5]}]});
        let edit = server.post(&format!("{path}/edits")).json(&moved);
        assert!(edit.send().await.unwrap().status().is_success(), "{method}");
    }
    let plain = json!({"points": roof(), "parameters": "uniform"});
    let fewer =
        json!({"kind": "least_squares", "control_points": {"u": 9, "v": 9}, "variant": "direct"});
    let swinging = server.fit(&job(plain, fewer)).await;
    assert!(swinging["error"]["max"].as_f64().unwrap() > 0.05);
}

#[tokio::test]
async fn creases_that_cannot_be_are_refused_by_name() {
    let server = Server::start().await;
    let with = |creases: Value| json!({"points": roof(), "creases": creases});
    let and = |field: &str, value: Value| {
        let mut surface = with(creases());
        surface[field] = value;
        surface
    };
    let auto = json!({"kind": "least_squares", "control_points": "auto"});
    let direct = || json!("direct");
    let scattered = json!({"scattered": [[0, 0, 1], [0, 1, 2], [1, 0, 3], [1, 1, 4], [0.5, 0.3, 1]], "parameters": "project", "creases": {"u": [2]}});
    for (surface, method, pointer, reason) in [
        (
            with(json!({"u": [31]})),
            direct(),
            "/surface/creases/u/0",
            "rows 0 to 30",
        ),
        (
            with(json!({"v": [5, 16]})),
            direct(),
            "/surface/creases/v/1",
            "an end of the surface",
        ),
        (
            with(json!({"v": [5, 5]})),
            direct(),
            "/surface/creases/v/1",
            "must increase",
        ),
        (with(json!({"w": [5]})), direct(), "/surface/creases/w", "w"),
        (
            with(json!({"u": "auto"})),
            direct(),
            "/surface/creases/u",
            "expected a list",
        ),
        (
            with(creases()),
            auto,
            "/surface/creases/u",
            "give the numbers",
        ),
        (
            and("basis", json!("bernstein")),
            direct(),
            "/surface/creases/u",
            "use a B-spline",
        ),
        (
            and("ends", json!("natural")),
            direct(),
            "/surface/creases/u",
            "leave ends out",
        ),
        (
            scattered,
            json!({"kind": "least_squares", "control_points": 2}),
            "/surface/creases/u",
            "no rows and columns",
        ),
        (
            with(creases()),
            json!({"kind": "least_squares", "control_points": 2, "variant": "direct"}),
            "/method/control_points",
            "3 to 31 control points",
        ),
    ] {
        server
            .assert_refused(&job(surface, method), pointer, reason)
            .await;
    }
}

/// In messages a direction has them.
#[tokio::test]
async fn messages_have_creases() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let create = |creases: Vec<u32>| pb::CreateJobRequest {
        input: Some(pb::JobInput {
            geometry: Some(pb::job_input::Geometry::Surface(pb::Surface {
                dimension: 3,
                rows: 31,
                columns: 17,
                points: flat(&roof()),
                u: Some(pb::SurfaceDirection {
                    creases,
                    ..Default::default()
                }),
                ..Default::default()
            })),
            ..Default::default()
        }),
        ..Default::default()
    };
    let created = client
        .create_job(create(vec![12]))
        .await
        .unwrap()
        .into_inner();
    let path = format!("/v1/jobs/{}", created.job.unwrap().id);
    let input = server.json(&format!("{path}/input")).await;
    assert_eq!(input["surface"]["creases"], json!({"u": [12]}));
    let refused = client.create_job(create(vec![12, 30])).await.unwrap_err();
    assert_eq!(refused.code(), Code::InvalidArgument);
    assert!(
        refused.message().contains("surface.u.creases[1]"),
        "{refused}"
    );
}
