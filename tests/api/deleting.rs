//! Jobs that are deleted while others read, edit or make them again.

use futures_util::future::join_all;
use piad::config::Storage;
use reqwest::{Method, RequestBuilder, Response};
use serde_json::{Value, json};

use crate::data;
use crate::program::Program;
use crate::support::{Server, Story, base, events, eventually, problem};
use futures_util::StreamExt;

/// How often each race is run.
const ROUNDS: usize = 60;

async fn durable() -> (tempfile::TempDir, Server) {
    let data = tempfile::tempdir().unwrap();
    let directory = data.path().to_owned();
    // Nothing is cached without references: everything is read from the store.
    let server = Server::with(|config| {
        config.store = Storage::Directory(directory);
        config.recent = bytesize::ByteSize::b(0);
    });
    let server = server.await;
    (data, server)
}

async fn post(server: &Server, key: &str) -> Response {
    let request = server.post("/v1/jobs").header("idempotency-key", key);
    let request = request.header("prefer", "wait=100");
    request.json(&data::small_job()).send().await.unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn a_key_whose_job_is_deleted_at_the_same_time_makes_a_job() {
    let (_data, server) = durable().await;
    for round in 0..ROUNDS {
        let key = format!("key {round}");
        let first: Value = post(&server, &key).await.json().await.unwrap();
        let deleted = server.delete(base(&first)).send();
        let replays = join_all((0..6).map(|_| post(&server, &key)));
        let (deleted, replays) = tokio::join!(deleted, replays);
        assert_eq!(deleted.unwrap().status(), 204);
        let mut others = Vec::new();
        for replay in replays {
            assert_eq!(replay.status(), 201);
            let job: Value = replay.json().await.unwrap();
            if job["id"] != first["id"] {
                others.push(job["id"].clone());
            }
        }
        others.dedup();
        assert!(others.len() <= 1, "{others:?} have the same key");
        let gone = server.get(base(&first)).send().await.unwrap();
        assert_eq!(problem(gone).await.0, 404);
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn whatever_meets_a_deletion_is_answered_as_before_or_after_it() {
    let (_data, server) = durable().await;
    for _ in 0..ROUNDS {
        let job = server.fit(&data::small_job()).await;
        let path = base(&job);
        let get = |rest: &str| server.get(&format!("{path}{rest}"));
        let edit = json!({"stop": {"max_iterations": 7}});
        let edit = server.post(&format!("{path}/edits")).json(&edit);
        let requests: Vec<RequestBuilder> = vec![
            get(""),
            get("/result"),
            get("/result/csv"),
            get("/input"),
            get("/iterations/3"),
            get("/iterations/last"),
            get("/iterations/2?view=samples&samples=20"),
            edit,
            server
                .client
                .request(Method::DELETE, format!("{}{path}", server.url)),
        ];
        let answers = join_all(requests.into_iter().map(RequestBuilder::send)).await;
        for answer in answers {
            let answer = answer.unwrap();
            let (status, url) = (answer.status().as_u16(), answer.url().clone());
            let good = [200, 201, 204, 404].contains(&status);
            assert!(good, "{url} {}", answer.text().await.unwrap());
        }
        assert_eq!(problem(get("").send().await.unwrap()).await.0, 404);
        assert_eq!(problem(get("/result").send().await.unwrap()).await.0, 404);
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn streams_of_deleted_jobs_come_to_their_ends() {
    let (_data, server) = durable().await;
    for round in 0..ROUNDS {
        let ended = server.fit(&data::small_job()).await;
        let endless = server.create(&data::endless_job()).await;
        for (job, state) in [(ended, "converged"), (endless, "cancelled")] {
            let path = base(&job).to_owned();
            let events_of = format!("{path}/events?every=1000000000");
            let whole = server.get(&format!("{path}/events")).send();
            let streams = join_all((0..4).map(|_| server.get(&events_of).send()));
            let deleted = server.delete(&path).send();
            let (whole, streams, deleted) = tokio::join!(whole, streams, deleted);
            assert_eq!(deleted.unwrap().status(), 204);
            for stream in streams {
                let stream = stream.unwrap();
                if stream.status() == 404 {
                    continue;
                }
                let events: Vec<_> = events(stream).collect().await;
                let end = events.last().unwrap();
                assert_eq!(end.name, "end", "round {round}");
                assert_eq!(end.data["state"], state);
            }
            let whole = whole.unwrap();
            if whole.status() == 200 {
                assert_eq!(Story::read(whole).await.state(), state);
            }
        }
    }
    server.stop().await;
}

/// Jobs that wait have their points in the store alone.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn streams_of_jobs_that_are_deleted_while_they_wait_come_to_their_ends() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::with(data.path(), &["--memory", "4MiB", "--ring", "64KiB"]);
    let large: Vec<_> = (0..4000).map(|i| json!([i, i % 7])).collect();
    let large = json!({"curve": {"points": large}, "stop": {"tolerance": 0, "max_iterations": 1_000_000_000}});
    let create = async || -> Value {
        let request = program.post("/v1/jobs").json(&large);
        request.send().await.unwrap().json().await.unwrap()
    };
    let mut job = create().await;
    while job["state"] != "queued" {
        job = create().await;
    }
    for _ in 0..30 {
        let job = create().await;
        assert_eq!(job["state"], "queued");
        let stream = program.get(&format!("{}/events", base(&job)));
        let mut stream = events(stream.send().await.unwrap());
        let url = format!("http://{}{}", program.address, base(&job));
        let deleted = program.client.delete(url).send().await.unwrap();
        assert_eq!(deleted.status(), 204);
        let mut last = None;
        while let Some(event) = stream.next().await {
            last = Some(event);
        }
        let end = last.expect("an end");
        assert_eq!(
            (end.name.as_str(), &end.data["state"]),
            ("end", &json!("cancelled"))
        );
    }
}

/// With no room for jobs that have ended, each one is there until its request is answered and its streams
/// have ended; then it goes.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn jobs_that_are_read_are_not_forgotten() {
    let directory = tempfile::tempdir().unwrap();
    let store = Storage::Directory(directory.path().to_owned());
    let server = Server::with(|config| {
        config.store = store;
        config.recent = bytesize::ByteSize::b(0);
        config.retain_jobs = 0;
    })
    .await;
    let small = data::small_job();
    for _ in 0..10 {
        let streams = (0..30).map(|_| server.stream(&small));
        for story in join_all(streams).await {
            assert_eq!(story.state(), "converged");
        }
    }

    // A stream that is not read to its end holds a job that has ended.
    let job = json!({
        "curve": {"points": data::wave(3000)},
        "stop": {"tolerance": 0, "max_iterations": 300},
    });
    let request = server
        .post("/v1/jobs")
        .header("accept", "text/event-stream");
    let response = request.json(&job).send().await.unwrap();
    let path = response.headers()["location"].to_str().unwrap().to_owned();
    let mut stream = events(response);
    assert_eq!(stream.next().await.unwrap().name, "job");
    server.until_state(&path, "exhausted").await;
    // Others end, so that the server looks for what is to be forgotten.
    let other = server.fit(&data::small_job()).await;
    eventually("the other one is forgotten", async || {
        server.get(base(&other)).send().await.unwrap().status() == 404
    })
    .await;
    let result = format!("{path}/result");
    assert_eq!(server.json(&result).await["state"], "exhausted");
    drop(stream);
    eventually("it is forgotten, too", async || {
        server.get(&path).send().await.unwrap().status() == 404
    })
    .await;
    server.stop().await;
}
