//! One client does not take what is there for all: jobs and connections of one address.

use std::path::Path;

use futures_util::StreamExt;
use reqwest::Client;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::{Duration, sleep, timeout};

use crate::data;
use crate::program::Program;
use crate::support::{PATIENCE, Server, base, client, events, problem};

#[tokio::test]
async fn one_client_does_not_fill_the_queue() {
    let server = Server::with(|config| config.max_jobs = 4).await;
    let capabilities = server.json("/v1/capabilities").await;
    assert_eq!(capabilities["limits"]["jobs_per_peer"], 2);
    let first = server.create(&data::endless_job()).await;
    server.create(&data::endless_job()).await;
    // Edits start from an iteration, so there must be one.
    let path = format!("{}/events", base(&first));
    let mut stream = events(server.get(&path).send().await.unwrap());
    while stream.next().await.unwrap().name != "iteration" {}
    drop(stream);

    let request = server.post("/v1/jobs").json(&data::small_job());
    let response = request.send().await.unwrap();
    assert_eq!(response.headers()["retry-after"], "5");
    let (status, answer) = problem(response).await;
    assert_eq!(status, 429);
    assert_eq!(answer["type"], "/problems/too-many-jobs");
    assert!(
        answer["detail"]
            .as_str()
            .unwrap()
            .contains("2 of your jobs")
    );
    // An edit is a job, too.
    let edit = server.post(&format!("{}/edits", base(&first)));
    let edit = edit.json(&json!({"stop": {"tolerance": 1}}));
    let (status, answer) = problem(edit.send().await.unwrap()).await;
    assert_eq!(status, 429, "{answer}");

    let request = another().post(format!("{}/v1/jobs", server.url));
    let response = request.json(&data::small_job()).send().await.unwrap();
    assert_eq!(response.status(), 201);

    let cancel = server.post(&format!("{}/cancel", base(&first)));
    assert!(cancel.send().await.unwrap().status().is_success());
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
}

/// A client at 127.0.0.2.
fn another() -> Client {
    let client = client().local_address(Some([127, 0, 0, 2].into()));
    client.build().unwrap()
}

/// However many jobs one client has, running and waiting for memory, a small job of another one runs.
#[tokio::test]
async fn one_client_does_not_take_all_turns_and_memory() {
    let server = Server::with(|config| config.memory = Some("64MiB".parse().unwrap())).await;
    let job = json!({
        "curve": {"points": data::wave(400)},
        "method": {"kind": "transpose"},
        "stop": {"tolerance": 0, "max_iterations": 100_000_000},
    });
    for _ in 0..200 {
        server.create(&job).await;
    }
    let queued = server.json("/v1/jobs?state=queued").await;
    assert!(!queued["jobs"].as_array().unwrap().is_empty(), "{queued}");
    let other = another();
    for _ in 0..10 {
        let request = other.post(format!("{}/v1/jobs", server.url));
        let request = request
            .header("prefer", "wait=100")
            .json(&data::small_job());
        let job: Value = request.send().await.unwrap().json().await.unwrap();
        assert_eq!(job["state"], "converged");
    }
    let ended = server.json("/v1/jobs?state=exhausted").await;
    assert_eq!(
        ended["jobs"],
        json!([]),
        "nothing of the first one has ended"
    );
}

/// One client cannot sit on the keys of another one.
#[tokio::test]
async fn each_client_has_keys_of_its_own() {
    let server = Server::start().await;
    let other = another();
    let post = async |client: &Client, job: &Value| {
        let request = client.post(format!("{}/v1/jobs", server.url));
        let request = request.header("idempotency-key", "wing-17").json(job);
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 201);
        let replayed = response.headers().contains_key("idempotency-replayed");
        let job: Value = response.json().await.unwrap();
        (job["id"].clone(), replayed)
    };
    let (first, replayed) = post(&server.client, &data::small_job()).await;
    assert!(!replayed);
    let endless = data::endless_job();
    let (second, replayed) = post(&other, &endless).await;
    assert!(!replayed && second != first);
    assert_eq!(post(&other, &endless).await, (second, true));
    assert_eq!(
        post(&server.client, &data::small_job()).await,
        (first, true)
    );
}

async fn connect_from(program: &Program, last: u8) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind(([127, 0, 0, last], 0).into()).unwrap();
    let address = program.address.parse().unwrap();
    timeout(PATIENCE, socket.connect(address))
        .await
        .unwrap()
        .unwrap()
}

/// The head and the body of an answer to a client at 127.0.0.`last`, on a connection of its own.
async fn get_from(program: &Program, last: u8, path: &str) -> (String, String) {
    let mut stream = connect_from(program, last).await;
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    let read = stream.read_to_string(&mut answer);
    timeout(PATIENCE, read).await.unwrap().unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").expect(&answer);
    (head.to_owned(), body.to_owned())
}

fn is_ok(answer: &(String, String)) -> bool {
    answer.0.starts_with("HTTP/1.1 200 ")
}

#[tokio::test]
async fn idle_connections_do_not_block_others() {
    // 192 connections in all, 96 of an address.
    let mut program = Program::in_shell(
        r#"ulimit -n 256; exec "$@" --header-timeout 3600"#,
        Path::new(":memory:"),
    );
    let mut idle = Vec::new();
    for _ in 0..300 {
        idle.push(connect_from(&program, 1).await);
    }
    assert!(is_ok(&get_from(&program, 2, "/v1/jobs").await));
    assert!(is_ok(&get_from(&program, 1, "/livez").await));
    assert!(is_ok(&get_from(&program, 1, "/readyz").await));
    let (head, body) = get_from(&program, 1, "/v1/jobs").await;
    assert!(head.starts_with("HTTP/1.1 503 "), "{head}");
    assert!(head.to_lowercase().contains("\r\nretry-after: 5"), "{head}");
    assert!(
        head.to_lowercase().contains("\r\nconnection: close"),
        "{head}"
    );
    let body: Value = serde_json::from_str(&body).unwrap();
    assert_eq!(body["type"], "/problems/too-many-connections");
    assert!(
        body["detail"].as_str().unwrap().starts_with("96 "),
        "{body}"
    );

    // Others take the rest; then only the state of the server is available.
    for last in 2..=4 {
        for _ in 0..100 {
            idle.push(connect_from(&program, last).await);
        }
    }
    for last in 1..=5 {
        assert!(is_ok(&get_from(&program, last, "/livez").await));
    }
    let (_, body) = get_from(&program, 5, "/v1/jobs").await;
    assert!(body.contains("192 connections are open"), "{body}");
    let (_, metrics) = get_from(&program, 5, "/metrics").await;
    let open = metrics
        .lines()
        .find_map(|line| line.strip_prefix("piad_connections_open "));
    let open: u32 = open.expect(&metrics).parse().unwrap();
    assert!((193..=192 + 32 + 1).contains(&open), "{open}");

    // It is logged occasionally, not each time.
    let log = program.log();
    let reported = log
        .lines()
        .filter(|line| line.contains("connections from one address are open"));
    assert!((1..=12).contains(&reported.count()), "{log}");
    // High demand is not an error of the server.
    assert!(!log.contains(r#""level":"ERROR""#), "{log}");

    // When they have gone everything is as before.
    drop(idle);
    let again = async {
        while !is_ok(&get_from(&program, 1, "/v1/jobs").await) {
            sleep(Duration::from_millis(20)).await;
        }
    };
    timeout(PATIENCE, again).await.unwrap();
    program.signal("-TERM");
    assert_eq!(program.wait().code(), Some(0));
}
