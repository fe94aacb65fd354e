//! Bodies that come compressed, and answers that go so.

use std::io::{Read, Write};
use std::time::Duration;

use bytes::Bytes;
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use prost::Message;
use reqwest::{Method, Response};
use serde_json::{Value, json};

use crate::data;
use crate::program::Program;
use crate::support::{Server, base, problem};

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = zstd::Encoder::new(Vec::new(), 3).unwrap();
    encoder.include_checksum(true).unwrap();
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A coding by its name.
fn packed(coding: &str, bytes: &[u8]) -> Vec<u8> {
    match coding {
        "gzip" => gzip(bytes),
        _ => zstd(bytes),
    }
}

fn unpacked(coding: &str, bytes: &[u8]) -> Vec<u8> {
    if coding == "zstd" {
        return zstd::decode_all(bytes).unwrap();
    }
    let mut unpacked = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes);
    decoder.read_to_end(&mut unpacked).unwrap();
    unpacked
}

async fn post(server: &Server, coding: &str, media_type: &str, body: Vec<u8>) -> Response {
    let request = server.post("/v1/jobs").header("content-encoding", coding);
    let request = request.header("content-type", media_type);
    request
        .header("prefer", "wait=100")
        .body(body)
        .send()
        .await
        .unwrap()
}

async fn post_json(server: &Server, coding: &str, body: Vec<u8>) -> Response {
    post(server, coding, "application/json", body).await
}

async fn get(server: &Server, method: Method, path: &str, accepted: &str) -> Response {
    let request = server
        .client
        .request(method, format!("{}{path}", server.url));
    let request = request.header("accept-encoding", accepted);
    request.send().await.unwrap()
}

fn header<'a>(response: &'a Response, name: &str) -> Option<&'a str> {
    let value = response.headers().get(name)?;
    Some(value.to_str().unwrap())
}

fn varies(response: &Response) -> bool {
    let values = response.headers().get_all("vary").iter();
    let mut names = values.flat_map(|value| value.to_str().unwrap().split(','));
    names.any(|name| name.trim().eq_ignore_ascii_case("accept-encoding"))
}

/// A job of a curve through this number of points.
fn long_job(count: usize) -> Value {
    let point = |i: usize| {
        let t = i as f64 * 0.01;
        json!([t, t.sin() * (1.0 + 0.1 * (3.0 * t).cos())])
    };
    let points: Vec<Value> = (0..count).map(point).collect();
    json!({"name": "long", "curve": {"points": points}, "method": "direct"})
}

#[tokio::test]
async fn bodies_may_be_compressed() {
    let server = Server::start().await;
    for job in [data::small_job(), long_job(30_000)] {
        let text = job.to_string().into_bytes();
        let plain = server.fit(&job).await;
        let expected = server.json(&format!("{}/input", base(&plain))).await;
        for coding in ["gzip", "x-gzip", "GZIP", "zstd", "identity, zstd"] {
            let name = coding.rsplit(' ').next().unwrap();
            let name = if name == "zstd" { "zstd" } else { "gzip" };
            let response = post_json(&server, coding, packed(name, &text)).await;
            assert_eq!(response.status(), 201, "{coding}");
            let job: Value = response.json().await.unwrap();
            let input = server.json(&format!("{}/input", base(&job))).await;
            assert_eq!(input, expected);
        }
        // In several parts, as some programs write.
        let (start, end) = text.split_at(text.len() / 3);
        for coding in ["gzip", "zstd"] {
            let parts = [packed(coding, start), packed(coding, end)].concat();
            let response = post_json(&server, coding, parts).await;
            assert_eq!(response.status(), 201, "{coding}");
        }
    }
    // Messages and edits, too.
    let message = crate::rpc::curve(&data::helix()).encode_to_vec();
    let response = post(&server, "gzip", "application/x-protobuf", gzip(&message)).await;
    assert_eq!(response.status(), 201);
    let job: Value = response.json().await.unwrap();
    let edit = gzip(br#"{"stop": {"tolerance": 1}}"#);
    let request = server.post(&format!("{}/edits", base(&job)));
    let request = request.header("content-encoding", "gzip");
    let request = request.header("content-type", "application/json");
    assert_eq!(request.body(edit).send().await.unwrap().status(), 201);
}

/// A key belongs to what was sent, however it was compressed.
#[tokio::test]
async fn a_body_is_the_same_in_each_coding() {
    let server = Server::start().await;
    let text = data::small_job().to_string().into_bytes();
    let mut ids = Vec::new();
    for coding in ["identity", "gzip", "zstd"] {
        let body = match coding {
            "identity" => text.clone(),
            _ => packed(coding, &text),
        };
        let request = server.post("/v1/jobs").header("content-encoding", coding);
        let request = request.header("idempotency-key", "one");
        let request = request.header("content-type", "application/json");
        let response = request.body(body).send().await.unwrap();
        assert_eq!(response.status(), 201);
        let job: Value = response.json().await.unwrap();
        ids.push(job["id"].clone());
    }
    assert!(ids.iter().all(|id| *id == ids[0]));
}

#[tokio::test]
async fn damaged_bodies_are_refused() {
    let server = Server::start().await;
    let text = long_job(5000).to_string().into_bytes();
    for coding in ["gzip", "zstd"] {
        let whole = packed(coding, &text);
        let mut damaged = whole.clone();
        let middle = damaged.len() / 2;
        damaged[middle..middle + 40].fill(0x55);
        let mut wrong_sum = whole.clone();
        let sum = wrong_sum.len() - 6;
        if coding == "gzip" {
            wrong_sum[sum] ^= 1;
        } else {
            wrong_sum[middle] ^= 0x10;
        }
        let cases = [
            whole[..whole.len() - 1].to_vec(),
            whole[..middle].to_vec(),
            whole[..3].to_vec(),
            Vec::new(),
            damaged,
            wrong_sum,
            text.clone(),
            [whole.clone(), b"and more".to_vec()].concat(),
        ];
        for (index, body) in cases.into_iter().enumerate() {
            let (status, answer) = problem(post_json(&server, coding, body).await).await;
            assert_eq!(status, 400, "{coding} {index}: {answer}");
            let detail = answer["detail"].as_str().unwrap();
            let reported = format!("the body cannot be unpacked as {coding}");
            assert!(detail.starts_with(&reported), "{detail}");
        }
    }
    // Compressed twice is compressed still, and no JSON.
    let twice = gzip(&gzip(&text));
    let response = post_json(&server, "gzip", twice).await;
    assert_eq!(problem(response).await.0, 400);
    let response = post_json(&server, "gzip, gzip", gzip(&text)).await;
    assert_eq!(header(&response, "accept-encoding"), Some("gzip, zstd"));
    assert_eq!(problem(response).await.0, 415);
}

/// The limit is for what is in a body, to the byte.
#[tokio::test]
async fn bodies_are_limited_by_their_unpacked_size() {
    let text = long_job(3000).to_string().into_bytes();
    for (limit, status) in [(text.len(), 201), (text.len() - 1, 413)] {
        let server =
            Server::with(|config| config.max_body = bytesize::ByteSize(limit as u64)).await;
        for coding in ["gzip", "zstd"] {
            let response = post_json(&server, coding, packed(coding, &text)).await;
            assert_eq!(response.status(), status, "{coding}");
        }
    }
    // Bytes that stand for nothing have an end, too: frames of zstd that are to be skipped.
    let server = Server::with(|config| config.max_body = bytesize::ByteSize(100_000)).await;
    let nothing = b"\x50\x2a\x4d\x18\x08\0\0\0........".repeat(10_000);
    let body = reqwest::Body::wrap_stream(futures_util::stream::iter([Ok::<_, std::io::Error>(
        Bytes::from(nothing),
    )]));
    let request = server.post("/v1/jobs").header("content-encoding", "zstd");
    let request = request.header("content-type", "application/json");
    let response = request.body(body).send().await.unwrap();
    assert_eq!(problem(response).await.0, 413);
}

/// A gigabyte of zeros in some kilobytes is refused without using memory.
#[tokio::test]
async fn bombs_do_not_go_off() {
    let directory = tempfile::tempdir().unwrap();
    let program = Program::with(
        directory.path(),
        &["--memory", "64MiB", "--max-body", "16MiB"],
    );
    let zeros = vec![0; 1 << 20];
    let mut small = GzEncoder::new(Vec::new(), Compression::best());
    let mut tiny = zstd::Encoder::new(Vec::new(), 3).unwrap();
    for _ in 0..1024 {
        small.write_all(&zeros).unwrap();
        tiny.write_all(&zeros).unwrap();
    }
    let bombs = [
        ("gzip", small.finish().unwrap()),
        ("zstd", tiny.finish().unwrap()),
    ];
    for round in 0..4 {
        let (coding, bomb) = &bombs[round % 2];
        let request = program.post("/v1/jobs");
        let request = request
            .header("content-encoding", *coding)
            .header("content-type", "application/json");
        let request = request.timeout(Duration::from_secs(60));
        let (status, answer) = problem(request.body(bomb.clone()).send().await.unwrap()).await;
        assert_eq!(status, 413, "{answer}");
    }
    let most = program.most_memory();
    assert!(most < 150 << 20, "{} MiB", most >> 20);
}

#[tokio::test]
async fn answers_are_compressed_for_clients_that_accept_it() {
    let server = Server::start().await;
    let job = server.fit(&long_job(20_000)).await;
    let job = base(&job);
    for path in [
        "/openapi.json".to_owned(),
        "/v1/capabilities".to_owned(),
        "/problems".to_owned(),
        format!("{job}/input"),
        format!("{job}/result"),
        format!("{job}/result/step"),
        format!("{job}/iterations/0?view=samples&samples=50000"),
        format!("{job}/iterations/0/csv"),
    ] {
        let plain = get(&server, Method::GET, &path, "identity").await;
        assert_eq!(header(&plain, "content-encoding"), None);
        assert!(varies(&plain), "{path}");
        let names = ["content-type", "content-disposition", "cache-control"];
        let reported = names.map(|name| header(&plain, name).map(str::to_owned));
        let plain = plain.bytes().await.unwrap();
        for coding in ["gzip", "zstd"] {
            let response = get(&server, Method::GET, &path, coding).await;
            assert_eq!(
                header(&response, "content-encoding"),
                Some(coding),
                "{path}"
            );
            assert_eq!(header(&response, "content-length"), None);
            assert!(varies(&response), "{path}");
            assert_eq!(
                names.map(|name| header(&response, name).map(str::to_owned)),
                reported
            );
            let bytes = response.bytes().await.unwrap();
            assert!(unpacked(coding, &bytes) == plain, "{path}");
            // Of numbers in binary hardly more than their exponents are alike.
            assert!(
                bytes.len() < plain.len() * 19 / 20,
                "{path} {coding}: {} of {}",
                bytes.len(),
                plain.len()
            );
            let head = get(&server, Method::HEAD, &path, coding).await;
            assert_eq!(header(&head, "content-encoding"), Some(coding), "{path}");
            assert_eq!(head.bytes().await.unwrap().len(), 0);
        }
    }
    // Jobs and problems that are short go as they are.
    let mut response = get(&server, Method::GET, "/livez", "gzip").await;
    assert_eq!(header(&response, "content-encoding"), None);
    response = get(&server, Method::GET, "/nothing", "gzip").await;
    assert_eq!(header(&response, "content-encoding"), None);
}

/// Each event is there when it was made.
#[tokio::test]
async fn event_streams_are_never_compressed() {
    let server = Server::start().await;
    for accept in ["text/event-stream", "application/x-ndjson"] {
        let request = server.post("/v1/jobs").header("accept", accept);
        let request = request
            .header("accept-encoding", "gzip, zstd")
            .json(&long_job(5000));
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 200);
        assert_eq!(header(&response, "content-encoding"), None, "{accept}");
        assert!(response.text().await.unwrap().contains("converged"));
    }
    let message = crate::rpc::curve(&data::helix()).encode_to_vec();
    let request = server
        .post("/v1/jobs")
        .header("accept", "application/x-protobuf");
    let request = request
        .header("prefer", "stream")
        .header("accept-encoding", "gzip");
    let request = request.header("content-type", "application/x-protobuf");
    let response = request.body(message).send().await.unwrap();
    assert_eq!(header(&response, "content-encoding"), None);
}
