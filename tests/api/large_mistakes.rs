//! Bodies of many megabytes that are wrong: the answers stay small.

use reqwest::Response;

use crate::support::{Server, problem};

/// The most bytes of an answer, however much was sent.
const MOST_ANSWERED: u64 = 8 * 1024;

async fn post(server: &Server, body: String) -> Response {
    let request = server.post("/v1/jobs");
    let request = request.header("content-type", "application/json");
    request.body(body).send().await.unwrap()
}

#[tokio::test]
async fn texts_are_not_repeated_whole() {
    let server = Server::start().await;
    let long = "x".repeat(20 << 20);
    let curve = r#""points":[[0,0],[1,1]]"#;
    let cases = [
        (format!(r#"{{"{long}":1}}"#), "/xxx"),
        (
            format!(r#"{{"curve":{{{curve},"{long}":1}}}}"#),
            "/curve/xxx",
        ),
        (
            format!(r#"{{"curve":{{{curve},"parameters":"{long}"}}}}"#),
            "/curve/parameters",
        ),
        (
            format!(r#"{{"curve":{{{curve},"basis":{{"kind":"{long}"}}}}}}"#),
            "/curve/basis/kind",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"stream":{{"view":"{long}"}}}}"#),
            "/stream/view",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"stop":"{long}"}}"#),
            "/stop",
        ),
        (
            format!(r#"{{"curve":{{{curve}}},"name":"{long}"}}"#),
            "/name",
        ),
    ];
    for (body, pointer) in cases {
        let response = post(&server, body).await;
        let length = response.content_length().unwrap();
        assert!(length < MOST_ANSWERED, "{pointer}: {length} bytes");
        let (status, problem) = problem(response).await;
        assert_eq!(status, 422, "{problem:#}");
        let said = problem["errors"][0]["pointer"].as_str().unwrap();
        assert!(said.starts_with(pointer), "{problem:#}");
    }
}
