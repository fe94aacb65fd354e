//! Protobuf messages as bodies of the REST resources.

use prost::Message;
use reqwest::Response;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::rpc::{Messages, assert_same_iteration, curve, stop};
use crate::support::{Server, base, problem};

const PROTOBUF: &str = "application/x-protobuf";

async fn post(server: &Server, path: &str, body: Vec<u8>) -> Response {
    let request = server.post(path).header("content-type", PROTOBUF);
    request.body(body).send().await.unwrap()
}

/// A message that a resource gives.
async fn get<M: Message + Default>(server: &Server, path: &str) -> M {
    let response = server.get(path).header("accept", PROTOBUF);
    message(response.send().await.unwrap()).await
}

async fn message<M: Message + Default>(response: Response) -> M {
    assert!(response.status().is_success(), "{}", response.status());
    assert_eq!(response.headers()["content-type"], PROTOBUF);
    M::decode(response.bytes().await.unwrap()).unwrap()
}

/// The messages of a stream, each after its length.
pub async fn events(response: Response) -> Messages {
    assert_eq!(response.status(), 200);
    assert_eq!(response.headers()["content-type"], PROTOBUF);
    let mut bytes = response.bytes().await.unwrap();
    let mut all = Vec::new();
    while !bytes.is_empty() {
        all.push(pb::WatchJobResponse::decode_length_delimited(&mut bytes).unwrap());
    }
    Messages::of(all)
}

fn helix() -> pb::JobInput {
    pb::JobInput {
        name: Some("a helix".to_owned()),
        stop: stop(1e-9, 100),
        ..curve(&data::helix())
    }
}

#[tokio::test]
async fn a_job_is_posted_and_shown_as_messages() {
    let server = Server::start().await;
    let created = post(&server, "/v1/jobs", helix().encode_to_vec()).await;
    assert_eq!(created.status(), 201);
    let json: Value = created.json().await.unwrap();
    assert_eq!(json["name"], "a helix");
    let path = base(&json);
    let request = server
        .get(&format!("{path}/events"))
        .header("accept", PROTOBUF);
    let streamed = events(request.send().await.unwrap()).await;
    let events = server.get(&format!("{path}/events")).send().await.unwrap();
    let (iterations, _) = crate::support::read_thinned(events).await;
    assert_eq!(streamed.iterations.len(), iterations.len());
    for (message, json) in streamed.iterations.iter().zip(&iterations) {
        assert_same_iteration(message, json, 1);
    }
    let job: pb::Job = get(&server, path).await;
    assert_eq!(json["id"], job.id);
    assert_eq!(job.iteration, Some(streamed.end.iterations));
    let list: pb::ListJobsResponse = get(&server, "/v1/jobs").await;
    assert_eq!(list.jobs, std::slice::from_ref(&job));
    let input: pb::JobInput = get(&server, &format!("{path}/input")).await;
    let Some(pb::job_input::Geometry::Curve(curve)) = &input.geometry else {
        panic!("a curve");
    };
    assert_eq!(curve.points, crate::numbers::flat(&data::helix()));
    let third: pb::Iteration = get(&server, &format!("{path}/iterations/3")).await;
    assert_eq!(third, streamed.iterations[3]);
    let result: pb::FitResult = get(&server, &format!("{path}/result")).await;
    assert_eq!(result.u.unwrap().knots, streamed.job.u.unwrap().knots);
    let query = "view=samples&samples=9";
    let result: pb::FitResult = get(&server, &format!("{path}/result?{query}")).await;
    assert!(matches!(result.geometry, Some(pb::fit_result::Geometry::Samples(it)) if it.rows == 9));
    // A stream is resumed by its number.
    let request = server
        .get(&format!("{path}/events"))
        .header("accept", PROTOBUF);
    let request = request.header("last-event-id", "4");
    let rest = crate::messages_over_rest::events(request.send().await.unwrap()).await;
    assert_eq!(rest.iterations, streamed.iterations[5..]);
}

#[tokio::test]
async fn answers_to_posts_are_messages_too() {
    let server = Server::start().await;
    let request = || {
        let request = server.post("/v1/jobs").header("content-type", PROTOBUF);
        let request = request.header("accept", PROTOBUF);
        request.body(helix().encode_to_vec())
    };
    let waited = request().header("prefer", "wait=10").send().await.unwrap();
    assert_eq!(waited.status(), 201);
    let job: pb::Job = message(waited).await;
    assert_eq!(job.state(), pb::JobState::Converged);
    let streamed = request().header("prefer", "stream").send().await.unwrap();
    let streamed = events(streamed).await;
    assert_eq!(streamed.end.iterations, job.iteration.unwrap());
    let edit = pb::Edit {
        moved: vec![3],
        points: vec![0.0, 0.0, 9.0],
        ..pb::Edit::default()
    };
    let path = format!("/v1/jobs/{}/edits", job.id);
    let edited = post(&server, &path, edit.encode_to_vec()).await;
    assert_eq!(edited.status(), 201);
    let edited: Value = edited.json().await.unwrap();
    assert_eq!(edited["parent"]["id"], job.id);
    let mut other = edit;
    other.moved = vec![99];
    let refused = post(&server, &path, other.encode_to_vec()).await;
    let (status, problem) = problem(refused).await;
    assert_eq!(
        (status, &problem["errors"][0]["field"]),
        (422, &json!("moved[0]"))
    );
}

/// Whatever the bytes are, they are refused or a job; nothing is allocated for what they only announce.
#[tokio::test]
async fn bytes_that_are_no_message_are_refused() {
    let server = Server::start().await;
    let good = helix().encode_to_vec();
    let absurd = |length: &[u8]| [&[0x12][..], length].concat();
    let nested = |levels: usize| [vec![0x13; levels], vec![0x14; levels]].concat();
    for (what, body) in [
        ("JSON", br#"{"curve": {}}"#.to_vec()),
        ("cut off", good[..good.len() - 1].to_vec()),
        ("cut off in the points", good[..100].to_vec()),
        (
            "a length of 2^63",
            absurd(&[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f]),
        ),
        ("a length of 4 GiB", absurd(&[0xff, 0xff, 0xff, 0xff, 0x0f])),
        ("a varint without end", vec![0xff; 20]),
        ("a curve that is a number", vec![0x10, 0x01]),
        ("a name that is no text", vec![0x0a, 0x02, 0xff, 0xfe]),
        (
            "points that end within a number",
            vec![0x12, 0x05, 0x12, 0x03, 0x01, 0x02, 0x03],
        ),
        ("field 0", vec![0x02, 0x00]),
        ("groups within groups", nested(100_000)),
    ] {
        let (status, problem) = problem(post(&server, "/v1/jobs", body).await).await;
        assert_eq!(status, 400, "{what}: {problem:#}");
        assert_eq!(problem["type"], "/problems/not-protobuf", "{what}");
    }
    // An empty message is a message.
    let (status, problem) = problem(post(&server, "/v1/jobs", Vec::new()).await).await;
    assert_eq!(status, 422, "{problem:#}");
    // Every prefix and every flipped byte.
    let mut seed = 1_u64;
    for _ in 0..300 {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let mut body = good.clone();
        let place = (seed >> 33) as usize % 40;
        body[place] ^= (seed >> 20) as u8 | 1;
        let response = post(&server, "/v1/jobs", body).await;
        assert!([201, 400, 422].contains(&response.status().as_u16()));
    }
}

#[tokio::test]
async fn fields_of_a_message_are_named_and_numbers_have_one_form() {
    let server = Server::start().await;
    let mut input = helix();
    let Some(pb::job_input::Geometry::Curve(curve)) = &mut input.geometry else {
        panic!("a curve");
    };
    curve.points[30] = f64::NAN;
    let (status, refused) = problem(post(&server, "/v1/jobs", input.encode_to_vec()).await).await;
    assert_eq!(
        (status, &refused["errors"][0]["field"]),
        (422, &json!("curve.points[30]"))
    );
    let job = server.fit(&data::small_job()).await;
    for path in ["events", "iterations/0", "result"] {
        let path = format!("{}/{path}?encoding=base64", base(&job));
        let request = server.get(&path).header("accept", PROTOBUF);
        let (status, refused) = problem(request.send().await.unwrap()).await;
        assert_eq!(
            (status, &refused["errors"][0]["parameter"]),
            (400, &json!("encoding"))
        );
    }
}

/// A job can say what its streams are like; what is about JSON is not about messages.
#[tokio::test]
async fn streams_of_jobs_with_options_of_json() {
    let server = Server::start().await;
    let mut job = data::small_job();
    job["stream"] = json!({"encoding": "base64", "every": 5});
    let job = server.fit(&job).await;
    let request = server
        .get(&format!("{}/events", base(&job)))
        .header("accept", PROTOBUF);
    let streamed = events(request.send().await.unwrap()).await;
    assert_eq!(streamed.iterations[1].iteration, 5);
    let shown: pb::Job = get(&server, base(&job)).await;
    let stream = shown.stream.unwrap();
    assert_eq!(stream.json_encoding(), pb::JsonEncoding::Base64);
    assert_eq!(stream.every, Some(5));
}
