//! Large jobs run to their tolerance, and small ones beside them do not wait.

use reqwest::Body;
use serde_json::Value;

use crate::data;
use crate::support::Server;

/// A long spiral with ripples, as JSON text: `[[x, y], …]`.
fn spiral(n: usize) -> String {
    let points = (0..n).map(|i| {
        let a = i as f64 * 0.01;
        let r = 100.0 + 0.01 * a + (0.37 * a).sin();
        format!("[{},{}]", r * a.cos(), r * a.sin())
    });
    format!("[{}]", points.collect::<Vec<_>>().join(","))
}

/// A wavy height field as JSON text: rows of `[x, y, z]`.
fn field(n: usize) -> String {
    let point = |i: usize, j: usize| {
        let (x, y) = (j as f64, i as f64);
        format!(
            "[{x},{y},{}]",
            5.0 * (0.3 * x).sin() * (0.2 * y + 0.05 * x).cos()
        )
    };
    let row = |i| (0..n).map(|j| point(i, j)).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = (0..n).map(|i| format!("[{}]", row(i))).collect();
    format!("[{}]", rows.join(","))
}

async fn post(server: &Server, body: String) -> Value {
    let request = server
        .post("/v1/jobs")
        .header("content-type", "application/json");
    let response = request.body(Body::from(body)).send().await.unwrap();
    assert_eq!(response.status(), 201);
    response.json().await.unwrap()
}

/// Follows a job to its end; meanwhile small jobs must come and go.
async fn assert_converges_beside_small_jobs(server: &Server, job: &Value) {
    let path = job["links"]["self"].as_str().unwrap();
    let mut small_jobs = 0;
    loop {
        let state = server.json(path).await["state"].clone();
        if state == "converged" {
            break;
        }
        assert!(state == "queued" || state == "running", "{state}");
        assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
        server.json("/livez").await;
        small_jobs += 1;
    }
    assert!(
        small_jobs > 0,
        "the large job was over before a small one could run"
    );
}

#[tokio::test]
async fn a_curve_of_a_million_points() {
    let server = Server::start().await;
    let body = format!(
        r#"{{"curve":{{"points":{}}},"stop":{{"tolerance":1e-9}}}}"#,
        spiral(1_000_000)
    );
    let job = post(&server, body).await;
    assert_eq!(job["points"], 1_000_000);
    assert_converges_beside_small_jobs(&server, &job).await;
    let path = job["links"]["self"].as_str().unwrap();
    let error = server.json(path).await["error"]["max"].as_f64().unwrap();
    assert!(error <= 1e-9);
    // Any of its iterations is recomputed on request.
    let first: Value = server.json(&format!("{path}/iterations/1")).await;
    assert_eq!(first["control_points"].as_array().unwrap().len(), 1_000_002);
}

#[tokio::test]
async fn a_surface_of_a_million_points() {
    let server = Server::start().await;
    let body = format!(
        r#"{{"surface":{{"points":{}}},"stop":{{"tolerance":1e-6}}}}"#,
        field(1000)
    );
    let job = post(&server, body).await;
    assert_converges_beside_small_jobs(&server, &job).await;
}

/// Dense collocation of the highest degree.
#[tokio::test]
async fn a_bernstein_curve_of_degree_1000() {
    let server = Server::start().await;
    let body = format!(
        r#"{{"curve":{{"points":{},"basis":{{"kind":"bernstein"}}}},"stop":{{"tolerance":0,"max_iterations":200}}}}"#,
        spiral(1001)
    );
    let job = post(&server, body).await;
    let path = job["links"]["self"].as_str().unwrap();
    let mut errors = Vec::new();
    for k in [0, 50, 200] {
        let level = server.json(&format!("{path}/iterations/{k}")).await;
        errors.push(level["error"]["max"].as_f64().unwrap());
    }
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
}
