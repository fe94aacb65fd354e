//! Bodies of requests that come slowly, or over HTTP/2 in large numbers.

use std::time::Duration;

use axum::http::Request;
use bytes::Bytes;
use futures_util::{StreamExt, stream};
use h2::client::SendRequest;
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use crate::data;
use crate::support::{PATIENCE, Server, eventually};

/// A slow body does not keep a request open forever, even if it is short.
#[tokio::test]
async fn small_bodies_that_trickle_in_are_given_up() {
    let server = Server::with(|config| config.body_timeout = Duration::from_secs(1)).await;
    let address = server.url.strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(address).await.unwrap();
    let head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
        Content-Type: application/json\r\nContent-Length: 60000\r\n\r\n";
    stream.write_all(head.as_bytes()).await.unwrap();
    let (mut input, mut output) = stream.into_split();
    let sending = async {
        while output.write_all(b" ").await.is_ok() {
            sleep(Duration::from_millis(100)).await;
        }
        std::future::pending::<()>().await
    };
    let mut answer = [0; 300];
    let read = async {
        let length = input.read(&mut answer).await.unwrap();
        String::from_utf8_lossy(&answer[..length]).into_owned()
    };
    let answer = tokio::select! {
        answer = timeout(PATIENCE, read) => answer.expect("it is given up"),
        () = sending => unreachable!(),
    };
    assert!(answer.starts_with("HTTP/1.1 408 "), "{answer}");
}

/// Each of them holds some memory when it needs more, and all together need more than there is.
#[tokio::test]
async fn large_bodies_of_one_client_do_not_wait_for_each_other() {
    let server = Server::with(|config| config.memory = Some("128MiB".parse().unwrap())).await;
    let points: Vec<_> = (0..20_000).map(|i| [f64::from(i), 0.1]).collect();
    let job = json!({"curve": {"points": points}, "stop": {"max_iterations": 1, "tolerance": 1.0}});
    let body = Bytes::from(job.to_string());
    let send = async |is_announced: bool| {
        let request = server
            .post("/v1/fit")
            .header("content-type", "application/json");
        // Not all at once, so that they all grow at the same time.
        let parts: Vec<Bytes> = body
            .chunks(body.len() / 10)
            .map(Bytes::copy_from_slice)
            .collect();
        let parts = stream::iter(parts).then(async |part| {
            sleep(Duration::from_millis(50)).await;
            Ok::<_, std::io::Error>(part)
        });
        let mut request = request.body(reqwest::Body::wrap_stream(Box::pin(parts)));
        if is_announced {
            request = request.header("content-length", body.len());
        }
        let answer = request.send().await.unwrap();
        (answer.status(), answer.text().await.unwrap())
    };
    let sent = futures_util::future::join_all((0..16).map(|k| send(k % 2 == 0)));
    for (status, text) in sent.await {
        assert_eq!(status, 200, "{}", &text[..text.len().min(500)]);
    }
}

/// An HTTP/2 connection.
pub struct Http2 {
    client: SendRequest<Bytes>,
    url: String,
}

/// A request whose body stalls; returns the status of its response.
pub type Halted = JoinHandle<Result<u16, h2::Error>>;

impl Http2 {
    pub async fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).await.unwrap();
        let (client, connection) = h2::client::handshake(stream).await.unwrap();
        tokio::spawn(connection);
        let url = format!("http://{address}");
        Self { client, url }
    }

    /// Sends a request with the beginning of its body, or without one.
    pub async fn begin(&mut self, method: &str, path: &str, body: Option<Bytes>) -> Halted {
        let request = Request::builder()
            .method(method)
            .uri(format!("{}{path}", self.url));
        let request = request
            .header("content-type", "application/json")
            .body(())
            .unwrap();
        let mut client = self.client.clone().ready().await.unwrap();
        let sent = client.send_request(request, body.is_none());
        let (answer, mut sender) = sent.unwrap();
        if let Some(body) = body {
            sender.send_data(body, false).unwrap();
        }
        tokio::spawn(async move {
            let answer = answer.await;
            drop(sender);
            answer.map(|answer| answer.status().as_u16())
        })
    }
}

/// The streams of all connections of a client are counted together.
#[tokio::test]
async fn requests_over_http2_are_limited_for_each_client() {
    let server = Server::with(|config| config.max_requests_per_peer = 30).await;
    let address = server.url.strip_prefix("http://").unwrap();
    let mut clients = [Http2::connect(address).await, Http2::connect(address).await];
    let mut halted = Vec::new();
    for k in 0..60 {
        let body = Some(Bytes::from_static(&[b' '; 1024]));
        halted.push(clients[k % 2].begin("POST", "/v1/jobs", body).await);
    }
    let refused = async || halted.iter().filter(|it| it.is_finished()).count() == 30;
    eventually("half of them are refused", refused).await;
    for client in &mut clients {
        let busy = client.begin("GET", "/v1/jobs", None).await;
        assert_eq!(busy.await.unwrap().unwrap(), 503);
        let alive = client.begin("GET", "/livez", None).await;
        assert_eq!(alive.await.unwrap().unwrap(), 200);
    }
    // Over HTTP/1.1 connections are limited, not requests.
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
    for request in &halted {
        request.abort();
    }
    eventually("there is room again", async || {
        let again = clients[0].begin("GET", "/v1/jobs", None).await;
        again.await.unwrap().unwrap() == 200
    })
    .await;
}
