//! Requests that nobody would send, made by changing such that are right at random: over HTTP/1.1, HTTP/2 and gRPC,
//! with a token, without one, and to a server that asks for none.
//!
//! `PIAD_TEST_REQUESTS=1000000 cargo test --release --test api made_up -- --nocapture` sends a million.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use bytes::Bytes;
use h2::client::SendRequest;
use prost::Message;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;
use tokio::time::timeout;

use crate::data;
use crate::messages as pb;
use crate::program::Program;
use crate::rpc::curve;
use crate::support::eventually;
use crate::tokens_file::TokensFile;

/// So many are sent to each server, unless the variable says how many in all.
const REQUESTS: usize = 10_000;

/// So many clients send them, each over one protocol.
const CLIENTS: usize = 12;

/// An answer that has not come by then is given up, as a client that goes away does.
const PATIENCE: Duration = Duration::from_millis(300);

/// So much of an answer is read.
const READ: usize = 64 << 10;

/// What may stay more of the memory of a server, in bytes: pools of threads and connections, caches of their bounded size.
const GROWTH: usize = 150_000_000;

/// The status of a call of gRPC, which is counted as one of HTTP that is so much larger.
const GRPC_STATUS: &str = "grpc-status";
const CALLS: u16 = 1000;

/// Failures that are not the client's: all of HTTP but 503; unknown, internal and data loss of gRPC.
fn is_failure(status: u16) -> bool {
    (500..CALLS).contains(&status) && status != 503 || [1002, 1013, 1015].contains(&status)
}

/// A request, right or not.
#[derive(Clone, Debug)]
struct Made {
    method: String,
    path: String,
    headers: Vec<(String, String)>,
    body: Vec<u8>,
}

/// Numbers that look random, the same in each run: splitmix64.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn one<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

const METHODS: [&str; 8] = [
    "GET", "POST", "DELETE", "HEAD", "PUT", "OPTIONS", "PATCH", "BREW",
];

const PIECES: [&str; 16] = [
    "1e309",
    "-0",
    "null",
    "NaN",
    "[",
    "{",
    "\"",
    "\\ud800",
    "99999999999999999999",
    "0.1",
    "[[[[",
    "\u{0}",
    "é",
    "1e-400",
    "true",
    ",",
];

const PATHS: [&str; 14] = [
    "%00",
    "..",
    "//",
    "%2f",
    "?",
    "&every=0",
    "&samples=9999999999x2",
    "&encoding=base64",
    "&limit=-1",
    "&cursor=x",
    "#",
    "?view=errors&milestones=1,0,nan",
    "/%ff",
    "?ticket=piad_ticket_x",
];

const HEADERS: [(&str, &[&str]); 12] = [
    (
        "accept",
        &[
            "text/event-stream",
            "application/x-ndjson",
            "application/x-protobuf",
            "*/*;q=0",
            "image/svg+xml",
            ",,;",
        ],
    ),
    (
        "content-type",
        &[
            "application/json",
            "application/x-protobuf",
            "text/csv",
            "text/plain",
            "application/grpc",
            "x",
        ],
    ),
    (
        "content-encoding",
        &["gzip", "zstd", "identity", "br", "gzip, gzip"],
    ),
    (
        "accept-encoding",
        &["gzip", "zstd;q=0.5, *;q=0", "identity;q=0"],
    ),
    (
        "prefer",
        &[
            "wait=1",
            "wait=0",
            "wait=99999999999",
            "stream",
            "wait=1, wait=2",
        ],
    ),
    ("idempotency-key", &["a", "b", "", "é"]),
    (
        "last-event-id",
        &["0", "3", "end", "99999999999999999999", "-1", "0-1"],
    ),
    ("if-none-match", &["*", "\"x\"", "W/\"y\""]),
    ("range", &["bytes=0-1", "bytes=9-1"]),
    (
        "traceparent",
        &[
            "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01",
            "00-x",
        ],
    ),
    ("x-request-id", &["mine", "a b", "\u{7f}"]),
    ("grpc-timeout", &["1n", "99999999H", "x"]),
];

/// Changes a request at one place.
fn change(made: &mut Made, dice: &mut Dice) {
    let place = dice.below(made.body.len());
    match dice.below(10) {
        0 => made.method = (*dice.one(&METHODS)).to_owned(),
        1 => made.path += dice.one::<&str>(&PATHS),
        2 => {
            let (name, values) = dice.one(&HEADERS);
            made.headers.retain(|(it, _)| it != name);
            made.headers
                .push(((*name).to_owned(), (*dice.one::<&str>(values)).to_owned()));
        }
        3 if !made.body.is_empty() => made.body[place] ^= 1 << dice.below(8),
        4 => made.body.truncate(place),
        5 | 6 => {
            let piece = dice.one(&PIECES).bytes();
            made.body.splice(place..place, piece);
        }
        7 => {
            let end = made.body.len().min(place + dice.below(40));
            let again = made.body[place..end].to_vec();
            made.body.splice(place..place, again);
        }
        8 => {
            let end = made.body.len().min(place + dice.below(40));
            made.body.drain(place..end);
        }
        _ => made
            .body
            .extend((0..dice.below(300)).map(|index| index as u8)),
    }
}

/// Requests that are right: each operation of the API with each of its examples, and each call of gRPC.
struct Seeds {
    http: Vec<Made>,
    calls: Vec<Made>,
}

impl Seeds {
    async fn of(server: &Program, id: &str) -> Self {
        let description = server.json("/openapi.json").await;
        let mut http = Vec::new();
        for (path, resource) in description["paths"].as_object().unwrap() {
            let path = path.replace("{id}", id).replace("{k}", "1");
            let path = path
                .replace("{format}", "svg")
                .replace("{slug}", "invalid-fit");
            for (method, operation) in resource.as_object().unwrap() {
                let content = operation["requestBody"]["content"].as_object();
                let mut bodies: Vec<(String, Vec<u8>)> = Vec::new();
                for (kind, content) in content.into_iter().flatten() {
                    let examples = content["examples"].as_object().into_iter().flatten();
                    bodies.extend(
                        examples.map(|(_, example)| (kind.clone(), written(&example["value"]))),
                    );
                }
                if bodies.is_empty() {
                    bodies.push((String::new(), Vec::new()));
                }
                for (kind, body) in bodies {
                    let kind = (!kind.is_empty()).then(|| ("content-type".to_owned(), kind));
                    http.push(Made {
                        method: method.to_uppercase(),
                        path: path.clone(),
                        headers: kind.into_iter().collect(),
                        body,
                    });
                }
            }
        }
        // The job itself must stay.
        http.retain(|it| it.method != "DELETE" && !it.path.ends_with("/cancel"));
        let calls = calls(id);
        Self { http, calls }
    }
}

fn written(example: &Value) -> Vec<u8> {
    match example {
        Value::String(text) => text.clone().into_bytes(),
        value => value.to_string().into_bytes(),
    }
}

fn calls(id: &str) -> Vec<Made> {
    let input = Some(curve(&data::wave(12)));
    let create = pb::CreateJobRequest {
        input: input.clone(),
        ..pb::CreateJobRequest::default()
    };
    let fit = pb::FitRequest {
        input,
        ..pb::FitRequest::default()
    };
    let watch = pb::WatchJobRequest {
        id: id.to_owned(),
        ..pb::WatchJobRequest::default()
    };
    // The other requests begin with an id, too, or are empty.
    let named = watch.encode_to_vec();
    let messages = BTreeMap::from([
        ("CreateJob", create.encode_to_vec()),
        ("Fit", fit.encode_to_vec()),
        ("WatchJob", named.clone()),
        ("GetJob", named.clone()),
        ("ListJobs", Vec::new()),
        ("EditJob", named.clone()),
        ("GetIteration", named.clone()),
        ("GetResult", named.clone()),
        ("GetDeviation", named.clone()),
        ("GetInput", named.clone()),
        ("CompareBases", vec![8, 20]),
        ("Nothing", named),
    ]);
    let call = |(name, message): (&str, Vec<u8>)| {
        let mut body = vec![0];
        body.extend((message.len() as u32).to_be_bytes());
        body.extend(message);
        Made {
            method: "POST".to_owned(),
            path: format!("/piad.v1.FittingService/{name}"),
            headers: vec![
                ("content-type".to_owned(), "application/grpc".to_owned()),
                ("te".to_owned(), "trailers".to_owned()),
            ],
            body,
        }
    };
    messages.into_iter().map(call).collect()
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
        let mut told = head.headers.get(GRPC_STATUS).cloned();
        let mut left = READ;
        while let Some(Ok(bytes)) = content.data().await {
            let _ = content.flow_control().release_capacity(bytes.len());
            left = left.saturating_sub(bytes.len());
            if left == 0 {
                break;
            }
        }
        if let Ok(Some(trailers)) = content.trailers().await {
            told = trailers.get(GRPC_STATUS).cloned();
        }
        let told = told.and_then(|told| told.to_str().ok()?.parse::<u16>().ok());
        Some((told.map_or(status, |told| CALLS + told), ready))
    };
    match timeout(PATIENCE, exchange).await {
        Ok(Some((status, ready))) => {
            *sender = Some(ready);
            status
        }
        _ => 0,
    }
}

/// Sends so many requests, which are those of this seed.
async fn client(
    address: String,
    protocol: Protocol,
    seeds: std::sync::Arc<Seeds>,
    token: Option<String>,
    count: usize,
    seed: u64,
) -> Answers {
    let mut dice = Dice(seed);
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
    let seeds = std::sync::Arc::new(Seeds::of(server, id).await);
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
