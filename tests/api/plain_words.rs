//! Whatever is wrong with a request, the answer says it in plain words, shortly, and points at it.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use prost::Message;
use reqwest::Response;
use serde_json::{Value, json};

use crate::data;
use crate::rpc::curve;
use crate::support::{Server, base, problem};

/// Words of the language and of the libraries that the server is made of.
const FOREIGN: [&str; 36] = [
    "map",
    "sequence",
    "struct",
    "enum",
    "tuple",
    "newtype",
    "unit",
    "ident",
    "serde",
    "prost",
    "deserialize",
    "u8",
    "u32",
    "u64",
    "usize",
    "i32",
    "i64",
    "f32",
    "f64",
    "bool",
    "str",
    "EOF",
    "Err",
    "Ok",
    "Some",
    "None",
    "unwrap",
    "panicked",
    "inf",
    "wire",
    "varint",
    "buffer",
    "underflow",
    "LengthDelimited",
    "parse",
    "FromStr",
];

const FOREIGN_PHRASES: [&str; 7] = [
    "invalid type",
    "invalid value",
    "invalid length",
    "unknown variant",
    "missing field",
    "18446744073709551615",
    "`",
];

/// The maximum length of an error in characters.
const LONGEST: usize = 420;

/// The error in a response, if there is one.
async fn complaint(response: Response, body: Option<&Value>) -> Option<String> {
    if response.status().is_success() {
        return None;
    }
    let (status, problem) = problem(response).await;
    let errors = problem["errors"].as_array().cloned().unwrap_or_default();
    let detail = problem["detail"].as_str().unwrap();
    let details = errors.iter().map(|error| error["detail"].as_str().unwrap());
    for text in details.clone().chain([detail]) {
        let mut words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
        let foreign = words.find(|word| FOREIGN.contains(word));
        let foreign = foreign.or_else(|| FOREIGN_PHRASES.into_iter().find(|it| text.contains(it)));
        if let Some(foreign) = foreign {
            return Some(format!("{foreign:?} in: {text}"));
        }
    }
    if let Some(long) = details.clone().find(|text| text.chars().count() > LONGEST) {
        return Some(format!("long: {long}"));
    }
    if !matches!(status, 400 | 422) {
        return Some(format!("{problem:#}"));
    }
    let body = body.filter(|_| status == 422)?;
    if errors.is_empty() {
        return Some(format!("it points at nothing: {problem:#}"));
    }
    let lost = errors.iter().find(|error| {
        let pointer = error["pointer"].as_str().unwrap();
        let parent = pointer.rsplit_once('/').map_or("", |(parent, _)| parent);
        body.pointer(pointer).is_none() && body.pointer(parent).is_none()
    });
    lost.map(|error| format!("it points at nothing: {error} of {body}"))
}

/// The pointers to all values within a value, itself too; of lists to the first two elements.
fn places(value: &Value, pointer: &str) -> Vec<String> {
    let mut all = vec![pointer.to_owned()];
    match value {
        Value::Array(list) => {
            let first = list.iter().take(2).enumerate();
            all.extend(first.flat_map(|(k, it)| places(it, &format!("{pointer}/{k}"))));
        }
        Value::Object(members) => {
            let members = members.iter();
            all.extend(members.flat_map(|(name, it)| places(it, &format!("{pointer}/{name}"))));
        }
        _ => {}
    }
    all
}

/// Everything that can stand where something else should.
fn wrong_values() -> Vec<Value> {
    vec![
        Value::Null,
        json!(true),
        json!(0),
        json!(-1),
        json!(2.5),
        json!(1e300),
        json!(10_000_000_000_000_000_000_u64),
        json!(""),
        json!("x"),
        json!("λ/~\"\n".repeat(100)),
        json!([]),
        json!([[]]),
        json!([1, "2", null, [3], {}]),
        json!({}),
        json!({"x": 1}),
        json!({"u": 1}),
        json!({"u": {"kind": "bspline"}, "v": [0, 1]}),
    ]
}

/// The value with one thing changed: each of its values by each wrong one, each field left out, and one
/// more in each object.
fn mutated(value: &Value) -> Vec<Value> {
    let mut all = Vec::new();
    for pointer in places(value, "") {
        for wrong in wrong_values() {
            let mut changed = value.clone();
            *changed.pointer_mut(&pointer).unwrap() = wrong;
            all.push(changed);
        }
        let names: Vec<String> = match value.pointer(&pointer) {
            Some(Value::Object(members)) => members.keys().cloned().collect(),
            _ => continue,
        };
        let with = |change: &dyn Fn(&mut serde_json::Map<String, Value>)| {
            let mut changed = value.clone();
            change(
                changed
                    .pointer_mut(&pointer)
                    .unwrap()
                    .as_object_mut()
                    .unwrap(),
            );
            changed
        };
        all.extend(names.iter().map(|name| with(&|it| drop(it.remove(name)))));
        all.push(with(&|it| drop(it.insert("more/~".to_owned(), json!([1])))));
    }
    all
}

fn jobs() -> Vec<Value> {
    let curve = |method: Value| {
        json!({
            "name": "all of it",
            "curve": {
                "points": [[0, 0], [1, 2], [3, 1], [4, 4], [5, 3], [7, 1]],
                "basis": {"kind": "bspline", "degree": 3, "knots": [0, 0, 0, 0, 2, 3, 5, 5, 5, 5]},
                "parameters": [0, 1, 2, 3, 4, 5],
                "weights": [1, 2, 1, 1, 2, 1],
                "closed": false,
            },
            "rational": "homogeneous",
            "method": method,
            "stop": {"tolerance": 1e-3, "max_iterations": 20},
            "stream": {"view": "samples", "samples": 20, "every": 2, "pace": "all", "changed": false,
                "encoding": "json", "digits": "full", "on_disconnect": "continue"},
        })
    };
    let each = |value: Value| json!({"u": value, "v": value});
    let basis = json!({"kind": "bspline", "degree": 2, "knots": "data"});
    let least_squares = json!({"kind": "least_squares", "control_points": each(json!(4)),
        "variant": "lspia", "mu": 0.1});
    let surface = json!({
        "surface": {"points": data::peaks(6), "basis": each(basis), "parameters": each(json!("uniform")),
            "weights": each(json!([1, 1, 2, 1, 1, 1])), "closed": each(json!(false))},
        "rational": "fixed",
        "method": {"kind": "local", "indices": [[1, 2], [2, 2]]},
        "stop": {"relative_tolerance": 1e-3},
        "stream": {"milestones": [1, 0.1]},
    });
    let grid = json!({"surface": {"points": data::peaks(6), "degree": {"u": 3, "v": 2}}, "method": least_squares});
    vec![
        curve(json!({"kind": "weighted", "omega": 1.2})),
        curve(json!({"kind": "adaptive", "threshold": 0.1})),
        curve(json!({"kind": "extended", "start": "data"})),
        curve(json!("direct")),
        surface,
        grid,
    ]
}

#[tokio::test]
async fn mutated_jobs_and_edits() {
    let server = Server::start().await;
    let parent = json!({"curve": {"points": data::wave(12), "weights": vec![1; 12]}});
    let parent = server.fit(&parent).await;
    let edits = format!("{}/edits", base(&parent));
    let edit = json!({
        "name": "edited",
        "iteration": "last",
        "points": [{"index": 3, "point": [1, 2], "weight": 2}, {"index": 4, "point": [2, 2]}],
        "weights": vec![1; 12],
        "rational": "homogeneous",
        "method": {"kind": "local", "indices": [3, 4]},
        "stop": {"tolerance": 1e-3},
        "stream": {"every": 3},
    });
    let jobs = jobs();
    let bodies = jobs.iter().map(|job| ("/v1/jobs", job));
    let mut complaints = Vec::new();
    let mut count = 0;
    for (path, whole) in bodies.chain([(edits.as_str(), &edit)]) {
        for body in mutated(whole) {
            let response = server.post(path).json(&body).send().await.unwrap();
            complaints.extend(complaint(response, Some(&body)).await);
            count += 1;
        }
    }
    assert!(count > 4000, "{count}");
    assert!(
        complaints.is_empty(),
        "{}: {}",
        complaints.len(),
        complaints.join("\n")
    );
}

/// A text with a part replaced by a few other bytes, or cut off.
fn damaged(text: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(
        prop::sample::select(b"[]{}\",:0-.eNaInf\\u \n\0\xff".to_vec()),
        0..4,
    );
    (0..text.len(), 0..6_usize, bytes, any::<bool>()).prop_map(
        move |(start, length, bytes, cut)| {
            let mut damaged = text.clone();
            let end = (start + length).min(text.len());
            damaged.splice(start..end, bytes);
            damaged.truncate(if cut { start } else { damaged.len() });
            damaged
        },
    )
}

#[tokio::test]
async fn damaged_bodies() {
    let server = Server::start().await;
    let mut runner = TestRunner::deterministic();
    let mut complaints = Vec::new();
    let json = jobs().remove(0).to_string().into_bytes();
    let message = curve(&data::helix()).encode_to_vec();
    for (media_type, body) in [
        ("application/json", json),
        ("application/x-protobuf", message),
    ] {
        let bodies = damaged(body);
        for _ in 0..1500 {
            let body = bodies.new_tree(&mut runner).unwrap().current();
            let request = server.post("/v1/jobs").header("content-type", media_type);
            let response = request.body(body.clone()).send().await.unwrap();
            let complaint = complaint(response, None).await;
            complaints
                .extend(complaint.map(|it| format!("{it} of {}", String::from_utf8_lossy(&body))));
        }
    }
    assert!(
        complaints.is_empty(),
        "{}: {}",
        complaints.len(),
        complaints.join("\n")
    );
}

#[tokio::test]
async fn wrong_queries_and_headers() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let path = base(&job);
    let mut complaints = Vec::new();
    let values = [
        "",
        "x",
        "-1",
        "0",
        "1.5",
        "99999999999999999999999",
        "%FF",
        "a,b",
        "true",
        "last",
    ];
    let resources = [
        ("/v1/jobs".to_owned(), vec!["state", "limit", "cursor", "?"]),
        (
            format!("{path}/events"),
            vec![
                "view",
                "samples",
                "every",
                "milestones",
                "pace",
                "changed",
                "encoding",
                "digits",
                "on_disconnect",
                "last_event_id",
                "?",
            ],
        ),
        (
            format!("{path}/result"),
            vec!["view", "samples", "encoding", "digits", "?"],
        ),
        (
            format!("{path}/iterations/last"),
            vec!["view", "samples", "encoding", "digits", "?"],
        ),
    ];
    for (resource, parameters) in resources {
        for parameter in parameters {
            for value in values {
                // Twice, too.
                for query in [
                    format!("{parameter}={value}"),
                    format!("{parameter}={value}&{parameter}={value}"),
                ] {
                    let response = server
                        .get(&format!("{resource}?{query}"))
                        .send()
                        .await
                        .unwrap();
                    let found = complaint(response, None).await;
                    complaints.extend(found.map(|it| format!("{query}: {it}")));
                }
            }
        }
    }
    for (header, value) in [
        ("last-event-id", "x"),
        ("accept", "x"),
        ("prefer", "wait=x"),
        ("idempotency-key", ""),
    ] {
        let request = server
            .post("/v1/jobs")
            .json(&data::small_job())
            .header(header, value);
        complaints.extend(complaint(request.send().await.unwrap(), None).await);
    }
    assert!(
        complaints.is_empty(),
        "{}: {}",
        complaints.len(),
        complaints.join("\n")
    );
}
