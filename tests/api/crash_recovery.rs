//! Many jobs that were running in a crash: the one that brings the server down fails, and the others continue.

use std::time::Duration;

use serde_json::Value;

use crate::data;
use crate::program::Program;
use crate::support::eventually;

/// Jobs with four iterations per second.
const JOBS: usize = 24;

fn start(data: &std::path::Path) -> Program {
    Program::with(data, &["--ring", "64KiB"])
}

async fn state(program: &Program, job: &str) -> String {
    let job = program.json(&format!("/v1/jobs/{job}")).await;
    job["state"].as_str().unwrap().to_owned()
}

async fn in_state(program: &Program, state: &str) -> usize {
    let path = format!("/v1/jobs?limit=1000&state={state}");
    let list = program.json(&path).await;
    list["jobs"].as_array().unwrap().len()
}

/// Waits until the job is in this state or has failed; says whether it is in the state.
async fn becomes(program: &Program, job: &str, wanted: &str) -> bool {
    loop {
        match state(program, job).await {
            now if now == wanted => return true,
            now if now == "failed" => return false,
            _ => tokio::time::sleep(Duration::from_millis(1)).await,
        }
    }
}

/// Requests that bring the server down are not the fault of the jobs that run meanwhile.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_survives_requests_that_crash_the_server() {
    let data = tempfile::tempdir().unwrap();
    let mut program = start(data.path());
    let request = program.post("/v1/jobs").json(&data::endless_job());
    let job: Value = request.send().await.unwrap().json().await.unwrap();
    let job = job["id"].as_str().unwrap();
    for _ in 0..5 {
        assert!(becomes(&program, job, "running").await);
        // From here on the job is not on probation: a crash could be the fault of this body.
        let request = program.post("/v1/jobs").body("[".repeat(100_000));
        let request = request.header("content-type", "application/json");
        assert!(request.send().await.unwrap().status().is_client_error());
        program.kill();
        program = start(data.path());
    }
    assert!(becomes(&program, job, "running").await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_crashes_the_server_fails_and_others_continue() {
    let data = tempfile::tempdir().unwrap();
    let mut program = start(data.path());
    let mut jobs = Vec::new();
    for _ in 0..JOBS {
        let request = program.post("/v1/jobs").json(&data::endless_job());
        let job: Value = request.send().await.unwrap().json().await.unwrap();
        jobs.push(job["id"].as_str().unwrap().to_owned());
    }
    assert_eq!(in_state(&program, "running").await, JOBS);
    // This one brings the server down as soon as it runs.
    let culprit = &jobs[JOBS / 2];
    let mut crashes = 0;
    while becomes(&program, culprit, "running").await {
        program.kill();
        crashes += 1;
        assert!(crashes <= 3, "the culprit does not fail");
        program = start(data.path());
    }
    assert_eq!(crashes, 3);
    eventually("the others continue", async || {
        in_state(&program, "running").await == JOBS - 1
    })
    .await;
    assert_eq!(in_state(&program, "failed").await, 1);
}
