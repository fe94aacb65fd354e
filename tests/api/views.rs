//! What streams show, and at which pace.

use futures_util::StreamExt;
use serde_json::json;

use crate::data;
use crate::support::{
    Server, Story, assert_query_refused, base, events, eventually, levels, problem, thinned,
};

#[tokio::test]
async fn views_show_errors_or_samples() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let base = story.end["links"]["self"].as_str().unwrap();
    let (errors, _) = thinned(&server, &format!("{base}/events?view=errors"), None).await;
    assert_eq!(errors.len(), story.iterations.len());
    for (shown, whole) in errors.iter().zip(&story.iterations) {
        assert_eq!(shown["error"], whole["error"]);
        assert_eq!(shown["rate"], whole["rate"]);
        assert!(shown.get("control_points").is_none());
    }
    let path = format!("{base}/events?view=samples&samples=50");
    let (samples, _) = thinned(&server, &path, None).await;
    for (k, shown) in samples.iter().enumerate() {
        assert_eq!(shown["samples"].as_array().unwrap().len(), 50);
        let path = format!("{base}/iterations/{k}?view=samples&samples=50");
        assert_eq!(&server.json(&path).await, shown);
    }
    let path = format!("{base}/result?view=errors");
    assert_eq!(&server.json(&path).await, errors.last().unwrap());
}

/// Streams that leave out iterations wait for the run of the job, and compute nothing themselves meanwhile.
#[tokio::test]
async fn streams_that_leave_out_iterations_share_the_run_of_the_job() {
    const STREAMS: usize = 10;
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let path = base(&job);
    let reached = async || server.json(path).await["iteration"].as_f64().unwrap_or(0.0);
    let comes_to = async |level: f64| {
        eventually("the job continues", async || reached().await > level).await;
    };
    // Iteration 0 has to be computed again.
    comes_to(10_000.0).await;
    let mut streams = Vec::new();
    for _ in 0..STREAMS {
        let stream = server.get(&format!("{path}/events?every=1000000000"));
        let mut stream = events(stream.send().await.unwrap());
        for name in ["job", "iteration"] {
            assert_eq!(stream.next().await.unwrap().name, name);
        }
        streams.push(stream);
    }
    comes_to(reached().await + 10_000.0).await;
    let computed = server.metrics().await["piad_iterations_total"];
    let again = computed - reached().await;
    assert!(again < 100.0 * STREAMS as f64, "{again} levels again");
    server.delete(path).send().await.unwrap();
}

#[tokio::test]
async fn every_nth_iteration_and_the_last() {
    let server = Server::start().await;
    let story = server.stream(&data::small_job()).await;
    let last = story.iterations.len() as u64 - 1;
    let base = story.end["links"]["self"].as_str().unwrap();
    for every in [1, 2, 7, last, 10 * last] {
        let path = format!("{base}/events?every={every}");
        let (iterations, end) = thinned(&server, &path, None).await;
        let mut expected: Vec<u64> = (0..=last).filter(|k| k % every == 0).collect();
        if expected.last() != Some(&last) {
            expected.push(last);
        }
        assert_eq!(levels(&iterations), expected);
        assert_eq!(end, story.end);
        for iteration in &iterations {
            let k = iteration["iteration"].as_u64().unwrap() as usize;
            assert_eq!(iteration, &story.iterations[k]);
        }
    }
    // Resuming keeps the rhythm.
    let (iterations, _) = thinned(&server, &format!("{base}/events?every=7"), Some("9")).await;
    assert_eq!(levels(&iterations)[0], 14);
    let over = format!("{base}/events?every=7");
    let (iterations, _) = thinned(&server, &over, Some(&last.to_string())).await;
    assert!(iterations.is_empty());
    // The same while the job runs.
    let request = server
        .post("/v1/jobs?every=7")
        .header("accept", "text/event-stream");
    let response = request.json(&data::small_job()).send().await.unwrap();
    let mut stream = events(response);
    let mut seen = Vec::new();
    while let Some(event) = stream.next().await {
        if event.name == "iteration" {
            seen.push(event.data);
        }
    }
    assert!(levels(&seen).iter().all(|k| k % 7 == 0 || *k == last));
    assert_eq!(levels(&seen).last(), Some(&last));
}

#[tokio::test]
async fn the_latest_pace_of_every_tenth() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let path = format!(
        "{}/events?pace=latest&every=10&view=errors",
        job["links"]["self"].as_str().unwrap()
    );
    let mut stream = events(server.get(&path).send().await.unwrap());
    stream.next().await.unwrap();
    for _ in 0..30 {
        let iteration = stream.next().await.unwrap();
        assert!(iteration.id.ends_with('0'), "{}", iteration.id);
        tokio::time::sleep(std::time::Duration::from_millis(1)).await;
    }
    server.stop().await;
}

#[tokio::test]
async fn the_latest_pace_skips_old_iterations() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let path = format!(
        "{}/events?pace=latest&view=errors",
        job["links"]["self"].as_str().unwrap()
    );
    let mut stream = events(server.get(&path).send().await.unwrap());
    stream.next().await.unwrap();
    let mut last = None;
    let mut skipped = 0;
    // A busy machine may not compute faster than it sends, for a while.
    while last < Some(50) || skipped == 0 {
        let k = stream.next().await.unwrap().data["iteration"]
            .as_u64()
            .unwrap();
        if let Some(last) = last {
            assert!(k > last, "{k} after {last}");
            skipped += k - last - 1;
        }
        last = Some(k);
        // Slower than the fit.
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
    }
    server.stop().await;
}

#[tokio::test]
async fn a_job_may_end_with_its_client() {
    let server = Server::start().await;
    for (option, expected) in [("cancel", "cancelled"), ("continue", "running")] {
        let request = server
            .post(&format!("/v1/jobs?on_disconnect={option}"))
            .header("accept", "text/event-stream");
        let mut stream = events(request.json(&data::endless_job()).send().await.unwrap());
        let job = stream.next().await.unwrap().data;
        stream.next().await.unwrap();
        drop(stream);
        let path = job["links"]["self"].as_str().unwrap();
        server.until_state(path, expected).await;
    }
    // A client that stays to the end has nothing to cancel.
    let request = server
        .post("/v1/jobs?on_disconnect=cancel")
        .header("accept", "text/event-stream");
    let response = request.json(&data::small_job()).send().await.unwrap();
    assert_eq!(Story::read(response).await.state(), "converged");
    server.stop().await;
}

/// Readers of a job cannot end it: neither by a parameter, nor by the job's stream settings, nor with the key of its
/// request.
#[tokio::test]
async fn readers_do_not_end_the_job_of_another() {
    let server = Server::start().await;
    let mut body = data::endless_job();
    body["stream"] = json!({"on_disconnect": "cancel"});
    let post = async || {
        let request = server.post("/v1/jobs").header("idempotency-key", "mine");
        let request = request.header("accept", "text/event-stream");
        request.json(&body).send().await.unwrap()
    };
    let response = post().await;
    let path = response.headers()["location"].to_str().unwrap().to_owned();
    let mut own = events(response);
    own.next().await.unwrap();
    let watch = format!("{path}/events");
    assert_query_refused(
        &server,
        &watch,
        "on_disconnect=cancel",
        "on_disconnect",
        "only the stream that is the answer",
    )
    .await;
    let replay = post().await;
    assert_eq!(replay.headers()["idempotency-replayed"], "true");
    let others = [
        replay,
        server.get(&watch).send().await.unwrap(),
        server
            .get(&format!("{watch}?on_disconnect=continue"))
            .send()
            .await
            .unwrap(),
    ];
    for response in others {
        let mut stream = events(response);
        stream.next().await.unwrap();
        drop(stream);
    }
    // The others disconnect when only the creator reads.
    server.until("piad_streams_open", 1.0).await;
    assert_eq!(server.json(&path).await["state"], "running");
    drop(own);
    server.until_state(&path, "cancelled").await;
    server.stop().await;
}

#[tokio::test]
async fn wrong_options_are_refused() {
    let server = Server::start().await;
    let job = data::small_job();
    let id = server.fit(&job).await["id"].as_str().unwrap().to_owned();
    for query in [
        "every=0",
        "every=-1",
        "every=x",
        "every=9007199254740992",
        "pace=fast",
        "view=all",
        "samples=9",
        "view=samples&samples=3x3",
        "on_disconnect=stop",
        "everyy=1",
    ] {
        let request = server.get(&format!("/v1/jobs/{id}/events?{query}"));
        let (status, answer) = problem(request.send().await.unwrap()).await;
        assert_eq!(status, 400, "{query}");
        let name = answer["errors"][0]["parameter"].as_str().unwrap();
        assert!(query.contains(name), "{answer:#}");
    }
    // Options of streams without a stream, and resuming what has not begun.
    let request = server.post("/v1/jobs?every=2").json(&job);
    assert_eq!(problem(request.send().await.unwrap()).await.0, 400);
    let request = server.post("/v1/jobs?last_event_id=2").json(&job);
    let request = request.header("accept", "text/event-stream");
    assert_eq!(problem(request.send().await.unwrap()).await.0, 400);
    let jobs = server.json("/v1/jobs").await;
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 1);
    assert_eq!(jobs["next"], json!(null));
}
