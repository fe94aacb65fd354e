//! Tickets: the key that signs them is the server's, and is kept in its store.

use std::fs;

use base64_simd::URL_SAFE_NO_PAD;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::{Value, json};
use sha2::Sha256;
use uuid::Uuid;

use crate::data;
use crate::program::Program;
use crate::support::base;
use crate::tokens_file::TokensFile;

async fn fit(server: &Program, token: &str) -> Value {
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let job = json!({"curve": {"points": data::wave(20)}});
    let response = request.bearer_auth(token).json(&job).send().await.unwrap();
    assert_eq!(response.status(), 201);
    response.json().await.unwrap()
}

async fn opens(server: &Program, job: &Value, ticket: &str) -> u16 {
    let path = format!("{}/events?ticket={ticket}", base(job));
    server.get(&path).send().await.unwrap().status().as_u16()
}

/// A ticket without an end, signed by what the tokens file has of its token.
fn signed_by_the_hash(content: &str, job: &Value) -> String {
    let value = |word: &str| {
        let (_, rest) = content.split_once(word).unwrap();
        rest.split('"').nth(1).unwrap().to_owned()
    };
    let (id, hash) = (value("id = "), value("hash = "));
    let mut key = [0; 64];
    key[..32].copy_from_slice(&URL_SAFE_NO_PAD.decode_to_vec(hash).unwrap());
    let job: Uuid = job["id"].as_str().unwrap().parse().unwrap();
    let expires = (1_i64 << 62).to_be_bytes();
    let mut signer = Hmac::<Sha256>::new(&key.into());
    for part in [
        &b"piad ticket 1"[..],
        job.as_bytes(),
        &expires,
        id.as_bytes(),
    ] {
        signer.update(part);
    }
    let signature = signer.finalize().into_bytes();
    let bytes = [
        job.as_bytes(),
        &expires[..],
        signature.as_slice(),
        id.as_bytes(),
    ]
    .concat();
    format!("piad_ticket_{}", URL_SAFE_NO_PAD.encode_to_string(bytes))
}

#[tokio::test]
async fn the_tokens_file_signs_no_tickets() {
    let file = TokensFile::new();
    let token = file.token("default", "jobs:read,jobs:write");
    let server = file.server(&[]);
    let job = fit(&server, &token).await;
    let content = fs::read_to_string(file.path()).unwrap();
    let made = signed_by_the_hash(&content, &job);
    assert_eq!(opens(&server, &job, &made).await, 401);
}

/// A browser that reconnects within the minute of its ticket finds the server that was started again.
#[tokio::test]
async fn a_ticket_outlasts_a_restart() {
    let file = TokensFile::new();
    let token = file.token("default", "jobs:read,jobs:write");
    let server = file.server(&[]);
    let job = fit(&server, &token).await;
    let request = server.post(&format!("{}/tickets", base(&job)));
    let made = request.bearer_auth(&token).send().await.unwrap();
    let made: Value = made.json().await.unwrap();
    let ticket = made["ticket"].as_str().unwrap();
    assert_eq!(opens(&server, &job, ticket).await, 200);
    drop(server);
    let server = file.server(&[]);
    assert_eq!(opens(&server, &job, ticket).await, 200);
}
