//! Jobs that outlive the process: restarts, keys, the file of the store.

use std::path::Path;
use std::time::Duration;

use futures_util::StreamExt;
use piad::config::Storage;
use serde_json::{Value, json};
use tokio::time::sleep;

use crate::data;
use crate::data::small_job;
use crate::program::Program;
use crate::support::{Server, Story, base, events, eventually, problem};

fn path(job: &Value) -> &str {
    job["links"]["self"].as_str().unwrap()
}

async fn stream(program: &Program, path: &str) -> Story {
    let response = program.get(&format!("{path}/events")).send().await.unwrap();
    Story::read(response).await
}

/// Jobs of every kind of method and basis, to see that nothing of them is lost on the way.
fn mixed_jobs() -> Vec<Value> {
    let points: Vec<_> = (0..24)
        .map(|i| {
            let t = f64::from(i) * 0.25;
            json!([t.cos() * 2.0, t.sin(), t / 3.0])
        })
        .collect();
    let planar: Vec<_> = points.iter().map(|p| json!([p[0], p[1]])).collect();
    let grid: Vec<Vec<_>> = (0..7)
        .map(|i| {
            (0..6)
                .map(|j| json!([i, j, f64::from(i * j % 5)]))
                .collect()
        })
        .collect();
    let weights: Vec<_> = (0..24).map(|i| 1.0 + f64::from(i % 3)).collect();
    let curve = |method: Value| json!({"curve": {"points": points}, "method": method});
    vec![
        json!({"name": "wing «α»", "curve": {"points": points, "parameters": "centripetal"}}),
        curve(json!({"kind": "weighted"})),
        curve(json!({"kind": "weighted", "omega": 1.2})),
        curve(json!({"kind": "local", "indices": [3, 4, 9]})),
        curve(json!({"kind": "adaptive", "threshold": 0.01})),
        curve(json!({"kind": "extended", "start": "data"})),
        curve(json!({"kind": "transpose"})),
        curve(json!({"kind": "chebyshev"})),
        curve(json!({"kind": "direct"})),
        curve(json!({"kind": "least_squares", "control_points": 9, "variant": "lspia", "mu": 0.3})),
        curve(
            json!({"kind": "least_squares", "control_points": 12, "variant": "cg", "fairness": 1e-7, "data_weights": weights,
            "constraints": [{"index": 7}, {"at": "start", "tangent": [0, 0, 1]}]}),
        ),
        json!({"surface": {"points": grid}, "method": {"kind": "least_squares", "control_points": {"u": 5, "v": 4},
            "constraints": [{"at": {"boundary": "v_end"}, "control_points": [[0, 5, 0], [1, 5, 1], [3, 5, 1], [4, 5, 1], [6, 5, 0]]}]}}),
        json!({"surface": {"scattered": points, "parameters": {"project": "xy"}},
            "method": {"kind": "least_squares", "control_points": 4, "variant": "cg"}}),
        json!({"surface": {"scattered": planar, "parameters": weights.iter().enumerate().map(|(i, w)| [i as f64, *w]).collect::<Vec<_>>(), "degree": 1},
            "method": {"kind": "least_squares", "control_points": {"u": 4, "v": 2}, "data_weights": weights}}),
        json!({"curve": {"points": points}, "method": {"kind": "least_squares", "control_points": "auto"}}),
        json!({"curve": {"points": planar, "closed": true}, "method": {"kind": "least_squares", "control_points": "auto", "max_control_points": 30, "correct_parameters": true}, "stop": {"tolerance": 1e-2}}),
        json!({"surface": {"points": grid}, "method": {"kind": "least_squares", "control_points": "auto"}, "stop": {"tolerance": 1e-2}}),
        json!({"curve": {"points": planar}, "method": {"kind": "convex"}}),
        json!({"curve": {"points": planar}, "stream": {"view": "samples", "samples": 9, "encoding": "base64"}}),
        json!({"curve": {"points": points, "closed": true}}),
        json!({"curve": {"points": points, "weights": weights}}),
        json!({"curve": {"points": points, "weights": weights}, "rational": "fixed"}),
        json!({"curve": {"points": points[..9], "basis": {"kind": "said_ball"}}}),
        json!({"curve": {"points": points[..3], "basis": {"kind": "bspline", "degree": 2,
            "knots": [0, 0, 0, 1, 1, 1]}, "parameters": [0, 0.4, 1]}}),
        json!({"surface": {"points": grid, "basis": {"u": {"kind": "bernstein"},
            "v": {"kind": "bspline", "degree": 2, "knots": "averaged"}}}}),
        json!({"surface": {"points": grid}, "method": {"kind": "local", "sweeps": "rows"},
            "stop": {"tolerance": 0.001, "max_iterations": 90}}),
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn ended_jobs_are_the_same_after_a_restart() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let mut before = Vec::new();
    for job in mixed_jobs() {
        let job = program.fit(&job).await;
        let result = program.json(&format!("{}/result", path(&job))).await;
        let input = program.json(&format!("{}/input", path(&job))).await;
        let story = stream(&program, path(&job)).await;
        before.push((job, result, input, story));
    }
    let listed = program.json("/v1/jobs?limit=5").await;
    program.signal("-TERM");
    assert_eq!(program.wait().code(), Some(0));

    let program = Program::start(data.path());
    assert_eq!(program.json("/v1/jobs?limit=5").await, listed);
    for (job, result, input, story) in before {
        assert_eq!(program.json(path(&job)).await, job);
        assert_eq!(
            program.json(&format!("{}/result", path(&job))).await,
            result
        );
        assert_eq!(program.json(&format!("{}/input", path(&job))).await, input);
        let again = stream(&program, path(&job)).await;
        assert_eq!(again.job, story.job);
        assert_eq!(again.iterations, story.iterations);
        assert_eq!(again.end, story.end);
    }
}

/// A job of a few seconds in a test build.
fn long_job(iterations: usize) -> Value {
    let points: Vec<_> = (0..3000)
        .map(|i| {
            let t = f64::from(i) / 40.0;
            json!([t.cos() * t, t.sin() * t, t])
        })
        .collect();
    json!({"curve": {"points": points}, "stop": {"tolerance": 0, "max_iterations": iterations}})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stream_resumes_after_a_restart() {
    let undisturbed = Server::start().await.stream(&long_job(60)).await;
    for signal in ["-TERM", "-KILL"] {
        let data = tempfile::tempdir().unwrap();
        let mut program = Program::start(data.path());
        let request = program.post("/v1/jobs").json(&long_job(60));
        let response = request
            .header("accept", "text/event-stream")
            .send()
            .await
            .unwrap();
        let path = response.headers()["location"].to_str().unwrap().to_owned();
        let mut stream = events(response);
        // The job event, and iterations 0 … 17.
        let mut seen = Vec::new();
        for _ in 0..19 {
            seen.push(stream.next().await.unwrap());
        }
        assert_eq!(seen[18].id, "17");
        program.signal(signal);
        program.wait();
        drop(stream);

        let program = Program::start(data.path());
        let request = program
            .get(&format!("{path}/events"))
            .header("last-event-id", "17");
        let response = request.send().await.unwrap();
        assert_eq!(response.headers()["piad-resumed-after"], "17");
        let rest = Story::read(response).await;
        assert_eq!(rest.iterations[0]["iteration"], 18);
        let all = seen[1..].iter().map(|event| &event.data);
        let all: Vec<_> = all.chain(&rest.iterations).collect();
        // Bit for bit: numbers are written so that they read back as the same.
        assert_eq!(all, undisturbed.iterations.iter().collect::<Vec<_>>());
        assert_eq!(rest.state(), "exhausted");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_was_running_in_three_crashes_is_not_tried_again() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let response = program.post("/v1/jobs").json(&data::endless_job());
    let job: Value = response.send().await.unwrap().json().await.unwrap();
    for _ in 0..2 {
        // An orderly stop is no crash.
        program.signal("-TERM");
        assert_eq!(program.wait().code(), Some(0));
        program = Program::start(data.path());
        wait_for(&program, path(&job), "running").await;
    }
    for _ in 0..3 {
        wait_for(&program, path(&job), "running").await;
        program.kill();
        program = Program::start(data.path());
    }
    let job = program.json(path(&job)).await;
    assert_eq!(job["state"], "failed");
    let detail = job["problem"]["detail"].as_str().unwrap();
    assert!(detail.contains("crashed at least 3 times"), "{detail}");
    // It stays failed, and its stream ends with the reason.
    program.kill();
    let program = Program::start(data.path());
    let story = stream(&program, path(&job)).await;
    assert_eq!(story.end["problem"], job["problem"]);
}

async fn wait_for(program: &Program, path: &str, state: &str) {
    let what = format!("{path} is {state}");
    eventually(&what, async || program.json(path).await["state"] == state).await;
}

/// Everything is there or nothing: a process killed in the middle of a commit leaves the file as it
/// was before it.
#[tokio::test(flavor = "multi_thread")]
async fn a_commit_that_is_cut_off_has_not_happened() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let small = program.fit(&data::small_job()).await;
    let points: Vec<_> = (0..400_000).map(|i| json!([i, i % 7, i % 11])).collect();
    let large = json!({"curve": {"points": points}});
    let mut cut_off = 0;
    // Few are not cut off in the first attempts.
    for attempt in 0.. {
        if cut_off > 1 {
            break;
        }
        assert!(attempt < 20, "no commit was cut off");
        let before = written(&program);
        let request = program.post("/v1/jobs").json(&large).send();
        let posted = tokio::spawn(request);
        // The input of the job is 10 MB: the commit has begun, and continues.
        while written(&program) < before + 100_000 && !posted.is_finished() {
            std::thread::yield_now();
        }
        program.kill();
        let acknowledged = posted.await.unwrap().is_ok();
        program = Program::start(data.path());
        let jobs = program.json("/v1/jobs").await;
        let count = jobs["jobs"].as_array().unwrap().len();
        assert!(!acknowledged || count == 2, "an acknowledged job is lost");
        cut_off += usize::from(count == 1);
        assert_eq!(program.json(path(&small)).await, small);
        for job in jobs["jobs"].as_array().unwrap() {
            if job["id"] != small["id"] {
                program
                    .client
                    .delete(format!("http://{}{}", program.address, path(job)))
                    .send()
                    .await
                    .unwrap();
            }
        }
    }
}

/// Bytes that a process has handed to the system so far.
fn written(program: &Program) -> u64 {
    let io = std::fs::read_to_string(format!("/proc/{}/io", program.id())).unwrap();
    let line = io.lines().find_map(|line| line.strip_prefix("wchar: "));
    line.unwrap().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn only_one_server_uses_a_data_directory() {
    let data = tempfile::tempdir().unwrap();
    let _first = Program::start(data.path());
    let second = Program::refused(data.path());
    assert_eq!(second.status.code(), Some(1));
    let message = String::from_utf8(second.stderr).unwrap();
    assert!(message.contains("in use by another process"), "{message}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_waits_for_the_one_before_it() {
    let data = tempfile::tempdir().unwrap();
    let start = || {
        let directory = data.path().to_owned();
        Server::with(|config| config.store = Storage::Directory(directory))
    };
    let first = start().await;
    let job = first.fit(&small_job()).await;
    let second = start().await;
    let path = base(&job);
    let (found, ()) = tokio::join!(second.json(path), async {
        sleep(Duration::from_millis(200)).await;
        first.stop().await;
    });
    assert_eq!(found["id"], job["id"]);
    second.stop().await;
}

/// Says of a store that it has this version of the format.
fn set_version(file: &Path, version: u64) {
    let database = redb::Database::create(file).unwrap();
    let transaction = database.begin_write().unwrap();
    let facts = redb::TableDefinition::<&str, u64>::new("facts");
    let mut table = transaction.open_table(facts).unwrap();
    table.insert("version", version).unwrap();
    drop(table);
    transaction.commit().unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn unknown_files_and_versions_are_clear_errors() {
    let refused = |data: &Path, reason: &str| {
        let output = Program::refused(data);
        assert_eq!(output.status.code(), Some(1));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(reason), "{message}");
    };
    let data = tempfile::tempdir().unwrap();
    let file = data.path().join("piad.redb");
    std::fs::write(&file, b"something else entirely").unwrap();
    refused(data.path(), "cannot be opened");
    std::fs::remove_file(&file).unwrap();

    for version in [0, 1, 2, 99] {
        set_version(&file, version);
        let reason =
            format!("has version {version} of the format, this program reads version 3 only");
        refused(data.path(), &reason);
    }

    // A store most of which is missing; at its end there may be nothing.
    std::fs::remove_file(&file).unwrap();
    drop(Program::start(data.path()));
    let cut = std::fs::OpenOptions::new().write(true).open(&file).unwrap();
    cut.set_len(16_384).unwrap();
    refused(data.path(), "cannot be opened");

    let not_a_directory = data.path().join("piad.redb");
    refused(&not_a_directory, "cannot be used");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_makes_one_job() {
    let data = tempfile::tempdir().unwrap();
    let mut program = Program::start(data.path());
    let post = async |program: &Program, key: &str, body: &Value| {
        let request = program.post("/v1/jobs").header("idempotency-key", key);
        request.json(body).send().await.unwrap()
    };
    let small = data::small_job();
    // At the same time: one of them makes the job, and all get it.
    let (first, second) = tokio::join!(post(&program, "a", &small), post(&program, "a", &small));
    assert_eq!(
        (first.status(), second.status()),
        (201.into_status(), 201.into_status())
    );
    let first: Value = first.json().await.unwrap();
    let second: Value = second.json().await.unwrap();
    assert_eq!(first["id"], second["id"]);
    let other = post(&program, "b", &small)
        .await
        .json::<Value>()
        .await
        .unwrap();
    assert_ne!(first["id"], other["id"]);
    // It is remembered by the disk, not by the process.
    program.kill();
    let program = Program::start(data.path());
    let again = post(&program, "a", &small).await;
    assert_eq!(again.headers()["idempotency-replayed"], "true");
    assert_eq!(again.json::<Value>().await.unwrap()["id"], first["id"]);

    let (status, refused) = problem(post(&program, "a", &data::endless_job()).await).await;
    assert_eq!(
        (status, refused["type"].as_str()),
        (422, Some("/problems/key-taken"))
    );
    let (status, _) = problem(post(&program, "", &small).await).await;
    assert_eq!(status, 400);
    let (status, _) = problem(post(&program, &"k".repeat(256), &small).await).await;
    assert_eq!(status, 400);
    // An edit is replayed when its parent is gone.
    let edits = format!("{}/edits", path(&other));
    let edit = async || {
        let request = program.post(&edits).header("idempotency-key", "edit");
        let body = json!({"stop": {"max_iterations": 3}});
        request
            .json(&body)
            .send()
            .await
            .unwrap()
            .json::<Value>()
            .await
            .unwrap()
    };
    let edited = edit().await;
    let url = format!("http://{}{}", program.address, path(&other));
    program.client.delete(url).send().await.unwrap();
    assert_eq!(edit().await["id"], edited["id"]);

    // A job that is deleted gives its key back.
    let url = format!("http://{}{}", program.address, path(&first));
    program.client.delete(url).send().await.unwrap();
    let anew = post(&program, "a", &small)
        .await
        .json::<Value>()
        .await
        .unwrap();
    assert_ne!(anew["id"], first["id"]);
}

/// Where the disk is full new jobs are refused and old ones are kept.
#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_refuses_new_jobs_and_loses_none() {
    let data = tempfile::tempdir().unwrap();
    // No file may grow beyond 4 MiB (8192 blocks of 512 bytes), and growing says so by an error.
    let limit = "trap '' XFSZ; ulimit -f 8192; exec \"$@\"";
    let mut program = Program::in_shell(limit, data.path());
    let points: Vec<_> = (0..10_000).map(|i| json!([i, i % 7, i % 11])).collect();
    let job = json!({"curve": {"points": points}});
    let mut kept = Vec::new();
    let refused = loop {
        let response = program.post("/v1/jobs").json(&job).send().await.unwrap();
        if response.status() == 201 {
            kept.push(response.json::<Value>().await.unwrap());
            assert!(kept.len() < 100, "the disk is never full");
            continue;
        }
        break response;
    };
    assert!(!kept.is_empty());
    assert_eq!(refused.headers()["retry-after"], "60");
    let (status, refused) = problem(refused).await;
    assert_eq!(
        (status, refused["type"].as_str()),
        (503, Some("/problems/store-full"))
    );
    // The server still works, and starts again; after a restart with more room nothing is missing.
    for is_last in [false, true] {
        for job in &kept {
            assert_eq!(program.json(path(job)).await["id"], job["id"]);
        }
        let list = program.json("/v1/jobs?limit=1000").await;
        assert_eq!(list["jobs"].as_array().unwrap().len(), kept.len());
        program.kill();
        // A third crash of a job on probation would be its last.
        if !is_last {
            program = Program::in_shell(limit, data.path());
        }
    }
    let program = Program::start(data.path());
    for job in &kept {
        let story = stream(&program, path(job)).await;
        assert_eq!(story.state(), "converged");
    }
    program.fit(&job).await;
}

/// Fills the file to the last page, with large jobs first; deletes all jobs; and makes new ones.
async fn fill_and_delete(program: &Program) {
    let mut kept = Vec::new();
    for count in [4000, 400, 40, 4] {
        let points: Vec<_> = (0..count).map(|i| json!([i, i % 7, i % 11])).collect();
        let job = json!({"curve": {"points": points}});
        let mut refused = 0;
        // Jobs that end meanwhile take room, too: the last one may be refused for a moment only.
        while refused < 3 {
            let response = program.post("/v1/jobs").json(&job).send().await.unwrap();
            match response.status().as_u16() {
                201 => kept.push(response.json::<Value>().await.unwrap()),
                status => {
                    assert_eq!(status, 503);
                    refused += 1;
                    tokio::time::sleep(Duration::from_millis(300)).await;
                }
            }
            assert!(kept.len() < 20_000, "the disk is never full");
        }
    }
    assert!(kept.len() > 3);
    for job in &kept {
        let url = format!("http://{}{}", program.address, path(job));
        let deleted = program.client.delete(url).send().await.unwrap();
        assert_eq!(deleted.status(), 204, "of {} jobs", kept.len());
    }
    let list = program.json("/v1/jobs").await;
    assert_eq!(list["jobs"], json!([]));
    for _ in 0..10 {
        program.fit(&data::small_job()).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_can_be_deleted_when_the_file_cannot_grow() {
    let data = tempfile::tempdir().unwrap();
    let limit = "trap '' XFSZ; ulimit -f 8192; exec \"$@\"";
    fill_and_delete(&Program::in_shell(limit, data.path())).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_past_is_kept_within_age_and_size_but_never_a_running_job() {
    let gone = async |program: &Program, job: &Value| {
        eventually("the job is gone", async || {
            program.get(path(job)).send().await.unwrap().status() == 404
        })
        .await;
    };
    let data = tempfile::tempdir().unwrap();
    let program = Program::with(data.path(), &["--retain-age", "1s"]);
    let endless = program.post("/v1/jobs").json(&data::endless_job());
    let endless: Value = endless.send().await.unwrap().json().await.unwrap();
    gone(&program, &program.fit(&data::small_job()).await).await;
    assert_eq!(program.json(path(&endless)).await["state"], "running");

    // A job of 100 points in a plane takes a bit more than 3 kB.
    let data = tempfile::tempdir().unwrap();
    let program = Program::with(data.path(), &["--retain-bytes", "8kB"]);
    let endless = program.post("/v1/jobs").json(&data::endless_job());
    let endless: Value = endless.send().await.unwrap().json().await.unwrap();
    let mut ended = Vec::new();
    for _ in 0..3 {
        ended.push(program.fit(&data::small_job()).await);
    }
    gone(&program, &ended[0]).await;
    for job in [&ended[1], &ended[2]] {
        assert_eq!(program.json(path(job)).await["state"], "converged");
    }
    assert_eq!(program.json(path(&endless)).await["state"], "running");
}

trait IntoStatus {
    fn into_status(self) -> reqwest::StatusCode;
}

impl IntoStatus for u16 {
    fn into_status(self) -> reqwest::StatusCode {
        reqwest::StatusCode::from_u16(self).unwrap()
    }
}
