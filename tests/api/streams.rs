//! Event streams: grammar, headers, several readers, slow readers, readers that go away or come back.

use std::time::Duration;

use futures_util::{StreamExt, future::join_all};
use serde_json::{Value, json};

use crate::data;
use crate::support::{NEVER, Server, Story, base, events, problem};

fn id(job: &Value) -> &str {
    job["id"].as_str().unwrap()
}

#[tokio::test]
async fn headers_forbid_buffering_of_streams() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&job));
    let response = server.get(&path).send().await.unwrap();
    let header = |name: &str| response.headers()[name].to_str().unwrap().to_owned();
    assert_eq!(header("content-type"), "text/event-stream");
    assert_eq!(header("cache-control"), "no-store, no-transform");
    assert_eq!(header("x-accel-buffering"), "no");
    let text = response.text().await.unwrap();
    assert!(text.starts_with(":"), "a comment comes at once");
    assert!(text.contains("retry: 2000\n"));
}

#[tokio::test]
async fn clients_choose_with_qualities_and_parameters() {
    let server = Server::start().await;
    let job = data::small_job();
    for (accept, expected) in [
        ("text/event-stream; charset=utf-8", "text/event-stream"),
        (
            "application/json;q=0.5, application/x-ndjson",
            "application/x-ndjson",
        ),
        (
            "text/html, text/event-stream;q=0.9, */*;q=0.1",
            "text/event-stream",
        ),
        ("*/*", "application/json"),
        ("application/*", "application/json"),
    ] {
        let request = server.post("/v1/jobs").header("accept", accept);
        let response = request.json(&job).send().await.unwrap();
        assert!(response.status().is_success(), "{accept}");
        assert_eq!(response.headers()["content-type"], expected, "{accept}");
    }
}

#[tokio::test]
async fn posting_streams_every_iteration_and_the_geometry_is_complete() {
    let server = Server::start().await;
    let request = server
        .post("/v1/jobs")
        .header("accept", "text/event-stream");
    let response = request.json(&data::small_job()).send().await.unwrap();
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let story = Story::read(response).await;
    assert_eq!(story.iterations[0]["iteration"], 0);
    assert_eq!(story.state(), "converged");
    assert_eq!(location, format!("/v1/jobs/{}", id(&story.job)));
    assert_eq!(story.end["links"]["result"], format!("{location}/result"));
    assert_eq!(story.end["iterations"], story.iterations.len() - 1);
    // A cubic with knots at 100 data points has 102 control points, one more on either side.
    let degree = story.job["degree"].as_u64().unwrap() as usize;
    let knots = story.job["knots"].as_array().unwrap();
    let points = &data::small_job()["curve"]["points"];
    for iteration in &story.iterations {
        let control_points = iteration["control_points"].as_array().unwrap();
        assert_eq!(control_points.len(), 102);
        assert_eq!(control_points.len() + degree + 1, knots.len());
        assert_eq!(control_points[0], points[0]);
        assert_eq!(control_points[101], points[99]);
    }
    let moved: Vec<_> = story.iterations.iter().map(|it| &it["moved"]).collect();
    assert_eq!(*moved[0], 0);
    assert!(moved[1..].iter().all(|&moved| *moved == 100));
}

#[tokio::test]
async fn all_readers_see_the_same_and_single_iterations_equal_it() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let base = format!("/v1/jobs/{}", id(&story.job));
    let again = server.get(&format!("{base}/events")).send().await.unwrap();
    let again = Story::read(again).await;
    assert_eq!(again.job, story.job);
    assert_eq!(again.iterations, story.iterations);
    assert_eq!(again.end, story.end);
    for k in [0, 7, story.iterations.len() - 1] {
        let single = server.json(&format!("{base}/iterations/{k}")).await;
        assert_eq!(single, story.iterations[k]);
    }
    let last = server.json(&format!("{base}/iterations/last")).await;
    assert_eq!(&last, story.iterations.last().unwrap());
    let result = server.json(&format!("{base}/result")).await;
    for field in ["control_points", "error", "iteration"] {
        assert_eq!(result[field], last[field]);
    }
    for field in ["degree", "knots", "kind"] {
        assert_eq!(result[field], story.job[field]);
    }
}

#[tokio::test]
async fn a_second_client_follows_a_running_job() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&job));
    let mut readers = Vec::new();
    for _ in 0..3 {
        let mut events = events(server.get(&path).send().await.unwrap());
        readers.push(async move {
            let mut seen = Vec::new();
            while seen.len() < 500 {
                seen.push(events.next().await.unwrap());
            }
            seen
        });
    }
    let seen = join_all(readers).await;
    assert_eq!(seen[0][1].data["iteration"], 0);
    assert_eq!(seen[0][499].data["iteration"], 498);
    assert_eq!(seen[0], seen[1]);
    assert_eq!(seen[0], seen[2]);
    server.stop().await;
}

#[tokio::test]
async fn ndjson_carries_the_same_events() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&story.job));
    let request = server.get(&path).header("accept", "application/x-ndjson");
    let response = request.send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "application/x-ndjson");
    let text = response.text().await.unwrap();
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), story.iterations.len() + 2);
    assert_eq!(lines[0], json!({"event": "job", "data": story.job}));
    for (k, iteration) in story.iterations.iter().enumerate() {
        let expected = json!({"event": "iteration", "id": k, "data": iteration});
        assert_eq!(lines[k + 1], expected);
    }
    let expected = json!({"event": "end", "id": "end", "data": story.end});
    assert_eq!(lines[lines.len() - 1], expected);
}

#[tokio::test]
async fn a_stream_resumes_after_the_last_event() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&story.job));
    let by_header = server.get(&path).header("last-event-id", "5");
    // The header wins over the parameter.
    let by_both = server
        .get(&format!("{path}?last_event_id=2"))
        .header("last-event-id", "5");
    let by_parameter = server.get(&format!("{path}?last_event_id=5"));
    for request in [by_header, by_both, by_parameter] {
        let response = request.send().await.unwrap();
        assert_eq!(response.headers()["piad-resumed-after"], "5");
        let rest = Story::read(response).await;
        assert_eq!(rest.job, story.job);
        assert_eq!(rest.iterations, story.iterations[6..]);
        assert_eq!(rest.end, story.end);
    }
    let last = story.end["iterations"].as_u64().unwrap();
    let seen = |k: u64| server.get(&path).header("last-event-id", k).send();
    let rest = Story::read(seen(last).await.unwrap()).await;
    assert!(rest.iterations.is_empty());
    let (status, answer) = problem(seen(last + 1).await.unwrap()).await;
    assert_eq!(status, 400);
    assert_eq!(answer["errors"][0]["header"], "Last-Event-ID");
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains(&format!("it ended at {last}")), "{detail}");
    let over = server.get(&path).header("last-event-id", "end");
    assert_eq!(over.send().await.unwrap().status(), 204);
    // Errors are reported even if they have no effect.
    let wrong = server
        .get(&format!("{path}?last_event_id=x"))
        .header("last-event-id", "5");
    assert_eq!(wrong.send().await.unwrap().status(), 400);
}

/// A job that runs, or that was cancelled, may have come further before a restart than it has now.
#[tokio::test]
async fn a_running_job_resumes_after_any_iteration_that_it_can_have() {
    let server = Server::start().await;
    let mut job = data::endless_job();
    job["stop"]["max_iterations"] = json!(1_000_000);
    let job = server.create(&job).await;
    let path = base(&job);
    let events = format!("{path}/events");
    let seen = |k: &str| server.get(&format!("{events}?last_event_id={k}")).send();
    assert_eq!(seen("1000000").await.unwrap().status(), 200);
    let (status, answer) = problem(seen("1000001").await.unwrap()).await;
    assert_eq!(status, 400);
    assert_eq!(answer["errors"][0]["parameter"], "last_event_id");
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains("at most 1000000"), "{detail}");
    let cancel = server.post(&format!("{path}/cancel")).send().await;
    assert_eq!(cancel.unwrap().status(), 200);
    let rest = Story::read(seen("999999").await.unwrap()).await;
    assert!(rest.iterations.is_empty() && rest.state() == "cancelled");
}

/// The ring holds only the newest frame, so that every reader falls out of it all the time.
#[tokio::test]
async fn readers_that_fall_behind_get_every_iteration() {
    let server = Server::with(|config| config.ring = "1B".parse().unwrap()).await;
    let usual = Server::start().await;
    let expected = usual.stream(&data::small_job()).await;
    let job = server.fit(&data::small_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&job));
    let readers = (0..8).map(|_| async {
        let response = server.get(&path).send().await.unwrap();
        Story::read(response).await
    });
    for story in join_all(readers).await {
        assert_eq!(story.iterations, expected.iterations);
    }
    let streamed = server.stream(&data::small_job()).await;
    assert_eq!(streamed.iterations, expected.iterations);
}

#[tokio::test]
async fn a_client_that_goes_away_does_not_end_its_job() {
    let server = Server::start().await;
    let request = server
        .post("/v1/jobs")
        .header("accept", "text/event-stream");
    let mut job = data::endless_job();
    job["stop"]["max_iterations"] = json!(20_000);
    let mut events = events(request.json(&job).send().await.unwrap());
    let job = events.next().await.unwrap().data;
    assert_eq!(events.next().await.unwrap().data["iteration"], 0);
    drop(events);
    let path = format!("/v1/jobs/{}", id(&job));
    server.until_state(&path, "exhausted").await;
    assert_eq!(server.json(&path).await["iteration"], 20_000);
}

#[tokio::test]
async fn a_client_that_does_not_read_delays_no_other() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&job));
    let stuck = server.get(&path).send().await.unwrap();
    let mut reading = events(server.get(&path).send().await.unwrap());
    for _ in 0..3000 {
        reading.next().await.unwrap();
    }
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
    drop(stuck);
}

/// A job that waits for memory is quiet; its stream is kept open by comments.
#[tokio::test]
async fn quiet_streams_are_kept_open() {
    let server = Server::with(|config| {
        config.memory = Some("128KiB".parse().unwrap());
        config.heartbeat = Duration::from_millis(20);
    })
    .await;
    let busy = server.create(&data::endless_job()).await;
    let waiting = server.create(&data::small_job()).await;
    let path = format!("/v1/jobs/{}", id(&waiting));
    assert_eq!(server.json(&path).await["state"], "queued");
    let response = server.get(&format!("{path}/events")).send().await.unwrap();
    let mut text = String::new();
    let mut bytes = response.bytes_stream();
    while text.matches(": still here\n\n").count() < 3 {
        text.push_str(std::str::from_utf8(&bytes.next().await.unwrap().unwrap()).unwrap());
    }
    assert!(!text.contains("event: iteration"));
    let cancel = server.post(&format!("/v1/jobs/{}/cancel", id(&busy)));
    assert_eq!(cancel.send().await.unwrap().status(), 200);
    while !text.contains("event: end") {
        text.push_str(std::str::from_utf8(&bytes.next().await.unwrap().unwrap()).unwrap());
    }
    assert!(text.contains("\"state\":\"converged\""));
}

#[tokio::test]
async fn streams_end_when_the_server_stops() {
    // Waiting for the grace period would take forever.
    let server = Server::with(|config| config.grace = NEVER).await;
    let job = server.create(&data::endless_job()).await;
    let path = format!("/v1/jobs/{}/events", id(&job));
    let response = server.get(&path).send().await.unwrap();
    let mut bytes = response.bytes_stream();
    bytes.next().await.unwrap().unwrap();
    let reader = tokio::spawn(async move {
        let mut text = String::new();
        while let Some(Ok(piece)) = bytes.next().await {
            // Pieces of large events may end within a character; the last ones do not.
            text = String::from_utf8_lossy(&piece).into_owned();
        }
        text
    });
    server.stop().await;
    let last = reader.await.unwrap();
    assert!(last.contains("retry: "), "{last}");
}
