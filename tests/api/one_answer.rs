//! Routes with one kind of answer each: they answer as the routes whose answer the client chooses.

use serde_json::json;

use crate::data;
use crate::support::{Server, Story, base, problem};

/// The events of a new job and of a new edit, without any Accept header.
#[tokio::test]
async fn streams_have_routes_of_their_own() {
    let server = Server::start().await;
    let job = data::small_job();
    let response = server.post("/v1/jobs/stream?view=errors").json(&job).send();
    let response = response.await.unwrap();
    assert_eq!(response.status(), 200);
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    let path = response.headers()["location"].to_str().unwrap().to_owned();
    let story = Story::read(response).await;
    assert_eq!(base(&story.job), path);
    assert!(story.iterations[0]["control_points"].is_null());

    let edits = format!("{path}/edits");
    let edit = json!({"points": [{"index": 1, "point": [1, 2]}]});
    let lines = server.post(&format!("{edits}/stream"));
    let lines = lines.header("accept", "application/x-ndjson").json(&edit);
    let lines = lines.send().await.unwrap();
    assert_eq!(lines.status(), 200);
    assert_eq!(lines.headers()["content-type"], "application/x-ndjson");
    let text = lines.text().await.unwrap();
    assert!(text.starts_with("{\"event\":\"job\""), "{text}");
    assert!(text.contains("{\"event\":\"end\""), "{text}");
}

/// There is nothing else than events there.
#[tokio::test]
async fn a_stream_is_no_job() {
    let server = Server::start().await;
    let request = server.post("/v1/jobs/stream");
    let request = request.header("accept", "application/json");
    let response = request.json(&data::small_job()).send().await.unwrap();
    assert_eq!(problem(response).await.0, 406);
    let response = server.get("/v1/jobs/stream").send().await.unwrap();
    assert_eq!(problem(response).await.0, 405);
}

/// A client that loses a stream can send the request again for the job alone, and the other way round.
#[tokio::test]
async fn keys_are_those_of_jobs() {
    let server = Server::start().await;
    let job = data::small_job();
    let request = server.post("/v1/jobs/stream").header("idempotency-key", 1);
    let streamed = request.json(&job).send().await.unwrap();
    let path = streamed.headers()["location"].to_str().unwrap().to_owned();
    streamed.text().await.unwrap();
    let request = server.post("/v1/jobs").header("idempotency-key", 1);
    let again = request.json(&job).send().await.unwrap();
    assert_eq!(again.status(), 201);
    assert_eq!(again.headers()["idempotency-replayed"], "true");
    assert_eq!(again.headers()["location"], path);
}

/// Files are the same as those of the Accept header.
#[tokio::test]
async fn files_have_routes_of_their_own() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    for level in ["result", "iterations/2", "iterations/last"] {
        let path = format!("{}/{level}", base(&job));
        for format in ["step", "iges", "obj", "gltf", "dxf", "svg", "csv"] {
            let named = server
                .get(&format!("{path}/{format}"))
                .send()
                .await
                .unwrap();
            let media_type = named.headers()["content-type"].clone();
            let chosen = server.get(&path).header("accept", media_type);
            let chosen = chosen.send().await.unwrap();
            assert_eq!(named.status(), 200, "{path}/{format}");
            for header in ["content-type", "content-disposition"] {
                assert_eq!(named.headers()[header], chosen.headers()[header]);
            }
            assert_eq!(named.bytes().await.unwrap(), chosen.bytes().await.unwrap());
        }
        for (query, status) in [("json", 404), ("csv?view=errors", 400)] {
            let response = server.get(&format!("{path}/{query}")).send().await.unwrap();
            assert_eq!(problem(response).await.0, status, "{path}/{query}");
        }
    }
    let few = server.get(&format!("{}/result/csv?samples=7", base(&job)));
    let text = few.send().await.unwrap().text().await.unwrap();
    assert_eq!(text.lines().count(), 8);
}
