//! Ephemeral edits: frames of a drag, which are streamed and leave nothing behind.

use std::pin::pin;
use std::time::Duration;

use futures_util::StreamExt;
use reqwest::Response;
use serde_json::{Value, json};
use tokio::time::timeout;

use crate::changed::apply;
use crate::data;
use crate::support::{NEVER, PATIENCE, Server, Story, base, events, problem};

/// Asks for the stream of an edit.
async fn send(server: &Server, parent: &Value, query: &str, body: &Value) -> Response {
    let path = format!("{}/edits/stream{query}", base(parent));
    server.post(&path).json(body).send().await.unwrap()
}

async fn stream(server: &Server, parent: &Value, query: &str, body: &Value) -> Story {
    let response = send(server, parent, query, body).await;
    assert_eq!(response.status(), 200, "{body}");
    Story::read(response).await
}

/// The edit that moves point 3 to this height.
fn drag(height: f64) -> Value {
    json!({"points": [{"index": 3, "point": [0.9, height]}], "ephemeral": true})
}

fn parent() -> Value {
    json!({"curve": {"points": data::wave(40)}})
}

#[tokio::test]
async fn an_edit_is_streamed_and_leaves_nothing() {
    let server = Server::start().await;
    let parent = server.fit(&parent()).await;
    let mut kept = drag(2.5);
    kept["ephemeral"] = json!(false);
    let kept = stream(&server, &parent, "", &kept).await;
    // Old jobs are looked for after a job has ended.
    tokio::time::sleep(Duration::from_millis(300)).await;
    let before = server.metrics().await;
    for _ in 0..20 {
        let response = send(&server, &parent, "", &drag(2.5)).await;
        assert_eq!(response.headers().get("location"), None);
        let story = Story::read(response).await;
        // The same fit.
        assert_eq!(story.iterations, kept.iterations);
        assert_eq!(story.state(), "converged");
        for name in ["knots", "parameters", "method", "stop", "weights"] {
            assert_eq!(story.job[name], kept.job[name], "{name}");
        }
        assert_eq!(story.job["links"], Value::Null);
        assert_eq!(story.end["links"], Value::Null);
        let path = format!("/v1/jobs/{}", story.job["id"].as_str().unwrap());
        for part in ["", "/result", "/events", "/input"] {
            let response = server.get(&format!("{path}{part}")).send().await.unwrap();
            assert_eq!(problem(response).await.0, 404, "{part}");
        }
    }
    let after = server.metrics().await;
    for name in [
        "piad_store_writes_total",
        "piad_jobs_accepted_total",
        "piad_jobs_ended_total{state=\"converged\"}",
    ] {
        assert_eq!(after[name], before[name], "{name}");
    }
    assert_eq!(after["piad_ephemeral_edits_total"], 20.0);
    server.until("piad_jobs_running", 0.0).await;
    let jobs = server.json("/v1/jobs").await;
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 2);
    server.stop().await;
}

/// A surface of 7 by 9 points.
fn surface() -> Value {
    let point = |i: usize, j: usize| json!([i, j, ((i * j) as f64).sin()]);
    let row = |i: usize| (0..9).map(|j| point(i, j)).collect::<Vec<_>>();
    json!({"surface": {"points": (0..7).map(row).collect::<Vec<_>>()}})
}

/// The client has the control points of the parent, so that the first event says only what is different
/// from these: nothing but copies at the ends whose derivatives are estimated, and weights.
#[tokio::test]
async fn changes_are_relative_to_the_parent() {
    let server = Server::start().await;
    let weighted = json!({"curve": {"points": data::wave(40), "weights": vec![1.5; 40]}});
    let local = |points: Value, indices: Value| json!({"points": points, "method": {"kind": "local", "indices": indices}});
    let inside = json!([{"index": 20, "point": [0.9, 2.5]}]);
    let near_end = json!([{"index": 2, "point": [0.9, 2.5]}]);
    let heavier = json!([{"index": 20, "weight": 3.0}]);
    let lifted = json!([{"index": [1, 4], "point": [1, 4, 3]}]);
    for (job, edit, first) in [
        (parent(), json!({"points": inside}), 0..=0),
        (parent(), local(inside, json!([19, 20, 21])), 0..=0),
        (parent(), local(near_end, json!([1, 2, 3])), 1..=2),
        (weighted, local(heavier, json!([19, 20, 21])), 1..=1),
        (surface(), local(lifted, json!([[1, 4], [2, 4]])), 1..=30),
    ] {
        let parent = server.fit(&job).await;
        let mut edit = edit;
        edit["ephemeral"] = json!(true);
        let whole = stream(&server, &parent, "", &edit).await;
        let story = stream(&server, &parent, "?changed=true&describe=none", &edit).await;
        assert_eq!(story.iterations.len(), whole.iterations.len());
        let changed = story.iterations[0]["changed"].as_array().unwrap();
        assert!(first.contains(&changed.len()), "{edit}: {changed:?}");
        let mut net = server.json(&format!("{}/result", base(&parent))).await;
        for (event, whole) in story.iterations.iter().zip(&whole.iterations) {
            if event.get("control_points").is_some() {
                net = event.clone();
            } else {
                apply(&mut net, event);
            }
            assert_eq!(net["control_points"], whole["control_points"], "{edit}");
            assert_eq!(net.get("weights"), whole.get("weights"), "{edit}");
        }
    }
    server.stop().await;
}

#[tokio::test]
async fn descriptions_can_be_short() {
    let server = Server::start().await;
    let mut job = parent();
    job["rational"] = json!("fixed");
    job["curve"]["weights"] = json!(vec![2.0; 40]);
    job["stream"] = json!({"describe": "none"});
    let parent = server.fit(&job).await;
    assert_eq!(parent["stream"], json!({"describe": "none"}));
    let events_of = async |query: &str| {
        let path = format!("{}/events{query}", base(&parent));
        Story::read(server.get(&path).send().await.unwrap()).await
    };
    let full = events_of("?describe=full").await;
    let arrays = ["knots", "parameters", "weights"];
    for query in ["", "?describe=none", "?encoding=base64"] {
        let short = events_of(query).await;
        let mut expected = full.job.clone();
        for name in arrays {
            assert!(expected.as_object_mut().unwrap().remove(name).is_some());
        }
        assert_eq!(short.job, expected, "{query}");
        assert_eq!(short.iterations.len(), full.iterations.len());
    }
    let path = format!("{}/events?describe=all", base(&parent));
    let (status, answer) = problem(server.get(&path).send().await.unwrap()).await;
    assert_eq!(
        (status, &answer["errors"][0]["parameter"]),
        (400, &json!("describe"))
    );
    server.stop().await;
}

/// A fit that does not end by itself, of the same points.
fn endless(session: &str) -> Value {
    let mut edit = drag(1.5);
    edit["stop"] = json!({"tolerance": 0, "max_iterations": 1_000_000_000});
    edit["session"] = json!(session);
    edit
}

#[tokio::test]
async fn an_edit_replaces_the_one_before_of_its_session() {
    let server = Server::start().await;
    let one = server.fit(&parent()).await;
    let other = server.fit(&parent()).await;
    let begin = async |parent: &Value, session: &str| {
        let mut events = events(send(&server, parent, "?pace=latest", &endless(session)).await);
        assert_eq!(events.next().await.unwrap().name, "job");
        events
    };
    let first = begin(&one, "a").await;
    let mut elsewhere = begin(&other, "a").await;
    let mut different = begin(&one, "b").await;
    server.until("piad_jobs_running", 3.0).await;
    let mut second = begin(&one, "a").await;
    let last = pin!(first)
        .fold(None, async |_, event| Some(event))
        .await
        .unwrap();
    assert_eq!(
        (last.name.as_str(), &last.data["state"]),
        ("end", &json!("cancelled"))
    );
    // No other stream has ended.
    server.until("piad_jobs_running", 3.0).await;
    for stream in [&mut elsewhere, &mut different, &mut second] {
        assert_eq!(stream.next().await.unwrap().name, "iteration");
    }
    // Neither does an edit that is kept, nor one without a session.
    let mut kept = drag(2.0);
    assert_eq!(stream(&server, &one, "", &kept).await.state(), "converged");
    kept["ephemeral"] = json!(false);
    assert_eq!(stream(&server, &one, "", &kept).await.state(), "converged");
    server.until("piad_jobs_running", 3.0).await;
    drop((elsewhere, different, second));
    server.until("piad_jobs_running", 0.0).await;
    server.stop().await;
}

/// It ends with its connection, and gives back its memory, wherever it is.
#[tokio::test]
async fn an_edit_ends_with_its_connection() {
    // There is memory for one of these fits at a time.
    let server = Server::with(|config| config.memory = Some(bytesize::ByteSize::kib(240))).await;
    let job = server
        .fit(&json!({"curve": {"points": data::wave(100)}}))
        .await;
    let read = |session: &str| {
        let path = format!("{}/edits/stream?pace=latest", base(&job));
        let answer = server.post(&path).json(&endless(session)).send();
        tokio::spawn(async { answer.await.unwrap().bytes().await })
    };
    let running = read("a");
    server.until("piad_jobs_running", 1.0).await;
    // Those for which there is no memory wait for it, and go when their clients do.
    let waiting = ["b", "c"].map(read);
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert!(waiting.iter().all(|it| !it.is_finished()));
    assert_eq!(server.metrics().await["piad_jobs_running"], 1.0);
    waiting.iter().for_each(|it| it.abort());
    // A newer edit of the session takes over the memory of the previous one, whose stream ends with a reason.
    let newer = send(&server, &job, "?pace=latest", &endless("a")).await;
    assert_eq!(newer.status(), 200);
    let reported = timeout(PATIENCE, running).await.unwrap().unwrap().unwrap();
    assert!(String::from_utf8_lossy(&reported).contains("\"state\":\"cancelled\""));
    server.until("piad_jobs_running", 1.0).await;
    drop(newer);
    server.until("piad_jobs_running", 0.0).await;
    server.until("piad_streams_open", 0.0).await;
    assert_eq!(
        stream(&server, &job, "", &drag(1.0)).await.state(),
        "converged"
    );
    server.stop().await;
}

#[tokio::test]
async fn a_server_that_stops_ends_them() {
    // Waiting for the grace period would take forever.
    let server = Server::with(|config| config.grace = NEVER).await;
    let job = server.fit(&parent()).await;
    let mut events = events(send(&server, &job, "?pace=latest", &endless("a")).await);
    events.next().await.unwrap();
    server.stop().await;
}

#[tokio::test]
async fn ephemeral_edits_must_be_streamed() {
    let server = Server::start().await;
    let job = server.fit(&parent()).await;
    let path = format!("{}/edits", base(&job));
    let request = server.post(&path).json(&drag(1.0));
    let (status, answer) = problem(request.send().await.unwrap()).await;
    assert_eq!(
        (status, &answer["errors"][0]["pointer"]),
        (422, &json!("/ephemeral"))
    );
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains("/edits/stream"), "{detail}");
    // With the Accept header there is a stream.
    let request = server.post(&path).header("accept", "application/x-ndjson");
    let response = request.json(&drag(1.0)).send().await.unwrap();
    let lines = response.text().await.unwrap();
    assert!(
        lines.lines().last().unwrap().contains("\"converged\""),
        "{lines}"
    );

    let request = server.post(&format!("{path}/stream")).json(&drag(1.0));
    let response = request.header("idempotency-key", "x").send().await.unwrap();
    let (status, answer) = problem(response).await;
    assert_eq!(
        (status, &answer["errors"][0]["header"]),
        (400, &json!("Idempotency-Key"))
    );

    for (session, ephemeral, reason) in [
        (json!("a"), json!(false), "only ephemeral"),
        (json!("a"), Value::Null, "only ephemeral"),
        (json!(""), json!(true), "1 to 100"),
        (json!("a".repeat(101)), json!(true), "1 to 100"),
    ] {
        let mut edit = drag(1.0);
        (edit["session"], edit["ephemeral"]) = (session, ephemeral);
        let (status, answer) = problem(send(&server, &job, "", &edit).await).await;
        assert_eq!(
            (status, &answer["errors"][0]["pointer"]),
            (422, &json!("/session"))
        );
        assert!(
            answer["detail"].as_str().unwrap().contains(reason),
            "{answer}"
        );
    }
    // A job is no edit.
    server
        .assert_refused(
            &json!({"curve": {"points": data::wave(5)}, "ephemeral": true}),
            "/ephemeral",
            "",
        )
        .await;
    assert_eq!(
        server.json("/v1/jobs").await["jobs"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    server.stop().await;
}

/// Also of a parent that is in no memory: with room for it, it stays there while it is edited.
#[tokio::test]
async fn parents_are_read_from_the_store() {
    for recent in [0, 64 << 20] {
        let server = Server::with(|config| config.recent = bytesize::ByteSize(recent)).await;
        let first = server
            .fit(&json!({"curve": {"points": data::wave(200)}}))
            .await;
        // Whatever there was of it, others have taken its place.
        for _ in 0..3 {
            server
                .fit(&json!({"curve": {"points": data::wave(3000)}}))
                .await;
        }
        let kept = stream(
            &server,
            &first,
            "",
            &json!({"points": [{"index": 3, "point": [0.9, 1.5]}]}),
        )
        .await;
        for _ in 0..3 {
            assert_eq!(
                stream(&server, &first, "", &drag(1.5)).await.iterations,
                kept.iterations
            );
        }
        let gone = server.delete(base(&first)).send().await.unwrap();
        assert_eq!(gone.status(), 204);
        assert_eq!(
            problem(send(&server, &first, "", &drag(1.5)).await).await.0,
            404
        );
        server.stop().await;
    }
}

/// Large fits: 10⁵ points of which a few are fitted again, as the page asks for it.
#[tokio::test]
async fn a_point_of_many_is_dragged() {
    let server = Server::start().await;
    let points = data::wave(100_000);
    let at = points[5000].clone();
    let parent = server.fit(&json!({"curve": {"points": points}})).await;
    let around: Vec<usize> = (4988..5013).collect();
    let edit = |up: f64| {
        let height = at[1].as_f64().unwrap() + up;
        json!({
            "points": [{"index": 5000, "point": [at[0], height]}],
            "method": {"kind": "local", "indices": around},
            "ephemeral": true, "session": "drag",
        })
    };
    for query in [
        "?changed=true&describe=none",
        "?view=samples&encoding=base64_f32&every=1000000&describe=none",
    ] {
        let response = send(&server, &parent, query, &edit(0.01)).await;
        let text = response.text().await.unwrap();
        assert!(text.len() < 50_000, "{query}: {} bytes", text.len());
        assert!(text.contains("\"converged\""), "{query}");
        let iterations = text.matches("event: iteration").count();
        assert_eq!(
            iterations == 1,
            query.contains("every"),
            "{query}: {iterations}"
        );
    }
    server.stop().await;
}
