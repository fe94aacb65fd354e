//! A server that clients see below a path.

use reqwest::redirect::Policy;
use serde_json::{Value, json};

use crate::data;
use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, base, client};

async fn start() -> Server {
    Server::with(|config| config.base_path = "/tools/fits".parse().unwrap()).await
}

#[tokio::test]
async fn links_begin_with_it() {
    let server = start().await;
    let request = server.post("/tools/fits/v1/jobs").json(&data::small_job());
    let response = request.header("prefer", "wait=10").send().await.unwrap();
    assert_eq!(response.status(), 201);
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let job: Value = response.json().await.unwrap();
    assert!(location.starts_with("/tools/fits/v1/jobs/"), "{location}");
    assert_eq!(base(&job), location);
    for link in job["links"].as_object().unwrap().values() {
        let link = link.as_str().unwrap();
        assert!(link.starts_with(&location), "{link}");
    }
    server.fit(&data::small_job()).await;
    let page = server.json("/tools/fits/v1/jobs?limit=1").await;
    let next = page["next"].as_str().unwrap();
    assert!(next.starts_with("/tools/fits/v1/jobs?cursor="), "{next}");
    assert_eq!(server.json(next).await["jobs"][0]["id"], job["id"]);
    let index = server.json("/tools/fits/").await;
    assert_eq!(index["links"]["jobs"], "/tools/fits/v1/jobs");
    for link in index["links"].as_object().unwrap().values() {
        let response = server.get(link.as_str().unwrap()).send().await.unwrap();
        assert_eq!(response.status(), 200, "{link}");
    }
    let description = server.json("/tools/fits/openapi.json").await;
    assert_eq!(description["servers"][0]["url"], "/tools/fits");
    server.stop().await;
}

/// A proxy may take the path off; those who ask for the health of the server and gRPC do not know it.
#[tokio::test]
async fn resources_are_there_without_it() {
    let server = start().await;
    let job = server.fit(&data::small_job()).await;
    let stripped = base(&job).strip_prefix("/tools/fits").unwrap();
    assert_eq!(server.json(stripped).await["id"], job["id"]);
    for path in ["/livez", "/tools/fits/livez"] {
        assert_eq!(server.json(path).await["status"], "alive");
    }
    let mut client = connect(&server).await;
    let request = pb::GetJobRequest {
        id: job["id"].as_str().unwrap().to_owned(),
    };
    client.get_job(request).await.unwrap();
    for path in ["/tools", "/tools/fit", "/tools/fitsy/livez", "/fits/livez"] {
        assert_eq!(
            server.get(path).send().await.unwrap().status(),
            404,
            "{path}"
        );
    }
    server.stop().await;
}

/// The page has relative addresses, which begin below the path.
#[tokio::test]
async fn the_page_is_below_it() {
    let server = start().await;
    let client = client().redirect(Policy::none()).build().unwrap();
    let get = async |path: &str| {
        let url = format!("{}{path}", server.url);
        client
            .get(url)
            .header("accept", "text/html")
            .send()
            .await
            .unwrap()
    };
    let response = get("/tools/fits?x=1").await;
    assert_eq!(response.status(), 308);
    assert_eq!(response.headers()["location"], "/tools/fits/?x=1");
    let page = get("/tools/fits/").await;
    assert_eq!(page.headers()["content-type"], "text/html; charset=utf-8");
    let page = page.text().await.unwrap();
    let script = page
        .split("src=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    assert!(!script.starts_with('/'), "{script}");
    assert_eq!(get(&format!("/tools/fits/{script}")).await.status(), 200);
    server.stop().await;
}

#[test]
fn paths_are_plain() {
    use piad::config::BasePath;
    for (text, path) in [
        ("/", ""),
        ("/a", "/a"),
        ("/a/", "/a"),
        ("/a-b/c.d", "/a-b/c.d"),
    ] {
        assert_eq!(text.parse::<BasePath>().unwrap().as_str(), path);
    }
    for text in [
        "",
        "a",
        "a/",
        "//a",
        "/a//b",
        "/../a",
        "/a?b",
        "/ä",
        "/a b",
        "http://x/a",
    ] {
        assert!(text.parse::<BasePath>().is_err(), "{text}");
    }
    assert_eq!(json!(BasePath::default().to_string()), "/");
}
