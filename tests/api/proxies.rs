//! Clients behind proxies: limits for an address are those of the client if the proxy is trusted.

use piad::config::network;
use reqwest::RequestBuilder;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::data;
use crate::support::{PATIENCE, Server};

/// A server on which an address has one job, and which trusts these proxies.
async fn server(proxies: &[&str]) -> Server {
    let networks = proxies.iter().map(|text| network(text).unwrap());
    let networks = networks.collect();
    Server::with(|config| {
        config.max_jobs_per_peer = Some(1);
        config.trusted_proxy = networks;
    })
    .await
}

fn post(server: &Server) -> RequestBuilder {
    server.post("/v1/jobs").json(&data::endless_job())
}

async fn status(request: RequestBuilder) -> u16 {
    request.send().await.unwrap().status().as_u16()
}

#[tokio::test]
async fn a_trusted_proxy_names_the_client_of_a_request() {
    let server = server(&["127.0.0.0/8", "10.0.0.0/8"]).await;
    let from = |name, value| status(post(&server).header(name, value));
    assert_eq!(from("x-forwarded-for", "192.0.2.1").await, 201);
    assert_eq!(from("x-forwarded-for", "192.0.2.1").await, 429);
    assert_eq!(
        from("x-forwarded-for", "6.6.6.6, 192.0.2.1, 10.0.0.7").await,
        429
    );
    assert_eq!(from("forwarded", "for=192.0.2.1;proto=https").await, 429);
    assert_eq!(from("x-forwarded-for", "192.0.2.2").await, 201);
    assert_eq!(from("forwarded", "for=\"[2001:db8::1]:4711\"").await, 201);
    // A client may send the other header: it wins nothing by it.
    let both = |value| {
        post(&server)
            .header("x-forwarded-for", "192.0.2.1")
            .header("forwarded", value)
    };
    assert_eq!(status(both("for=192.0.2.1")).await, 429);
    assert_eq!(
        status(both("for=6.6.6.1")).await,
        201,
        "the job of clients without a name"
    );
    assert_eq!(status(both("for=6.6.6.2")).await, 429);
    for value in ["for=unknown", "for=_x", "for=", "nonsense", "\""] {
        assert_eq!(status(both(value)).await, 429, "{value}");
        assert_eq!(from("forwarded", value).await, 429, "{value}");
    }
    // The proxy itself has a job of its own.
    assert_eq!(status(post(&server)).await, 201);
    assert_eq!(status(post(&server)).await, 429);
}

#[tokio::test]
async fn other_proxies_are_not_trusted() {
    let server = server(&["10.0.0.0/8"]).await;
    assert_eq!(status(post(&server)).await, 201);
    let other = post(&server).header("x-forwarded-for", "192.0.2.1");
    assert_eq!(status(other).await, 429);
    let answer = over_tcp(&server, b"PROXY TCP4 192.0.2.1 127.0.0.1 4711 80\r\n").await;
    assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
}

/// The answer to a job on a connection that begins with these bytes.
async fn over_tcp(server: &Server, begin: &[u8]) -> String {
    over_tcp_with(server, begin, "").await
}

/// The same with more headers.
async fn over_tcp_with(server: &Server, begin: &[u8], headers: &str) -> String {
    let address = server.url.strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(address).await.unwrap();
    let body = data::endless_job().to_string();
    let head = format!(
        "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
         Content-Type: application/json\r\n{headers}Content-Length: {}\r\n\r\n",
        body.len()
    );
    let _ = stream
        .write_all(&[begin, head.as_bytes(), body.as_bytes()].concat())
        .await;
    let mut answer = Vec::new();
    let read = timeout(PATIENCE, stream.read_to_end(&mut answer)).await;
    // A connection that is cut off has no answer.
    let _ = read.expect("an answer or the end");
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn a_trusted_proxy_names_the_client_of_a_connection() {
    let server = server(&["127.0.0.1"]).await;
    for (begin, status) in [
        (&b"PROXY TCP4 192.0.2.1 127.0.0.1 4711 80\r\n"[..], "201"),
        (b"PROXY TCP4 192.0.2.1 127.0.0.1 4712 80\r\n", "429"),
        (b"PROXY TCP6 2001:db8::1 ::1 4711 80\r\n", "201"),
        (
            b"\r\n\r\n\0\r\nQUIT\n\x21\x11\0\x0c\xc0\0\x02\x01\x7f\0\0\x01\x12\x67\0\x50",
            "429",
        ),
        (
            b"\r\n\r\n\0\r\nQUIT\n\x21\x11\0\x0c\xc0\0\x02\x09\x7f\0\0\x01\x12\x67\0\x50",
            "201",
        ),
        // The proxy itself.
        (b"", "201"),
        (b"PROXY UNKNOWN\r\n", "429"),
    ] {
        let answer = over_tcp(&server, begin).await;
        let expected = format!("HTTP/1.1 {status} ");
        assert!(answer.starts_with(&expected), "{begin:?}: {answer}");
    }
    // After a header of the connection, those of requests are the client's.
    for begin in [
        &b"PROXY UNKNOWN\r\n"[..],
        b"PROXY TCP4 192.0.2.1 127.0.0.1 4711 80\r\n",
        b"\r\n\r\n\0\r\nQUIT\n\x20\0\0\0",
    ] {
        for name in ["Forwarded: for=", "X-Forwarded-For: "] {
            let headers = format!("{name}203.0.113.7\r\n");
            let answer = over_tcp_with(&server, begin, &headers).await;
            assert!(answer.starts_with("HTTP/1.1 429 "), "{begin:?}: {answer}");
        }
    }
    let cut_off = over_tcp(&server, b"PROXY TCP4 unknown\r\n").await;
    assert_eq!(cut_off, "");
}

/// Requests of a client are limited, too, where it has no connections of its own.
#[tokio::test]
async fn requests_of_a_client_behind_a_proxy_are_limited() {
    let proxies = vec![network("127.0.0.1").unwrap()];
    let server = Server::with(|config| {
        config.max_requests_per_peer = 2;
        config.max_connections_per_peer = Some(1);
        config.trusted_proxy = proxies;
    })
    .await;
    let job = server.create(&data::endless_job()).await;
    let events = format!("{}/events", crate::support::base(&job));
    let watch = |address| {
        server
            .get(&events)
            .header("x-forwarded-for", address)
            .send()
    };
    let first = watch("192.0.2.1").await.unwrap();
    let second = watch("192.0.2.1").await.unwrap();
    assert!(first.status() == 200 && second.status() == 200);
    let third = watch("192.0.2.1").await.unwrap();
    assert_eq!(third.headers()["retry-after"], "5");
    let (status, answer) = crate::support::problem(third).await;
    assert_eq!(
        (status, answer["type"].as_str()),
        (503, Some("/problems/too-many-connections"))
    );
    assert!(
        answer["detail"].as_str().unwrap().contains("2 requests"),
        "{answer}"
    );
    assert_eq!(watch("192.0.2.2").await.unwrap().status(), 200);
    drop(first);
    crate::support::eventually("there is room for another one", async || {
        watch("192.0.2.1").await.unwrap().status() == 200
    })
    .await;
}
