//! `POST /v1/batch`: many fits in one request, a line for each, and nothing is kept.

use std::time::Duration;

use futures_util::{StreamExt, stream};
use reqwest::{Body, Response};
use serde_json::{Value, json};
use tokio::sync::mpsc;
use tokio::time::timeout;

use crate::data;
use crate::support::{NEVER, PATIENCE, Server, events, problem};

const NDJSON: &str = "application/x-ndjson";

/// The answer to a batch.
struct Lines {
    items: Vec<Value>,
    /// The totals, or the problem that has ended the batch.
    last: Value,
}

impl Lines {
    async fn of(response: Response) -> Self {
        assert_eq!(response.status(), 200);
        assert_eq!(response.headers()["content-type"], NDJSON);
        let text = response.text().await.unwrap();
        let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
        let mut items: Vec<Value> = lines.collect();
        let last = items.pop().expect("a last line");
        for (index, item) in items.iter().enumerate() {
            assert_eq!(item["index"], index, "items are in order");
        }
        Self { items, last }
    }

    fn states(&self) -> Vec<&str> {
        let states = self
            .items
            .iter()
            .map(|item| item["state"].as_str().unwrap());
        states.collect()
    }

    /// The items without the id of their request.
    fn without_requests(&self) -> Vec<Value> {
        self.items.iter().map(without_request).collect()
    }

    fn totals(&self) -> [u64; 3] {
        let totals = &self.last["totals"];
        assert!(totals["seconds"].is_number(), "{}", self.last);
        ["items", "converged", "failed"].map(|name| totals[name].as_u64().unwrap())
    }
}

async fn post(server: &Server, batch: &Value) -> Response {
    server.post("/v1/batch").json(batch).send().await.unwrap()
}

async fn lines(server: &Server, batch: &Value) -> Lines {
    Lines::of(post(server, batch).await).await
}

/// A body in lines.
fn in_lines(items: &[Value]) -> String {
    items.iter().map(|item| format!("{item}\n")).collect()
}

async fn post_lines(server: &Server, body: impl Into<Body>) -> Response {
    let request = server.post("/v1/batch").header("content-type", NDJSON);
    request.body(body).send().await.unwrap()
}

/// A small curve, others for other numbers.
fn curve(number: usize) -> Value {
    let points: Vec<[f64; 2]> = (0..50)
        .map(|i| f64::from(i) / 7.0)
        .map(|x| [x, (x + number as f64).sin()])
        .collect();
    json!({"name": format!("curve {number}"), "curve": {"points": points}})
}

/// All kinds of jobs that end.
fn jobs() -> Vec<Value> {
    let grid = data::peaks(9);
    let few = json!({"kind": "least_squares", "control_points": "auto"});
    let tolerance = json!({"tolerance": 0.01});
    let few_steps = json!({"tolerance": 1e-9, "max_iterations": 3});
    vec![
        data::small_job(),
        json!({"surface": {"points": grid}, "method": "direct"}),
        json!({"curve": {"points": data::wave(60)}, "method": few, "stop": tolerance}),
        json!({"curve": {"points": data::helix()}, "stop": few_steps}),
        json!({"curve": {"points": data::wave(12), "closed": true}, "stop": tolerance}),
        json!({"curve": {"points": data::wave(3000)}, "name": "long"}),
        json!({"surface": {"points": data::peaks(60)}, "method": {"kind": "weighted", "omega": "auto"}}),
        json!({"curve": {"points": [[0, 0], [1, 2], [3, 2], [4, 0]], "weights": [1, 2, 2, 1]}}),
        json!({"curve": {"points": data::wave(200), "basis": "bernstein"}, "method": "extended", "stop": {"max_iterations": 1000}}),
        json!({"curve": {"points": [[0, 0], [1, 1], [1, 1]]}}),
        json!({"curve": {"points": data::wave(5)}, "stop": {"tolerance": -1}}),
        json!({"nothing": 1}),
        json!(7),
    ]
}

/// Each item is what `POST /v1/fit` answers, bit for bit.
#[tokio::test]
async fn items_are_what_fits_of_their_own_are() {
    let server = Server::start().await;
    let jobs = jobs();
    let batch = lines(&server, &json!({"items": jobs})).await;
    let in_lines = post_lines(&server, in_lines(&jobs)).await;
    let in_lines = Lines::of(in_lines).await;
    assert_eq!(batch.without_requests(), in_lines.without_requests());
    let mut converged = 0;
    for (index, job) in jobs.iter().enumerate() {
        let item = &batch.items[index];
        let response = server.post("/v1/fit").json(job).send().await.unwrap();
        if response.status() == 200 {
            let once: Value = response.json().await.unwrap();
            let geometry = match once["kind"].as_str().unwrap() {
                "curve" => &item["curve"],
                _ => &item["surface"],
            };
            let fields = geometry.as_object().unwrap();
            assert!(fields.contains_key("control_points") && fields.contains_key("knots"));
            for (name, value) in fields {
                assert_eq!(value, &once[name], "{name} of item {index}");
            }
            for name in ["state", "iteration", "error"] {
                assert_eq!(item[name], once[name], "{name} of item {index}");
            }
            assert_eq!(item.get("problem"), None);
            converged += 1;
            continue;
        }
        let (_, reported) = problem(response).await;
        let found = &item["problem"];
        for name in ["type", "title", "status"] {
            assert_eq!(found[name], reported[name], "{name} of item {index}");
        }
        let prefix =
            |pointer: &Value| json!(format!("/items/{index}{}", pointer.as_str().unwrap()));
        match reported.get("errors") {
            None => assert_eq!(found["detail"], reported["detail"]),
            Some(errors) => {
                let errors = errors.as_array().unwrap();
                assert_eq!(found["errors"].as_array().unwrap().len(), errors.len());
                for (own, error) in found["errors"].as_array().unwrap().iter().zip(errors) {
                    assert_eq!(own["detail"], error["detail"]);
                    assert_eq!(own["pointer"], prefix(&error["pointer"]));
                }
            }
        }
    }
    let count = jobs.len() as u64;
    assert_eq!(batch.totals(), [count, converged, count - converged]);
    assert_eq!(batch.items[5]["name"], "long");
    let states = batch.states();
    assert_eq!(states[3], "exhausted");
    // The achieved distance and the geometry are returned.
    assert_eq!(batch.items[3]["iteration"], 3);
    assert!(batch.items[3]["curve"]["control_points"].is_array());
    assert_eq!(&states[9..], ["failed"; 4]);
    assert_eq!(server.json("/v1/jobs").await["jobs"], json!([]));
    server.until("piad_jobs_running", 0.0).await;
    let metrics = server.metrics().await;
    assert_eq!(metrics["piad_batches_total"], 2.0);
    assert_eq!(metrics["piad_batch_items_total"], 2.0 * jobs.len() as f64);
}

/// A batch of nothing has totals.
#[tokio::test]
async fn an_empty_batch_has_totals() {
    let server = Server::start().await;
    let empty = lines(&server, &json!({"items": []})).await;
    assert_eq!(empty.totals(), [0, 0, 0]);
    for body in ["", "\n\n", "{\"defaults\": {}}\n"] {
        let empty = Lines::of(post_lines(&server, body).await).await;
        assert_eq!(empty.totals(), [0, 0, 0], "{body:?}");
    }
}

#[tokio::test]
async fn items_have_the_defaults_that_they_do_not_change() {
    let server = Server::start().await;
    let defaults = json!({
        "curve": {"degree": 2},
        "surface": {"closed": {"u": true, "v": false}},
        "method": {"kind": "weighted", "omega": 0.9},
        "stop": {"tolerance": 0.5, "max_iterations": 7},
    });
    let rows = data::peaks(5);
    let items = [
        json!({"curve": {"points": data::wave(20)}}),
        json!({"curve": {"points": data::wave(20), "degree": 5}, "stop": {"tolerance": 1e-12}}),
        json!({"curve": {"points": data::wave(20)}, "method": "direct", "stop": null}),
        json!({"surface": {"points": rows}}),
        json!({"curve": {"points": data::wave(20)}, "stop": {"max_iterations": -1}}),
    ];
    let batch = lines(&server, &json!({"defaults": defaults, "items": items})).await;
    let [first, other, direct, surface, wrong] = &batch.items[..] else {
        panic!("{:?}", batch.items);
    };
    assert_eq!(
        (&first["curve"]["degree"], &first["state"]),
        (&json!(2), &json!("converged"))
    );
    assert_eq!(other["curve"]["degree"], 5);
    assert_eq!(
        (&other["state"], &other["iteration"]),
        (&json!("exhausted"), &json!(7))
    );
    let detail = other["problem"]["detail"].as_str().unwrap();
    assert!(detail.contains("the tolerance is 1.000e-12"), "{detail}");
    assert_eq!(
        (&direct["state"], &direct["curve"]["degree"]),
        (&json!("converged"), &json!(2))
    );
    assert_eq!(surface["surface"]["closed"], json!({"u": true, "v": false}));
    let pointer = &wrong["problem"]["errors"][0]["pointer"];
    assert_eq!(pointer, "/items/4/stop/max_iterations");
    // In lines they are the first one.
    let first = [json!({"defaults": defaults})];
    let in_lines = in_lines(&[&first[..], &items].concat());
    let in_lines = Lines::of(post_lines(&server, in_lines).await).await;
    assert_eq!(in_lines.without_requests(), batch.without_requests());
    // Their errors name them.
    let negative = json!({"defaults": {"stop": {"tolerance": -1}}, "items": [curve(1)]});
    let negative = lines(&server, &negative).await;
    let errors = &negative.items[0]["problem"]["errors"];
    assert_eq!(errors[0]["pointer"], "/defaults/stop/tolerance");
    let unknown = json!({"defaults": {"tolerance": 1}, "items": [curve(1)]});
    let (status, reported) = problem(post(&server, &unknown).await).await;
    assert_eq!(
        (status, &reported["errors"][0]["pointer"]),
        (422, &json!("/defaults/tolerance"))
    );
}

/// What is no batch is answered as usual, before anything is computed.
#[tokio::test]
async fn invalid_batches_are_rejected() {
    let server = Server::start().await;
    for (body, status, detail) in [
        ("", 400, "the body is empty"),
        ("nonsense", 422, "expected an object with items"),
        ("{", 400, "the body ends"),
        (
            r#"{"curve": {}}"#,
            422,
            "unknown field \"curve\"; expected one of defaults, items",
        ),
        (r#"{"items": {}}"#, 422, "/items: expected a list"),
        (
            r#"{"items": ["#,
            400,
            "the body ends within the list of items",
        ),
        (
            r#"{"items": [], "defaults": {}}"#,
            422,
            "it must come before the items",
        ),
    ] {
        let request = server.post("/v1/batch");
        let request = request
            .header("content-type", "application/json")
            .body(body);
        let (found, reported) = problem(request.send().await.unwrap()).await;
        assert_eq!(found, status, "{body}: {reported:#}");
        assert!(
            reported["detail"].as_str().unwrap().contains(detail),
            "{body}: {reported:#}"
        );
    }
    let batch = json!({"items": [curve(1)]});
    let request = server.post("/v1/batch").header("content-type", "text/html");
    let (status, _) = problem(request.body("1,2\n").send().await.unwrap()).await;
    assert_eq!(status, 415);
    let request = server.post("/v1/batch").header("accept", "image/png");
    let (status, _) = problem(request.json(&batch).send().await.unwrap()).await;
    assert_eq!(status, 406);
    for (query, parameter) in [
        ("every=2", "every"),
        ("digits=auto", "digits"),
        ("dots=none", "dots"),
    ] {
        let request = server.post(&format!("/v1/batch?{query}")).json(&batch);
        let (status, reported) = problem(request.send().await.unwrap()).await;
        assert_eq!(
            (status, &reported["errors"][0]["parameter"]),
            (400, &json!(parameter))
        );
    }
}

/// A truncated or invalid body ends the batch at that point.
#[tokio::test]
async fn a_broken_body_ends_the_batch() {
    let server = Server::start().await;
    let (one, other) = (curve(1), curve(2));
    for (rest, detail) in [
        (
            format!(r#"{other} {other}]}}"#),
            "/items/2: expected , or ]",
        ),
        (other.to_string(), "the body ends within the list of items"),
        (
            r#"{"curve": {"points": [[0, NaN]]}}]}"#.to_owned(),
            "JSON has no NaN",
        ),
        (format!("{other}]}} more"), "something follows the end"),
        (
            format!(r#"{other}], "more": 1}}"#),
            "unknown field \"more\"",
        ),
    ] {
        let body = format!(r#"{{"items": [{one}, {rest}"#);
        let request = server.post("/v1/batch");
        let request = request
            .header("content-type", "application/json")
            .body(body);
        let batch = Lines::of(request.send().await.unwrap()).await;
        assert_eq!(batch.items[0]["state"], "converged");
        assert_eq!(batch.last.get("totals"), None);
        let reported = batch.last["problem"]["detail"].as_str().unwrap();
        assert!(reported.contains(detail), "{rest}: {reported}");
        assert!(batch.last["problem"]["request_id"].is_string());
    }
    // A connection that is cut off, of which the client may see nothing more.
    let parts = [Ok(one.to_string()), Err(std::io::Error::other("cut off"))];
    let request = server.post("/v1/batch").header("content-type", NDJSON);
    let sent = request
        .body(Body::wrap_stream(stream::iter(parts)))
        .send()
        .await;
    if let Ok(answer) = sent {
        let text = answer.text().await.unwrap_or_default();
        assert!(!text.contains("totals"), "{text}");
    }
    server.until("piad_jobs_running", 0.0).await;
    // Lines are texts of their own: one that is no JSON fails alone.
    let body = format!("{one}\nnonsense\n{{\"curve\": \n{other}");
    let batch = Lines::of(post_lines(&server, body).await).await;
    assert_eq!(
        batch.states(),
        ["converged", "failed", "failed", "converged"]
    );
    assert_eq!(batch.items[1]["problem"]["type"], "/problems/not-json");
    assert_eq!(batch.totals(), [4, 2, 2]);
}

#[tokio::test]
async fn answers_have_the_requested_form() {
    let server = Server::start().await;
    let batch = json!({"items": [curve(1), {"surface": {"points": data::peaks(5)}}, {}]});
    let request = server
        .post("/v1/batch")
        .header("accept", "text/event-stream");
    let response = request.json(&batch).send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    assert_eq!(
        response.headers()["cache-control"],
        "no-store, no-transform"
    );
    let plain = lines(&server, &batch).await;
    let all: Vec<_> = events(response).collect().await;
    let names: Vec<_> = all
        .iter()
        .map(|it| (it.name.as_str(), it.id.as_str()))
        .collect();
    assert_eq!(names[..3], [("item", "0"), ("item", "1"), ("item", "2")]);
    assert_eq!(names[3].0, "totals");
    for (event, item) in all.iter().zip(&plain.items) {
        assert_eq!(without_request(&event.data), without_request(item));
    }
    assert_eq!(all[3].data["totals"]["converged"], 2);
    // Other views, and encodings of numbers.
    let ask = async |query: &str| {
        let request = server.post(&format!("/v1/batch?{query}")).json(&batch);
        Lines::of(request.send().await.unwrap()).await
    };
    let samples = ask("view=samples&samples=7").await;
    let curve = &samples.items[0]["curve"];
    assert_eq!(curve["samples"].as_array().unwrap().len(), 7);
    assert_eq!(curve["parameters"].as_array().unwrap().len(), 7);
    // A number of samples is none of a surface, which has rows of them.
    let error = &samples.items[1]["problem"]["errors"][0];
    assert_eq!(error["parameter"], "samples");
    let samples = ask("view=samples&samples=4x5").await;
    assert_eq!(
        samples.items[1]["surface"]["samples"]
            .as_array()
            .unwrap()
            .len(),
        4
    );
    assert_eq!(samples.items[0]["state"], "failed");
    let errors = ask("view=errors").await;
    assert!(errors.items[0].get("curve").is_none());
    assert_eq!(errors.items[0]["error"], plain.items[0]["error"]);
    let binary = ask("encoding=base64").await;
    assert!(binary.items[0]["curve"]["control_points"].is_string());
    assert_eq!(binary.items[0]["curve"]["encoding"], "base64");
}

/// An item without the id of its request.
fn without_request(item: &Value) -> Value {
    let mut item = item.clone();
    if let Some(problem) = item["problem"].as_object_mut() {
        problem.remove("request_id");
    }
    item
}

/// Two thousand items, some of them large, through small windows; compressed, too.
#[tokio::test]
async fn many_items_come_in_order() {
    let server = Server::start().await;
    let mut items: Vec<Value> = (0..2000).map(curve).collect();
    for index in [0, 700, 701, 1999] {
        items[index] =
            json!({"name": format!("curve {index}"), "curve": {"points": data::wave(8000)}});
    }
    items[100] = json!({"name": "curve 100", "curve": {"points": [[0, 0]]}});
    let body = json!({"defaults": {"method": "direct"}, "items": items}).to_string();
    let parts: Vec<_> = body.as_bytes().chunks(10_007).map(<[u8]>::to_vec).collect();
    let parts = stream::iter(parts.into_iter().map(Ok::<_, std::io::Error>));
    let request = server
        .post("/v1/batch")
        .header("content-type", "application/json");
    let response = request.body(Body::wrap_stream(parts)).send().await.unwrap();
    let batch = Lines::of(response).await;
    assert_eq!(batch.totals(), [2000, 1999, 1]);
    for (index, item) in batch.items.iter().enumerate() {
        assert_eq!(item["name"], format!("curve {index}"));
    }
    let error = &batch.items[100]["problem"]["errors"][0];
    assert!(
        error["pointer"]
            .as_str()
            .unwrap()
            .starts_with("/items/100/curve")
    );
    let request = server
        .post("/v1/batch")
        .header("content-type", "application/json");
    let request = request.header("content-encoding", "zstd");
    let packed = zstd_of(body.as_bytes());
    let packed = Lines::of(request.body(packed).send().await.unwrap()).await;
    assert_eq!(packed.totals(), [2000, 1999, 1]);
    assert_eq!(packed.items[700], batch.items[700]);
}

fn zstd_of(bytes: &[u8]) -> Vec<u8> {
    zstd::encode_all(bytes, 1).unwrap()
}

/// Each line comes before the next item has been sent.
#[tokio::test]
async fn lines_come_while_the_body_is_sent() {
    let server = Server::start().await;
    let (sender, parts) = mpsc::channel::<Result<String, std::io::Error>>(1);
    let body = stream::unfold(parts, |mut parts| async {
        Some((parts.recv().await?, parts))
    });
    sender.send(Ok(format!("{}\n", curve(0)))).await.unwrap();
    let response = post_lines(&server, Body::wrap_stream(body)).await;
    let mut answer = response.bytes_stream();
    let mut text = String::new();
    for number in 1..5 {
        while text.lines().count() < number || !text.ends_with('\n') {
            let bytes = timeout(PATIENCE, answer.next()).await.unwrap();
            text += std::str::from_utf8(&bytes.unwrap().unwrap()).unwrap();
        }
        sender
            .send(Ok(format!("{}\n", curve(number))))
            .await
            .unwrap();
    }
    drop(sender);
    while let Some(bytes) = answer.next().await {
        text += std::str::from_utf8(&bytes.unwrap()).unwrap();
    }
    assert_eq!(text.lines().count(), 6, "{text}");
    assert!(
        text.lines().last().unwrap().contains("\"converged\":5"),
        "{text}"
    );
}

/// A body that pauses for too long ends the batch, with what came before.
#[tokio::test]
async fn a_pause_in_the_body_has_an_end() {
    let server = Server::with(|config| config.body_timeout = Duration::from_millis(300)).await;
    let first = Ok::<_, std::io::Error>(format!("{}\n{{\"curve\"", curve(0)));
    let body = stream::iter([first]).chain(stream::pending());
    let batch = Lines::of(post_lines(&server, Body::wrap_stream(body)).await).await;
    assert_eq!(batch.states(), ["converged"]);
    assert_eq!(batch.last["problem"]["type"], "/problems/body-timeout");
    server.until("piad_jobs_running", 0.0).await;
}

/// A client that goes away ends its fits, and so does a server that stops.
#[tokio::test]
async fn it_ends_with_its_request() {
    let server = Server::with(|config| config.grace = NEVER).await;
    let ask = || {
        let items: Vec<_> = (0..50).map(|_| data::endless_job()).collect();
        let batch = server.post("/v1/batch").json(&json!({"items": items}));
        tokio::spawn(async { Lines::of(batch.send().await.unwrap()).await })
    };
    let gone = ask();
    server.until("piad_jobs_running", 1.0).await;
    gone.abort();
    server.until("piad_jobs_running", 0.0).await;
    let waiting = ask();
    server.until("piad_jobs_running", 1.0).await;
    server.stop().await;
    let batch = waiting.await.unwrap();
    assert_eq!(batch.last["problem"]["type"], "/problems/stopping");
}

/// Others do not wait for a batch, however many long fits it has.
#[tokio::test]
async fn others_do_not_wait_for_a_batch() {
    let server = Server::with(|config| config.workers = Some(1)).await;
    let items: Vec<_> = (0..50).map(|_| data::endless_job()).collect();
    let batch = server.post("/v1/batch").json(&json!({"items": items}));
    let batch = tokio::spawn(async { Lines::of(batch.send().await.unwrap()).await });
    server.until("piad_jobs_running", 1.0).await;
    for _ in 0..10 {
        let job = server.post("/v1/fit").json(&data::small_job());
        assert_eq!(job.send().await.unwrap().status(), 200);
    }
    assert!(!batch.is_finished());
    batch.abort();
    server.until("piad_jobs_running", 0.0).await;
}

/// Limits hold for each item, of which there may be any number.
#[tokio::test]
async fn limits_hold_for_each_item() {
    let server = Server::with(|config| {
        config.max_points = 60;
        config.max_iterations = 500;
        config.max_body = "10kB".parse().unwrap();
    })
    .await;
    let mut items: Vec<_> = (0..40).map(curve).collect();
    items[3] = json!({"curve": {"points": data::wave(61)}});
    items[4] = json!({"curve": {"points": data::wave(10)}, "stop": {"max_iterations": 501}});
    let batch = lines(&server, &json!({"items": items})).await;
    assert_eq!(batch.totals(), [40, 38, 2]);
    for (index, pointer) in [
        (3, "/items/3/curve/points"),
        (4, "/items/4/stop/max_iterations"),
    ] {
        let error = &batch.items[index]["problem"]["errors"][0];
        assert_eq!(error["pointer"], pointer);
    }
    items[7] = json!({"curve": {"points": data::wave(10)}, "name": "x".repeat(10_000)});
    let batch = lines(&server, &json!({"items": items})).await;
    assert_eq!(batch.items.len(), 7);
    assert_eq!(batch.last["problem"]["type"], "/problems/body-too-large");
    // A batch is one job of its client.
    let server = Server::with(|config| config.max_jobs = 1).await;
    let running = server.create(&data::endless_job()).await;
    let (status, reported) = problem(post(&server, &json!({"items": []})).await).await;
    assert_eq!(
        (status, &reported["type"]),
        (503, &json!("/problems/queue-full"))
    );
    server
        .delete(running["links"]["self"].as_str().unwrap())
        .send()
        .await
        .unwrap();
    assert_eq!(
        lines(&server, &json!({"items": [curve(1), curve(2)]}))
            .await
            .totals(),
        [2, 2, 0]
    );
}

/// Little memory is enough for any batch, and a client that reads nothing takes no more of it.
#[tokio::test]
async fn a_slow_client_is_read_slowly() {
    let server = Server::with(|config| {
        config.memory = Some("64MiB".parse().unwrap());
        config.write_timeout = NEVER;
        config.body_timeout = NEVER;
    })
    .await;
    let line = format!(
        "{}\n",
        json!({"curve": {"points": data::wave(1500)}, "method": "direct"})
    );
    let sent = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let counted = std::sync::Arc::clone(&sent);
    let parts = stream::repeat_with(move || {
        counted.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok::<_, std::io::Error>(line.clone())
    });
    let response = post_lines(&server, Body::wrap_stream(parts.take(2000))).await;
    // Until nothing more is taken of the body.
    let sent = || sent.load(std::sync::atomic::Ordering::Relaxed);
    let mut before = 0;
    while before == 0 || sent() > before {
        before = sent();
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    assert!(
        before < 1900,
        "{before} of 2000 were taken though nothing was read"
    );
    // Others have room meanwhile.
    let job = server.post("/v1/fit").json(&data::small_job());
    assert_eq!(job.send().await.unwrap().status(), 200);
    assert_eq!(Lines::of(response).await.totals(), [2000, 2000, 0]);
}
