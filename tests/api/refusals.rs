//! Requests beyond the limits, and errors of paths, methods, headers and parameters.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, problem};

#[tokio::test]
async fn limits_are_named() {
    let server = Server::with(|config| {
        config.max_body = "10000".parse().unwrap();
        config.max_points = 50;
        config.max_iterations = 10;
    })
    .await;
    let job = json!({"curve": {"points": data::wave(100)}});
    let response = server.post("/v1/jobs").json(&job).send().await.unwrap();
    let (status, answer) = problem(response).await;
    assert_eq!(status, 422);
    assert_eq!(answer["errors"][0]["pointer"], "/curve/points");
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains("100 points are more than 50"), "{detail}");

    // With a Content-Length, and without one.
    let long = json!({"name": "n".repeat(20_000)}).to_string();
    let chunks = [Ok::<_, std::io::Error>(long.clone())];
    let streamed = reqwest::Body::wrap_stream(futures_util::stream::iter(chunks));
    for body in [reqwest::Body::from(long), streamed] {
        let request = server
            .post("/v1/jobs")
            .header("content-type", "application/json");
        let (status, answer) = problem(request.body(body).send().await.unwrap()).await;
        assert_eq!(status, 413);
        assert!(answer["detail"].as_str().unwrap().contains("10000 bytes"));
    }

    let mut job = json!({"curve": {"points": [[0], [1]]}});
    assert_eq!(server.fit(&job).await["stop"]["max_iterations"], 10);
    job["stop"] = json!({"max_iterations": 11});
    let (status, answer) = problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
    assert_eq!(status, 422);
    assert!(answer["detail"].as_str().unwrap().contains("more than 10"));
}

/// Lists end where they are longer than a job of as many points as there may be has them, and the error names them.
#[tokio::test]
async fn lists_that_are_too_long_are_named() {
    let server = Server::with(|config| config.max_points = 50).await;
    let numbers = |count: usize| vec![1; count];
    // As many knots or weights of control points as the largest degree has more.
    let (long, most) = (numbers(3000), 50 + 2002);
    let curve = |field: &str, value: Value| json!({"curve": {"points": [[0], [1]], field: value}});
    let method = |value: Value| json!({"curve": {"points": [[0], [1]]}, "method": value});
    let too_many = format!("more than {most} of them");
    let rows = json!({"surface": {"points": vec![vec![1; 10]; 10]}});
    let cases = [
        (
            json!({"curve": {"points": vec![[1]; 75]}}),
            "/curve/points",
            "75 points are more than 50",
        ),
        (
            json!({"curve": {"points": vec![[1]; 2000]}}),
            "/curve/points",
            "more than 100 points are more than 50",
        ),
        (rows, "/surface/points", "100 points are more than 50"),
        (curve("weights", json!(long)), "/curve/weights", &too_many),
        (
            curve("parameters", json!(long)),
            "/curve/parameters",
            &too_many,
        ),
        (
            curve("basis", json!({"kind": "bspline", "knots": long})),
            "/curve/basis/knots",
            &too_many,
        ),
        (
            method(json!({"kind": "local", "indices": numbers(51)})),
            "/method/indices",
            "more than 50 of them",
        ),
        (
            method(json!({"kind": "adaptive", "threshold": long})),
            "/method/threshold",
            &too_many,
        ),
        (
            method(json!({"kind": "least_squares", "control_points": 2, "data_weights": long})),
            "/method/data_weights",
            &too_many,
        ),
        (
            method(json!({"kind": "custom", "transform": [numbers(501)]})),
            "/method/transform/0",
            "at most 500 of them",
        ),
        (
            curve("ends", json!({"start": {"derivatives": vec![[1]; 1001]}})),
            "/curve/ends/start",
            "1001 orders of derivatives",
        ),
    ];
    for (job, pointer, reason) in cases {
        let (status, answer) =
            problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
        assert_eq!(status, 422, "{answer:#}");
        let said = answer["errors"][0]["pointer"].as_str().unwrap();
        assert!(said.starts_with(pointer), "{pointer}: {answer:#}");
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{reason}: {detail}");
    }
}

#[tokio::test]
async fn fits_that_need_too_much_memory_are_refused() {
    let server = Server::with(|config| config.memory = Some("1MiB".parse().unwrap())).await;
    let job = json!({"curve": {"points": data::wave(50_000)}});
    let (status, answer) = problem(server.post("/v1/jobs").json(&job).send().await.unwrap()).await;
    assert_eq!(status, 422);
    let detail = answer["detail"].as_str().unwrap();
    assert!(detail.contains("bytes of memory"), "{detail}");
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
}

#[tokio::test]
async fn resources_methods_and_media_types() {
    let server = Server::start().await;
    let job = data::small_job().to_string();
    let id = server.fit(&data::small_job()).await["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let missing = "/v1/jobs/018f0000-0000-7000-8000-000000000000";
    let typed = |kind: &str| {
        server
            .post("/v1/jobs")
            .header("content-type", kind)
            .body(job.clone())
    };
    let json = "application/json";
    let cases = [
        (server.get("/nothing"), 404, "not-found"),
        (server.get(missing), 404, "unknown-job"),
        (server.get("/v1/jobs/seven"), 404, "unknown-job"),
        (server.get(&format!("{missing}/events")), 404, "unknown-job"),
        (server.get(&format!("{missing}/result")), 404, "unknown-job"),
        (
            server.get(&format!("{missing}/iterations/0")),
            404,
            "unknown-job",
        ),
        (
            server.post(&format!("{missing}/cancel")),
            404,
            "unknown-job",
        ),
        (server.delete(missing), 404, "unknown-job"),
        (
            server.get(&format!("/v1/jobs/{id}/iterations/999")),
            404,
            "no-such-iteration",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/iterations/-1")),
            404,
            "no-such-iteration",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/iterations/first")),
            404,
            "no-such-iteration",
        ),
        (
            server.post(&format!("/v1/jobs/{id}/cancel")),
            409,
            "already-ended",
        ),
        (server.delete("/v1/jobs"), 405, "method-not-allowed"),
        (
            server.post(&format!("/v1/jobs/{id}/events")),
            405,
            "method-not-allowed",
        ),
        (
            server.post("/v1/jobs").body(job.clone()),
            415,
            "unsupported-media-type",
        ),
        (typed("text/html"), 415, "unsupported-media-type"),
        (typed("application/yaml"), 415, "unsupported-media-type"),
        (
            typed(json).header("accept", "image/png"),
            406,
            "not-acceptable",
        ),
        (
            server
                .get(&format!("/v1/jobs/{id}/events"))
                .header("accept", json),
            406,
            "not-acceptable",
        ),
        (
            server
                .get(&format!("/v1/jobs/{id}/result"))
                .header("accept", "image/png"),
            406,
            "not-acceptable",
        ),
        (
            typed(json).header("prefer", "wait=soon"),
            400,
            "invalid-request",
        ),
        (
            typed(json).header("prefer", "wait=-1"),
            400,
            "invalid-request",
        ),
        (server.get("/v1/jobs?state=busy"), 400, "invalid-request"),
        (server.get("/v1/jobs?limit=0"), 400, "invalid-request"),
        (server.get("/v1/jobs?limit=many"), 400, "invalid-request"),
        (server.get("/v1/jobs?page=2"), 400, "invalid-request"),
        (server.get("/v1/jobs?cursor=2"), 400, "invalid-request"),
        (server.post("/v1/jobs?every=2"), 400, "invalid-request"),
        (
            server.get(&format!("/v1/jobs/{id}/events?last_event_id=x")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/events?last_id=1")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/result?view=points")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/result?samples=10")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/result?view=samples&samples=1")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!("/v1/jobs/{id}/result?view=samples&samples=9x9")),
            400,
            "invalid-request",
        ),
        (
            server.get(&format!(
                "/v1/jobs/{id}/result?view=samples&samples=9999999"
            )),
            400,
            "invalid-request",
        ),
    ];
    for (request, status, slug) in cases {
        let (client, request) = request.build_split();
        let request = request.unwrap();
        let shown = format!("{} {}", request.method(), request.url());
        let (given, problem) = problem(client.execute(request).await.unwrap()).await;
        assert_eq!(given, status, "{shown} {problem:#}");
        assert_eq!(
            problem["type"],
            format!("/problems/{slug}"),
            "{shown} {problem:#}"
        );
        if status == 400 {
            let error = &problem["errors"][0];
            assert!(
                error["parameter"].is_string() || error["header"].is_string(),
                "{problem:#}"
            );
        }
    }
}

#[tokio::test]
async fn every_type_of_problem_is_documented() {
    let server = Server::start().await;
    let problems = server.json("/problems").await;
    for entry in problems.as_array().unwrap() {
        let path = entry["type"].as_str().unwrap();
        assert_eq!(&server.json(path).await, entry);
        assert!(!entry["meaning"].as_str().unwrap().is_empty());
    }
    let (status, _) = problem(server.get("/problems/none").send().await.unwrap()).await;
    assert_eq!(status, 404);
}
