//! `piad store copy`: jobs move between a directory and a database, with their results and keys.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::data;
use crate::database;
use crate::program::{PROGRAM, Program};
use crate::support::eventually;

fn copy(from: &str, to: &str) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(["store", "copy", from, to]).output().unwrap()
}

fn copied(from: &str, to: &str) -> String {
    let done = copy(from, to);
    assert!(done.status.success(), "{done:?}");
    String::from_utf8(done.stdout).unwrap()
}

async fn post(program: &Program, key: &str, job: &Value) -> Value {
    let request = program.post("/v1/jobs").header("idempotency-key", key);
    let request = request.header("prefer", "wait=100");
    request
        .json(job)
        .send()
        .await
        .unwrap()
        .json()
        .await
        .unwrap()
}

async fn result(program: &Program, job: &Value) -> Value {
    program.json(job["links"]["result"].as_str().unwrap()).await
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_copied_with_their_results_and_keys() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let paths = [&first, &second].map(|it| it.path().to_str().unwrap().to_owned());
    let url = database::new();
    // In a file, whatever the other tests have.
    let mut program = Program::with_store(first.path());
    let done = post(&program, "wing", &data::small_job()).await;
    let expected = result(&program, &done).await;
    let endless = program
        .post("/v1/jobs")
        .json(&data::endless_job())
        .send()
        .await
        .unwrap();
    let endless: Value = endless.json().await.unwrap();
    program.signal("-TERM");
    program.wait();
    assert!(copied(&paths[0], &url).contains("2 jobs copied"));
    // Once more, as after an interruption; and to another file.
    assert!(copied(&paths[0], &url).contains("2 jobs copied"));
    assert!(copied(&url, &paths[1]).contains("2 jobs copied"));
    for store in [url.as_str(), paths[1].as_str()] {
        let mut program = Program::with_store(Path::new(store));
        assert_eq!(result(&program, &done).await, expected);
        let again = post(&program, "wing", &data::small_job()).await;
        assert_eq!(again["id"], done["id"]);
        let path = endless["links"]["self"].as_str().unwrap();
        eventually("it runs again", async || {
            program.json(path).await["state"] == "running"
        })
        .await;
        program.signal("-TERM");
        program.wait();
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn stores_that_cannot_be_copied_are_refused() {
    let data = tempfile::tempdir().unwrap();
    let path = data.path().to_str().unwrap();
    let url = database::new();
    let refused = |from: &str, to: &str, reason: &str| {
        let done = copy(from, to);
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(!done.status.success() && said.contains(reason), "{said}");
    };
    refused(":memory:", path, "not a persistent store");
    refused(path, path, "are the same");
    refused(&format!("{path}/none"), &url, "there is no store");
    refused("mysql://x", path, "begins with postgres://");
    // While servers run.
    let program = Program::with_store(data.path());
    refused(path, &url, "in use by another process");
    drop(program);
    let replica = Program::with_store(Path::new(&url));
    let posted = replica
        .post("/v1/jobs")
        .json(&data::endless_job())
        .send()
        .await
        .unwrap();
    assert_eq!(posted.status(), 201);
    refused(&url, path, "stop them first");
}
