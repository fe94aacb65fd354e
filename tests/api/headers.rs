//! Heads of requests as they come over the wire, and those of the answers to them.

use piad::config::Config;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Duration, sleep, timeout};

use crate::data;
use crate::support::{PATIENCE, Server};

async fn connect(server: &Server) -> TcpStream {
    let (_, port) = server.url.rsplit_once(':').unwrap();
    let port = port.parse().unwrap();
    TcpStream::connect(("127.0.0.1", port)).await.unwrap()
}

/// An answer as it comes: its head in lower case, and its body.
struct Answer {
    head: String,
    body: String,
}

impl Answer {
    fn status(&self) -> u16 {
        self.head.split(' ').nth(1).unwrap().parse().unwrap()
    }

    fn closes(&self) -> bool {
        self.head.contains("\r\nconnection: close\r\n")
    }

    fn problem(&self) -> Value {
        serde_json::from_str(&self.body).expect(&self.body)
    }
}

/// Sends bytes and reads one answer with a length.
async fn exchange(stream: &mut TcpStream, request: &str) -> Answer {
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut bytes = Vec::new();
    loop {
        let text = String::from_utf8_lossy(&bytes);
        if let Some((head, body)) = text.split_once("\r\n\r\n") {
            let head = format!("{}\r\n", head.to_lowercase());
            let length = head
                .lines()
                .find_map(|line| line.strip_prefix("content-length: "));
            if body.len() == length.map_or(0, |length| length.parse().unwrap()) {
                let body = body.to_owned();
                return Answer { head, body };
            }
        }
        let read = timeout(PATIENCE, stream.read_buf(&mut bytes)).await;
        assert!(
            read.unwrap().unwrap() > 0,
            "{}",
            String::from_utf8_lossy(&bytes)
        );
    }
}

async fn ask(server: &Server, request: &str) -> Answer {
    exchange(&mut connect(server).await, request).await
}

#[tokio::test]
async fn requests_have_one_host() {
    let server = Server::start().await;
    for (head, status) in [
        ("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", 200),
        ("GET / HTTP/1.1\r\n\r\n", 400),
        (
            "GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
            400,
        ),
        ("GET / HTTP/1.1\r\nHost: local host\r\n\r\n", 400),
        ("GET / HTTP/1.1\r\nHost: me@localhost\r\n\r\n", 400),
        (
            "GET http://localhost/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
            200,
        ),
        // The address of a request line is the one that counts.
        (
            "GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
            421,
        ),
        ("GET /livez HTTP/1.1\r\n\r\n", 400),
    ] {
        let answer = ask(&server, head).await;
        assert_eq!(answer.status(), status, "{head}");
        if status == 400 {
            let problem = answer.problem();
            assert_eq!(problem["errors"][0]["header"], "Host", "{head}");
        }
    }
}

/// A page of the web whose name stands for 127.0.0.1 does not get at a server of this machine.
#[tokio::test]
async fn other_names_do_not_reach_a_server_of_this_machine() {
    let with = |host: &str, path: &str| format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
    let server = Server::start().await;
    for host in [
        "localhost:8080",
        "a.localhost",
        "127.0.0.1",
        "127.0.0.2:1",
        "[::1]:8080",
    ] {
        let answer = ask(&server, &with(host, "/v1/jobs")).await;
        assert_eq!(answer.status(), 200, "{host}");
    }
    for host in [
        "evil.example",
        "localhost.evil.example:8080",
        "10.0.0.1",
        "",
    ] {
        let answer = ask(&server, &with(host, "/v1/jobs")).await;
        assert_eq!(answer.status(), 421, "{host}");
        let problem = answer.problem();
        assert_eq!(problem["type"], "/problems/unknown-host");
        assert!(
            problem["detail"]
                .as_str()
                .unwrap()
                .contains("--allowed-host")
        );
        // Liveness is public.
        assert_eq!(ask(&server, &with(host, "/livez")).await.status(), 200);
    }

    let names = || vec!["fit.example.org".to_owned(), "*.cad.example".to_owned()];
    let server = Server::with(|config| config.allowed_host = names()).await;
    for (host, status) in [
        ("FIT.example.org:443", 200),
        ("a.cad.example", 200),
        ("localhost", 200),
        ("cad.example", 421),
        ("example.org", 421),
    ] {
        assert_eq!(
            ask(&server, &with(host, "/v1/jobs")).await.status(),
            status,
            "{host}"
        );
    }
    let server = Server::with(|config| config.allowed_host = vec!["*".to_owned()]).await;
    assert_eq!(
        ask(&server, &with("any.example", "/v1/jobs"))
            .await
            .status(),
        200
    );
}

/// Names are checked on other addresses if there are any.
#[tokio::test]
async fn names_are_checked_on_any_address_if_they_are_given() {
    let request = "GET /v1/jobs HTTP/1.1\r\nHost: any.example\r\n\r\n";
    for (names, status) in [(vec![], 200), (vec!["fit.example.org".to_owned()], 421)] {
        let listener = TcpListener::bind("0.0.0.0:0").await.unwrap();
        let change = |config: &mut Config| {
            config.allowed_host = names;
            config.insecure_no_auth = true;
        };
        let server = Server::on(listener, change).await;
        assert_eq!(ask(&server, request).await.status(), status);
    }
}

#[tokio::test]
async fn ids_of_requests_are_short_words() {
    let server = Server::start().await;
    let long = "x".repeat(128);
    for (ids, kept) in [
        (vec!["plugin-42"], true),
        (vec![&*long], true),
        (vec![&*format!("{long}x")], false),
        (vec![""], false),
        (vec!["two words"], false),
        (vec!["t\u{e4}g"], false),
        (vec!["a", "b"], false),
    ] {
        let lines: String = ids
            .iter()
            .map(|id| format!("X-Request-Id: {id}\r\n"))
            .collect();
        let head = format!("GET /nothing HTTP/1.1\r\nHost: localhost\r\n{lines}\r\n");
        let answer = ask(&server, &head).await;
        let id = answer.problem()["request_id"].as_str().unwrap().to_owned();
        assert!(answer.head.contains(&format!("\r\nx-request-id: {id}\r\n")));
        match kept {
            true => assert_eq!(id, ids[0]),
            false => assert_eq!(id.len(), 36, "{id} is a UUID"),
        }
    }
}

/// A connection without a request for five seconds is parked: the next request is still answered, in each form.
#[tokio::test]
async fn connections_continue_after_a_pause() {
    let server = Server::start().await;
    let request = "GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let (mut used, mut left) = (connect(&server).await, connect(&server).await);
    for stream in [&mut used, &mut left] {
        assert_eq!(exchange(stream, request).await.status(), 200);
    }
    sleep(Duration::from_secs(6)).await;
    let (first, rest) = request.split_at(1);
    used.write_all(first.as_bytes()).await.unwrap();
    sleep(Duration::from_millis(100)).await;
    assert_eq!(exchange(&mut used, rest).await.status(), 200);
    let form = "{\"curve\": {\"points\": [[0, 0], [1, 1]]}}";
    let head = format!(
        "POST /v1/fit HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n",
        form.len()
    );
    assert_eq!(exchange(&mut used, &(head + form)).await.status(), 200);
    // One that is laid aside ends with the server.
    timeout(PATIENCE, server.stop()).await.unwrap();
    for stream in [&mut used, &mut left] {
        assert_eq!(stream.read(&mut [0]).await.unwrap(), 0);
    }
}

/// What is answered before the body has come ends the connection and says so, unless the body is so
/// short that it can be read all the same.
#[tokio::test]
async fn answers_say_that_the_connection_ends() {
    let server = Server::with(|config| config.max_body = bytesize::ByteSize::mib(1)).await;
    let head = |method: &str, length: usize, more: &str| {
        format!(
            "{method} /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n{more}\r\n"
        )
    };
    for (request, status) in [
        (head("POST", 2 << 20, ""), 413),
        (head("PUT", 2 << 20, ""), 405),
        (head("PUT", 5, "Expect: 100-continue\r\n"), 405),
    ] {
        let mut stream = connect(&server).await;
        let answer = exchange(&mut stream, &request).await;
        assert_eq!(answer.status(), status);
        assert!(answer.closes(), "{}", answer.head);
        let read = timeout(PATIENCE, stream.read(&mut [0])).await;
        assert!(matches!(read.unwrap(), Ok(0) | Err(_)));
    }
    let mut stream = connect(&server).await;
    for _ in 0..2 {
        let request = head("PUT", 5, "") + "12345";
        let answer = exchange(&mut stream, &request).await;
        assert_eq!(answer.status(), 405);
        assert!(!answer.closes(), "{}", answer.head);
    }
}

/// A client that sends everything before it reads anything reads the answer, too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn clients_that_are_still_sending_get_the_answer() {
    let server = Server::with(|config| config.max_body = bytesize::ByteSize::kib(1)).await;
    for _ in 0..10 {
        let mut stream = connect(&server).await;
        let body = " ".repeat(8 << 20);
        let request = format!(
            "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let answer = exchange(&mut stream, &request).await;
        assert_eq!(answer.status(), 413);
        assert_eq!(answer.problem()["type"], "/problems/body-too-large");
        assert!(answer.closes());
    }
}

/// Idempotency keys are what the description says; blanks around them are not a part of them.
#[tokio::test]
async fn idempotency_keys_are_visible_ascii_and_spaces() {
    let server = Server::start().await;
    let (longest, too_long) = ("k".repeat(255), "k".repeat(256));
    for (key, status) in [
        ("wing 17", 201),
        (" \t around \t", 201),
        (longest.as_str(), 201),
        (too_long.as_str(), 400),
        ("", 400),
        ("wing\t17", 400),
        ("Flügel", 400),
    ] {
        let body = data::small_job().to_string();
        let request = format!(
            "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
             Idempotency-Key: {key}\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let answer = exchange(&mut connect(&server).await, &request).await;
        assert_eq!(answer.status(), status, "{key:?}: {}", answer.body);
        if status == 400 {
            assert_eq!(answer.problem()["errors"][0]["header"], "Idempotency-Key");
        }
    }
}
