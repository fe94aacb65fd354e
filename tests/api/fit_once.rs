//! `POST /v1/fit`: one request, one answer, and nothing is kept.

use prost::Message;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::support::{NEVER, Server, problem};

async fn answer(server: &Server, accept: &str, job: &Value) -> reqwest::Response {
    let request = server.post("/v1/fit").header("accept", accept);
    request.json(job).send().await.unwrap()
}

/// It is the result that a job has, and leaves nothing behind.
#[tokio::test]
async fn the_answer_is_the_result_of_a_job() {
    let server = Server::start().await;
    let surface = json!({"surface": {"points": data::peaks(9)}, "method": "direct"});
    let few = json!({"kind": "least_squares", "control_points": "auto"});
    let few =
        json!({"curve": {"points": data::wave(60)}, "method": few, "stop": {"tolerance": 0.01}});
    for job in [data::small_job(), surface, few] {
        let response = answer(&server, "application/json", &job).await;
        assert_eq!(response.status(), 200);
        let once: Value = response.json().await.unwrap();
        assert_eq!(once["state"], "converged");
        let kept = server.fit(&job).await;
        let result = server.json(kept["links"]["result"].as_str().unwrap()).await;
        for name in ["control_points", "knots", "degree", "error", "iteration"] {
            assert_eq!(once[name], result[name], "{name}");
        }
        let path = format!("/v1/jobs/{}", once["id"].as_str().unwrap());
        let (status, _) = problem(server.get(&path).send().await.unwrap()).await;
        assert_eq!(status, 404);
        let deleted = server.delete(kept["links"]["self"].as_str().unwrap());
        deleted.send().await.unwrap();
    }
    assert_eq!(server.json("/v1/jobs").await["jobs"], json!([]));
    server.until("piad_jobs_running", 0.0).await;
}

/// Files, messages and encodings, by the Accept header and the query.
#[tokio::test]
async fn the_answer_has_the_requested_form() {
    let server = Server::start().await;
    let job = json!({"name": "a wave", "curve": {"points": data::wave(40)}});
    let step = answer(&server, "model/step", &job).await;
    assert_eq!(step.headers()["content-type"], "model/step");
    let named = step.headers()["content-disposition"].to_str().unwrap();
    assert!(named.contains("a wave"), "{named}");
    assert!(step.text().await.unwrap().starts_with("ISO-10303-21;"));
    let message = answer(&server, "application/x-protobuf", &job).await;
    let message = pb::FitResult::decode(message.bytes().await.unwrap()).unwrap();
    assert_eq!(message.name.as_deref(), Some("a wave"));
    let binary = server.post("/v1/fit?encoding=base64").json(&job);
    let binary: Value = binary.send().await.unwrap().json().await.unwrap();
    assert!(binary["control_points"].is_string());
    let points = "x,y\n0,0\n1,2\n2,0\n3,1\n";
    let csv = server
        .post("/v1/fit?curve.degree=2&samples=7")
        .header("content-type", "text/csv")
        .header("accept", "text/csv");
    let csv = csv.body(points).send().await.unwrap();
    assert_eq!(csv.status(), 200);
    assert_eq!(csv.text().await.unwrap().lines().count(), 8);
}

/// What does not come within its tolerance is no answer, and says how near it came.
#[tokio::test]
async fn fits_that_do_not_converge_are_reported() {
    let server = Server::start().await;
    let short = json!({"curve": {"points": data::helix()}, "stop": {"tolerance": 1e-9, "max_iterations": 3}});
    let (status, reported) = problem(answer(&server, "*/*", &short).await).await;
    assert_eq!(
        (status, &reported["type"]),
        (422, &json!("/problems/not-converged"))
    );
    let detail = reported["detail"].as_str().unwrap();
    for part in [
        "exhausted after iteration 3",
        "a distance of",
        "the tolerance is 1.000e-9",
    ] {
        assert!(detail.contains(part), "{detail}");
    }
    let wrong = json!({"curve": {"points": [[0, 0], [1, 1], [1, 1]]}});
    let (status, reported) = problem(answer(&server, "*/*", &wrong).await).await;
    assert_eq!(
        (status, &reported["errors"][0]["pointer"]),
        (422, &json!("/curve/points/2"))
    );
    let (status, _) = problem(answer(&server, "text/html", &data::small_job()).await).await;
    assert_eq!(status, 406);
    let request = server.post("/v1/fit?every=2").json(&data::small_job());
    let (status, reported) = problem(request.send().await.unwrap()).await;
    assert_eq!(
        (status, &reported["errors"][0]["parameter"]),
        (400, &json!("every"))
    );
}

/// A file that cannot hold the result is refused before the fit, which here would not converge.
#[tokio::test]
async fn files_that_cannot_be_written_are_refused_before_the_fit() {
    let server = Server::start().await;
    let stop = json!({"tolerance": 1e-9, "max_iterations": 1});
    let curve = json!({"curve": {"points": data::helix()}, "stop": stop});
    let rows = [[1, 2, 3, 4], [2, 3, 1, 2], [1, 0, 1, 2], [3, 1, 2, 2]];
    let heights = json!({"surface": {"points": rows}, "stop": stop});
    let steep = json!({"curve": {"points": data::wave(40), "basis": "bernstein"}, "stop": stop});
    for (media_type, job) in [
        ("model/stl", &curve),
        ("model/step", &heights),
        ("image/svg+xml", &heights),
        ("model/iges", &steep),
    ] {
        let (status, reported) = problem(answer(&server, media_type, job).await).await;
        let expected = (409, &json!("/problems/no-export"));
        assert_eq!(
            (status, &reported["type"]),
            expected,
            "{media_type}: {reported:#}"
        );
    }
    let (status, _) = problem(answer(&server, "text/csv", &heights).await).await;
    assert_eq!(status, 422);
}

/// A client that goes away ends its fit, and so does a server that stops.
#[tokio::test]
async fn it_ends_with_its_request() {
    let server = Server::with(|config| config.grace = NEVER).await;
    let ask = || {
        let request = server.post("/v1/fit").json(&data::endless_job()).send();
        tokio::spawn(request)
    };
    let gone = ask();
    server.until("piad_jobs_running", 1.0).await;
    gone.abort();
    server.until("piad_jobs_running", 0.0).await;
    let waiting = ask();
    server.until("piad_jobs_running", 1.0).await;
    server.stop().await;
    let (status, reported) = problem(waiting.await.unwrap().unwrap()).await;
    assert_eq!(
        (status, &reported["type"]),
        (503, &json!("/problems/stopping"))
    );
}
