//! Bodies in other encodings than UTF-8 are named as what they are.

use prost::Message;
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

/// A body, the value of Content-Encoding if there is one, the type of the problem and a part of the reason.
type Case = (Vec<u8>, Option<&'static str>, &'static str, &'static str);

fn utf16(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(bytes).collect()
}

fn utf32(text: &str, bytes: impl Fn(u32) -> [u8; 4]) -> Vec<u8> {
    text.chars().flat_map(|c| bytes(c.into())).collect()
}

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
async fn other_encodings_are_named() {
    let server = Server::start().await;
    let job = job();
    let marked = format!("\u{feff}{job}");
    let (media, coding) = ("unsupported-media-type", "unsupported-encoding");
    let cases: Vec<Case> = vec![
        (utf16(&marked, u16::to_le_bytes), None, media, "UTF-16"),
        (utf16(&marked, u16::to_be_bytes), None, media, "UTF-16"),
        (utf16(&job, u16::to_le_bytes), None, media, "UTF-16"),
        (utf16(&job, u16::to_be_bytes), None, media, "UTF-16"),
        (utf32(&marked, u32::to_le_bytes), None, media, "UTF-32"),
        (utf32(&marked, u32::to_be_bytes), None, media, "UTF-32"),
        (utf32(&job, u32::to_le_bytes), None, media, "UTF-32"),
        (utf32(&job, u32::to_be_bytes), None, media, "UTF-32"),
        (b"\x1f\x8b\x08\0\0\0".to_vec(), None, coding, "gzip"),
        (b"\x28\xb5\x2f\xfd\x04".to_vec(), None, coding, "zstd"),
        (b"\x78\x9c\xab\x56".to_vec(), None, coding, "deflate"),
        (job.clone().into(), Some("br"), coding, "\"br\""),
        (
            job.clone().into(),
            Some("identity, deflate"),
            coding,
            "\"deflate\"",
        ),
    ];
    for (body, encoding, kind, reason) in cases {
        let mut request = server.post("/v1/jobs");
        request = request.header("content-type", "application/json");
        if let Some(encoding) = encoding {
            request = request.header("content-encoding", encoding);
        }
        let response = request.body(body).send().await.unwrap();
        // What would be understood instead (RFC 9110, 15.5.16).
        let accepted = response.headers().get("accept-encoding").cloned();
        assert_eq!(
            accepted.is_some_and(|it| it == "gzip, zstd"),
            kind == coding
        );
        let (status, answer) = problem(response).await;
        assert_eq!(
            (status, &answer["type"]),
            (415, &json!(format!("/problems/{kind}")))
        );
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{reason}: {detail}");
    }
    // What is not encoded may say so.
    let request = server
        .post("/v1/jobs")
        .header("content-encoding", "identity");
    let response = request.json(&data::small_job()).send().await.unwrap();
    assert_eq!(response.status(), 201);
}

#[tokio::test]
async fn compressed_messages_are_named() {
    let server = Server::start().await;
    let message = crate::rpc::curve(&data::helix()).encode_to_vec();
    for (body, encoding, status) in [
        // It is not what it says.
        (message, "gzip", 400),
        (b"\x1f\x8b\x08\0\0\0".to_vec(), "identity", 415),
    ] {
        let request = server.post("/v1/jobs").header("content-encoding", encoding);
        let request = request.header("content-type", "application/x-protobuf");
        let (found, answer) = problem(request.body(body).send().await.unwrap()).await;
        assert_eq!(found, status);
        assert!(answer["detail"].as_str().unwrap().contains("gzip"));
    }
}
