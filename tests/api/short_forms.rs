//! Short forms mean the long ones and nothing else.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, base};

fn with(mut job: Value, object: Option<&str>, field: &str, value: Value) -> Value {
    match object {
        None => job[field] = value,
        Some(object) => job[object][field] = value,
    }
    job
}

fn curve() -> Value {
    json!({"curve": {"points": data::wave(12)}})
}

fn surface() -> Value {
    json!({"surface": {"points": data::peaks(6)}})
}

#[tokio::test]
async fn short_forms_are_the_long_ones() {
    let server = Server::start().await;
    let bspline = |degree: u32| json!({"kind": "bspline", "degree": degree});
    let mut cases = Vec::new();
    for kind in ["bspline", "bernstein", "said_ball", "wang_ball"] {
        let (short, long) = (json!(kind), json!({"kind": kind}));
        cases.push((
            curve(),
            Some("curve"),
            ("basis", short.clone()),
            ("basis", long.clone()),
        ));
        let short = json!({"u": short, "v": "bspline"});
        let long = json!({"u": long, "v": {"kind": "bspline"}});
        cases.push((
            surface(),
            Some("surface"),
            ("basis", short),
            ("basis", long),
        ));
    }
    for kind in [
        "global",
        "weighted",
        "extended",
        "transpose",
        "convex",
        "chebyshev",
        "direct",
    ] {
        cases.push((
            curve(),
            None,
            ("method", json!(kind)),
            ("method", json!({"kind": kind})),
        ));
    }
    cases.push((
        curve(),
        Some("curve"),
        ("degree", json!(2)),
        ("basis", bspline(2)),
    ));
    cases.push((
        surface(),
        Some("surface"),
        ("degree", json!(2)),
        ("basis", bspline(2)),
    ));
    let each = json!({"u": bspline(1), "v": bspline(4)});
    let degrees = json!({"u": 1, "v": 4});
    cases.push((
        surface(),
        Some("surface"),
        ("degree", degrees),
        ("basis", each),
    ));
    for (job, object, short, long) in cases {
        let mut inputs = Vec::new();
        for (field, value) in [short, long] {
            let job = with(job.clone(), object, field, value);
            let created = server.create(&job).await;
            inputs.push(server.json(&format!("{}/input", base(&created))).await);
        }
        assert_eq!(inputs[0], inputs[1]);
    }
    // In edits, too.
    let parent = server.fit(&curve()).await;
    let edit = server.post(&format!("{}/edits", base(&parent)));
    let response = edit
        .json(&json!({"method": "direct"}))
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 201);
    let job: Value = response.json().await.unwrap();
    assert_eq!(job["method"], json!({"kind": "direct"}));
}

#[tokio::test]
async fn errors_of_short_forms_have_locations() {
    let server = Server::start().await;
    let both = with(curve(), Some("curve"), "basis", json!("bspline"));
    for (job, pointer, reason) in [
        (
            with(curve(), None, "method", json!("local")),
            "/method",
            "indices",
        ),
        (
            with(curve(), None, "method", json!("adaptive")),
            "/method",
            "threshold",
        ),
        (
            with(curve(), None, "method", json!("least_squares")),
            "/method",
            "control_points",
        ),
        (
            with(curve(), None, "method", json!("lspia")),
            "/method",
            "unknown kind of method \"lspia\"",
        ),
        (
            with(curve(), Some("curve"), "basis", json!("nurbs")),
            "/curve/basis",
            "unknown kind of basis",
        ),
        (
            with(curve(), Some("curve"), "degree", json!(0)),
            "/curve/degree",
            "below 1",
        ),
        (
            with(
                surface(),
                Some("surface"),
                "degree",
                json!({"u": 3, "v": 2000}),
            ),
            "/surface/degree/v",
            "above 1000",
        ),
        (
            with(both, Some("curve"), "degree", json!(3)),
            "/curve/degree",
            "a basis is given",
        ),
    ] {
        server.assert_refused(&job, pointer, reason).await;
    }
}

/// What people try first, with what to do instead.
#[tokio::test]
async fn points_in_other_forms_are_explained() {
    let server = Server::start().await;
    let rows = json!([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]]);
    let objects = json!([{"x": 0, "y": 0}, {"x": 1, "y": 1}]);
    let coordinates = json!({"x": [0, 1], "y": [0, 1]});
    for (job, pointer, reason) in [
        (
            json!({"curve": {"points": rows}}),
            "/curve/points/0/0",
            "\"surface\"",
        ),
        (
            json!({"curve": {"points": objects}}),
            "/curve/points/0",
            "[x, y]",
        ),
        (
            json!({"curve": {"points": coordinates}}),
            "/curve/points",
            "[[x, y], …]",
        ),
        (
            json!({"curve": {"points": [0, 1, 2]}}),
            "/curve/points/0",
            "a list of 1 to 16 numbers",
        ),
        (
            json!({"surface": {"points": [[0, 0], [1, 1]]}}),
            "/surface/points/0",
            "a list of points is a curve",
        ),
        (
            json!({"surface": {"points": [objects]}}),
            "/surface/points/0/0",
            "[x, y, z]",
        ),
    ] {
        server.assert_refused(&job, pointer, reason).await;
    }
}
