//! How long connections stay open that do nothing, and that those that do something stay.

use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt;
use h2::client::SendRequest;
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};

use crate::data;
use crate::support::{NEVER, PATIENCE, Server, base, events};

/// When connections that do nothing are closed. Long enough for a client on a busy machine to send its
/// request in time.
const SOON: Duration = Duration::from_secs(1);

/// A limit that clients keep which are slow on purpose, also on a busy machine.
const LIMIT: Duration = Duration::from_secs(3);

async fn connect(server: &Server) -> TcpStream {
    let address = server.url.strip_prefix("http://").unwrap();
    TcpStream::connect(address).await.unwrap()
}

/// Reads what comes until the server closes.
async fn to_the_end(stream: &mut TcpStream) -> String {
    let mut bytes = Vec::new();
    // A reset closes, too.
    let _ = timeout(PATIENCE, stream.read_to_end(&mut bytes))
        .await
        .expect("it is closed");
    String::from_utf8_lossy(&bytes).into_owned()
}

/// An HTTP/2 connection with windows of this size, and the task that ends with it.
async fn connect_h2(
    server: &Server,
    window: u32,
) -> (
    SendRequest<Bytes>,
    tokio::task::JoinHandle<Result<(), h2::Error>>,
) {
    let (client, connection) = h2::client::Builder::new()
        .initial_window_size(window)
        .handshake(connect(server).await)
        .await
        .unwrap();
    (client, tokio::spawn(connection))
}

fn get(server: &Server, path: &str) -> axum::http::Request<()> {
    let uri = format!("{}{path}", server.url);
    axum::http::Request::get(uri).body(()).unwrap()
}

#[tokio::test]
async fn heads_of_requests_have_their_time() {
    let server = Server::with(|config| {
        config.header_timeout = SOON;
        config.idle_timeout = NEVER;
    })
    .await;
    let frame_of_settings = [0, 0, 0, 4, 0, 0, 0, 0, 0];
    let preface = [b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", &frame_of_settings[..]].concat();
    for bare in [
        b"".as_slice(),
        b"PRI",
        &preface,
        b"G",
        b"GET /livez HTTP/1.1\r\nHost: localhost\r\n",
    ] {
        let mut stream = connect(&server).await;
        stream.write_all(bare).await.unwrap();
        let answer = to_the_end(&mut stream).await;
        assert!(!answer.contains("200"), "{answer}");
    }
}

#[tokio::test]
async fn a_head_that_trickles_in_is_given_up() {
    let server = Server::with(|config| {
        config.header_timeout = SOON;
        config.idle_timeout = NEVER;
    })
    .await;
    // Also after a request that was in time.
    for before in ["", "GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n"] {
        let mut stream = connect(&server).await;
        stream.write_all(before.as_bytes()).await.unwrap();
        if !before.is_empty() {
            assert!(stream.read(&mut [0; 4096]).await.unwrap() > 0);
        }
        let (mut reader, mut writer) = stream.split();
        let trickle = async {
            let head = b"GET /livez HTTP/1.1\r\nX: ";
            for byte in head.iter().chain([b'x'].iter().cycle()) {
                if writer.write_all(&[*byte]).await.is_err() {
                    break;
                }
                sleep(Duration::from_millis(20)).await;
            }
        };
        let mut rest = [0; 64];
        tokio::select! {
            () = trickle => {}
            read = timeout(PATIENCE, reader.read(&mut rest)) => {
                assert!(matches!(read.unwrap(), Ok(0) | Err(_)));
            }
        }
    }
}

#[tokio::test]
async fn idle_connections_are_closed() {
    let server = Server::with(|config| {
        config.header_timeout = NEVER;
        config.idle_timeout = SOON;
    })
    .await;
    let mut stream = connect(&server).await;
    let request = b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n";
    stream.write_all(request).await.unwrap();
    assert!(to_the_end(&mut stream).await.contains("alive"));

    let (mut client, ended) = connect_h2(&server, 65535).await;
    let (response, _) = client.send_request(get(&server, "/livez"), true).unwrap();
    assert_eq!(response.await.unwrap().status(), 200);
    // The client is still there, so that it does not end the connection itself.
    timeout(PATIENCE, ended).await.unwrap().unwrap().unwrap();
    drop(client);
}

#[tokio::test]
async fn what_takes_long_is_not_idle() {
    let server = Server::with(|config| {
        config.header_timeout = LIMIT;
        config.idle_timeout = LIMIT;
        config.write_timeout = LIMIT;
        config.heartbeat = NEVER;
    })
    .await;
    let job = server.create(&data::endless_job()).await;
    // A stream whose first iteration is its only one for a long time.
    let quiet = format!("{}/events?every=1000000000", base(&job));
    let mut stream = events(server.get(&quiet).send().await.unwrap());
    for name in ["job", "iteration"] {
        assert_eq!(stream.next().await.unwrap().name, name);
    }
    let (mut client, ended) = connect_h2(&server, 65535).await;
    let (response, _) = client.send_request(get(&server, &quiet), true).unwrap();
    let mut body = response.await.unwrap().into_body();

    // An answer that takes longer than all limits.
    let request = server.post("/v1/jobs").header("prefer", "wait=4");
    let response = request.json(&data::endless_job()).send().await.unwrap();
    assert_eq!(response.status(), 201);
    assert_eq!(
        response.json::<serde_json::Value>().await.unwrap()["state"],
        "running"
    );

    let cancelled = server.post(&format!("{}/cancel", base(&job)));
    assert!(cancelled.send().await.unwrap().status().is_success());
    while stream.next().await.unwrap().name != "end" {}
    let mut text = Vec::new();
    while let Some(data) = body.data().await {
        text.extend_from_slice(&data.unwrap());
    }
    assert!(String::from_utf8(text).unwrap().contains("event: end"));
    timeout(PATIENCE, ended).await.unwrap().unwrap().unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn answers_that_are_not_read_are_abandoned() {
    let server = Server::with(|config| {
        config.write_timeout = LIMIT;
    })
    .await;
    let job = server.create(&data::endless_job()).await;
    let path = format!("{}/events", base(&job));
    // Reads a little now and then.
    let mut slow = connect(&server).await;
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
    slow.write_all(request.as_bytes()).await.unwrap();
    let slow = tokio::spawn(async move {
        let mut room = vec![0; 1 << 20];
        loop {
            assert!(slow.read(&mut room).await.unwrap() > 0, "it continues");
            sleep(Duration::from_millis(20)).await;
        }
    });
    server.until("piad_streams_open", 1.0).await;

    let mut stalled = connect(&server).await;
    stalled.write_all(request.as_bytes()).await.unwrap();
    server.until("piad_streams_open", 2.0).await;
    server.until("piad_streams_open", 1.0).await;

    // A window of HTTP/2 that is not opened again, on a connection that is well otherwise.
    let (mut client, _connection) = connect_h2(&server, 65535).await;
    let (response, _) = client.send_request(get(&server, &path), true).unwrap();
    let mut body = response.await.unwrap().into_body();
    server.until("piad_streams_open", 2.0).await;
    server.until("piad_streams_open", 1.0).await;
    let (response, _) = client.send_request(get(&server, "/livez"), true).unwrap();
    assert_eq!(response.await.unwrap().status(), 200);
    let reason = loop {
        match body.data().await.expect("the stream has no end") {
            Ok(_) => {}
            Err(reason) => break reason,
        }
    };
    assert_eq!(reason.reason(), Some(h2::Reason::CANCEL), "{reason}");
    assert!(!slow.is_finished());
    slow.abort();
}

/// A large answer that is taken slowly, but taken, comes whole.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn slow_clients_get_all_of_a_large_answer() {
    let server = Server::with(|config| {
        config.header_timeout = LIMIT;
        config.idle_timeout = LIMIT;
        config.write_timeout = LIMIT;
    })
    .await;
    let points: Vec<_> = (0..100_000)
        .map(|i| json!([i, f64::from(i).sin(), f64::from(i).cos()]))
        .collect();
    let job = json!({"curve": {"points": points}, "stop": {"max_iterations": 1}});
    let path = format!("{}/result", base(&server.fit(&job).await));
    let whole = server
        .get(&path)
        .send()
        .await
        .unwrap()
        .bytes()
        .await
        .unwrap();
    // Forty pauses of a tenth of a second: longer than the limits.
    let step = whole.len() / 40;

    let (mut client, _connection) = connect_h2(&server, 16384).await;
    let (response, _) = client.send_request(get(&server, &path), true).unwrap();
    let mut body = response.await.unwrap().into_body();
    let (mut taken, mut pause) = (0, step);
    while let Some(data) = body.data().await {
        let length = data.unwrap().len();
        taken += length;
        body.flow_control().release_capacity(length).unwrap();
        if taken > pause {
            pause += step;
            sleep(Duration::from_millis(100)).await;
        }
    }
    assert_eq!(taken, whole.len());

    let mut stream = connect(&server).await;
    let request = format!("GET {path} HTTP/1.0\r\nHost: localhost\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let (mut room, mut taken, mut pause) = (vec![0; 1 << 16], 0, step);
    loop {
        match stream.read(&mut room).await.unwrap() {
            0 => break,
            length => taken += length,
        }
        if taken > pause {
            pause += step;
            sleep(Duration::from_millis(100)).await;
        }
    }
    assert!(
        taken > whole.len(),
        "{taken} with the head, {}",
        whole.len()
    );
}
