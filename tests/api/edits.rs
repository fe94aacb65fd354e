//! Edits: moving points, changing weights, methods and stop rules of a fit that is there.

use std::time::Duration;

use serde_json::{Value, json};

use crate::data;
use crate::numbers::largest_difference;
use crate::program::Program;
use crate::support::{Server, Story, problem};

fn path(job: &Value) -> &str {
    job["links"]["self"].as_str().unwrap()
}

/// Posts an edit and reads its stream.
async fn edit(server: &Server, parent: &Value, body: &Value) -> Story {
    let request = server.post(&format!("{}/edits", path(parent)));
    let request = request.header("accept", "text/event-stream").json(body);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 200, "{body}");
    Story::read(response).await
}

async fn assert_refused(
    server: &Server,
    parent: &Value,
    body: &Value,
    pointer: &str,
    reason: &str,
) {
    let request = server.post(&format!("{}/edits", path(parent))).json(body);
    let (status, problem) = problem(request.send().await.unwrap()).await;
    assert_eq!(status, 422, "{body}");
    assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem:#}");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains(reason), "{problem:#}");
}

fn wave(count: usize) -> Vec<Value> {
    let x = |i: usize| i as f64 * 0.3;
    (0..count).map(|i| json!([x(i), x(i).sin()])).collect()
}

/// An edit keeps the parameters and knots of its parent, and converges to the interpolant of the
/// moved points.
#[tokio::test]
async fn moved_points_are_interpolated_with_the_parameters_of_the_parent() {
    let server = Server::start().await;
    let tight = json!({"tolerance": 1e-12, "max_iterations": 3000});
    for (name, basis, closed) in [
        ("open", json!({"kind": "bspline", "degree": 4}), false),
        (
            "averaged",
            json!({"kind": "bspline", "knots": "averaged"}),
            false,
        ),
        ("closed", json!({"kind": "bspline", "degree": 2}), true),
        ("bernstein", json!({"kind": "bernstein"}), false),
    ] {
        let mut points = if closed {
            let circle = |i| f64::from(i) * std::f64::consts::TAU / 12.0;
            (0..12)
                .map(|i| json!([circle(i).cos(), circle(i).sin()]))
                .collect()
        } else {
            wave(8)
        };
        let parent =
            json!({"curve": {"points": points, "basis": basis, "closed": closed}, "stop": tight});
        let parent = server.stream(&parent).await.job;
        points[3] = json!([0.5, 2.5]);
        let moved =
            json!({"points": [{"index": 3, "point": points[3]}], "method": {"kind": "chebyshev"}});
        let story = edit(&server, &parent, &moved).await;
        // So far from its neighbours, the point makes all but the closed curve swing beside it.
        let reason = if closed {
            Value::Null
        } else {
            json!("between")
        };
        assert_eq!(story.end["reason"], reason, "{name}: {}", story.end);
        assert_eq!(story.job["knots"], parent["knots"], "{name}");
        assert_eq!(story.job["parameters"], parent["parameters"], "{name}");
        // The same from scratch; what was accepted can be posted again.
        let mut input = server.json(&format!("{}/input", path(&story.job))).await;
        assert_eq!(input["curve"]["points"], json!(points));
        input["method"] = json!({"kind": "direct"});
        let direct = server.stream(&input).await;
        let (edited, direct) = (story.iterations.last(), direct.iterations.last());
        let difference = largest_difference(
            &edited.unwrap()["control_points"],
            &direct.unwrap()["control_points"],
        );
        // The least eigenvalue of the Bernstein basis of degree 7 is 2e-3.
        assert!(difference < 2e-9, "{name}: {difference}");
    }
}

/// Classical PIA has no memory: it continues as if it had not been interrupted, bit for bit.
#[tokio::test]
async fn an_edit_starts_at_any_iteration_of_its_parent() {
    let server = Server::start().await;
    let parent = server.stream(&data::small_job()).await;
    let parent_id = parent.job["id"].clone();
    for from in [json!(4), json!("last")] {
        let k = from
            .as_u64()
            .map_or(parent.iterations.len() - 1, |k| k as usize);
        let stop = json!({"tolerance": 0, "max_iterations": 3});
        let story = edit(
            &server,
            &parent.job,
            &json!({"iteration": from, "stop": stop}),
        )
        .await;
        assert_eq!(story.state(), "exhausted");
        let own = parent.iterations[k..].iter().zip(&story.iterations);
        for (theirs, ours) in own {
            assert_eq!(ours["control_points"], theirs["control_points"]);
            assert_eq!(ours["error"], theirs["error"]);
        }
        let job = server.json(path(&story.job)).await;
        assert_eq!(job["parent"], json!({"id": parent_id, "iteration": k}));
    }
    let unedited = server.json(path(&parent.job)).await;
    assert!(unedited.get("parent").is_none());
}

#[tokio::test]
async fn local_edits_leave_the_rest_alone() {
    let server = Server::start().await;
    let parent = server
        .stream(&json!({"curve": {"points": wave(400)}}))
        .await;
    let before = parent.iterations.last().unwrap();
    let body = json!({
        "points": [{"index": 200, "point": [60.0, 1.5]}],
        "method": {"kind": "local", "indices": [199, 200, 201]},
    });
    let story = edit(&server, &parent.job, &body).await;
    assert_eq!(story.state(), "converged");
    assert_eq!(
        story.iterations[0]["control_points"],
        before["control_points"]
    );
    let after = &story.iterations.last().unwrap()["control_points"];
    for (index, point) in after.as_array().unwrap().iter().enumerate() {
        // One end copy stands in front.
        let adjusted = (200..=202).contains(&index);
        assert_eq!(
            *point != before["control_points"][index],
            adjusted,
            "{index}"
        );
    }
    // Adaptive fits find the points that need it by themselves.
    let body = json!({
        "points": [{"index": 200, "point": [60.0, 1.5]}],
        "method": {"kind": "adaptive", "threshold": 1e-4},
    });
    let story = edit(&server, &parent.job, &body).await;
    assert_eq!(story.state(), "converged");
    let moved = |k: usize| story.iterations[k]["moved"].as_u64().unwrap();
    assert_eq!(moved(1), 1);
    assert!((2..story.iterations.len()).all(|k| moved(k) < 40));
}

#[tokio::test]
async fn edits_of_edits_of_surfaces() {
    let server = Server::start().await;
    let grid: Vec<Vec<_>> = (0..9)
        .map(|i| {
            (0..7)
                .map(|j| json!([i, j, f64::from(i * j) * 0.1]))
                .collect()
        })
        .collect();
    let parent = server.stream(&json!({"surface": {"points": grid}})).await;
    let body = json!({"name": "bump", "points": [{"index": [4, 3], "point": [4, 3, 3]}]});
    let child = edit(&server, &parent.job, &body).await;
    assert_eq!(child.state(), "converged");
    assert_eq!(child.iterations[0]["error"]["at"], json!([4, 3]));
    let body = json!({"points": [{"index": [4, 3], "point": grid[4][3]}]});
    let grandchild = edit(&server, &child.job, &body).await;
    let (a, b) = (
        parent.iterations.last().unwrap(),
        grandchild.iterations.last().unwrap(),
    );
    let difference = largest_difference(&a["control_points"], &b["control_points"]);
    // Distances of 1e-6 of the diagonal, divided by the least eigenvalue 1/9, twice.
    assert!(difference < 2.5e-4, "{difference}");
    let job = server.json(path(&grandchild.job)).await;
    assert_eq!(job["parent"]["id"], child.job["id"]);
    assert_eq!(child.job["name"], "bump");
}

#[tokio::test]
async fn weights_are_added_and_changed() {
    let server = Server::start().await;
    let parent = json!({"curve": {"points": wave(6), "ends": "repeated"}});
    let parent = server.stream(&parent).await;
    let body = json!({"weights": [1, 1.2, 1, 1, 1.3, 1]});
    let weighted = edit(&server, &parent.job, &body).await;
    assert_eq!(weighted.state(), "converged");
    // The control points start where they are, with the new weights.
    assert_eq!(
        weighted.iterations[0]["control_points"],
        parent.iterations.last().unwrap()["control_points"]
    );
    assert_eq!(
        weighted.iterations[0]["weights"],
        json!([1.0, 1.0, 1.2, 1.0, 1.0, 1.3, 1.0, 1.0])
    );
    let fresh = json!({"curve": {"points": wave(6), "weights": [1, 1.2, 1, 1, 1.3, 1], "ends": "repeated"}});
    let fresh = server.stream(&fresh).await;
    let last = |story: &Story, field: &str| story.iterations.last().unwrap()[field].clone();
    for field in ["control_points", "weights"] {
        let difference = largest_difference(&last(&weighted, field), &last(&fresh, field));
        assert!(difference < 1e-4, "{field}: {difference}");
    }
    let body = json!({"points": [{"index": 1, "weight": 1}, {"index": 4, "weight": 1, "point": [1.2, 0.9]}]});
    let story = edit(&server, &weighted.job, &body).await;
    assert_eq!(story.state(), "converged");
    let input = server.json(&format!("{}/input", path(&story.job))).await;
    assert_eq!(
        input["curve"]["weights"],
        json!([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    );
    assert_eq!(input["curve"]["points"][4], json!([1.2, 0.9]));

    let fixed = json!({"weights": [1, 1.2, 1, 1, 1.3, 1], "rational": "fixed"});
    let fixed = edit(&server, &parent.job, &fixed).await;
    assert_eq!(fixed.job["rational"], "fixed");
    let refused = json!({"weights": [1, 1, 1, 1, 1, 1], "rational": "homogeneous"});
    assert_refused(
        &server,
        &fixed.job,
        &refused,
        "/rational",
        "stay homogeneous or fixed",
    )
    .await;
}

#[tokio::test]
async fn errors_of_edits_are_reported() {
    let server = Server::start().await;
    let curve = server
        .stream(&json!({"curve": {"points": wave(6)}}))
        .await
        .job;
    let grid: Vec<Vec<_>> = (0..4)
        .map(|i| (0..4).map(|j| json!([i, j, 0])).collect())
        .collect();
    let surface = server
        .stream(&json!({"surface": {"points": grid}}))
        .await
        .job;
    for (parent, body, pointer, reason) in [
        (&curve, json!({}), "", "changes something"),
        (&curve, json!({"name": "only"}), "", "changes something"),
        (&curve, json!({"points": []}), "", "changes something"),
        (
            &curve,
            json!({"points": [{"index": 6, "point": [0, 0]}]}),
            "/points/0/index",
            "not one of the 6",
        ),
        (
            &curve,
            json!({"points": [{"index": [1, 2], "point": [0, 0]}]}),
            "/points/0/index",
            "single indices",
        ),
        (
            &curve,
            json!({"points": [{"index": -1, "point": [0, 0]}]}),
            "/points/0/index",
            "index",
        ),
        (
            &curve,
            json!({"points": [{"index": 1, "point": [0, 0, 0]}]}),
            "/points/0/point",
            "3 coordinates",
        ),
        (
            &curve,
            json!({"points": [{"index": 1}]}),
            "/points/0",
            "a point or a weight",
        ),
        (
            &curve,
            json!({"points": [{"index": 1, "weight": 2}]}),
            "/points/0/weight",
            "homogeneous",
        ),
        (
            &curve,
            json!({"points": [{"index": 1, "point": [0, 0]}, {"index": 1, "point": [1, 0]}]}),
            "/points/1/index",
            "moved before",
        ),
        (
            &curve,
            json!({"points": [[1, [0, 0]]]}),
            "/points/0",
            "object",
        ),
        (&curve, json!({"weights": [1, 2]}), "/weights", "2 weights"),
        (
            &curve,
            json!({"weights": [1, 2], "points": [{"index": 3, "weight": 2}]}),
            "/weights",
            "2 weights for 6 points",
        ),
        (
            &curve,
            json!({"weights": [1, 2, 0, 1, 1, 1]}),
            "/weights/2",
            "greater than 0",
        ),
        (
            &curve,
            json!({"rational": "fixed"}),
            "/rational",
            "no weights",
        ),
        (
            &curve,
            json!({"method": {"kind": "adaptive"}}),
            "/method",
            "threshold",
        ),
        (
            &curve,
            json!({"method": {"kind": "local", "indices": [9]}}),
            "/method/indices/0",
            "9",
        ),
        (
            &curve,
            json!({"method": {"kind": "least_squares", "control_points": 4}}),
            "/method",
            "6 control points",
        ),
        (
            &curve,
            json!({"method": {"kind": "least_squares", "control_points": 6}}),
            "/method",
            "another basis",
        ),
        (
            &curve,
            json!({"stop": {"tolerance": -1}}),
            "/stop/tolerance",
            "zero or greater",
        ),
        (
            &curve,
            json!({"stop": {}, "iteration": 1000}),
            "/iteration",
            "before 1000",
        ),
        (
            &curve,
            json!({"stop": {}, "iteration": "first"}),
            "/iteration",
            "last",
        ),
        (&curve, json!({"curve": {}}), "/curve", "unknown field"),
        (
            &surface,
            json!({"points": [{"index": 3, "point": [0, 0, 0]}]}),
            "/points/0/index",
            "[row, column]",
        ),
        (
            &surface,
            json!({"points": [{"index": [0, 4], "point": [0, 0, 0]}]}),
            "/points/0/index",
            "outside",
        ),
    ] {
        assert_refused(&server, parent, &body, pointer, reason).await;
    }
    let unknown = json!({"links": {"self": "/v1/jobs/00000000-0000-0000-0000-000000000000"}});
    let request = server
        .post(&format!("{}/edits", path(&unknown)))
        .json(&json!({"stop": {}}));
    assert_eq!(request.send().await.unwrap().status(), 404);
}

#[tokio::test]
async fn a_running_fit_is_edited_at_its_level() {
    let server = Server::start().await;
    let parent = server.create(&data::endless_job()).await;
    let body = json!({"stop": {"tolerance": 0, "max_iterations": 2}});
    // If it has not begun, the edit waits for its first iteration.
    let request = server.post(&format!("{}/edits", path(&parent))).json(&body);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 201);
    let child: Value = response.json().await.unwrap();
    let k = child["parent"]["iteration"].as_u64().unwrap();
    let theirs = server
        .json(&format!("{}/iterations/{k}", path(&parent)))
        .await;
    // The parent is forgotten, the edit has all it needs.
    server.delete(path(&parent)).send().await.unwrap();
    let ours = server.json(&format!("{}/iterations/0", path(&child))).await;
    assert_eq!(ours["control_points"], theirs["control_points"]);
    server.stop().await;
}

#[tokio::test]
async fn an_edit_waits_for_a_parent_that_waits() {
    // Room for one job.
    let server = Server::with(|config| config.memory = Some("128KiB".parse().unwrap())).await;
    let busy = server.create(&data::endless_job()).await;
    let edit_of = |parent: &Value| {
        let request = server.post(&format!("{}/edits", path(parent)));
        let body = json!({"stop": {"tolerance": 0, "max_iterations": 2}});
        tokio::spawn(request.json(&body).send())
    };
    let cancel = |job: &Value| server.post(&format!("{}/cancel", path(job))).send();
    // A parent that never begins has nothing to start from.
    let given_up = server.create(&data::small_job()).await;
    let edit = edit_of(&given_up);
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(server.json(path(&given_up)).await["state"], "queued");
    assert!(!edit.is_finished());
    cancel(&given_up).await.unwrap();
    let (status, body) = problem(edit.await.unwrap().unwrap()).await;
    assert_eq!(status, 422);
    let mistake = &body["errors"][0];
    assert_eq!(mistake["pointer"], "/iteration");
    let detail = "the job is cancelled and has no iteration to start from";
    assert_eq!(mistake["detail"], detail);
    let parent = server.create(&data::small_job()).await;
    let edit = edit_of(&parent);
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert!(!edit.is_finished());
    cancel(&busy).await.unwrap();
    assert_eq!(edit.await.unwrap().unwrap().status(), 201);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_is_the_same_after_a_restart() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let parent = program.fit(&data::small_job()).await;
    let body = json!({"points": [{"index": 7, "point": [1, 1]}], "method": {"kind": "local", "indices": [6, 7]}});
    let request = program.post(&format!("{}/edits", path(&parent)));
    let request = request.header("accept", "text/event-stream").json(&body);
    let story = Story::read(request.send().await.unwrap()).await;
    program.kill();
    let program = Program::start(data.path());
    let events = format!("{}/events", path(&story.job));
    let again = Story::read(program.get(&events).send().await.unwrap()).await;
    // What is found out at the end of the fit is known in the meantime.
    let begun = |mut job: Value| {
        job["warnings"].take();
        job
    };
    assert_eq!(begun(again.job), begun(story.job.clone()));
    assert_eq!(again.iterations, story.iterations);
    assert_eq!(
        program.json(path(&story.job)).await["parent"]["id"],
        parent["id"]
    );
}
