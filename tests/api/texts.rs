//! Bodies in UTF-8, with a byte-order mark or without one, and in other encodings.

use prost::Message;
use serde_json::Value;

use crate::data;
use crate::support::{Server, problem};

fn job() -> String {
    data::small_job().to_string()
}

#[tokio::test]
async fn a_byte_order_mark_is_passed_over() {
    let server = Server::start().await;
    let body = format!("\u{feff}{}", job());
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let request = request.header("content-type", "application/json");
    let response = request.body(body).send().await.unwrap();
    assert_eq!(response.status(), 201);
    let job: Value = response.json().await.unwrap();
    assert_eq!(job["state"], "converged");
    // In edits, too; and it is no JSON by itself.
    let edits = format!("{}/edits", job["links"]["self"].as_str().unwrap());
    for (path, body, status) in [
        (
            edits.as_str(),
            "\u{feff}{\"stop\": {\"tolerance\": 1}}",
            201,
        ),
        ("/v1/jobs", "\u{feff}", 400),
    ] {
        let request = server.post(path).header("content-type", "application/json");
        let response = request.body(body).send().await.unwrap();
        assert_eq!(response.status(), status);
    }
}

#[tokio::test]
async fn unknown_encodings_of_content_are_named() {
    let server = Server::start().await;
    for (encoding, name) in [("br", "\"br\""), ("identity, deflate", "\"deflate\"")] {
        let request = server.post("/v1/jobs").header("content-encoding", encoding);
        let request = request.header("content-type", "application/json");
        let response = request.body(job()).send().await.unwrap();
        // What would be understood instead (RFC 9110, 15.5.16).
        assert_eq!(response.headers()["accept-encoding"], "gzip, zstd");
        let (status, answer) = problem(response).await;
        assert_eq!(
            (status, answer["type"].as_str()),
            (415, Some("/problems/unsupported-encoding"))
        );
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains(name), "{name}: {detail}");
    }
    // What is not encoded may say so.
    let request = server
        .post("/v1/jobs")
        .header("content-encoding", "identity");
    let response = request.json(&data::small_job()).send().await.unwrap();
    assert_eq!(response.status(), 201);
}

/// Other encodings than UTF-8, and what is compressed without saying so, are no JSON and no message.
#[tokio::test]
async fn other_encodings_are_refused() {
    let server = Server::start().await;
    let job = job();
    let utf16: Vec<u8> = job.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let message = crate::rpc::curve(&data::helix()).encode_to_vec();
    let gzip = b"\x1f\x8b\x08\0\0\0".to_vec();
    for (body, content_type, encoding) in [
        (utf16, "application/json", "identity"),
        (gzip.clone(), "application/json", "identity"),
        (gzip, "application/x-protobuf", "identity"),
        // It is not what it says.
        (message, "application/x-protobuf", "gzip"),
    ] {
        let request = server.post("/v1/jobs").header("content-encoding", encoding);
        let request = request.header("content-type", content_type);
        let (status, _) = problem(request.body(body).send().await.unwrap()).await;
        assert_eq!(status, 400);
    }
}
