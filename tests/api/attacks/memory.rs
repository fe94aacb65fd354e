//! The resident size of a server stays within what it may take and a constant of its own.

use bytes::Bytes;
use futures_util::future::join_all;
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use super::{MIB, alone, iterations, post, spiral};
use crate::bodies::Http2;
use crate::program::Program;
use crate::support::{base, client, eventually};

/// What a server takes besides: the program, its stacks and the cache of the store, and what the
/// allocator holds back.
const CONSTANT: usize = 110 * MIB;

/// What each answer takes that is on its way: the piece that is sent, and those that are made ahead.
const ANSWER: usize = 2 * MIB;

/// Reads an answer to its end, and says how long it was.
async fn length(program: &Program, path: &str) -> usize {
    let mut answer = program.get(path).send().await.unwrap();
    assert_eq!(answer.status(), 200, "{path}");
    let mut length = 0;
    while let Some(chunk) = answer.chunk().await.unwrap() {
        length += chunk.len();
    }
    length
}

/// Posts a job and waits for its end; gives its path.
async fn fitted(program: &Program, job: &Value) -> String {
    let job = program.fit(job).await;
    assert!(
        job["error"].is_object() && job["state"] != "running",
        "{job}"
    );
    base(&job).to_owned()
}

/// The memory of the server stays within what it was given.
fn check(program: &Program, given: usize) {
    let most = program.most_memory();
    assert!(most < given + CONSTANT, "{} MiB", most / MIB);
}

/// Runs whose frames are not read: each ring could hold 64 MiB.
#[tokio::test]
async fn recent_frames_share_a_budget() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "64MiB"]);
    let job = json!({
        "curve": {"points": spiral(12)},
        "method": {"kind": "weighted", "omega": 1e-9},
        "stop": {"tolerance": 0, "max_iterations": 1_000_000_000},
    });
    for _ in 0..40 {
        post(&program, "/v1/jobs", &job).await;
    }
    // Kept as they came, they would take some 700 bytes each.
    eventually("they run", async || iterations(&program).await > 500_000.0).await;
    check(&program, 64 * MIB);
}

/// One frame in many forms: each number of samples is another one.
#[tokio::test]
async fn forms_of_a_frame_share_a_budget() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "32MiB"]);
    let job = json!({
        "curve": {"points": spiral(50)}, "stop": {"tolerance": 0, "max_iterations": 9},
    });
    let job = fitted(&program, &job).await;
    for samples in 40_000..40_080 {
        let path = format!("{job}/iterations/3?view=samples&samples={samples}&encoding=base64");
        assert!(length(&program, &path).await > 640_000);
    }
    check(&program, 32 * MIB);
}

/// Readers at different iterations, each of which needs a run of its own that it does not use.
#[tokio::test]
async fn stalled_readers_do_not_hold_runs() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let arguments = ["--memory", "64MiB", "--recent", "0"];
    let program = Program::with(directory.path(), &arguments);
    let job = json!({
        "curve": {"points": spiral(60_000)}, "stop": {"tolerance": 0, "max_iterations": 60},
    });
    let job = fitted(&program, &job).await;
    let paths: Vec<_> = (0..30)
        .map(|k| format!("{job}/events?last_event_id={k}"))
        .collect();
    let stalled = join_all(paths.iter().map(|path| program.stalled_client(path))).await;
    // Another reader has its turn among them.
    assert!(length(&program, &format!("{job}/iterations/37")).await > 2_000_000);
    check(&program, 64 * MIB + stalled.len() * ANSWER);
    drop(stalled);
}

/// Files that are requested but not read.
#[tokio::test]
async fn files_that_are_not_read_share_a_budget() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let arguments = ["--memory", "64MiB", "--write-timeout", "2"];
    let program = Program::with(directory.path(), &arguments);
    let job = json!({"curve": {"points": spiral(40_000)}, "stop": {"max_iterations": 1}});
    let result = format!("{}/result", fitted(&program, &job).await);
    let paths = ["/step", "/csv?samples=500000", "/iges"];
    let paths: Vec<_> = (0..30)
        .map(|i| format!("{result}{}", paths[i % 3]))
        .collect();
    let stalled = join_all(paths.iter().map(|path| program.stalled_client(path))).await;
    // Those that take nothing are closed, and then it is this one's turn.
    assert!(length(&program, &format!("{result}/step")).await > 1_000_000);
    check(&program, 64 * MIB + stalled.len() * ANSWER);
    drop(stalled);
}

/// Jobs that wait have their points in the store, also after somebody has looked at them.
#[tokio::test]
async fn queued_jobs_give_their_points_back() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "32MiB"]);
    let job = json!({
        "curve": {"points": spiral(60_000)},
        "stop": {"tolerance": 0, "max_iterations": 1_000_000_000},
    });
    let mut paths = Vec::new();
    for _ in 0..16 {
        let job = post(&program, "/v1/jobs", &job).await;
        paths.push(base(&job).to_owned());
    }
    assert_eq!(program.json(&paths[15]).await["state"], "queued");
    for path in &paths[2..] {
        assert!(length(&program, &format!("{path}/input")).await > 2_000_000);
    }
    check(&program, 32 * MIB);
}

/// Bodies that are announced, and do not come.
#[tokio::test]
async fn announced_bodies_take_nothing() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "64MiB"]);
    let head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
        Content-Length: 268435456\r\n\r\n{";
    let mut announced = Vec::new();
    for _ in 0..200 {
        let mut stream = TcpStream::connect(&program.address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        announced.push(stream);
    }
    assert_eq!(program.get("/livez").send().await.unwrap().status(), 200);
    check(&program, 64 * MIB);
    drop(announced);
}

/// Small bodies that come in half, as many as HTTP/2 connections carry.
#[tokio::test]
async fn small_bodies_over_http2_are_counted() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "64MiB"]);
    let half = Bytes::from_static(&[b' '; 16 * 1024]);
    let mut connections = Vec::new();
    let mut attacks = Vec::new();
    for _ in 0..100 {
        let mut connection = Http2::connect(&program.address).await;
        for _ in 0..100 {
            let body = Some(half.clone());
            attacks.push(connection.begin("POST", "/v1/jobs", body).await);
        }
        connections.push(connection);
    }
    eventually("most of them are refused", async || {
        attacks.iter().filter(|it| it.is_finished()).count() > 8_900
    })
    .await;
    check(&program, 64 * MIB);
    // Another client is served.
    let other = client().local_address(Some([127, 0, 0, 2].into()));
    let job = json!({"curve": {"points": spiral(12)}});
    let url = format!("http://{}/v1/jobs", program.address);
    let request = other.build().unwrap().post(url).json(&job);
    assert_eq!(request.send().await.unwrap().status(), 201);
    for attack in attacks {
        attack.abort();
    }
}

/// Bodies that arrive mostly and then stall: some are accepted, the others rejected with Retry-After.
#[tokio::test]
async fn large_bodies_wait_for_each_other() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let arguments = ["--memory", "64MiB", "--body-timeout", "4"];
    let program = Program::with(directory.path(), &arguments);
    let head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
        Content-Length: 33554432\r\n\r\n";
    let part = vec![b' '; 8 * MIB];
    let attack = || async {
        let mut stream = TcpStream::connect(&program.address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        // It is refused before it has sent everything.
        let _ = stream.write_all(&part).await;
        stream
    };
    let attacks = join_all((0..40).map(|_| attack())).await;
    let job = json!({"curve": {"points": spiral(12)}});
    let answer = program.post("/v1/jobs").json(&job).send().await.unwrap();
    assert_eq!(answer.status(), 201, "small ones have their own room");
    check(&program, 64 * MIB);
    // Stalled clients are disconnected, and then there is room again.
    let large = json!({"curve": {"points": spiral(60_000)}, "stop": {"max_iterations": 1}});
    eventually("there is room", async || {
        let answer = program.post("/v1/jobs").json(&large).send().await.unwrap();
        match answer.status().as_u16() {
            201 => true,
            503 => {
                assert_eq!(answer.headers()["retry-after"], "5");
                let problem: Value = answer.json().await.unwrap();
                assert_eq!(problem["type"], "/problems/busy");
                false
            }
            status => panic!("{status}"),
        }
    })
    .await;
    drop(attacks);
}

/// At each parameter a thousand basis functions differ from zero: for all samples together their
/// values would take hundreds of megabytes.
#[tokio::test]
async fn samples_are_evaluated_as_they_are_sent() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(directory.path(), &["--memory", "128MiB"]);
    let job = json!({
        "curve": {"points": spiral(1000), "basis": {"kind": "bernstein"}},
        "stop": {"max_iterations": 1},
    });
    let result = format!("{}/result", fitted(&program, &job).await);
    for (view, least) in [
        ("?view=samples&samples=20000", 600_000),
        ("?view=samples&samples=20000&encoding=base64_f32", 200_000),
        ("/csv?samples=20000", 1_000_000),
        ("/gltf?samples=20000", 240_000),
    ] {
        let length = length(&program, &format!("{result}{view}")).await;
        assert!(length > least, "{view}: {length} bytes");
    }
    check(&program, 128 * MIB);
}

/// The memory of a server with nothing to do comes down to a bound.
async fn settles(program: &Program, bound: usize) {
    let what = format!("memory is below {} MiB", bound / MIB);
    eventually(&what, async || program.memory() < bound).await;
}

/// Jobs that have gone leave nothing in the threads that worked for them: neither a large one, nor
/// many of all sizes.
#[tokio::test]
async fn memory_goes_back_when_nothing_happens() {
    let _alone = alone().await;
    let directory = tempfile::tempdir().unwrap();
    let program = Program::start(directory.path());
    let job = |count| json!({"curve": {"points": spiral(count)}, "stop": {"max_iterations": 20}});
    fitted(&program, &job(12)).await;
    let idle = program.memory();

    let large = fitted(&program, &job(400_000)).await;
    // How much it takes depends on how many of its frames are still on their way: 60 to 72 MiB.
    let most = program.most_memory();
    assert!(
        most > idle + 48 * MIB,
        "{} MiB: it is not large",
        most / MIB
    );
    program.delete(&large).send().await.unwrap();
    settles(&program, idle + 32 * MIB).await;

    let one = async |count| {
        let path = fitted(&program, &job(count)).await;
        for file in ["iterations/3?encoding=base64", "result", "result/step"] {
            length(&program, &format!("{path}/{file}")).await;
        }
        program.delete(&path).send().await.unwrap();
    };
    for count in 1..=12 {
        join_all([200, 1000, 3500].map(|size| one(count * size))).await;
    }
    settles(&program, idle + 48 * MIB).await;
}
