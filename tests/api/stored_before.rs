//! Store files of earlier programs: nothing in them is lost, and what they had not ended ends.
//!
//! `tests/stored/README.md` says what is in the files. The programs were killed while jobs were
//! running.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use flate2::read::GzDecoder;
use piad::config::DataDir;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::time::sleep;

use crate::support::{PATIENCE, Server, base, problem, thinned};

/// Fields in words for people: they may be said in another way.
const WORDS: [&str; 2] = ["detail", "title"];

fn stored(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/stored")
        .join(name)
}

/// The versions of the format of which there are files, with the number of unfinished jobs.
const VERSIONS: [(u32, usize); 2] = [(1, 11), (2, 9)];

/// A data directory with the file of a version.
fn data(version: u32) -> TempDir {
    let data = tempfile::tempdir().unwrap();
    let packed = std::fs::File::open(stored(&format!("version_{version}.redb.gz"))).unwrap();
    let mut bytes = Vec::new();
    GzDecoder::new(packed).read_to_end(&mut bytes).unwrap();
    std::fs::write(data.path().join("piad.redb"), bytes).unwrap();
    data
}

/// What the earlier program answered for each job, the newest first.
fn answers(version: u32) -> Vec<Value> {
    let lines = std::fs::read_to_string(stored(&format!("version_{version}.jsonl"))).unwrap();
    // What was called so is now the reason `minimum`.
    let answer = |line: &str| {
        let line = line.replace("\"reason\":\"stationary\"", "\"reason\":\"minimum\"");
        serde_json::from_str(&line).unwrap()
    };
    lines.lines().map(answer).collect()
}

/// A server that keeps jobs however old they are: by default they would be forgotten after a week.
async fn start(data: &TempDir) -> Server {
    let directory = data.path().to_owned();
    let server = Server::with(|config| {
        config.data_dir = DataDir::Directory(directory);
        config.retain_age = Duration::MAX;
        // Nothing is at hand once nobody holds it: everything is read from the store.
        config.recent = bytesize::ByteSize::b(0);
    });
    server.await
}

fn path(answer: &Value) -> String {
    format!("/v1/jobs/{}", answer["job"]["id"].as_str().unwrap())
}

fn is_unfinished(answer: &Value) -> bool {
    answer["unfinished"] == true
}

/// Checks that all that was said before is said now, with the same bits. More may be said.
fn assert_holds(before: &Value, now: &Value, place: &str) {
    match before {
        Value::Object(fields) => {
            for (name, value) in fields {
                if !WORDS.contains(&name.as_str()) {
                    assert_holds(value, &now[name], &format!("{place}/{name}"));
                }
            }
        }
        Value::Array(values) => {
            let count = now.as_array().map(Vec::len);
            assert_eq!(count, Some(values.len()), "{place}");
            for (i, value) in values.iter().enumerate() {
                assert_holds(value, &now[i], &format!("{place}/{i}"));
            }
        }
        value => assert_eq!(value, now, "{place}"),
    }
}

/// Fields that do not change from the beginning of a job to its end.
fn lasting(job: &Value) -> Value {
    let names = [
        "id",
        "name",
        "kind",
        "points",
        "stop",
        "stream",
        "created_at",
    ];
    let mut lasting: Value = names
        .map(|name| (name, job[name].clone()))
        .into_iter()
        .collect();
    lasting["method"] = json!({"kind": job["method"]["kind"]});
    if let Some(parent) = job.get("parent") {
        lasting["parent"] = parent.clone();
    }
    lasting
}

/// Cancels what has not ended, so that it takes no time from what else is tested.
async fn cancel_unfinished(server: &Server, answers: &[Value]) {
    for answer in answers.iter().filter(|answer| is_unfinished(answer)) {
        let cancel = format!("{}/cancel", path(answer));
        let status = server.post(&cancel).send().await.unwrap().status();
        // The shortest one may have come to its end.
        assert!([200, 409].contains(&status.as_u16()), "{status} {cancel}");
    }
}

/// All jobs as they are listed, page by page.
async fn listed(server: &Server, query: &str) -> Vec<Value> {
    let mut jobs = Vec::new();
    let mut next = json!(format!("/v1/jobs?limit=40{query}"));
    while let Some(page) = next.as_str() {
        let page = server.json(page).await;
        jobs.extend(page["jobs"].as_array().unwrap().clone());
        next = page["next"].clone();
    }
    jobs
}

/// Checks a job that has ended.
async fn assert_kept(server: &Server, answer: &Value) {
    let path = path(answer);
    let name = &answer["job"]["name"];
    let job = server.json(&path).await;
    assert_holds(&answer["job"], &job, &format!("{name}: "));
    let input = server.json(&format!("{path}/input")).await;
    assert_holds(&answer["input"], &input, &format!("{name}: /input"));

    let result = server.get(&format!("{path}/result")).send().await.unwrap();
    if let Some(status) = answer.get("refused") {
        assert_eq!(json!(result.status().as_u16()), *status, "{name}");
        return;
    }
    assert_eq!(result.status(), 200, "{name}");
    let result: Value = result.json().await.unwrap();
    assert_holds(&answer["result"], &result, &format!("{name}: /result"));
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_of_an_earlier_program_are_as_they_were() {
    for (version, _) in VERSIONS {
        assert_as_they_were(version).await;
    }
}

async fn assert_as_they_were(version: u32) {
    let (data, answers) = (data(version), answers(version));
    let server = start(&data).await;
    let list = listed(&server, "").await;
    assert_eq!(list.len(), answers.len());
    for (answer, job) in answers.iter().zip(&list) {
        match is_unfinished(answer) {
            true => assert_holds(&lasting(&answer["job"]), job, "the list: "),
            false => assert_holds(&answer["job"], job, "the list: "),
        }
        let input = server.json(&format!("{}/input", path(answer))).await;
        assert_holds(&answer["input"], &input, &path(answer));
    }
    cancel_unfinished(&server, &answers).await;
    for answer in answers.iter().filter(|answer| !is_unfinished(answer)) {
        assert_kept(&server, answer).await;
    }
    server.stop().await;

    // And again, as the file was left by the program of now.
    let server = start(&data).await;
    for answer in answers.iter().filter(|answer| !is_unfinished(answer)) {
        assert_kept(&server, answer).await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn unfinished_jobs_of_an_earlier_program_end_with_the_same_bits() {
    for (version, count) in VERSIONS {
        assert_unfinished_end(version, count).await;
    }
}

async fn assert_unfinished_end(version: u32, count: usize) {
    let (data, answers) = (data(version), answers(version));
    let server = start(&data).await;
    let unfinished = || answers.iter().filter(|answer| is_unfinished(answer));
    assert_eq!(unfinished().count(), count);
    for answer in unfinished() {
        until_ended(&server, answer).await;
        assert_kept(&server, answer).await;
    }
    let mut ended: HashMap<&str, usize> = HashMap::new();
    for answer in &answers {
        *ended
            .entry(answer["job"]["state"].as_str().unwrap())
            .or_default() += 1;
    }
    for (state, count) in ended {
        let jobs = listed(&server, &format!("&state={state}")).await;
        assert_eq!(jobs.len(), count, "{state}");
    }
    server.stop().await;
    let server = start(&data).await;
    for answer in unfinished() {
        assert_kept(&server, answer).await;
    }
    server.stop().await;
}

/// Waits until the job has ended.
async fn until_ended(server: &Server, answer: &Value) {
    let begin = tokio::time::Instant::now();
    while server.json(&path(answer)).await["finished_at"].is_null() {
        assert!(begin.elapsed() < PATIENCE, "{} has not ended", path(answer));
        sleep(Duration::from_millis(20)).await;
    }
}

/// All numbers of lists in lists.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        value => vec![value.as_f64().unwrap()],
    }
}

/// Checks that points that were computed again are those that were stored. The order of sums, and with
/// it the rounding of dense matrices, depends on the processor.
fn assert_close(stored: &Value, computed: &Value, what: &str) {
    let (stored, computed) = (numbers(stored), numbers(computed));
    assert_eq!(stored.len(), computed.len(), "{what}");
    let largest = stored.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for (a, b) in stored.iter().zip(&computed) {
        assert!((a / largest - b / largest).abs() < 1e-9, "{what}: {a} {b}");
    }
}

/// Whether the job has reached its end in its own time, by a method that rounding does not spoil.
fn is_computed_again(answer: &Value) -> bool {
    let state = answer["job"]["state"].as_str().unwrap();
    !is_unfinished(answer) && ["converged", "exhausted"].contains(&state)
}

/// What is stored of a job is enough to compute it again: as a stream, and as a new job.
#[tokio::test(flavor = "multi_thread")]
async fn jobs_of_an_earlier_program_are_computed_again() {
    for (version, _) in VERSIONS {
        assert_computed_again(version).await;
    }
}

async fn assert_computed_again(version: u32) {
    let (data, answers) = (data(version), answers(version));
    let server = start(&data).await;
    cancel_unfinished(&server, &answers).await;
    let mut posted = 0;
    for answer in answers.iter().filter(|answer| is_computed_again(answer)) {
        let name = answer["job"]["name"].to_string();
        let events = format!("{}/events", path(answer));
        let (iterations, end) = thinned(&server, &events, None).await;
        let last = iterations.last().unwrap();
        assert_eq!(end["state"], answer["job"]["state"], "{name}");
        assert_eq!(last["iteration"], answer["job"]["iteration"], "{name}");
        match answer.get("last") {
            Some(before) => assert_holds(before, last, &format!("{name}: /events")),
            None => {
                let stored = &answer["result"]["control_points"];
                assert_close(stored, &last["control_points"], &name);
            }
        }
        if answer["job"].get("parent").is_some() {
            continue;
        }
        // Whatever is the default now: the input says all that it takes.
        let input = server.json(&format!("{}/input", path(answer))).await;
        let job = server.fit(&input).await;
        assert_eq!(job["iteration"], answer["job"]["iteration"], "{name}");
        let result = server.json(&format!("{}/result", base(&job))).await;
        for field in ["knots", "control_points", "weights"] {
            if let Some(Value::Array(_)) = answer["result"].get(field) {
                assert_close(&answer["result"][field], &result[field], &name);
            }
        }
        posted += 1;
    }
    assert!(posted > 70, "{posted}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_of_an_earlier_program_can_be_edited() {
    let (data, answers) = (data(1), answers(1));
    let server = start(&data).await;
    cancel_unfinished(&server, &answers).await;
    for (name, index, point) in [
        ("global", json!(3), json!([1, 1, 1])),
        ("homogeneous surface", json!([1, 2]), json!([1, 1, 1])),
        ("edit that keeps its eigenvalue", json!(4), json!([0, 0, 0])),
        (
            "least squares with missing points",
            json!([1, 1]),
            json!([1, 1, 0]),
        ),
    ] {
        let named = |answer: &&Value| answer["job"]["name"] == name;
        let parent = answers.iter().find(named).unwrap();
        let edit = json!({"points": [{"index": index, "point": point}],
            "stop": {"max_iterations": 500}});
        let request = server.post(&format!("{}/edits", path(parent)));
        let request = request.header("prefer", "wait=100").json(&edit);
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 201, "{name}");
        let job: Value = response.json().await.unwrap();
        assert_eq!(job["state"], "converged", "{name}");
        assert_eq!(job["parent"]["id"], parent["job"]["id"]);
        // It starts where its parent has ended.
        let first = format!("{}/iterations/0", base(&job));
        let first = server.json(&first).await;
        let stored = &parent["result"]["control_points"];
        assert_close(stored, &first["control_points"], name);
    }
    server.stop().await;
}

/// Keys are remembered for a day. In the file only those are so young that come from a clock that was
/// ahead; with the others, which are too old, a request makes a new job.
#[tokio::test(flavor = "multi_thread")]
async fn keys_of_an_earlier_program_are_known_for_a_day() {
    let (data, answers) = (data(1), answers(1));
    let server = start(&data).await;
    cancel_unfinished(&server, &answers).await;
    let (mut known, mut expired) = (0, 0);
    for answer in &answers {
        let Some(request) = answer.get("request") else {
            continue;
        };
        let [path, key, body] = ["path", "key", "body"].map(|name| request[name].as_str().unwrap());
        let post = |body: &str| {
            let request = server.post(path).header("idempotency-key", key);
            let request = request.header("content-type", "application/json");
            request.body(body.to_owned()).send()
        };
        let is_ahead = answer["job"]["created_at"].as_str().unwrap() > "2125";
        let response = post(body).await.unwrap();
        assert_eq!(response.status(), 201, "{key}");
        let replayed = response.headers().get("idempotency-replayed").is_some();
        let job: Value = response.json().await.unwrap();
        assert_eq!(replayed, is_ahead, "{key}");
        assert_eq!(job["id"] == answer["job"]["id"], is_ahead, "{key}");
        known += usize::from(is_ahead);
        expired += usize::from(!is_ahead);
        // From now on either is known.
        let (status, taken) = problem(post(&format!("{body} ")).await.unwrap()).await;
        let refused = (status, taken["type"].as_str());
        assert_eq!(refused, (422, Some("/problems/key-taken")), "{key}");
    }
    assert_eq!((known, expired), (3, 20));
    // That of a deleted job is free.
    let request = server
        .post("/v1/jobs")
        .header("idempotency-key", "key-ahead-deleted");
    let response = request
        .json(&crate::data::small_job())
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 201);
    server.stop().await;
}
