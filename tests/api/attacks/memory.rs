//! The resident size of a server stays within what it may take and a constant of its own.

use serde_json::{Value, json};

use super::{MIB, alone};
use crate::program::Program;

/// What a server takes besides: the program, its stacks, what the allocator holds back, and answers
/// that are on their way.
const CONSTANT: usize = 100 * MIB;

/// `count` points of a spiral.
fn spiral(count: usize) -> Value {
    let point = |i: usize| {
        let t = i as f64 / 40.0;
        json!([t * t.cos(), t * t.sin()])
    };
    (0..count).map(point).collect()
}

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
    let answer = program
        .post("/v1/jobs")
        .header("prefer", "wait=60")
        .json(&job);
    let job: Value = answer.send().await.unwrap().json().await.unwrap();
    assert_eq!(job["state"], "exhausted", "{job}");
    let result = format!("/v1/jobs/{}/result", job["id"].as_str().unwrap());
    for (query, least) in [
        ("view=samples&samples=20000", 600_000),
        ("view=samples&samples=20000&encoding=base64_f32", 200_000),
        ("view=samples&samples=20000&format=protobuf", 480_000),
        ("format=csv&samples=20000", 1_000_000),
        ("format=gltf&samples=20000", 240_000),
    ] {
        let length = length(&program, &format!("{result}?{query}")).await;
        assert!(length > least, "{query}: {length} bytes");
    }
    let most = program.most_memory();
    assert!(most < 128 * MIB + CONSTANT, "{} MiB", most / MIB);
}
