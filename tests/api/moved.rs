//! A file of jobs that is moved away, deleted or replaced while a server has it open: no job is accepted that
//! would be gone after the next start.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde_json::Value;
use tokio::time::sleep;

use crate::data::small_job;
use crate::program::Program;
use crate::support::{base, eventually, problem};

async fn is_ready(program: &Program) -> bool {
    program.get("/readyz").send().await.unwrap().status() == 200
}

/// No job is accepted from now on, with a reason, while those that are there can be read.
async fn assert_refuses(program: &Program, job: &Value, reason: &str) {
    // At once, not only when the server has looked again.
    let refused = program.post("/v1/jobs").json(&small_job()).send().await;
    let refused = refused.unwrap();
    assert_eq!(refused.headers()["retry-after"], "5");
    let (status, refused) = problem(refused).await;
    assert_eq!(
        (status, refused["type"].as_str()),
        (503, Some("/problems/store-away"))
    );
    let detail = refused["detail"].as_str().unwrap();
    assert!(detail.contains(reason), "{detail}");
    let (status, unready) = problem(program.get("/readyz").send().await.unwrap()).await;
    assert_eq!((status, unready["detail"].as_str()), (503, Some(detail)));
    assert_eq!(program.json(base(job)).await["id"], job["id"]);
    let list = program.json("/v1/jobs").await;
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
}

fn complaints(program: &Program) -> usize {
    program.log().matches("no more jobs are accepted").count()
}

/// What is done to the file at a path, and what the server says of it.
type Mishap = (fn(&Path), &'static str);

#[tokio::test(flavor = "multi_thread")]
async fn no_job_is_accepted_that_cannot_be_found() {
    let mishaps: [Mishap; 3] = [
        (|file| fs::remove_file(file).unwrap(), "cannot be found"),
        (
            |file| {
                fs::copy(file, file.with_extension("copy")).unwrap();
                fs::rename(file.with_extension("copy"), file).unwrap();
            },
            "is another file",
        ),
        (
            |file| {
                let directory = file.parent().unwrap();
                fs::rename(directory, directory.with_extension("away")).unwrap();
            },
            "cannot be found",
        ),
    ];
    for (mishap, reason) in mishaps {
        let data = tempfile::tempdir().unwrap();
        let store = data.path().join("jobs");
        let program = Program::with_store(&store);
        let job = program.fit(&small_job()).await;
        assert!(is_ready(&program).await);
        mishap(&store.join("piad.redb"));
        assert_refuses(&program, &job, reason).await;
        sleep(Duration::from_millis(2500)).await;
        assert_eq!(complaints(&program), 1);
        assert_refuses(&program, &job, reason).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_that_comes_back_takes_jobs_again() {
    let data = tempfile::tempdir().unwrap();
    let store = data.path().join("jobs");
    let (file, away) = (store.join("piad.redb"), data.path().join("away"));
    let mut program = Program::with_store(&store);
    let mut jobs = vec![program.fit(&small_job()).await];
    for _ in 0..2 {
        fs::rename(&file, &away).unwrap();
        // The server looks by itself.
        eventually("it is not ready", async || !is_ready(&program).await).await;
        fs::rename(&away, &file).unwrap();
        eventually("it is ready", async || is_ready(&program).await).await;
        jobs.push(program.fit(&small_job()).await);
    }
    assert_eq!(complaints(&program), 2);
    program.kill();
    let program = Program::with_store(&store);
    for job in &jobs {
        assert_eq!(program.json(base(job)).await, *job);
    }
}
