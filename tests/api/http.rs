//! What every HTTP service has: health, capabilities, request ids.

use serde_json::json;

use crate::data;
use crate::support::{Server, base, problem};

#[tokio::test]
async fn health() {
    let server = Server::start().await;
    assert_eq!(server.json("/livez").await, json!({"status": "alive"}));
    assert_eq!(server.json("/readyz").await, json!({"status": "ready"}));
    let head = server.client.head(format!("{}/livez", server.url));
    assert_eq!(head.send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn capabilities_name_the_limits() {
    let server = Server::with(|config| config.max_points = 1234).await;
    let capabilities = server.json("/v1/capabilities").await;
    assert_eq!(capabilities["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(capabilities["limits"]["points"], 1234);
    assert_eq!(capabilities["limits"]["body_bytes"], 256 * 1024 * 1024);
    let index = server.json("/").await;
    for link in index["links"].as_object().unwrap().values() {
        let response = server.get(link.as_str().unwrap()).send().await.unwrap();
        assert_eq!(response.status(), 200, "{link}");
    }
}

/// Each basis, knot choice and parametrization that is announced is accepted.
#[tokio::test]
async fn capabilities_are_true() {
    let server = Server::start().await;
    let capabilities = server.json("/v1/capabilities").await;
    let names = |value: &serde_json::Value| -> Vec<String> {
        let names = value.as_array().unwrap().iter();
        names
            .map(|name| name.as_str().unwrap().to_owned())
            .collect()
    };
    let points = json!([[0, 0], [1, 2], [2, 1], [3, 3], [4, 0]]);
    for parameters in names(&capabilities["parameters"]) {
        let parameters = match parameters.as_str() {
            "explicit" => json!([0, 1, 2, 3, 4]),
            name => json!(name),
        };
        for basis in capabilities["bases"].as_array().unwrap() {
            let mut bases = vec![json!({"kind": basis["kind"]})];
            if !basis["knots"].is_null() {
                bases = names(&basis["knots"])
                    .iter()
                    .map(|knots| match knots.as_str() {
                        "explicit" => json!([0, 0, 0, 1.5, 2.5, 4, 4, 4]),
                        name => json!(name),
                    })
                    .map(|knots| json!({"kind": basis["kind"], "degree": 2, "knots": knots}))
                    .collect();
            }
            for basis in bases {
                for method in [
                    "global",
                    "weighted",
                    "extended",
                    "transpose",
                    "chebyshev",
                    "direct",
                ] {
                    let method = json!({"kind": method});
                    let job = server
                        .fit(&json!({
                            "curve": {"points": points, "parameters": parameters, "basis": basis},
                            "method": method,
                            "stop": {"tolerance": 1e-3, "max_iterations": 100_000},
                        }))
                        .await;
                    assert_eq!(job["state"], "converged", "{basis} {parameters}");
                }
            }
        }
    }
}

#[tokio::test]
async fn a_client_may_name_its_request() {
    let server = Server::start().await;
    let request = server.get("/nothing").header("x-request-id", "plugin-42");
    let (_, answer) = problem(request.send().await.unwrap()).await;
    assert_eq!(answer["request_id"], "plugin-42");
}

#[tokio::test]
async fn a_wrong_method_gets_the_allowed_ones() {
    let server = Server::start().await;
    for (path, allowed) in [
        ("/v1/jobs", "GET, HEAD, POST"),
        ("/v1/jobs/x", "DELETE, GET, HEAD"),
        ("/v1/jobs/x/cancel", "POST"),
        ("/livez", "GET, HEAD"),
    ] {
        let request = server.client.patch(format!("{}{path}", server.url));
        let response = request.send().await.unwrap();
        let header = response.headers()["allow"].to_str().unwrap();
        let sorted = |list: &str| {
            let mut words: Vec<_> = list.split(',').map(|word| word.trim().to_owned()).collect();
            words.sort();
            words.join(", ")
        };
        assert_eq!(sorted(header), allowed, "{path}");
        let (status, answer) = problem(response).await;
        assert_eq!(status, 405);
        let detail = answer["detail"].as_str().unwrap();
        let (_, reported) = detail
            .split_once(" does not support PATCH; allowed: ")
            .unwrap();
        assert_eq!(sorted(reported), allowed, "{path}");
    }
}

/// JSON ends with a newline, and says how long it is with it; so does HEAD.
#[tokio::test]
async fn json_ends_with_a_newline() {
    let server = Server::start().await;
    let curve = json!({"points": crate::data::helix()});
    let small = server.fit(&crate::data::small_job()).await;
    let large = server
        .fit(&json!({"curve": curve, "method": "direct"}))
        .await;
    let mut paths: Vec<String> = [
        "/",
        "/livez",
        "/openapi.json",
        "/v1/capabilities",
        "/v1/jobs",
        "/problems",
    ]
    .map(str::to_owned)
    .into();
    for job in [small, large] {
        let parts = [
            "",
            "/input",
            "/result",
            "/iterations/0?encoding=base64",
            "/iterations/last?view=samples&samples=20000",
            "/nothing",
        ];
        paths.extend(parts.map(|part| format!("{}{part}", crate::support::base(&job))));
    }
    for path in paths {
        let response = server.get(&path).send().await.unwrap();
        let length = response.content_length();
        let text = response.text().await.unwrap();
        assert!(text.ends_with("}\n") || text.ends_with("]\n"), "{path}");
        assert!(!text.trim_end_matches('\n').contains('\n'), "{path}");
        assert!(
            length.is_none_or(|length| length == text.len() as u64),
            "{path}"
        );
        let head = server.client.head(format!("{}{path}", server.url));
        let head = head.send().await.unwrap();
        let reported = head.headers().get("content-length");
        let reported = reported.map(|value| value.to_str().unwrap().parse::<u64>().unwrap());
        assert_eq!(reported, length, "{path}");
    }
    // Lines of streams have theirs already; messages are no text.
    let request = server
        .post("/v1/jobs")
        .header("accept", "application/x-ndjson");
    let lines = request
        .json(&crate::data::small_job())
        .send()
        .await
        .unwrap();
    let lines = lines.text().await.unwrap();
    assert!(lines.ends_with("}\n") && !lines.contains("\n\n"));
}

#[tokio::test]
async fn iterations_are_waited_for_as_long_as_the_client_wants() {
    let server = Server::start().await;
    let job = server.create(&data::endless_job()).await;
    let ask = |k: usize, wait: &str| {
        let request = server.get(&format!("{}/iterations/{k}", base(&job)));
        request.header("prefer", wait).send()
    };
    let reached = ask(50, "wait=100").await.unwrap();
    assert_eq!(reached.status(), 200);
    assert_eq!(reached.headers()["preference-applied"], "wait=100");
    // What was reached comes without waiting for anything else.
    let first = server.json(&format!("{}/iterations/0", base(&job))).await;
    assert_eq!(first["iteration"], 0);
    for (wait, format) in [("wait=0", ""), ("wait=1", "/csv")] {
        let path = format!("{}/iterations/999999999{format}", base(&job));
        let request = server.get(&path).header("prefer", wait);
        let response = request.send().await.unwrap();
        assert_eq!(response.headers()["retry-after"], "10");
        let (status, answer) = problem(response).await;
        assert_eq!(status, 503);
        assert_eq!(answer["type"], "/problems/not-reached");
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains("running at iteration"), "{detail}");
        assert!(detail.contains("largest distance"), "{detail}");
    }
    let (status, answer) = problem(ask(1, "wait=soon").await.unwrap()).await;
    assert_eq!(
        (status, &answer["errors"][0]["header"]),
        (400, &json!("Prefer"))
    );
    // The end of the server is not waited for, either.
    let waits = tokio::spawn(ask(999_999_999, "wait=300"));
    server.until("piad_jobs_running", 1.0).await;
    server.stop().await;
    if let Ok(answer) = waits.await.unwrap() {
        assert_eq!(problem(answer).await.0, 503);
    }
}

/// An iteration far behind is not computed from the start each time, and is the same to the last bit.
#[tokio::test]
async fn early_iterations_are_recomputed_from_checkpoints() {
    let server = Server::with(|config| config.ring = "1B".parse().unwrap()).await;
    let points = data::wave(300);
    let selected: Vec<usize> = (0..300).step_by(2).collect();
    for method in [
        json!({"kind": "weighted", "omega": 1e-4}),
        json!({"kind": "transpose"}),
        json!({"kind": "chebyshev"}),
        json!({"kind": "local", "indices": selected, "omega": 1e-4}),
        json!({"kind": "least_squares", "control_points": 40, "variant": "lspia", "mu": 1e-5, "fairness": 1e-3}),
    ] {
        let job = json!({
            "curve": {"points": points},
            "method": method,
            "stop": {"tolerance": 0, "max_iterations": 6000},
        });
        let story = server.stream(&job).await;
        let last = story.iterations.len() - 1;
        let path = base(&story.job).to_owned();
        for k in [last - 1, last / 2, last - 1, 300, last / 3] {
            if k == 0 || k > last {
                continue;
            }
            let before = server.metrics().await["piad_iterations_total"];
            let iteration = server.json(&format!("{path}/iterations/{k}")).await;
            assert_eq!(iteration, story.iterations[k], "{method}");
            let computed = server.metrics().await["piad_iterations_total"] - before;
            // Checkpoints of 6000 levels are 1024 levels apart; a few levels are computed ahead.
            assert!(
                computed < 1200.0,
                "{method}: {computed} levels for level {k}"
            );
        }
    }
}
