//! CORS headers for pages of other origins. `tests/python/cors_check.py` tests a browser.

use reqwest::{Method, RequestBuilder, Response};
use serde_json::json;

use crate::data;
use crate::support::{Server, base};

const PAGE: &str = "https://cad.example";

async fn start(origins: &[&str]) -> Server {
    let origins = origins
        .iter()
        .map(|origin| origin.parse().unwrap())
        .collect();
    Server::with(|config| config.cors_origin = origins).await
}

async fn from(page: &str, request: RequestBuilder) -> Response {
    request.header("origin", page).send().await.unwrap()
}

/// The words of a header that is a list, in order.
fn words(response: &Response, name: &str) -> Vec<String> {
    let values = response.headers().get_all(name).iter();
    let values = values.flat_map(|value| value.to_str().unwrap().split(','));
    let mut words: Vec<_> = values.map(|word| word.trim().to_lowercase()).collect();
    words.sort();
    words
}

fn allowed(response: &Response) -> Option<&str> {
    let origin = response.headers().get("access-control-allow-origin")?;
    Some(origin.to_str().unwrap())
}

#[tokio::test]
async fn pages_of_given_origins_are_let_in() {
    let server = start(&[PAGE, "http://localhost:3000"]).await;
    for (page, expected) in [
        (PAGE, Some(PAGE)),
        ("http://localhost:3000", Some("http://localhost:3000")),
        ("http://localhost:3001", None),
        ("https://evil.example", None),
        ("null", None),
    ] {
        let response = from(page, server.get("/v1/jobs")).await;
        assert_eq!(allowed(&response), expected, "{page}");
        assert!(words(&response, "vary").contains(&"origin".to_owned()));
        // Problems are for pages, too.
        let response = from(page, server.get("/nothing")).await;
        assert_eq!(response.status(), 404);
        assert_eq!(allowed(&response), expected, "{page}");
    }
    let any = start(&["*"]).await;
    let response = from("null", any.get("/v1/jobs")).await;
    assert_eq!(allowed(&response), Some("*"));
    let none = start(&[]).await;
    let response = from(PAGE, none.get("/v1/jobs")).await;
    assert_eq!(allowed(&response), None);
}

#[tokio::test]
async fn preflights_list_what_pages_may_send() {
    let server = start(&[PAGE]).await;
    let url = format!("{}/v1/jobs", server.url);
    let preflight = server.client.request(Method::OPTIONS, &url);
    let preflight = preflight
        .header("access-control-request-method", "POST")
        .header("access-control-request-headers", "content-type,prefer");
    let response = from(PAGE, preflight).await;
    assert_eq!(response.status(), 200);
    assert_eq!(allowed(&response), Some(PAGE));
    assert_eq!(response.headers()["access-control-max-age"], "7200");
    let methods = words(&response, "access-control-allow-methods");
    assert_eq!(methods, ["delete", "get", "head", "post"]);
    let headers = words(&response, "access-control-allow-headers");
    // All that the description has, and what says how a body is written.
    let description = server.json("/openapi.json").await;
    let parameters = description["components"]["parameters"].as_object().unwrap();
    for parameter in parameters.values().filter(|it| it["in"] == "header") {
        let name = parameter["name"].as_str().unwrap().to_lowercase();
        assert!(headers.contains(&name), "{name} of {headers:?}");
    }
    for name in ["accept", "authorization", "content-type"] {
        assert!(headers.contains(&name.to_owned()), "{name}");
    }
}

/// Headers that are for browsers and proxies, or that every page may read.
const OTHERS: [&str; 8] = [
    "cache-control",
    "connection",
    "content-length",
    "content-type",
    "date",
    "transfer-encoding",
    "vary",
    "x-accel-buffering",
];

#[tokio::test]
async fn pages_may_read_every_header_of_answers() {
    let server = start(&[PAGE]).await;
    let new = || {
        let request = server.post("/v1/jobs").json(&data::small_job());
        let request = request.header("prefer", "wait=100");
        from(PAGE, request.header("idempotency-key", "one"))
    };
    let response = new().await;
    let mut responses = vec![new().await];
    let job: serde_json::Value = response.json().await.unwrap();
    let path = |end: &str| format!("{}{end}", base(&job));
    let resumed = server.get(&path("/events")).header("last-event-id", "3");
    for request in [
        resumed,
        server.get(&path("/result/step")),
        server.post("/v1/jobs").json(&json!({})),
        server.post(&path("/cancel")),
        server.post(&path("")),
        server.get("/docs"),
    ] {
        responses.push(from(PAGE, request).await);
    }
    let mut seen = Vec::new();
    for response in responses {
        let shown = words(&response, "access-control-expose-headers");
        for name in response.headers().keys().map(|name| name.as_str()) {
            let hidden = OTHERS.contains(&name) || name.starts_with("access-control-");
            let of_pages = [
                "content-security-policy",
                "etag",
                "referrer-policy",
                "x-content-type-options",
            ]
            .contains(&name);
            assert!(
                hidden || of_pages || shown.iter().any(|it| it == name),
                "{name}"
            );
            seen.push(name.to_owned());
        }
        // All that the description has.
        let description = server.json("/openapi.json").await;
        let headers = description["components"]["headers"].as_object().unwrap();
        for name in headers.keys().map(|name| name.to_lowercase()) {
            let hidden = OTHERS.contains(&name.as_str());
            assert!(hidden || shown.contains(&name), "{name} of {shown:?}");
        }
    }
    for name in [
        "location",
        "idempotency-replayed",
        "preference-applied",
        "piad-resumed-after",
        "content-disposition",
        "allow",
        "x-request-id",
    ] {
        assert!(seen.iter().any(|it| it == name), "{name}");
    }
}
