//! Constraints, end points, weights of data and fairness that cannot be.

use serde_json::{Value, json};

use crate::constraints::wave;
use crate::data;
use crate::numbers::flat;
use crate::support::{Server, problem};

/// Interpolated ends are conditions like the others.
#[tokio::test]
async fn ends_count() {
    let server = Server::start().await;
    let points = json!([[0, 0], [2, 3], [5, 4], [8, 3], [10, 0]]);
    let job = |more: Value| {
        let mut method = json!({"kind": "least_squares", "control_points": 4, "variant": "direct"});
        let more = more.as_object().unwrap().clone();
        method.as_object_mut().unwrap().extend(more);
        json!({"curve": {"points": points}, "method": method})
    };
    let three = json!([{"index": 1}, {"index": 2}, {"index": 3}]);
    let asked = server
        .post("/v1/jobs")
        .json(&job(json!({"constraints": three})));
    let (_, found) = problem(asked.send().await.unwrap()).await;
    let error = &found["errors"][0];
    assert_eq!(error["pointer"], "/method/constraints/2", "{found}");
    let detail = error["detail"].as_str().unwrap();
    for part in [
        "the interpolated start, the interpolated end, constraint 0 and constraint 1",
        "\"end_points\": \"free\"",
    ] {
        assert!(detail.contains(part), "{detail}");
    }
    let free = job(json!({"constraints": three, "end_points": "free"}));
    assert_eq!(server.fit(&free).await["state"], "converged");
    // What follows from others may be said.
    let twice =
        json!([{"index": 0}, {"index": 2}, {"index": 2}, {"at": {"index": 4}, "point": [10, 0]}]);
    let twice = server.stream(&job(json!({"constraints": twice}))).await;
    let once = server
        .stream(&job(json!({"constraints": [{"index": 2}]})))
        .await;
    let [twice, once] = [twice, once].map(|it| flat(&it.iterations[1]["control_points"]));
    // But for rounding: the data are at most 10.
    for (a, b) in twice.iter().zip(&once) {
        assert!((a - b).abs() < 1e-13, "{twice:?} {once:?}");
    }
    // Explicitly requested ends are not replaced.
    let other =
        json!({"constraints": [{"at": "end", "point": [9, 0]}], "end_points": "interpolated"});
    let asked = server.post("/v1/jobs").json(&job(other));
    let (_, found) = problem(asked.send().await.unwrap()).await;
    let detail = found["errors"][0]["detail"].as_str().unwrap();
    assert!(
        detail.contains("the interpolated end, with which it differs by 1.000e0"),
        "{detail}"
    );
}

/// Errors name the constraint and a remedy.
#[tokio::test]
async fn constraints_that_cannot_be_are_refused() {
    let server = Server::start().await;
    let curve = |method: Value| json!({"curve": {"points": wave(30)}, "method": method});
    let surface = |method: Value| json!({"surface": {"points": data::peaks(8)}, "method": method});
    let with = |constraints: Value| json!({"kind": "least_squares", "control_points": 8, "constraints": constraints});
    let setting = |name: &str, value: Value| json!({"kind": "least_squares", "control_points": 8, name: value});
    let across: Vec<[f64; 3]> = vec![[0.0; 3]; 8];
    for (job, pointer, reason) in [
        (
            curve(with(json!([{"index": 30}]))),
            "/method/constraints/0",
            "data point 30, but there are 30",
        ),
        (
            curve(with(
                json!([{"index": 3}, {"at": {"index": 3}, "point": [0, 0, 0]}]),
            )),
            "/method/constraints/1",
            "together with constraint 0, with which it differs by",
        ),
        (
            curve(with(
                json!([{"at": "end", "derivative": [1, 0, 0]}, {"at": "end", "tangent": [-1, 0, 0]}]),
            )),
            "/method/constraints/1",
            "together with constraint 0",
        ),
        (
            curve(with(
                json!([{"at": "start", "point": [0, 0, 0]}, {"index": 0}]),
            )),
            "/method/constraints/1",
            "together with constraint 0",
        ),
        (
            curve(with(
                json!([{"index": 1}, {"index": 2}, {"index": 3}, {"index": 4}, {"index": 5}]),
            )),
            "/method/constraints/3",
            "together with the interpolated start, constraint 0, constraint 1 and constraint 2",
        ),
        (
            curve(with(json!([{"at": {"parameter": -1}, "point": [0, 0, 0]}]))),
            "/method/constraints/0",
            "outside",
        ),
        (
            curve(with(json!([{"at": "start", "point": [0, 0]}]))),
            "/method/constraints/0",
            "2 coordinates, the data have 3",
        ),
        (
            curve(with(json!([{"at": "start", "tangent": [0, 0, 0]}]))),
            "/method/constraints/0",
            "length zero",
        ),
        (
            curve(with(json!([{"at": "middle", "point": [0, 0, 0]}]))),
            "/method/constraints/0/at",
            "\"middle\"",
        ),
        (
            curve(with(
                json!([{"at": {"index": 1, "parameter": 2}, "point": [0, 0, 0]}]),
            )),
            "/method/constraints/0/at",
            "one of index, parameter and boundary",
        ),
        (
            curve(with(json!([{"at": "start"}]))),
            "/method/constraints/0",
            "needs a point or a derivative",
        ),
        (
            curve(with(
                json!([{"at": "start", "point": [0, 0, 0], "tangent": [0, 0, 1]}]),
            )),
            "/method/constraints/0",
            "tangent is another",
        ),
        (
            curve(with(json!([{"at": "start", "derivative_u": [0, 0, 1]}]))),
            "/method/constraints/0",
            "derivative_u is for surfaces",
        ),
        (
            curve(with(
                json!([{"at": {"boundary": "u_start"}, "control_points": across}]),
            )),
            "/method/constraints/0",
            "for surfaces",
        ),
        (
            curve(with(json!([{"at": "start", "point": [[0, 0, 0]]}]))),
            "/method/constraints/0",
            "point is a vector",
        ),
        (
            curve(with(json!([{"at": "start", "poin": [0, 0, 0]}]))),
            "/method/constraints/0/poin",
            "unknown field",
        ),
        (
            curve(with(json!([{}]))),
            "/method/constraints/0",
            "has an index, or at",
        ),
        (
            surface(with(json!([{"index": 3}]))),
            "/method/constraints/0",
            "[row, column]",
        ),
        (
            surface(with(json!([{"at": "start", "point": [0, 0, 0]}]))),
            "/method/constraints/0",
            "a surface has boundaries",
        ),
        (
            surface(with(
                json!([{"at": {"boundary": "u_start"}, "control_points": across[1..]}]),
            )),
            "/method/constraints/0",
            "7 control points along a boundary of 8",
        ),
        (
            surface(with(
                json!([{"at": {"boundary": "u_top"}, "control_points": across}]),
            )),
            "/method/constraints/0/at/boundary",
            "u_top",
        ),
        (
            surface(with(
                json!([{"at": {"boundary": "u_start"}, "point": [0, 0, 0]}]),
            )),
            "/method/constraints/0",
            "along a boundary",
        ),
        (
            curve(setting("end_points", json!("closed"))),
            "/method/end_points",
            "interpolated",
        ),
        (
            curve(setting("fairness", json!(-1))),
            "/method/fairness",
            "zero or greater",
        ),
        (
            curve(setting("gap_stiffness", json!(0.1))),
            "/method/gap_stiffness",
            "this is a curve",
        ),
        (
            surface(setting("gap_stiffness", json!(-1))),
            "/method/gap_stiffness",
            "zero or greater",
        ),
        (
            curve(setting("fairness_order", json!(2))),
            "/method/fairness_order",
            "which is not given",
        ),
        (
            curve(setting("data_weights", json!([1, 2]))),
            "/method/data_weights",
            "2 weights of data for 30 points",
        ),
        (
            curve(setting("data_weights", json!(vec![0; 30]))),
            "/method/data_weights",
            "all weights of data are zero",
        ),
        (
            surface(setting("data_weights", json!([1, 2]))),
            "/method/data_weights",
            "rows of numbers",
        ),
        (
            json!({"curve": {"points": wave(30)}, "method": {"kind": "global", "end_points": "free"}}),
            "/method/end_points",
            "unknown field \"end_points\"",
        ),
    ] {
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (_, found) = problem(response).await;
        let error = &found["errors"][0];
        assert_eq!(error["pointer"], pointer, "{found}");
        assert!(
            error["detail"].as_str().unwrap().contains(reason),
            "{found}"
        );
    }
    let mut negative = vec![1.0; 30];
    negative[7] = -2.0;
    let mut fair = setting("fairness", json!(1));
    fair["fairness_order"] = json!(4);
    let closed = json!({"curve": {"points": wave(30), "closed": true}, "method": setting("end_points", json!("interpolated"))});
    for (job, pointer, reason) in [
        (
            curve(setting("data_weights", json!(negative))),
            "/method/data_weights/7",
            "not negative",
        ),
        (
            curve(fair),
            "/method/fairness_order",
            "is 4; expected 2 or 3",
        ),
        (closed, "/method/end_points", "closed"),
    ] {
        let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
        let (_, found) = problem(response).await;
        assert_eq!(found["errors"][0]["pointer"], pointer, "{found}");
        assert!(
            found["errors"][0]["detail"]
                .as_str()
                .unwrap()
                .contains(reason),
            "{found}"
        );
    }
}
