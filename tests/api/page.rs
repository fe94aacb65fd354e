//! The page at `/`: who gets it, its headers for browsers, and its size.

use std::io::Read;

use flate2::read::GzDecoder;
use reqwest::header::HeaderMap;
use reqwest::{Method, Response, StatusCode};
use serde_json::Value;

use crate::support::{Server, problem};

/// What browsers send when somebody opens an address.
const BROWSER: &str =
    "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,image/webp,*/*;q=0.8";

async fn get(server: &Server, path: &str, headers: &[(&str, &str)]) -> Response {
    ask(server, Method::GET, path, headers).await
}

async fn ask(server: &Server, method: Method, path: &str, headers: &[(&str, &str)]) -> Response {
    let mut request = server
        .client
        .request(method, format!("{}{path}", server.url));
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    request.send().await.unwrap()
}

fn header<'a>(headers: &'a HeaderMap, name: &str) -> &'a str {
    let values: Vec<_> = headers.get_all(name).iter().collect();
    assert!(values.len() < 2, "{name} is there more than once");
    values.first().map_or("", |value| value.to_str().unwrap())
}

/// The names in all Vary headers.
fn vary(headers: &HeaderMap) -> Vec<String> {
    let values = headers.get_all("vary").iter();
    let names = values.flat_map(|value| value.to_str().unwrap().split(','));
    let mut names: Vec<_> = names.map(|name| name.trim().to_lowercase()).collect();
    names.sort();
    names
}

/// The addresses in a page: values of `src` and `href`.
fn addresses(page: &str) -> Vec<&str> {
    let parts = page.split([' ', '\n', '>']);
    let values = parts.filter_map(|part| {
        let value = part.strip_prefix("src=").or(part.strip_prefix("href="))?;
        Some(value.trim_matches(['"', '\'']))
    });
    values.filter(|value| !value.starts_with("data:")).collect()
}

#[tokio::test]
async fn browsers_get_the_page_and_programs_the_index() {
    let server = Server::start().await;
    for (accept, is_page) in [
        (BROWSER, true),
        ("text/html", true),
        ("text/*", true),
        ("text/html, application/json;q=0.9", true),
        ("text/html;q=0.5, application/json", false),
        ("application/json", false),
        ("*/*", false),
        ("", false),
        // As before there was a page.
        ("image/png", false),
        ("no media type", false),
    ] {
        let response = get(&server, "/", &[("accept", accept)]).await;
        assert_eq!(response.status(), 200, "{accept}");
        assert!(vary(response.headers()).contains(&"accept".to_owned()));
        let media_type = header(response.headers(), "content-type").to_owned();
        let text = response.text().await.unwrap();
        if is_page {
            assert_eq!(media_type, "text/html; charset=utf-8", "{accept}");
            assert!(text.starts_with("<!doctype html>") || text.starts_with("<!DOCTYPE html>"));
        } else {
            assert_eq!(media_type, "application/json", "{accept}");
            let index: Value = serde_json::from_str(&text).unwrap();
            assert_eq!(index["name"], "piad");
        }
    }
}

/// Each of its files is there, says what it is, and is for this server alone.
#[tokio::test]
async fn the_page_is_whole_and_needs_nothing_from_elsewhere() {
    let server = Server::start().await;
    let response = get(&server, "/", &[("accept", BROWSER)]).await;
    let headers = response.headers().clone();
    let page = response.text().await.unwrap();
    let policy = header(&headers, "content-security-policy");
    for rule in [
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "connect-src 'self'",
        "img-src 'self' data: blob:",
        "base-uri 'none'",
        "frame-ancestors 'none'",
        "form-action 'none'",
    ] {
        assert!(policy.split("; ").any(|it| it == rule), "{rule}: {policy}");
    }
    assert!(
        !policy.contains("unsafe") && !policy.contains("http"),
        "{policy}"
    );
    assert_eq!(header(&headers, "x-content-type-options"), "nosniff");
    assert_eq!(header(&headers, "referrer-policy"), "no-referrer");
    // What the policy forbids anyway.
    for forbidden in [
        "<style", "style=", "<script>", "onclick=", "onload=", "<base",
    ] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    let addresses = addresses(&page);
    assert!(addresses.len() >= 2, "{addresses:?}");
    for address in addresses {
        // Relative to where the page stands, so that it works under any prefix.
        assert!(
            !address.starts_with('/') && !address.contains("//"),
            "{address}"
        );
        let path = format!("/{}", address.split('#').next().unwrap());
        let response = get(&server, &path, &[]).await;
        assert_eq!(response.status(), 200, "{path}");
        let expected = match path.rsplit_once('.') {
            Some((_, "js")) => "text/javascript; charset=utf-8",
            Some((_, "css")) => "text/css; charset=utf-8",
            Some((_, "svg")) => "image/svg+xml",
            _ => continue,
        };
        assert_eq!(header(response.headers(), "content-type"), expected);
        assert_eq!(
            header(response.headers(), "content-security-policy"),
            policy
        );
        assert_eq!(
            header(response.headers(), "x-content-type-options"),
            "nosniff"
        );
    }
}

/// A browser that has a file asks whether it is still good, and gets it only if not.
#[tokio::test]
async fn files_that_a_browser_has_are_not_sent_again() {
    let server = Server::start().await;
    let paths = [
        "/",
        "/viewer/app.js",
        "/viewer/app.css",
        "/docs",
        "/docs/swagger-ui.css",
    ];
    let mut tags = Vec::new();
    for path in paths {
        for coding in ["identity", "gzip"] {
            let sent = [("accept", BROWSER), ("accept-encoding", coding)];
            let first = get(&server, path, &sent).await;
            assert_eq!(header(first.headers(), "cache-control"), "no-cache");
            let tag = header(first.headers(), "etag").to_owned();
            assert!(tag.starts_with('"') && tag.ends_with('"'), "{tag}");
            for (known, status) in [
                (tag.clone(), StatusCode::NOT_MODIFIED),
                (format!("W/{tag}"), StatusCode::NOT_MODIFIED),
                (format!("\"else\", {tag}"), StatusCode::NOT_MODIFIED),
                ("*".to_owned(), StatusCode::NOT_MODIFIED),
                ("\"else\"".to_owned(), StatusCode::OK),
            ] {
                let again = [sent[0], sent[1], ("if-none-match", known.as_str())];
                let response = get(&server, path, &again).await;
                assert_eq!(response.status(), status, "{path} {known}");
                let headers = response.headers().clone();
                assert_eq!(header(&headers, "etag"), tag);
                assert_eq!(vary(&headers), vary(first.headers()));
                let length = response.bytes().await.unwrap().len();
                assert_eq!(length == 0, status == StatusCode::NOT_MODIFIED);
            }
            tags.push(tag);
        }
    }
    // Also those of the same file in another coding: a strong tag stands for bytes.
    let count = tags.len();
    tags.sort();
    tags.dedup();
    assert!(tags.len() >= count - 1, "{tags:?}");
}

#[tokio::test]
async fn files_are_compressed_for_clients_that_accept_it() {
    let server = Server::start().await;
    for path in ["/docs/swagger-ui-bundle.js", "/docs/swagger-ui.css"] {
        let plain = get(&server, path, &[("accept-encoding", "gzip;q=0, br")]).await;
        assert_eq!(header(plain.headers(), "content-encoding"), "");
        assert!(vary(plain.headers()).contains(&"accept-encoding".to_owned()));
        let plain = plain.bytes().await.unwrap();
        let packed = get(&server, path, &[("accept-encoding", "br, gzip")]).await;
        assert_eq!(header(packed.headers(), "content-encoding"), "gzip");
        assert!(vary(packed.headers()).contains(&"accept-encoding".to_owned()));
        let packed = packed.bytes().await.unwrap();
        assert!(packed.len() < plain.len() / 2, "{path}");
        let mut unpacked = Vec::new();
        GzDecoder::new(&packed[..])
            .read_to_end(&mut unpacked)
            .unwrap();
        assert!(unpacked == plain, "{path}");
    }
}

/// HEAD has the headers of GET and no body.
#[tokio::test]
async fn heads_are_those_of_the_files() {
    let server = Server::start().await;
    for path in ["/", "/viewer/app.js", "/docs"] {
        for coding in ["identity", "gzip"] {
            let sent = [("accept", BROWSER), ("accept-encoding", coding)];
            let whole = get(&server, path, &sent).await;
            let head = ask(&server, Method::HEAD, path, &sent).await;
            assert_eq!(head.status(), 200);
            for name in [
                "content-type",
                "content-length",
                "content-encoding",
                "etag",
                "cache-control",
            ] {
                let of = |response: &Response| header(response.headers(), name).to_owned();
                assert_eq!(of(&head), of(&whole), "{path} {name}");
            }
            assert_eq!(head.bytes().await.unwrap().len(), 0);
        }
    }
}

#[tokio::test]
async fn there_are_no_other_files() {
    let server = Server::start().await;
    for path in [
        "/viewer/else.js",
        "/viewer/index.html",
        "/viewer/..%2fCargo.toml",
        "/viewer/%FF",
        "/viewer/",
        "/viewer",
        "/docs/page.html",
    ] {
        let (status, _) = problem(get(&server, path, &[]).await).await;
        assert_eq!(status, 404, "{path}");
    }
    let (status, _) = problem(ask(&server, Method::POST, "/viewer/app.js", &[]).await).await;
    assert_eq!(status, 405);
}
