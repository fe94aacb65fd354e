//! Curves with corners.

use serde_json::{Value, json};
use tonic::Code;

use crate::messages as pb;
use crate::numbers::{largest_difference, numbers};
use crate::rpc::connect;
use crate::support::{Server, Story, base, problem};

/// Six edges, with five points each but for the last one.
fn zigzag() -> Vec<[f64; 2]> {
    (0..24)
        .map(|i| [f64::from(i), f64::from((i % 8 - 4_i32).abs())])
        .collect()
}

/// The largest distance of samples from the zigzag, along y.
fn from_zigzag(samples: &Value) -> f64 {
    let samples = samples.as_array().unwrap().iter();
    let distances = samples.map(|point| {
        let point = numbers(point);
        (point[1] - (point[0].rem_euclid(8.0) - 4.0).abs()).abs()
    });
    distances.fold(0.0, f64::max)
}

async fn samples(server: &Server, job: &Value) -> Value {
    let path = format!("{}/result?view=samples&samples=1500", base(job));
    server.json(&path).await["samples"].take()
}

/// By each method, and however corners are named; without them the curve swings.
#[tokio::test]
async fn edges_between_corners_are_straight() {
    let server = Server::start().await;
    let found = json!([4, 8, 12, 16, 20]);
    let corners = [json!("auto"), json!({"angle": 80}), found.clone()];
    let methods = [
        json!("global"),
        json!("chebyshev"),
        json!({"kind": "weighted"}),
        json!("direct"),
        json!("transpose"),
        json!({"kind": "adaptive", "threshold": 1e-9}),
        json!({"kind": "least_squares", "control_points": 7, "variant": "direct"}),
        json!({"kind": "least_squares", "control_points": 19}),
    ];
    for (method, corners) in methods.iter().zip(corners.iter().cycle()) {
        let job = json!({
            "curve": {"points": zigzag(), "corners": corners},
            "method": method, "stop": {"tolerance": 1e-9, "max_iterations": 10_000},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{method}: {}", story.end);
        assert_eq!(story.job["corners"], found, "{method}");
        assert_eq!(story.job["warnings"], json!([]), "{method}");
        let off = from_zigzag(&samples(&server, &story.job).await);
        assert!(off < 1e-8, "{method}: {off:e}");
        // A corner has as many knots as the degree, and is passed through at each iteration.
        let knots = numbers(&story.job["knots"]);
        for index in [4, 8, 12, 16, 20] {
            let at = story.job["parameters"][index].as_f64().unwrap();
            assert_eq!(
                knots.iter().filter(|knot| **knot == at).count(),
                3,
                "{method}"
            );
        }
    }
    let smooth = server
        .fit(&json!({"curve": {"points": zigzag()}, "method": "direct"}))
        .await;
    assert!(from_zigzag(&samples(&server, &smooth).await) > 0.05);
}

/// Corners that were found stay when points move, and the input of a job makes the same job again.
#[tokio::test]
async fn edits_keep_corners() {
    let server = Server::start().await;
    let job = json!({"curve": {"points": zigzag(), "corners": "auto"}, "method": "direct"});
    let parent = server.fit(&job).await;
    let input = server.json(&format!("{}/input", base(&parent))).await;
    assert_eq!(input["curve"]["corners"], json!([4, 8, 12, 16, 20]));
    let again = server.fit(&input).await;
    let result = |job: &Value| format!("{}/result", base(job));
    let (one, other) = (
        server.json(&result(&parent)).await,
        server.json(&result(&again)).await,
    );
    assert_eq!(one["control_points"], other["control_points"]);
    // A straight point where there was a corner.
    let edit = json!({"points": [{"index": 8, "point": [8, 0.1]}]});
    let request = server
        .post(&format!("{}/edits/stream", base(&parent)))
        .json(&edit);
    let edited = Story::read(request.send().await.unwrap()).await;
    assert_eq!(edited.job["corners"], json!([4, 8, 12, 16, 20]));
    assert_eq!(edited.state(), "converged");
    // Pieces that have no part of it stay.
    let last = &edited.iterations.last().unwrap()["control_points"];
    let far = |net: &Value| json!(&net.as_array().unwrap()[14..]);
    assert!(largest_difference(&far(&one["control_points"]), &far(last)) < 1e-14);
    // Noise has no corners, and a curve without any is as usual.
    let wave: Vec<[f64; 2]> = (0..30)
        .map(f64::from)
        .map(|x| [x, (0.3 * x).sin()])
        .collect();
    let with = server
        .fit(&json!({"curve": {"points": wave, "corners": "auto"}}))
        .await;
    let without = server.fit(&json!({"curve": {"points": wave}})).await;
    assert_eq!(
        server.json(&result(&with)).await["control_points"],
        server.json(&result(&without)).await["control_points"]
    );
}

/// Least squares gives each piece a share of the control points, and passes through the corners.
#[tokio::test]
async fn least_squares_passes_through_corners() {
    let server = Server::start().await;
    let noise = |i: usize| 0.02 * ((i * i % 17) as f64 - 8.0) / 8.0;
    let points: Vec<[f64; 2]> = (0..=80)
        .map(|i| {
            [
                i as f64 / 8.0,
                ((i % 40) as f64 - 20.0).abs() / 8.0 + noise(i),
            ]
        })
        .collect();
    for variant in ["direct", "cg", "diagonal"] {
        let job = json!({
            "curve": {"points": points, "corners": [20, 40, 60]},
            "method": {"kind": "least_squares", "control_points": 17, "variant": variant},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{}", story.end);
        assert_eq!(story.job["control_points"], 17);
        for iteration in &story.iterations {
            let net = &iteration["control_points"];
            for (control, index) in [(4, 20), (8, 40), (12, 60)] {
                let off = largest_difference(&net[control], &json!(points[index]));
                assert!(off < 1e-9, "{variant} {control}: {off:e}");
            }
        }
        let error = story.end["error"]["max"].as_f64().unwrap();
        assert!(error < 0.04, "{variant}: {error}");
    }
}

/// The corners of a square and of a drop, whose only one is its first point: exactly what was given, at each corner
/// passed through, and closed in whatever reads it.
#[tokio::test]
async fn closed_curves_begin_at_their_first_corner() {
    let server = Server::start().await;
    let side = |x: f64, y: f64| move |k: usize| [x * k as f64 / 6.0, y * k as f64 / 6.0];
    // The first point is in the middle of an edge.
    let square: Vec<[f64; 2]> = (0..24)
        .map(|i| (i + 3) % 24)
        .map(|i| match i / 6 {
            0 => side(1.0, 0.0)(i % 6),
            1 => [1.0, side(0.0, 1.0)(i % 6)[1]],
            2 => [1.0 - side(1.0, 0.0)(i % 6)[0], 1.0],
            _ => [0.0, 1.0 - side(0.0, 1.0)(i % 6)[1]],
        })
        .collect();
    let from_square = |samples: &Value| {
        let samples = samples.as_array().unwrap().iter();
        let off = samples.map(|point| {
            let point = numbers(point);
            let [x, y] = [point[0], point[1]].map(|x| (x - 0.5).abs());
            (x.max(y) - 0.5).abs()
        });
        off.fold(0.0, f64::max)
    };
    for method in [
        json!("global"),
        json!("direct"),
        json!({"kind": "least_squares", "control_points": 4, "variant": "direct"}),
        json!({"kind": "least_squares", "control_points": 9}),
    ] {
        let job = json!({
            "curve": {"points": square, "closed": true, "corners": "auto"},
            "method": method, "stop": {"tolerance": 1e-9, "max_iterations": 10_000},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{method}: {}", story.end);
        assert_eq!(story.job["corners"], json!([3, 9, 15, 21]), "{method}");
        assert_eq!(story.job["closed"], true);
        let off = from_square(&samples(&server, &story.job).await);
        assert!(off < 1e-8, "{method}: {off:e}");
        let net = story.iterations.last().unwrap()["control_points"]
            .as_array()
            .unwrap();
        assert_eq!(net.first(), net.last());
        let knots = numbers(&story.job["knots"]);
        let first = story.job["parameters"][3].as_f64().unwrap();
        assert_eq!(knots[..4], [first; 4], "{method}");
        // The parameters go once around the square.
        let last = &knots[knots.len() - 4..];
        assert!(
            last.iter().all(|knot| (knot - first - 4.0).abs() < 1e-12),
            "{method}: {last:?}"
        );
    }
    let drop: Vec<[f64; 2]> = (0..40)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 40.0)
        .map(|a| [a.cos(), a.sin() * (a / 2.0).sin().powi(3)])
        .collect();
    let fit =
        json!({"curve": {"points": drop, "closed": true, "corners": "auto"}, "method": "direct"});
    let story = server.stream(&fit).await;
    assert_eq!(story.job["corners"], json!([0]));
    assert_eq!(story.state(), "converged");
    // What was a corner at the first point stays one when the points move, and its net is closed all the same.
    let edit = json!({"points": [{"index": 0, "point": [1.2, 0]}]});
    let request = server
        .post(&format!("{}/edits/stream", base(&story.job)))
        .json(&edit);
    let edited = Story::read(request.send().await.unwrap()).await;
    let net = &edited.iterations.last().unwrap()["control_points"];
    assert_eq!(net[0], json!([1.2, 0.0]));
    assert_eq!(net[0], net[net.as_array().unwrap().len() - 1]);
}

/// Fits that choose their knots do so between corners: three control points more for each straight edge, one edge in
/// each export, and edits that start from the existing knots.
#[tokio::test]
async fn as_few_control_points_as_pieces_need() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": zigzag(), "corners": "auto"},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": 1e-6},
    });
    let story = server.stream(&job).await;
    assert_eq!(story.state(), "converged", "{}", story.end);
    let last = story.iterations.last().unwrap();
    assert_eq!(last["control_points"].as_array().unwrap().len(), 19);
    assert!(from_zigzag(&samples(&server, &story.job).await) < 1e-12);
    let warnings = |of: &Value| of["warnings"].as_array().unwrap().clone();
    assert!(warnings(&story.end).is_empty(), "{}", story.end);
    // Without them the curve rounds the corners, and a warning names the first one.
    let round = json!({
        "curve": {"points": zigzag()},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": 1e-3},
    });
    let round = warnings(&server.stream(&round).await.end);
    assert_eq!(round[0]["code"], "rounded_corners");
    assert_eq!(round[0]["pointer"], "/curve/points/4");
    assert!(round[0]["detail"].as_str().unwrap().contains("5 corners"));
    // With a bend that needs more, the levels grow.
    let bent: Vec<[f64; 2]> = (0..=120)
        .map(|i| f64::from(i) * 0.05)
        .map(|x| [x, (2.0 * x).sin() + 3.0 * (x - 3.0).abs()])
        .collect();
    let job = json!({
        "curve": {"points": bent, "corners": [60]},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": 1e-4},
    });
    let parent = server.stream(&job).await;
    assert_eq!(parent.state(), "converged", "{}", parent.end);
    let counts: Vec<usize> = parent
        .iterations
        .iter()
        .map(|it| it["control_points"].as_array().unwrap().len())
        .collect();
    assert!(
        counts[0] == 7 && counts[counts.len() - 1] > 12,
        "{counts:?}"
    );
    let edit = json!({"points": [{"index": 60, "point": [3, -0.3]}]});
    let request = server
        .post(&format!("{}/edits/stream", base(&parent.job)))
        .json(&edit);
    let edited = Story::read(request.send().await.unwrap()).await;
    assert_eq!(edited.state(), "converged", "{}", edited.end);
    let first = edited.iterations[0]["control_points"].as_array().unwrap();
    assert_eq!(first.len(), counts[counts.len() - 1]);
    // A stream that is resumed in the middle has the same content.
    let middle = parent.iterations.len() / 2;
    let path = format!("{}/iterations/{middle}", base(&parent.job));
    let again = server.json(&path).await;
    assert_eq!(
        again["control_points"],
        parent.iterations[middle]["control_points"]
    );
}

async fn refused(server: &Server, job: &Value, pointer: &str, reason: &str) {
    let (status, problem) = problem(server.post("/v1/jobs").json(job).send().await.unwrap()).await;
    assert_eq!(status, 422, "{job}");
    assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem:#}");
    let detail = problem["errors"][0]["detail"].as_str().unwrap();
    assert!(detail.contains(reason), "{detail}");
}

#[tokio::test]
async fn what_has_no_corners_is_named() {
    let server = Server::start().await;
    let curve = |corners: Value| json!({"curve": {"points": zigzag(), "corners": corners}});
    for (corners, pointer, reason) in [
        (json!([0]), "/curve/corners/0", "an end"),
        (json!([4, 23]), "/curve/corners/1", "an end"),
        (json!([4, 99]), "/curve/corners/1", "no point 99"),
        (json!([8, 4]), "/curve/corners/1", "increase"),
        (json!({"angle": 0}), "/curve/corners", "between 0 and 180"),
        (json!({"angle": 200}), "/curve/corners", "between 0 and 180"),
    ] {
        refused(&server, &curve(corners), pointer, reason).await;
    }
    let with = |field: &str, value: Value| {
        let mut job = curve(json!([4]));
        job["curve"][field] = value;
        job
    };
    let automatic = |field: &str, value: Value| {
        let mut job = curve(json!([4]));
        job["method"] = json!({"kind": "least_squares", "control_points": "auto", field: value});
        job
    };
    for (job, reason) in [
        (with("basis", json!("bernstein")), "polynomial"),
        (
            with("basis", json!({"kind": "bspline", "knots": "data"})),
            "knots",
        ),
        (with("ends", json!("natural")), "ends"),
        (
            automatic("constraints", json!([{"index": 7}])),
            "constraints",
        ),
        (automatic("end_points", json!("free")), "end_points"),
    ] {
        refused(&server, &job, "/curve/corners", reason).await;
    }
    let few = automatic("max_control_points", json!(5));
    refused(&server, &few, "/method/max_control_points", "at least 7").await;
    // What is no choice at all.
    for (corners, pointer) in [
        (json!("sharp"), "/curve/corners"),
        (json!([4.5]), "/curve/corners/0"),
        (json!({"angle": "wide"}), "/curve/corners/angle"),
        (json!({"degrees": 30}), "/curve/corners/degrees"),
        (json!(30), "/curve/corners"),
    ] {
        refused(&server, &curve(corners), pointer, "").await;
    }
}

#[tokio::test]
async fn messages_have_corners() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let points: Vec<f64> = zigzag().concat();
    let create = |choice| {
        let curve = pb::Curve {
            dimension: 2,
            points: points.clone(),
            corners: Some(pb::Corners {
                choice: Some(choice),
            }),
            ..Default::default()
        };
        let input = pb::JobInput {
            geometry: Some(pb::job_input::Geometry::Curve(curve)),
            ..Default::default()
        };
        pb::CreateJobRequest {
            input: Some(input),
            ..Default::default()
        }
    };
    use pb::corners::Choice;
    let job = client
        .create_job(create(Choice::Angle(30.0)))
        .await
        .unwrap()
        .into_inner();
    let id = job.job.unwrap().id;
    let input = client
        .get_input(pb::GetInputRequest { id })
        .await
        .unwrap()
        .into_inner();
    let Some(pb::job_input::Geometry::Curve(curve)) = input.input.unwrap().geometry else {
        panic!("no curve");
    };
    let expected = Choice::At(pb::Indices {
        indices: vec![4, 8, 12, 16, 20],
    });
    assert_eq!(curve.corners.unwrap().choice, Some(expected));
    let wrong = create(Choice::At(pb::Indices {
        indices: vec![4, 99],
    }));
    let status = client.create_job(wrong).await.unwrap_err();
    assert_eq!(status.code(), Code::InvalidArgument);
    assert!(
        format!("{status:?}").contains("curve.corners.at.indices[1]"),
        "{status:?}"
    );
}
