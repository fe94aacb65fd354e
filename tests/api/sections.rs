//! Surfaces through sections: curves with different numbers of points, which start and go around as they like.

use std::f64::consts::TAU;

use reqwest::RequestBuilder;
use serde_json::{Value, json};

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, problem};

/// Ellipses one behind the other, each with its number of points, turned by `turn` from one to the next; every other
/// one is reversed if they are `mixed`.
fn hull(counts: &[usize], turn: f64, mixed: bool) -> Vec<Vec<[f64; 3]>> {
    let section = |(k, &count): (usize, &usize)| {
        let z = 5.0 * k as f64;
        let (a, b) = (6.0 + 1.5 * (k as f64).sin(), 4.0 + 0.8 * k as f64);
        let sense = if mixed && k % 2 == 1 { -1.0 } else { 1.0 };
        let point = |i: usize| {
            let angle = turn * k as f64 + sense * TAU * i as f64 / count as f64;
            [a * angle.cos(), b * angle.sin(), z]
        };
        (0..count).map(point).collect()
    };
    counts.iter().enumerate().map(section).collect()
}

/// The answer to a job that is refused.
async fn refusal(request: RequestBuilder) -> Value {
    let (status, refused) = problem(request.send().await.unwrap()).await;
    assert_eq!(status, 422, "{refused:#}");
    refused
}

async fn area(server: &Server, job: &Value) -> f64 {
    let shape = server.json(&format!("{}/shape", base(job))).await;
    shape["area"].as_f64().unwrap()
}

/// The same surface whatever the sections start with and whichever way they go; it is within the tolerance of all points,
/// closed along the sections, and made again of its input and by messages.
#[tokio::test]
async fn sections_are_aligned() {
    let server = Server::start().await;
    let counts = [24, 40, 31, 57, 36];
    let mut areas = Vec::new();
    for (turn, mixed) in [(0.0, false), (0.7, true)] {
        let job = json!({
            "surface": {"sections": hull(&counts, turn, mixed)},
            "stop": {"tolerance": 0.001},
        });
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["state"], "converged", "{fitted:#}");
        assert_eq!(fitted["notices"][0], "the points are 5 closed sections");
        let result = server
            .json(fitted["links"]["result"].as_str().unwrap())
            .await;
        assert_eq!(result["closed"], json!({"u": false, "v": true}));
        let rows = result["control_points"].as_array().unwrap();
        assert_eq!(rows.len(), 5);
        assert!(rows[0].as_array().unwrap().len() < 32, "{}", rows[0]);
        areas.push(area(&server, &fitted).await);
        let input = server.json(&format!("{}/input", base(&fitted))).await;
        assert_eq!(input["surface"]["parameters"], json!({"sections": counts}));
        let again = server.fit(&input).await;
        let second = server
            .json(again["links"]["result"].as_str().unwrap())
            .await;
        assert_eq!(second["control_points"], result["control_points"]);
    }
    assert!((areas[1] / areas[0] - 1.0).abs() < 1e-4, "{areas:?}");

    let mut client = connect(&server).await;
    let sections = hull(&counts, 0.0, false);
    let input = pb::JobInput {
        geometry: Some(pb::job_input::Geometry::Surface(pb::Surface {
            dimension: 3,
            points: sections.concat().concat(),
            scattered: Some(pb::ScatteredParameters {
                sections: counts.iter().map(|&count| count as u32).collect(),
                ..Default::default()
            }),
            ..Default::default()
        })),
        stop: Some(pb::StopRules {
            rule: Some(pb::stop_rules::Rule::Tolerance(0.001)),
            ..Default::default()
        }),
        ..Default::default()
    };
    let request = pb::CreateJobRequest {
        input: Some(input),
        ..Default::default()
    };
    let created = client.create_job(request).await.unwrap().into_inner();
    let id = created.job.unwrap().id;
    let path = format!("/v1/jobs/{id}");
    server.until_state(&path, "converged").await;
    let json = server.json(&path).await;
    let by_message = area(&server, &json).await;
    assert_eq!(by_message, areas[0]);
}

/// Sections with few points and a requested fairness, or the least that the tolerance allows: both stay near
/// the ellipse between the points of the first section.
#[tokio::test]
async fn surfaces_do_not_swing_between_few_points() {
    let server = Server::start().await;
    for fairness in [None, Some(1e-9)] {
        let mut method = json!({"kind": "least_squares", "control_points": "auto"});
        if let Some(fairness) = fairness {
            method["fairness"] = fairness.into();
        }
        let job = json!({
            "surface": {"sections": hull(&[14, 57, 40, 57], 0.3, false)},
            "method": method,
            "stop": {"tolerance": 0.02},
        });
        let fitted = server.fit(&job).await;
        assert_eq!(fitted["state"], "converged", "{fitted:#}");
        let path = format!("{}/result?view=samples&samples=2x300", base(&fitted));
        let result = server.json(&path).await;
        let first = result["samples"][0].as_array().unwrap();
        assert_eq!(first.len(), 300);
        for point in first {
            let [x, y] = [0, 1].map(|k| point[k].as_f64().unwrap());
            let off = 4.0 * ((x / 6.0).hypot(y / 4.0) - 1.0);
            assert!(off.abs() < 0.05, "{off} at {point}");
        }
    }
}

/// Open sections, few of them, and few points in them: the degree is lower where nothing is said of it.
#[tokio::test]
async fn few_open_sections() {
    let server = Server::start().await;
    let sections = json!([
        [[0, 0, 0], [1, 0, 1], [3, 0, 0]],
        [[4, 2, 0], [2, 2, 2], [1, 2, 1.5], [0, 2, 0]],
    ]);
    let job = json!({"surface": {"sections": sections}});
    let fitted = server.fit(&job).await;
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    assert_eq!(fitted["notices"][0], "the points are 2 open sections");
    let result = server
        .json(fitted["links"]["result"].as_str().unwrap())
        .await;
    assert_eq!(result["degree"], json!({"u": 1, "v": 3}));
    // The second section goes the other way: its last point is beside the first one of the first section.
    let first = &result["control_points"];
    assert!(first[0][0][0].as_f64().unwrap().abs() < 1e-4, "{first}");
    assert!(first[1][0][0].as_f64().unwrap().abs() < 1e-4, "{first}");
    // A given number of control points, and sections that are to be closed.
    let job = json!({
        "surface": {"sections": hull(&[12, 12, 12, 12], 0.0, false), "closed": {"u": false, "v": false}},
        "method": {"kind": "least_squares", "control_points": {"u": 4, "v": 8}},
    });
    let fitted = server.fit(&job).await;
    let result = server
        .json(fitted["links"]["result"].as_str().unwrap())
        .await;
    assert_eq!(result["closed"], json!({"u": false, "v": false}));
}

#[tokio::test]
async fn wrong_sections_are_refused() {
    let server = Server::start().await;
    let ring = hull(&[12, 12], 0.0, false);
    let one = [&ring[0]];
    let twice = [&ring[0], &ring[0]];
    let short = json!([ring[0], [[0, 0, 1]]]);
    let cases = [
        (
            json!({"sections": one}),
            "/surface/parameters",
            "two of them or more, not 1",
        ),
        (
            json!({"sections": twice}),
            "/surface/sections/1",
            "the same as section 0",
        ),
        (
            json!({"sections": short}),
            "/surface/sections/1",
            "section 1 has 1 points",
        ),
        (
            json!({"sections": [[], [[0, 0, 1]]]}),
            "/surface/sections",
            "section 0 has no points",
        ),
        (
            json!({"sections": [[[0, 0]], [[0, 0, 1]]]}),
            "/surface/sections/1/0",
            "3 coordinates, the first has 2",
        ),
        (
            json!({"sections": ring, "parameters": "auto"}),
            "/surface/sections",
            "parameters of their own",
        ),
        (
            json!({"sections": ring, "scattered": ring[0]}),
            "/surface/sections",
            "cannot have sections as well",
        ),
        (
            json!({"scattered": ring.concat(), "parameters": {"sections": [12, 11]}}),
            "/surface/parameters",
            "the sections have 23 points, and 24 are given",
        ),
        (
            json!({"scattered": ring.concat(), "parameters": {"sections": [12, 12], "project": "xy"}}),
            "/surface/parameters",
            "parameters of their own",
        ),
    ];
    for (surface, pointer, detail) in cases {
        let body = json!({"surface": surface});
        let refused = refusal(server.post("/v1/jobs").json(&body)).await;
        let error = &refused["errors"][0];
        assert_eq!(error["pointer"], pointer, "{refused:#}");
        assert!(
            error["detail"].as_str().unwrap().contains(detail),
            "{refused:#}"
        );
    }
    // Sections keep their parameters.
    let corrected =
        json!({"kind": "least_squares", "control_points": "auto", "correct_parameters": true});
    let body =
        json!({"surface": {"sections": ring}, "method": corrected, "stop": {"tolerance": 0.1}});
    let refused = refusal(server.post("/v1/jobs").json(&body)).await;
    assert_eq!(
        refused["errors"][0]["pointer"],
        "/method/correct_parameters"
    );
    // No other method fits sections.
    let body = json!({"surface": {"sections": ring}, "method": "global"});
    let refused = refusal(server.post("/v1/jobs").json(&body)).await;
    assert_eq!(refused["errors"][0]["pointer"], "/method", "{refused:#}");
}

/// Blank lines of a table separate sections; errors of a section are reported at its line.
#[tokio::test]
async fn files_of_sections() {
    let server = Server::start().await;
    let text = |sections: &[Vec<[f64; 3]>]| {
        let rows = |section: &Vec<[f64; 3]>| {
            let row = |[x, y, z]: &[f64; 3]| format!("{x},{y},{z}\n");
            section.iter().map(row).collect::<String>()
        };
        let parts: Vec<String> = sections.iter().map(rows).collect();
        format!("x,y,z\n{}", parts.join("\n"))
    };
    let post = |path: &str, body: &str| {
        let request = server.post(path).header("content-type", "text/csv");
        request.header("prefer", "wait=20").body(body.to_owned())
    };
    let file = text(&hull(&[12, 15, 11], 0.4, true));
    let answer = post("/v1/points", &file).send().await.unwrap();
    let points: Value = answer.json().await.unwrap();
    assert_eq!(
        points["surface"]["parameters"],
        json!({"sections": [12, 15, 11]})
    );
    assert_eq!(points["surface"]["scattered"].as_array().unwrap().len(), 38);
    let answer = post("/v1/jobs?stop.tolerance=0.01", &file)
        .send()
        .await
        .unwrap();
    let fitted: Value = answer.json().await.unwrap();
    assert_eq!(fitted["state"], "converged", "{fitted:#}");
    let notices = fitted["notices"].to_string();
    assert!(
        notices.contains("3 sections of 11 to 15 points"),
        "{notices}"
    );
    assert!(notices.contains("3 closed sections"), "{notices}");
    // They are curves if that is said.
    let refused = refusal(post("/v1/jobs?surface.sections=false", &file)).await;
    assert_eq!(refused["errors"][0]["parameter"], "part");
    let ring = &hull(&[12], 0.0, false)[0];
    let wrong = text(&[ring.clone(), vec![[0.0, 0.0, 1.0]; 2]]);
    let refused = refusal(post("/v1/jobs?surface.sections=true", &wrong)).await;
    assert_eq!(refused["errors"][0]["line"], 15, "{refused:#}");
    let request = post("/v1/jobs?surface.sections=maybe", &wrong);
    let (status, refused) = problem(request.send().await.unwrap()).await;
    assert_eq!(status, 400);
    assert_eq!(refused["errors"][0]["parameter"], "surface.sections");
}
