//! One client's work does not stop the others: the server answers at once, and their jobs run.

use std::pin::pin;
use std::time::Duration;

use futures_util::future::join_all;
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::time::sleep;

use super::{alone, iterations, post, spiral};
use crate::program::Program;
use crate::support::{base, client, eventually};

/// A job whose set-up takes seconds: the factors of a dense matrix, some times over.
fn dense(count: usize) -> Value {
    json!({
        "curve": {"points": spiral(count), "basis": {"kind": "bspline", "degree": count / 3}},
        "stop": {"max_iterations": 2},
    })
}

/// The server answers, and another client's small jobs are done.
async fn serves_others(program: &Program) {
    let job = json!({"curve": {"points": spiral(30)}});
    for _ in 0..5 {
        for _ in 0..3 {
            assert_eq!(program.get("/livez").send().await.unwrap().status(), 200);
        }
        assert_eq!(program.fit(&job).await["state"], "converged");
    }
}

/// A job is still before its first iteration.
async fn assert_in_set_up(program: &Program, job: &Value) {
    let job = program.json(base(job)).await;
    assert_eq!(job["iteration"], Value::Null, "{job}");
    assert!(job["finished_at"].is_null(), "{job}");
}

async fn until_ended(program: &Program, job: &Value) {
    let result = format!("{}/result", base(job));
    eventually("the job has ended", async || {
        program.get(&result).send().await.unwrap().status() == 200
    })
    .await;
}

/// Set-ups take seconds each, in one piece: they have a lane of their own, and who cancels a job in
/// its set-up, or one that waits for it, does not wait.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn set_ups_do_not_delay_others_and_are_cancelled_at_once() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    let body = dense(700);
    let jobs = join_all((0..9).map(|_| post(&program, "/v1/jobs", &body))).await;
    // They are done in the order in which they came: while the last one waits, others do not.
    serves_others(&program).await;
    assert_in_set_up(&program, &jobs[8]).await;
    let cancelled = jobs[..4]
        .iter()
        .map(|job| post_empty(&program, format!("{}/cancel", base(job))));
    for state in join_all(cancelled).await {
        assert_eq!(state, "cancelled");
    }
    for job in &jobs[4..8] {
        let answer = program.delete(base(job)).send().await.unwrap();
        assert_eq!(answer.status(), 204);
    }
    assert_in_set_up(&program, &jobs[8]).await;
}

async fn post_empty(program: &Program, path: String) -> String {
    let answer = program.post(&path).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    let job: Value = answer.json().await.unwrap();
    job["state"].as_str().unwrap().to_owned()
}

/// What would take too long in one piece is refused, with the reason.
#[tokio::test]
async fn too_much_work_in_one_piece_is_refused() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    let job = json!({"curve": {
        "points": spiral(3900), "basis": {"kind": "bspline", "degree": 1000},
    }});
    let answer = program.post("/v1/jobs").json(&job).send().await.unwrap();
    assert_eq!(answer.status(), 422);
    let problem: Value = answer.json().await.unwrap();
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("preparing the fit"), "{detail}");
    assert!(detail.contains("lower degree"), "{detail}");
}

/// Each sample of four points of degree 1000 takes a million multiplications. Others have their turns beside millions
/// of them, and none is computed once the clients have gone.
#[tokio::test]
async fn samples_of_a_high_degree_give_way_and_end_with_their_clients() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    let job = json!({
        "curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]], "degree": 1000, "ends": "repeated"},
        "method": {"kind": "direct"},
        "stop": {"max_iterations": 1},
    });
    let request = program.post("/v1/jobs").header("prefer", "wait=60");
    let answer = request.json(&job).send().await.unwrap();
    let job: Value = answer.json().await.unwrap();
    let path = job["links"]["result"].as_str().unwrap();
    let mut streams = Vec::new();
    for index in 0..8 {
        let samples = format!("{path}/csv?samples={}", 1_000_000 - index);
        let mut response = program.get(&samples).send().await.unwrap();
        assert!(response.chunk().await.unwrap().is_some());
        streams.push(response);
    }
    let other = client()
        .local_address(Some([127, 0, 0, 2].into()))
        .build()
        .unwrap();
    for file in ["svg", "csv?samples=100", "dxf"] {
        let answer = other
            .get(format!("http://{}{path}/{file}", program.address))
            .send()
            .await
            .unwrap();
        assert_eq!(answer.status(), 200, "{file}");
        answer.bytes().await.unwrap();
    }
    drop(streams);
    // What has begun takes hundredths of a second.
    sleep(Duration::from_secs(2)).await;
    let before = ticks(&program);
    sleep(Duration::from_secs(3)).await;
    let used = ticks(&program) - before;
    assert!(
        used < 100,
        "{used} hundredths of a second for clients that have gone"
    );
}

/// A scattered surface with fairness, whose matrices take long.
fn fair(points: usize, degree: usize, control_points: usize) -> Value {
    let place = |i: usize| {
        [
            (i as f64 * 0.618_033_988_75) % 1.0,
            (i as f64 + 0.5) / points as f64,
        ]
    };
    let places: Vec<_> = (0..points).map(place).collect();
    let point = |&[u, v]: &[f64; 2]| [u, v, (7.0 * u).sin() * v];
    let data: Vec<_> = places.iter().map(point).collect();
    json!({
        "surface": {"scattered": data, "parameters": places, "degree": degree},
        "method": {"kind": "least_squares", "control_points": control_points, "fairness": 1e-6},
    })
}

/// How much processor time the server has used, in clock ticks, which are hundredths of a second.
fn ticks(program: &Program) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", program.id())).unwrap();
    let (_, fields) = stat.rsplit_once(')').unwrap();
    let fields: Vec<&str> = fields.split_whitespace().collect();
    fields[11..=12]
        .iter()
        .map(|it| it.parse::<u64>().unwrap())
        .sum()
}

/// Sizes are known before anything is computed that takes long.
#[tokio::test]
async fn too_much_memory_is_refused_before_anything_is_computed() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "1GiB"]);
    let job = fair(40_000, 100, 150);
    let before = ticks(&program);
    let answer = program.post("/v1/jobs").json(&job).send().await.unwrap();
    assert_eq!(answer.status(), 422);
    let problem: Value = answer.json().await.unwrap();
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("bytes of memory"), "{detail}");
    let used = ticks(&program) - before;
    assert!(used < 300, "it took {used} hundredths of a second");
}

/// The set-up of an abandoned job ends.
#[tokio::test]
async fn set_ups_end_with_their_jobs() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    // Seconds each.
    let body = dense(700);
    let jobs = join_all((0..8).map(|_| post(&program, "/v1/jobs", &body))).await;
    for job in &jobs {
        let answer = program.delete(base(job)).send().await.unwrap();
        assert_eq!(answer.status(), 204);
    }
    let before = ticks(&program);
    serves_others(&program).await;
    let used = ticks(&program) - before;
    assert!(
        used < 300,
        "set-ups continue: {used} hundredths of a second"
    );
}

/// Edits of a job whose system is being made: the threads of the network do not wait for it.
#[tokio::test]
async fn edits_do_not_stop_the_network() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--recent", "0"]);
    let parent = post(&program, "/v1/jobs", &dense(600)).await;
    until_ended(&program, &parent).await;
    let edits = format!("{}/edits", base(&parent));
    let edit = json!({"points": [{"index": 3, "point": [1, 2]}], "iteration": 1});
    let mut edits = pin!(join_all((0..3).map(|_| post(&program, &edits, &edit))));
    tokio::select! {
        _ = &mut edits => panic!("others waited for the edits"),
        () = serves_others(&program) => {}
    }
    assert_eq!(edits.await.len(), 3);
}

/// Levels that are computed again for clients that have gone are given up.
#[tokio::test]
async fn abandoned_work_stops() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--recent", "0", "--ring", "64KiB"]);
    let job = json!({
        "curve": {"points": spiral(4000), "basis": {"kind": "bspline", "degree": 30}},
        "method": {"kind": "weighted", "omega": 1e-6},
        "stop": {"tolerance": 0, "max_iterations": 2000},
    });
    let job = post(&program, "/v1/jobs", &job).await;
    until_ended(&program, &job).await;
    let before = iterations(&program).await;
    for k in 1980..1990 {
        let mut stream = TcpStream::connect(&program.address).await.unwrap();
        let request = format!(
            "GET {}/iterations/{k} HTTP/1.1\r\nHost: localhost\r\n\r\n",
            base(&job)
        );
        stream.write_all(request.as_bytes()).await.unwrap();
    }
    // All of them have gone by now: their work, of which there is much, is soon at rest.
    let mut last = iterations(&program).await;
    eventually("work for clients that have gone stops", async || {
        sleep(Duration::from_millis(300)).await;
        let before = std::mem::replace(&mut last, iterations(&program).await);
        last == before
    })
    .await;
    assert!(
        last - before < 1900.0,
        "{} iterations without a reader",
        last - before
    );
    serves_others(&program).await;
}
