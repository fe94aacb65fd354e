//! How far the data are from the nearest points of a curve or surface.

use serde_json::{Value, json};
use tonic::Code;

use crate::data;
use crate::messages as pb;
use crate::random::Random;
use crate::rpc::connect;
use crate::support::{Server, assert_query_refused, base, problem};

async fn deviation(server: &Server, job: &Value, query: &str) -> Value {
    server
        .json(&format!("{}/deviation{query}", base(job)))
        .await
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Points near the unit circle, by turns a hundredth outside and inside.
fn ring(count: usize) -> Value {
    let point = |i: usize| {
        let a = std::f64::consts::PI * i as f64 / (count - 1) as f64;
        let r = 1.0 + if i.is_multiple_of(2) { 0.01 } else { -0.01 };
        json!([r * a.cos(), r * a.sin()])
    };
    (0..count).map(point).collect()
}

/// A line: distances are those of plane geometry, and the numbers that are made of them.
#[tokio::test]
async fn distances_are_those_from_the_nearest_points() {
    let server = Server::start().await;
    // Least squares of degree one with two control points is the chord between the end points.
    let heights: [f64; 6] = [0.0, 1.0, -2.0, 3.0, 0.5, 0.0];
    let points: Value = heights
        .iter()
        .enumerate()
        .map(|(i, y)| json!([i, y]))
        .collect();
    let line = json!({
        "curve": {"points": points, "degree": 1},
        "method": {"kind": "least_squares", "control_points": 2, "variant": "direct"},
    });
    let job = server.fit(&line).await;
    let reported = deviation(&server, &job, "?list=true").await;
    let distances: Vec<f64> = reported["distances"]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .collect();
    for (distance, height) in distances.iter().zip(heights) {
        assert!((distance - height.abs()).abs() < 1e-14, "{distances:?}");
    }
    assert_eq!(
        (number(&reported["max"]), &reported["at"]),
        (distances[3], &json!(3))
    );
    let mean = heights.iter().map(|y| y * y).sum::<f64>() / 6.0;
    assert!((number(&reported["rms"]) - mean.sqrt()).abs() < 1e-14);
    // Of 0, 0, 0.5, 1, 2, 3: half way between the third and the fourth; 95 % of the way to the last.
    assert!((number(&reported["percentiles"]["50"]) - 0.75).abs() < 1e-14);
    assert!((number(&reported["percentiles"]["95"]) - 2.75).abs() < 1e-14);
    let short = deviation(&server, &job, "").await;
    assert_eq!(short["distances"], Value::Null);
    assert_eq!(short["max"], reported["max"]);
}

/// They are at most the errors, at each iteration, and no other point of the curve is nearer.
#[tokio::test]
async fn they_are_at_most_the_errors() {
    let server = Server::start().await;
    let points = ring(101);
    let few = json!({"kind": "least_squares", "control_points": 8, "variant": "diagonal"});
    let job = json!({"curve": {"points": points}, "method": few, "stop": {"max_iterations": 20}});
    let job = server.fit(&job).await;
    for k in ["0", "5", "last"] {
        let reported = deviation(&server, &job, &format!("?iteration={k}&list=true")).await;
        let iteration = server.json(&format!("{}/iterations/{k}", base(&job))).await;
        assert_eq!(reported["iteration"], iteration["iteration"]);
        for name in ["max", "rms"] {
            assert!(number(&reported[name]) <= number(&iteration["error"][name]) * (1.0 + 1e-12));
        }
        let view = "view=samples&samples=20001";
        let samples = server
            .json(&format!("{}/iterations/{k}?{view}", base(&job)))
            .await;
        let samples = samples["samples"].as_array().unwrap();
        for (point, reported) in points
            .as_array()
            .unwrap()
            .iter()
            .zip(reported["distances"].as_array().unwrap())
        {
            let [x, y] = [0, 1].map(|c| number(&point[c]));
            let distances = samples
                .iter()
                .map(|s| (number(&s[0]) - x).hypot(number(&s[1]) - y));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            // Samples lie 2e-4 apart.
            assert!(
                (0.0..2e-4).contains(&(nearest - number(reported) + 1e-13)),
                "{nearest} {reported}"
            );
        }
    }
}

/// Grids have rows, with null where a point is missing; scattered points have a list.
#[tokio::test]
async fn surfaces_are_measured() {
    let server = Server::start().await;
    let mut grid = data::peaks(12);
    grid[3][4] = Value::Null;
    let few = json!({"kind": "least_squares", "control_points": {"u": 7, "v": 8}});
    let job = server
        .fit(&json!({"surface": {"points": grid}, "method": few}))
        .await;
    let reported = deviation(&server, &job, "?list=true").await;
    let rows = reported["distances"].as_array().unwrap();
    assert_eq!((rows.len(), rows[0].as_array().unwrap().len()), (12, 12));
    assert_eq!(rows[3][4], Value::Null);
    let at = &reported["at"];
    let [i, j] = [0, 1].map(|axis| at[axis].as_u64().unwrap() as usize);
    assert_eq!(rows[i][j], reported["max"]);
    assert!(number(&reported["max"]) <= number(&job["error"]["max"]));

    let points: Value = (0..300)
        .map(|i| {
            let (x, y) = (
                (0.618 * f64::from(i)).fract(),
                (0.755 * f64::from(i)).fract(),
            );
            json!([x, y, (3.0 * x).sin() * y])
        })
        .collect();
    let few = json!({"kind": "least_squares", "control_points": 6, "variant": "direct"});
    let job = json!({"surface": {"scattered": points, "parameters": "project"}, "method": few});
    let reported = deviation(&server, &server.fit(&job).await, "?list=true").await;
    assert_eq!(reported["distances"].as_array().unwrap().len(), 300);
    assert!(reported["at"].is_u64());
}

/// Noise and close knots bend a surface to and fro within its spans.
#[tokio::test]
async fn bent_surfaces_are_measured() {
    let server = Server::start().await;
    let mut random = Random(7);
    let (mut points, mut parameters) = (Vec::new(), Vec::new());
    for _ in 0..600 {
        let [u, v, noise] = [(); 3].map(|()| random.part());
        parameters.push(json!([u, v]));
        points.push(json!([u, v, (3.0 * u).sin() * v + 0.4 * noise]));
    }
    let auto = json!({"kind": "least_squares", "control_points": "auto", "end_points": "free"});
    let job = json!({
        "surface": {"scattered": points, "parameters": parameters},
        "method": auto, "stop": {"tolerance": 0.15},
    });
    let job = server.fit(&job).await;
    let reported = deviation(&server, &job, "").await;
    for name in ["max", "rms"] {
        let (distance, error) = (number(&reported[name]), number(&job["error"][name]));
        assert!(
            distance <= error * (1.0 + 1e-12),
            "{name}: {distance} {error}"
        );
    }
}

/// Closed, rational and Bézier curves, and data that a curve goes through.
#[tokio::test]
async fn all_kinds_of_curves_are_measured() {
    let server = Server::start().await;
    let points = data::lemniscate();
    let points = points.as_array().unwrap();
    let weights: Vec<f64> = (0..points.len())
        .map(|i| 1.0 + 0.1 * (i % 3) as f64)
        .collect();
    for curve in [
        json!({"points": points}),
        json!({"points": points, "basis": "bernstein"}),
        json!({"points": points, "basis": "wang_ball"}),
        json!({"points": points, "weights": weights}),
        json!({"points": &points[..points.len() - 1], "closed": true}),
    ] {
        let job = server
            .fit(&json!({"curve": curve, "method": "direct"}))
            .await;
        let reported = deviation(&server, &job, "").await;
        assert!(number(&reported["max"]) < 1e-13, "{reported}");
    }
}

#[tokio::test]
async fn what_has_no_nearest_points_is_said() {
    let server = Server::start().await;
    let values = json!({"curve": {"points": [[0], [2], [1], [3]], "parameters": "uniform"}});
    let circle: Vec<[f64; 2]> = (0..80)
        .map(|i| f64::from(i) / 80.0)
        .map(|t| [t.cos(), t.sin()])
        .collect();
    let steep =
        json!({"curve": {"points": circle, "basis": "bernstein"}, "stop": {"max_iterations": 2}});
    for (job, reason) in [(values, "values of a function"), (steep, "degree 79")] {
        let job = server.fit(&job).await;
        let url = format!("{}/deviation", base(&job));
        let (status, problem) = problem(server.get(&url).send().await.unwrap()).await;
        assert_eq!(
            (status, &problem["type"]),
            (409, &json!("/problems/no-deviation"))
        );
        assert!(
            problem["detail"].as_str().unwrap().contains(reason),
            "{problem}"
        );
    }
    let job = server.fit(&data::small_job()).await;
    let path = format!("{}/deviation", base(&job));
    for (query, parameter, reason) in [
        ("iteration=-1", "iteration", "neither a number nor"),
        ("list=yes", "list", "neither"),
        ("view=samples", "view", "no such parameter"),
    ] {
        assert_query_refused(&server, &path, query, parameter, reason).await;
    }
    let beyond = server.get(&format!("{path}?iteration=900000"));
    let (status, problem) = problem(beyond.send().await.unwrap()).await;
    assert_eq!(
        (status, &problem["type"]),
        (404, &json!("/problems/no-such-iteration"))
    );
}

/// The same by gRPC.
#[tokio::test]
async fn messages_say_it_too() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let reported = deviation(&server, &job, "?iteration=1&list=true").await;
    let mut client = connect(&server).await;
    let request = |list| pb::GetDeviationRequest {
        id: job["id"].as_str().unwrap().to_owned(),
        iteration: Some(1),
        list,
    };
    let message = client
        .get_deviation(request(true))
        .await
        .unwrap()
        .into_inner();
    assert_eq!(
        (message.iteration, message.max),
        (1, number(&reported["max"]))
    );
    assert_eq!(message.rms, number(&reported["rms"]));
    assert_eq!(json!(message.at), reported["at"]);
    assert_eq!(json!(message.distances), reported["distances"]);
    assert_eq!(
        message.percentiles[3],
        number(&reported["percentiles"]["99"])
    );
    let short = client.get_deviation(request(false)).await.unwrap();
    assert!(short.into_inner().distances.is_empty());
    let unknown = pb::GetDeviationRequest {
        id: "01900000-0000-7000-8000-000000000000".to_owned(),
        ..pb::GetDeviationRequest::default()
    };
    let status = client.get_deviation(unknown).await.unwrap_err();
    assert_eq!(status.code(), Code::NotFound);
}
