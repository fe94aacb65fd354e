//! Random changes of valid requests: over HTTP/1.1, HTTP/2 and gRPC,
//! with a token, without one, and to a server that requires none.
//!
//! `PIAD_TEST_REQUESTS=1000000 cargo test --release --test api generated -- --nocapture` sends a million.

mod requests;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use h2::client::SendRequest;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;
use tokio::time::timeout;

use crate::data;
use crate::program::Program;
use crate::random::Random;
use crate::support::eventually;
use crate::tokens_file::TokensFile;
use requests::{Made, Seeds, change};

/// The number sent to each server, unless the variable sets the total number.
const REQUESTS: usize = 10_000;

/// The number of clients, each with one protocol.
const CLIENTS: usize = 12;

/// An answer that has not come by then is given up, as a client that goes away does.
const PATIENCE: Duration = Duration::from_millis(300);

/// So much of an answer is read.
const READ: usize = 64 << 10;

/// What may stay more of the memory of a server, in bytes: pools of threads and connections, caches of their bounded size.
const GROWTH: usize = 150_000_000;

/// The header with the status of a gRPC call.
const GRPC_STATUS: &str = "grpc-status";

/// The status of a call is counted as one of HTTP that is so much larger.
const CALLS: u16 = 1000;

/// Failures that are not the client's: all of HTTP but 503; unknown, internal and data loss of gRPC.
fn is_failure(status: u16) -> bool {
    (500..CALLS).contains(&status) && status != 503 || [1002, 1013, 1015].contains(&status)
}

/// How a client speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Protocol {
    Http1,
    Http2,
    Grpc,
}

/// What came of the requests of a client, by the status; 0 is no answer.
type Answers = BTreeMap<u16, usize>;

/// Sends one request over HTTP/1.1; what it says may be no HTTP at all.
async fn over_http1(address: &str, made: &Made) -> u16 {
    let Ok(mut stream) = TcpStream::connect(address).await else {
        return 0;
    };
    let Made {
        method,
        path,
        headers,
        body,
    } = made;
    let mut bytes = format!(
        "{method} {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\ncontent-length: {}\r\n",
        body.len()
    );
    for (name, value) in headers {
        bytes += &format!("{name}: {value}\r\n");
    }
    bytes += "\r\n";
    let bytes = [bytes.as_bytes(), body].concat();
    let mut answer = Vec::new();
    let exchange = async {
        // It may answer, and close, before it has all.
        let _ = stream.write_all(&bytes).await;
        let mut answered = (&mut stream).take(READ as u64);
        let _ = answered.read_to_end(&mut answer).await;
    };
    let _ = timeout(PATIENCE, exchange).await;
    // No port is kept for a connection that has been reset.
    let _ = stream.set_zero_linger();
    let status = answer
        .get(9..12)
        .and_then(|it| std::str::from_utf8(it).ok());
    status.and_then(|it| it.parse().ok()).unwrap_or(0)
}

/// Sends one request over a connection of HTTP/2; what no request of HTTP/2 can be is not sent.
async fn over_http2(sender: &mut Option<SendRequest<Bytes>>, address: &str, made: &Made) -> u16 {
    if sender.is_none() {
        let Ok(stream) = TcpStream::connect(address).await else {
            return 0;
        };
        let Ok((new, connection)) = h2::client::handshake(stream).await else {
            return 0;
        };
        tokio::spawn(connection);
        *sender = Some(new);
    }
    let mut request = hyper::Request::builder();
    request = request
        .method(made.method.as_str())
        .uri(format!("http://localhost{}", made.path));
    for (name, value) in &made.headers {
        request = request.header(name.as_str(), value.as_str());
    }
    let (Ok(request), Some(ready)) = (request.body(()), sender.take()) else {
        return 0;
    };
    let exchange = async {
        let mut ready = ready.ready().await.ok()?;
        let (answer, mut body) = ready.send_request(request, false).ok()?;
        let _ = body.send_data(Bytes::copy_from_slice(&made.body), true);
        let answer = answer.await.ok()?;
        let (head, mut content) = answer.into_parts();
        let status = head.status.as_u16();
        let mut reported = head.headers.get(GRPC_STATUS).cloned();
        let mut left = READ;
        while let Some(Ok(bytes)) = content.data().await {
            let _ = content.flow_control().release_capacity(bytes.len());
            left = left.saturating_sub(bytes.len());
            if left == 0 {
                break;
            }
        }
        if let Ok(Some(trailers)) = content.trailers().await {
            reported = trailers.get(GRPC_STATUS).cloned();
        }
        let reported = reported.and_then(|reported| reported.to_str().ok()?.parse::<u16>().ok());
        Some((reported.map_or(status, |reported| CALLS + reported), ready))
    };
    match timeout(PATIENCE, exchange).await {
        Ok(Some((status, ready))) => {
            *sender = Some(ready);
            status
        }
        _ => 0,
    }
}

/// Sends this number of requests, generated from this seed.
async fn client(
    address: String,
    protocol: Protocol,
    seeds: Arc<Seeds>,
    token: Option<String>,
    count: usize,
    seed: u64,
) -> Answers {
    let mut dice = Random(seed);
    let mut answers = Answers::new();
    let mut sender = None;
    for _ in 0..count {
        let of_protocol = match protocol {
            Protocol::Grpc => &seeds.calls,
            Protocol::Http1 | Protocol::Http2 => &seeds.http,
        };
        let mut made = dice.one(of_protocol).clone();
        for _ in 0..dice.below(4) {
            change(&mut made, &mut dice);
        }
        // One in four has none, and one in sixteen another one.
        if let Some(token) = token.as_ref().filter(|_| dice.below(4) > 0) {
            let mut value = format!("Bearer {token}");
            if dice.below(16) == 0 {
                value.truncate(dice.below(value.len()));
            }
            made.headers.push(("authorization".to_owned(), value));
        }
        let status = match protocol {
            Protocol::Http1 => over_http1(&address, &made).await,
            Protocol::Http2 | Protocol::Grpc => over_http2(&mut sender, &address, &made).await,
        };
        assert!(!is_failure(status), "{status}: {made:?}");
        *answers.entry(status).or_default() += 1;
    }
    answers
}

async fn survives(server: &Program, token: Option<String>, count: usize) {
    let mut request = server
        .post("/v1/jobs")
        .header("prefer", "wait=60")
        .json(&data::small_job());
    if let Some(token) = &token {
        request = request.bearer_auth(token);
    }
    let job: Value = request.send().await.unwrap().json().await.unwrap();
    let id = job["id"].as_str().unwrap();
    let seeds = Arc::new(Seeds::of(server, id).await);
    let before = server.memory();
    let begin = Instant::now();
    let mut clients = JoinSet::new();
    for index in 0..CLIENTS {
        let protocol = [Protocol::Http1, Protocol::Http2, Protocol::Grpc][index % 3];
        let (address, seeds, token) = (server.address.clone(), seeds.clone(), token.clone());
        let seed = index as u64;
        let answers = client(address, protocol, seeds, token, count / CLIENTS, seed);
        clients.spawn(async move { (protocol, answers.await) });
    }
    let mut all = BTreeMap::new();
    while let Some(answered) = clients.join_next().await {
        let (protocol, answers) = answered.unwrap();
        for (status, count) in answers {
            *all.entry((format!("{protocol:?}"), status)).or_insert(0) += count;
        }
    }
    eprintln!("{count} requests in {:.0?}: {all:?}", begin.elapsed());
    // Answers of all kinds: the requests are not all wrong at the first look.
    let statuses: Vec<u16> = all.keys().map(|(_, status)| *status).collect();
    for status in [200, 201, 400, 404, 422, CALLS, CALLS + 3] {
        assert!(statuses.contains(&status), "{status}: {all:?}");
    }
    assert_eq!(server.get("/livez").send().await.unwrap().status(), 200);
    assert!(!server.log().contains("panicked"), "{}", server.log());
    if let Some(token) = token {
        assert!(!server.log().contains(&token));
    }
    eventually("memory is where it was", async || {
        server.memory() < before + GROWTH
    })
    .await;
}

fn count() -> usize {
    let count = std::env::var("PIAD_TEST_REQUESTS").ok();
    count.map_or(REQUESTS, |count| count.parse::<usize>().unwrap() / 2)
}

/// Fits that do not converge end soon, and few are kept.
const SHORT: [&str; 6] = [
    "--max-points",
    "2000",
    "--retain-jobs",
    "100",
    "--heartbeat",
    "1",
];

#[tokio::test]
async fn a_server_without_tokens_survives() {
    let folder = tempfile::tempdir().unwrap();
    let server = Program::with(folder.path(), &SHORT);
    survives(&server, None, count()).await;
}

#[tokio::test]
async fn a_server_with_tokens_survives() {
    let file = TokensFile::new();
    let token = file.token("a", "jobs:read,jobs:write,metrics");
    let server = file.server(&SHORT);
    survives(&server, Some(token), count()).await;
}
