//! The life of jobs: created, listed, followed, cancelled, deleted, forgotten.

use std::time::Duration;

use futures_util::{StreamExt, future::join_all};
use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, events, eventually, problem};

fn path(job: &Value) -> String {
    job["links"]["self"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn creating_answers_with_the_job_and_its_place() {
    let server = Server::start().await;
    let response = server
        .post("/v1/jobs")
        .json(&data::small_job())
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 201);
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let job: Value = response.json().await.unwrap();
    assert_eq!(path(&job), location);
    assert_eq!(job["kind"], "curve");
    assert_eq!(job["points"], 100);
    assert_eq!(job["stop"]["max_iterations"], 1000);
}

#[tokio::test]
async fn waiting_answers_with_the_end_or_with_what_there_is() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    assert_eq!(job["state"], "converged");
    assert_eq!(job["progress"], 1.0);
    let times: Vec<&str> = ["created_at", "started_at", "finished_at"]
        .map(|field| job[field].as_str().unwrap())
        .to_vec();
    assert!(times.is_sorted(), "{times:?}");

    let request = server
        .post("/v1/jobs")
        .header("prefer", "respond-async, wait=0");
    let response = request.json(&data::endless_job()).send().await.unwrap();
    assert_eq!(response.headers()["preference-applied"], "wait=0");
    let job: Value = response.json().await.unwrap();
    assert!(["queued", "running"].contains(&job["state"].as_str().unwrap()));
    assert_eq!(job["finished_at"], Value::Null);
}

#[tokio::test]
async fn progress_is_that_of_geometric_convergence() {
    let server = Server::start().await;
    let mut job = json!({"curve": {"points": data::lemniscate(), "basis": {"kind": "bernstein"}}});
    job["stop"] = json!({"tolerance": 1e-30, "max_iterations": 1_000_000});
    let job = server.create(&job).await;
    let first = server.json(&format!("{}/iterations/0", path(&job))).await;
    let mut seen = 0;
    while seen < 10 {
        let now = server.json(&path(&job)).await;
        if now["state"] == "running" && !now["error"].is_null() {
            let error = |job: &Value| job["error"]["max"].as_f64().unwrap();
            let expected = (error(&first) / error(&now)).ln() / (error(&first) / 1e-30).ln();
            let progress = now["progress"].as_f64().unwrap();
            assert!((progress - expected).abs() < 1e-12);
            assert!((0.0..1.0).contains(&progress));
            seen += 1;
        }
        // On a busy machine the fit can end before it was looked at ten times.
        if now["finished_at"].is_string() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    assert!(seen > 0);
    server.stop().await;
}

#[tokio::test]
async fn a_running_job_is_cancelled_and_its_streams_end() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let mut stream = events(
        server
            .get(&format!("{}/events", path(&job)))
            .send()
            .await
            .unwrap(),
    );
    for _ in 0..10 {
        stream.next().await.unwrap();
    }
    let cancel = format!("{}/cancel", path(&job));
    let cancelled = server.post(&cancel).send().await.unwrap();
    assert_eq!(cancelled.status(), 200);
    let cancelled: Value = cancelled.json().await.unwrap();
    assert_eq!(cancelled["state"], "cancelled");
    let reached = cancelled["iteration"].as_u64().unwrap();
    // Streams that are open end soon, wherever they are.
    let mut last = stream.next().await.unwrap();
    while let Some(event) = stream.next().await {
        last = event;
    }
    assert_eq!(last.name, "end");
    assert_eq!(last.data["state"], "cancelled");
    assert_eq!(last.data["iterations"], reached);
    // What was computed can still be read, and cancelling again changes nothing.
    let result = server.json(&format!("{}/result", path(&job))).await;
    assert_eq!(result["iteration"], reached);
    let iteration = server
        .json(&format!("{}/iterations/{reached}", path(&job)))
        .await;
    assert_eq!(iteration["control_points"], result["control_points"]);
    let beyond = server.get(&format!("{}/iterations/{}", path(&job), reached + 1));
    assert_eq!(problem(beyond.send().await.unwrap()).await.0, 404);
    assert_eq!(server.post(&cancel).send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn a_queued_job_is_cancelled_before_it_begins() {
    let server = Server::with(|config| config.memory = Some("128KiB".parse().unwrap())).await;
    let busy = server.create(&data::endless_job()).await;
    let queued = server.create(&data::endless_job()).await;
    assert_eq!(server.json(&path(&queued)).await["state"], "queued");
    let (status, _) = problem(
        server
            .get(&format!("{}/result", path(&queued)))
            .send()
            .await
            .unwrap(),
    )
    .await;
    assert_eq!(status, 409);
    server
        .post(&format!("{}/cancel", path(&queued)))
        .send()
        .await
        .unwrap();
    let queued = server.json(&path(&queued)).await;
    assert_eq!(queued["state"], "cancelled");
    assert_eq!(queued["iteration"], Value::Null);
    let none = server.get(&format!("{}/iterations/0", path(&queued)));
    assert_eq!(problem(none.send().await.unwrap()).await.0, 404);
    assert_eq!(server.json(&path(&busy)).await["state"], "running");
}

#[tokio::test]
async fn deleting_ends_a_job_and_forgets_it() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let mut stream = events(
        server
            .get(&format!("{}/events", path(&job)))
            .send()
            .await
            .unwrap(),
    );
    stream.next().await.unwrap();
    assert_eq!(
        server.delete(&path(&job)).send().await.unwrap().status(),
        204
    );
    let mut last = stream.next().await.unwrap();
    while let Some(event) = stream.next().await {
        last = event;
    }
    assert_eq!(last.data["state"], "cancelled");
    let (status, _) = problem(server.get(&path(&job)).send().await.unwrap()).await;
    assert_eq!(status, 404);
    let (status, _) = problem(server.delete(&path(&job)).send().await.unwrap()).await;
    assert_eq!(status, 404);
}

#[tokio::test]
async fn jobs_are_listed_newest_first_page_by_page() {
    let server = Server::start().await;
    let mut ids = Vec::new();
    for _ in 0..7 {
        ids.push(server.fit(&data::small_job()).await["id"].clone());
    }
    let running = server.create(&data::endless_job()).await["id"].clone();
    ids.push(running.clone());
    ids.reverse();
    let mut seen = Vec::new();
    let mut next = Some("/v1/jobs?limit=3".to_owned());
    let mut pages = 0;
    while let Some(page) = next {
        let page = server.json(&page).await;
        let jobs = page["jobs"].as_array().unwrap();
        seen.extend(jobs.iter().map(|job| job["id"].clone()));
        next = page["next"].as_str().map(str::to_owned);
        pages += 1;
    }
    assert_eq!(seen, ids);
    assert_eq!(pages, 3);
    let converged = server.json("/v1/jobs?state=converged").await;
    assert_eq!(converged["jobs"].as_array().unwrap().len(), 7);
    assert_eq!(converged["next"], Value::Null);
    let page = server.json("/v1/jobs?state=converged&limit=5").await;
    let rest = server.json(page["next"].as_str().unwrap()).await;
    assert_eq!(rest["jobs"].as_array().unwrap().len(), 2);
    let others = server.json("/v1/jobs?state=running").await;
    assert_eq!(others["jobs"][0]["id"], running);
}

#[tokio::test]
async fn several_jobs_at_once_do_not_disturb_each_other() {
    let server = Server::start().await;
    let alone = server.stream(&data::small_job()).await;
    let endless =
        join_all((0..6).map(|_| async { server.create(&data::endless_job()).await })).await;
    let stories =
        join_all((0..20).map(|_| async { server.stream(&data::small_job()).await })).await;
    for story in stories {
        assert_eq!(story.iterations, alone.iterations);
    }
    for job in endless {
        assert_eq!(server.json(&path(&job)).await["state"], "running");
    }
    server.stop().await;
}

#[tokio::test]
async fn a_full_server_says_when_to_come_back() {
    let server = Server::with(|config| {
        config.max_jobs = 2;
        config.max_jobs_per_peer = Some(2);
    })
    .await;
    let first = server.create(&data::endless_job()).await;
    server.create(&data::endless_job()).await;
    let response = server
        .post("/v1/jobs")
        .json(&data::small_job())
        .send()
        .await
        .unwrap();
    assert_eq!(response.headers()["retry-after"], "5");
    let (status, answer) = problem(response).await;
    assert_eq!(status, 503);
    assert_eq!(answer["type"], "/problems/queue-full");
    server
        .post(&format!("{}/cancel", path(&first)))
        .send()
        .await
        .unwrap();
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
}

#[tokio::test]
async fn the_number_of_ended_jobs_is_limited() {
    let server = Server::with(|config| config.retain_jobs = 3).await;
    let running = server.create(&data::endless_job()).await;
    let mut ended = Vec::new();
    for _ in 0..5 {
        ended.push(server.fit(&data::small_job()).await);
    }
    let kept = [&ended[4], &ended[3], &ended[2], &running].map(path);
    // The last one is forgotten a moment after the next has ended.
    eventually("the last four are kept", async || {
        let listed = server.json("/v1/jobs").await;
        let listed = listed["jobs"].as_array().unwrap().iter().map(path);
        listed.eq(kept.iter().cloned())
    })
    .await;
    let (status, _) = problem(server.get(&path(&ended[0])).send().await.unwrap()).await;
    assert_eq!(status, 404);
}

/// Bernstein control points of data that go up and down grow with every iteration.
#[tokio::test]
async fn a_fit_that_overflows_fails_with_a_reason() {
    let server = Server::start().await;
    let points: Vec<[f64; 1]> = (0..20)
        .map(|i| [if i % 2 == 0 { 2e306 } else { -2e306 }])
        .collect();
    let story = server
        .stream(&json!({
            "curve": {"points": points, "basis": {"kind": "bernstein"}, "parameters": "uniform"},
            "stop": {"tolerance": 1, "max_iterations": 100_000},
        }))
        .await;
    assert_eq!(story.state(), "failed");
    assert_eq!(story.end["problem"]["type"], "/problems/overflow");
    assert!(!story.iterations.is_empty());
    let last = story.iterations.last().unwrap();
    assert!(last["error"]["max"].as_f64().unwrap().is_finite());
    assert_eq!(story.end["iterations"], last["iteration"]);
    let job = server
        .json(story.end["links"]["self"].as_str().unwrap())
        .await;
    assert_eq!(job["problem"]["type"], "/problems/overflow");
}

#[tokio::test]
async fn surfaces_are_fitted_with_a_basis_for_each_direction() {
    let server = Server::start().await;
    let story = server
        .stream(&json!({
            "surface": {
                "points": data::peaks(9),
                "basis": {"u": {"kind": "bernstein"}, "v": {"kind": "bspline", "degree": 2, "knots": "averaged"}},
                "parameters": {"u": "uniform", "v": "centripetal"},
            },
            "stop": {"tolerance": 1e-3, "max_iterations": 100_000},
        }))
        .await;
    // Degree 8 in one direction and centripetal parameters in the other: the surface swings between the points.
    assert_eq!(story.end["reason"], "between");
    assert_eq!(story.job["degree"], json!({"u": 8, "v": 2}));
    assert_eq!(
        story.job["basis"],
        json!({"u": "bernstein", "v": "bspline"})
    );
    let net = story.iterations[0]["control_points"].as_array().unwrap();
    assert_eq!((net.len(), net[0].as_array().unwrap().len()), (9, 9));
    let at = story.iterations[0]["error"]["at"].as_array().unwrap();
    assert_eq!(at.len(), 2);
}

/// Samples at the parameters of the data lie on the data, up to the error of the fit.
#[tokio::test]
async fn results_can_be_sampled() {
    let server = Server::start().await;
    let points: Vec<[f64; 2]> = (0..=20)
        .map(f64::from)
        .map(|x| [x, (x / 3.0).sin()])
        .collect();
    let job = server
        .fit(&json!({
            "curve": {"points": points, "parameters": "uniform"},
            "stop": {"tolerance": 1e-10},
        }))
        .await;
    let sampled = server
        .json(&format!("{}/result?view=samples&samples=21", path(&job)))
        .await;
    let samples = sampled["samples"].as_array().unwrap();
    assert_eq!(samples.len(), 21);
    for (sample, point) in samples.iter().zip(&points) {
        for c in 0..2 {
            assert!((sample[c].as_f64().unwrap() - point[c]).abs() < 1.1e-10);
        }
    }
    let story = server
        .stream(&json!({
            "surface": {"points": data::peaks(7), "parameters": "uniform"},
            "stop": {"tolerance": 1e-10},
        }))
        .await;
    let base = story.end["links"]["self"].as_str().unwrap().to_owned();
    let sampled = server
        .json(&format!("{base}/iterations/last?view=samples&samples=7x7"))
        .await;
    let data = data::peaks(7);
    for i in 0..7 {
        for j in 0..7 {
            for c in 0..3 {
                let sample = sampled["samples"][i][j][c].as_f64().unwrap();
                assert!((sample - data[i][j][c].as_f64().unwrap()).abs() < 1.1e-10);
            }
        }
    }
}
