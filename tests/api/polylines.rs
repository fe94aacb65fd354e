//! Polylines, whose edges are data, too.

use serde_json::{Value, json};

use crate::numbers::numbers;
use crate::support::{Server, Story, base, problem};

/// A plate with round corners: edges have two points, arcs one every 7.5 degrees.
fn plate() -> Vec<[f64; 2]> {
    let centres = [[105.0, 15.0], [105.0, 55.0], [15.0, 55.0], [15.0, 15.0]];
    let arc = |(corner, centre): (usize, &[f64; 2])| {
        let [x, y] = *centre;
        (0..=12).map(move |k| {
            let quarter = std::f64::consts::FRAC_PI_2;
            let angle = (corner as f64 - 1.0 + f64::from(k) / 12.0) * quarter;
            [x + 15.0 * angle.cos(), y + 15.0 * angle.sin()]
        })
    };
    centres.iter().enumerate().flat_map(arc).collect()
}

fn distance(point: &[f64], polyline: &[[f64; 2]]) -> f64 {
    let to_edge = |i: usize| {
        let (a, b) = (polyline[i], polyline[(i + 1) % polyline.len()]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy);
        let along = along.clamp(0.0, 1.0);
        (point[0] - a[0] - along * dx).hypot(point[1] - a[1] - along * dy)
    };
    (0..polyline.len())
        .map(to_edge)
        .fold(f64::INFINITY, f64::min)
}

/// As few control points as all edges need; without a method it is the one that polylines have.
#[tokio::test]
async fn all_points_of_all_edges_are_near() {
    let server = Server::start().await;
    let plate = plate();
    for (tolerance, most) in [(0.1, 32), (0.01, 180)] {
        let job = json!({
            "curve": {"points": plate, "closed": true, "polyline": true},
            "stop": {"tolerance": tolerance},
        });
        let story = server.stream(&job).await;
        assert_eq!(story.state(), "converged", "{}", story.end);
        assert_eq!(story.job["method"]["control_points"], "auto");
        assert_eq!(story.job["points"], plate.len());
        let last = story.iterations.last().unwrap();
        let count = last["control_points"].as_array().unwrap().len();
        assert!(count <= most, "{tolerance}: {count}");
        let path = format!("{}/result?view=samples&samples=3000", base(&story.job));
        let samples = server.json(&path).await["samples"].take();
        let points = samples.as_array().unwrap().iter().map(numbers);
        let off = points
            .map(|point| distance(&point, &plate))
            .fold(0.0, f64::max);
        assert!(off <= 1.001 * tolerance, "{tolerance}: {off}");
    }
}

/// Corners are where the edges turn; the input of the job makes the same job again, and edits move vertices.
#[tokio::test]
async fn polylines_keep_their_corners() {
    let server = Server::start().await;
    let square = [[0.0, 0.0], [2.8, 0.0], [2.8, 2.8], [0.0, 2.8]];
    let job = json!({
        "curve": {"points": square, "closed": true, "polyline": true},
        "stop": {"tolerance": 1e-6},
    });
    let parent = server.stream(&job).await;
    assert_eq!(parent.state(), "converged");
    assert_eq!(parent.job["corners"], json!([0, 1, 2, 3]));
    let last = parent.iterations.last().unwrap();
    assert_eq!(last["control_points"].as_array().unwrap().len(), 13);
    let input = server.json(&format!("{}/input", base(&parent.job))).await;
    assert_eq!(input["curve"]["polyline"], true);
    let again = server.stream(&input).await;
    assert_eq!(
        again.iterations.last().unwrap()["control_points"],
        last["control_points"]
    );
    let edit = json!({"points": [{"index": 2, "point": [3, 3]}]});
    let request = server
        .post(&format!("{}/edits/stream", base(&parent.job)))
        .json(&edit);
    let edited = Story::read(request.send().await.unwrap()).await;
    assert_eq!(edited.state(), "converged", "{}", edited.end);
    let net = edited.iterations.last().unwrap()["control_points"]
        .as_array()
        .unwrap();
    assert!(net.contains(&json!([3.0, 3.0])), "{net:?}");
}

#[tokio::test]
async fn invalid_polylines_are_named() {
    let server = Server::start().await;
    let bend = json!([[0, 0], [1, 0], [1, 1]]);
    let with = |points: &Value, method: Value| {
        let mut job = json!({"curve": {"points": points, "polyline": true}});
        if !method.is_null() {
            job["method"] = method;
        }
        job
    };
    let least_squares = |field: &str, value: Value| json!({"kind": "least_squares", "control_points": "auto", field: value});
    for (job, pointer, reason) in [
        (
            with(&json!([[0, 0], [1, 0]]), Value::Null),
            "/curve/points",
            "two edges",
        ),
        (
            with(&json!([[0, 0], [1, 0], [0.5, 0]]), Value::Null),
            "/curve/points/1",
            "turns back",
        ),
        (
            with(&json!([[0, 0], [1, 0], [1, 0]]), Value::Null),
            "/curve/points/2",
            "equals",
        ),
        (
            with(&json!([[0], [1], [0]]), Value::Null),
            "/curve/polyline",
            "one coordinate",
        ),
        (with(&bend, json!("global")), "/curve/polyline", "auto"),
        (
            with(&bend, json!({"kind": "least_squares", "control_points": 3})),
            "/curve/polyline",
            "auto",
        ),
        (
            with(&bend, least_squares("fairness", json!(1e-9))),
            "/curve/polyline",
            "fairness",
        ),
        (
            with(&bend, least_squares("data_weights", json!([1, 1, 1]))),
            "/curve/polyline",
            "weights",
        ),
        (
            with(&bend, least_squares("correct_parameters", json!(true))),
            "/curve/polyline",
            "stay",
        ),
        (
            with(&bend, least_squares("end_points", json!("free"))),
            "/curve/polyline",
            "ends",
        ),
    ] {
        let (status, problem) =
            problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
        assert_eq!(status, 422, "{job}");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem:#}");
        let detail = problem["errors"][0]["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{detail}");
    }
}
