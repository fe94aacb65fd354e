//! Bodies of many megabytes that are wrong: the answers stay small, and so does the server.

use prost::Message;
use prost::encoding::{WireType, encode_key, encode_varint};
use reqwest::Response;

use crate::data;
use crate::messages as pb;
use crate::program::Program;
use crate::rpc::{connect_to, curve};
use crate::support::{Server, base, problem};

/// The most bytes of an answer, however much was sent.
const MOST_ANSWERED: u64 = 8 * 1024;

const MEGABYTE: usize = 1 << 20;

const JSON: &str = "application/json";

const PROTOBUF: &str = "application/x-protobuf";

async fn post(server: &Server, body: String) -> Response {
    let request = server.post("/v1/jobs").header("content-type", JSON);
    request.body(body).send().await.unwrap()
}

#[tokio::test]
async fn texts_are_not_repeated_whole() {
    let server = Server::start().await;
    let long = "x".repeat(20 * MEGABYTE);
    let curve = r#""points":[[0,0],[1,1]]"#;
    let cases = [
        (format!(r#"{{"{long}":1}}"#), "/xxx"),
        (
            format!(r#"{{"curve":{{{curve},"{long}":1}}}}"#),
            "/curve/xxx",
        ),
        (
            format!(r#"{{"curve":{{{curve},"parameters":"{long}"}}}}"#),
            "/curve/parameters",
        ),
        (
            format!(r#"{{"curve":{{{curve},"basis":{{"kind":"{long}"}}}}}}"#),
            "/curve/basis/kind",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"stream":{{"view":"{long}"}}}}"#),
            "/stream/view",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"stop":"{long}"}}"#),
            "/stop",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"name":"{long}"}}"#),
            "/name",
        ),
    ];
    for (body, pointer) in cases {
        let response = post(&server, body).await;
        let length = response.content_length().unwrap();
        assert!(length < MOST_ANSWERED, "{pointer}: {length} bytes");
        let (status, problem) = problem(response).await;
        assert_eq!(status, 422, "{problem:#}");
        let said = problem["errors"][0]["pointer"].as_str().unwrap();
        assert!(said.starts_with(pointer), "{problem:#}");
    }
}

/// The bytes of each of the bodies that follow.
const BODY: usize = 48 * MEGABYTE;

/// The most points of jobs of the server that gets them.
const MOST_POINTS: usize = 100_000;

/// Repetitions of a text between a prefix and a suffix.
fn many(before: &str, element: &str, after: &str) -> String {
    let count = BODY / (element.len() + 1);
    let list = vec![element; count].join(",");
    format!("{before}{list}{after}")
}

/// Bodies with too much of everything, and their errors.
fn too_much() -> Vec<(String, &'static str)> {
    let curve = r#"{"curve":{"points":[[0,0],[1,1],[2,0]]"#;
    let of_curve = |field: &str| format!(r#"{curve},"{field}":["#);
    let of_job = |object: &str, field: &str| format!(r#"{curve}}},"{object}":{{{field}:["#);
    let keys = (0..BODY / 16).map(|k| format!("\"key{k}\":0"));
    let keys = keys.collect::<Vec<_>>().join(",");
    vec![
        (
            many(&of_job("stream", r#""milestones""#), "1", "]}}"),
            "at most 100",
        ),
        (
            many(&of_job("method", r#""kind":"local","indices""#), "1", "]}}"),
            "there are more than 100000 of them",
        ),
        (
            many(
                &of_job("method", r#""kind":"local","indices""#),
                "[1,1]",
                "]}}",
            ),
            "there are more than 100000 of them",
        ),
        (
            many(
                &of_job("method", r#""kind":"local","indices""#),
                "\"x\"",
                "]}}",
            ),
            "found \"x\"",
        ),
        (format!("{{{keys}}}"), "unknown field \"key0\""),
        (
            format!("{{\"{}\":0}}", "x".repeat(BODY)),
            "unknown field \"xxx",
        ),
        (many("{\"curve\":{", "\"points\":[]", "}}"), "given twice"),
        (
            many(&of_curve("parameters"), "1", "]}}"),
            "there are more than 102002 of them",
        ),
        (
            many(&of_curve("weights"), "1", "]}}"),
            "there are more than 102002 of them",
        ),
        (
            many(&of_curve("weights"), "[1]", "]}}"),
            "there are more than 102002 of them",
        ),
        (many(&of_curve("basis"), "1", "]}}"), "expected an object"),
        (
            many("{\"curve\":{\"points\":[", "[0,0]", "]}}"),
            "points are more than 100000",
        ),
        (
            many(
                &(of_job("method", r#""kind":"custom","transform""#) + "["),
                "1",
                "]]}}",
            ),
            "at most 500 of them",
        ),
        (
            many(
                r#"{"curve":{"points":[[0],[1],[2]],"ends":{"start":{"derivatives":["#,
                "[1]",
                "]}}}}",
            ),
            "there are more than 1602002 of them",
        ),
        (
            many(
                r#"{"curve":{"points":[[0],[1],[2]],"basis":{"kind":"bspline","knots":["#,
                "1",
                "]}}}",
            ),
            "there are more than 102002 of them",
        ),
        (
            many(
                r#"{"curve":{"points":[[0],[1],[2]]},"method":{"#,
                r#""a":0"#,
                "}}",
            ),
            "more than 100 fields before the kind",
        ),
        (
            many("{\"curve\":{\"points\":[", "[0,\"\"]", "]}}"),
            "found \"\"",
        ),
        (
            many("{\"curve\":{\"points\":[[", "0", "]]}}"),
            "found 25165824 of them",
        ),
        (
            many("{\"surface\":{\"points\":[", "[]", "]}}"),
            "at least 2 points",
        ),
        (
            many("{\"surface\":{\"points\":[[", "null", "]]}}"),
            "points are more than 100000",
        ),
        (
            many("{\"surface\":{\"points\":[", "[[0]]", "]}}"),
            "points are more than 100000",
        ),
        ("[".repeat(BODY), "expected an object"),
        ("{\"a\":".repeat(BODY / 5), "unknown field \"a\""),
        (
            format!("{{\"curve\":{}", "[".repeat(BODY)),
            "expected an object",
        ),
    ]
}

/// A job with an index in each byte, four in memory.
fn job_with_indices() -> pb::JobInput {
    let local = pb::method::Local {
        indices: vec![0; BODY],
        ..pb::method::Local::default()
    };
    pb::JobInput {
        method: Some(pb::Method {
            kind: Some(pb::method::Kind::Local(local)),
        }),
        ..curve(&data::helix())
    }
}

fn edit_with_indices() -> pb::Edit {
    pb::Edit {
        moved: vec![0; BODY],
        ..pb::Edit::default()
    }
}

/// A job whose method has constraints of two bytes each, which take fifty times as much when they are decoded.
fn job_with_constraints() -> Vec<u8> {
    let field = |tag, content: Vec<u8>| {
        let mut field = Vec::new();
        encode_key(tag, WireType::LengthDelimited, &mut field);
        encode_varint(content.len() as u64, &mut field);
        [field, content].concat()
    };
    let constraints = field(10, Vec::new()).repeat(BODY / 2);
    let method = field(5, field(10, constraints));
    [curve(&data::helix()).encode_to_vec(), method].concat()
}

/// Sends a body that must be refused, with this as a part of the reason; gives the most memory that
/// the server has needed so far.
async fn refuse(
    program: &Program,
    (path, media_type): (&str, &str),
    body: Vec<u8>,
    reason: &str,
) -> usize {
    let request = program.post(path).header("content-type", media_type);
    let response = request.body(body).send().await.unwrap();
    let length = response.content_length().unwrap();
    assert!(length < MOST_ANSWERED, "{reason}: {length} bytes");
    let (status, problem) = problem(response).await;
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains(reason), "{reason}: {problem:#}");
    assert_eq!(status, 422, "{problem:#}");
    program.most_memory()
}

#[tokio::test]
async fn too_much_of_anything_costs_no_more_than_its_body() {
    let directory = tempfile::tempdir().unwrap();
    // What is freed goes back to the operating system at once: requests do not add up.
    let script = format!("export MIMALLOC_PURGE_DELAY=0; exec \"$@\" --max-points {MOST_POINTS}");
    let program = Program::in_shell(&script, directory.path());
    let job = program.fit(&data::small_job()).await;
    let edits = format!("{}/edits", base(&job));
    let edit = many("{\"points\":[", "{\"index\":1,\"weight\":1}", "]}");
    let cases = too_much().into_iter();
    let jobs = "/v1/jobs";
    let cases = cases.map(|(body, reason)| ((jobs, JSON), body.into_bytes(), reason));
    let edit = (
        (edits.as_str(), JSON),
        edit.into_bytes(),
        "there are more than 100 of them",
    );
    let messages = [
        (jobs, job_with_indices().encode_to_vec()),
        (edits.as_str(), edit_with_indices().encode_to_vec()),
    ];
    let messages = messages.map(|(path, body)| ((path, PROTOBUF), body, "indices, the limit here"));
    let constraints = (
        (jobs, PROTOBUF),
        job_with_constraints(),
        "more than 1000 constraints, the limit here",
    );
    let cases = cases.chain([edit, constraints]).chain(messages);
    let cases: Vec<_> = cases.collect();
    // The body, also while it grows, and lists of as many points as there may be.
    let bound = program.most_memory() + BODY * 5;
    for (to, body, reason) in cases {
        let most = refuse(&program, to, body, reason).await;
        assert!(most < bound, "{reason}: {most} bytes of {bound}");
    }
}

/// Files whose points are few: what else is in them is not kept.
#[tokio::test]
async fn words_around_points_cost_no_more_than_their_file() {
    let directory = tempfile::tempdir().unwrap();
    let program = Program::in_shell(
        "export MIMALLOC_PURGE_DELAY=0; exec \"$@\"",
        directory.path(),
    );
    let bound = program.most_memory() + BODY * 5;
    let remarks = format!("1 2\n3 4\n\n{}", "a\n".repeat(BODY / 2));
    let names = format!("{}\n1,2\n3,4\n", "a,".repeat(BODY / 2));
    for file in [remarks, names] {
        let request = program
            .post("/v1/points")
            .header("content-type", "text/csv");
        let response = request.body(file).send().await.unwrap();
        assert_eq!(response.status(), 200, "{:?}", response.text().await);
        let most = program.most_memory();
        assert!(most < bound, "{most} bytes of {bound}");
    }
}

#[tokio::test]
async fn too_many_indices_of_a_call_cost_no_more_than_its_body() {
    let directory = tempfile::tempdir().unwrap();
    let most_points = MOST_POINTS.to_string();
    let program = Program::with(directory.path(), &["--max-points", &most_points]);
    let bound = program.most_memory() + BODY * 5 / 2 + 32 * MEGABYTE;
    let url = format!("http://{}", program.address);
    let mut client = connect_to(url).await;
    let request = pb::CreateJobRequest {
        input: Some(job_with_indices()),
        ..pb::CreateJobRequest::default()
    };
    let status = client.create_job(request).await.unwrap_err();
    assert_eq!(status.code(), tonic::Code::InvalidArgument, "{status:?}");
    let field = "input.method.local.indices: more than 100000";
    assert!(status.message().contains(field), "{status:?}");
    let most = program.most_memory();
    assert!(most < bound, "{most} bytes of {bound}");
}
