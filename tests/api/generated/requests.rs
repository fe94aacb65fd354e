//! Requests that are right, by the description of the API and its contract, and changes that make them wrong.

use std::collections::BTreeMap;

use prost::Message;
use serde_json::Value;

use crate::data;
use crate::messages as pb;
use crate::program::Program;
use crate::random::Random;
use crate::rpc::curve;

/// A request, right or not.
#[derive(Clone, Debug)]
pub struct Made {
    pub method: String,
    pub path: String,
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
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
pub fn change(made: &mut Made, dice: &mut Random) {
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
pub struct Seeds {
    pub http: Vec<Made>,
    pub calls: Vec<Made>,
}

impl Seeds {
    pub async fn of(server: &Program, id: &str) -> Self {
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
