//! Starts servers and reads event streams.

use std::collections::HashMap;
use std::time::Duration;

use eventsource_stream::Eventsource;
use futures_util::{Stream, StreamExt};
use piad::config::{Config, Storage};
use reqwest::header::{AUTHORIZATION, HeaderValue};
use reqwest::{Client, ClientBuilder, RequestBuilder, Response};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use crate::database;

/// A guard against hanging, also on a slow and busy machine: how long anything takes is measured by
/// benches, not by tests.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// A limit that no test reaches.
pub const NEVER: Duration = Duration::from_secs(3600);

/// No output of a server contains a token or a ticket.
pub fn assert_no_token(text: &str) {
    let is_of_token = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    for found in text.split("piad_").skip(1) {
        let length = found.find(|c| !is_of_token(c)).unwrap_or(found.len());
        // A token has 43 characters behind its beginning; metrics have fewer.
        assert!(length < 40, "a token: {text}");
    }
}

/// What clients send where the variable PIAD_TOKEN is set, as servers then ask for its token.
pub fn authorization() -> Option<String> {
    let token = std::env::var("PIAD_TOKEN").ok();
    token.map(|token| format!("Bearer {token}"))
}

/// A client whose patience is that of tests.
pub fn client() -> ClientBuilder {
    let value = |text| HeaderValue::try_from(text).unwrap();
    let header = authorization().map(|text| (AUTHORIZATION, value(text)));
    let client = Client::builder().read_timeout(PATIENCE);
    client.default_headers(header.into_iter().collect())
}

/// Asks until the answer is yes.
pub async fn eventually(what: &str, mut is_so: impl AsyncFnMut() -> bool) {
    let asked = async {
        while !is_so().await {
            sleep(Duration::from_millis(10)).await;
        }
    };
    let answered = timeout(PATIENCE, asked).await;
    assert!(answered.is_ok(), "not within {PATIENCE:?}: {what}");
}

/// A server of its own for a test, in the same process, on a free port.
pub struct Server {
    pub url: String,
    pub client: Client,
    stop: Option<oneshot::Sender<()>>,
    served: JoinHandle<std::io::Result<()>>,
}

impl Server {
    pub async fn start() -> Self {
        Self::with(|_| {}).await
    }

    /// A server whose configuration differs from the standard one.
    pub async fn with(change: impl FnOnce(&mut Config)) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        Self::on(listener, change).await
    }

    /// The same where it listens.
    pub async fn on(listener: TcpListener, change: impl FnOnce(&mut Config)) -> Self {
        let mut config = Config::standard();
        // So that there are jobs that outlast any test.
        config.max_iterations = 1_000_000_000;
        config.store = Storage::Memory;
        change(&mut config);
        config.store = database::instead_of(config.store);
        config.lease = database::LEASE;
        let url = format!("http://{}", listener.local_addr().unwrap());
        let (stop, stopped) = oneshot::channel::<()>();
        let served = tokio::spawn(piad::server::serve(vec![listener.into()], config, async {
            let _ = stopped.await;
        }));
        let client = client().build().unwrap();
        Self {
            url,
            client,
            stop: Some(stop),
            served,
        }
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(format!("{}{path}", self.url))
    }

    pub fn post(&self, path: &str) -> RequestBuilder {
        self.client.post(format!("{}{path}", self.url))
    }

    pub fn delete(&self, path: &str) -> RequestBuilder {
        self.client.delete(format!("{}{path}", self.url))
    }

    /// Posts a job and gives its resource.
    pub async fn create(&self, job: &Value) -> Value {
        let response = self.post("/v1/jobs").json(job).send().await.unwrap();
        assert_eq!(response.status(), 201, "{job}");
        response.json().await.unwrap()
    }

    /// Posts a job and waits for its end.
    pub async fn fit(&self, job: &Value) -> Value {
        let request = self.post("/v1/jobs").header("prefer", "wait=100");
        let response = request.json(job).send().await.unwrap();
        assert_eq!(response.status(), 201, "{job}");
        response.json().await.unwrap()
    }

    /// Posts a job and reads all of its events.
    pub async fn stream(&self, job: &Value) -> Story {
        let request = self.post("/v1/jobs").header("accept", "text/event-stream");
        let response = request.json(job).send().await.unwrap();
        assert_eq!(response.status(), 200, "{job}");
        Story::read(response).await
    }

    /// Posts a job that must be refused: with this pointer, and this as a part of the reason.
    pub async fn assert_refused(&self, job: &Value, pointer: &str, reason: &str) {
        let response = self.post("/v1/jobs").json(job).send().await.unwrap();
        let (status, problem) = problem(response).await;
        assert_eq!(status, 422, "{job}");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem:#}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(reason), "{problem:#}");
    }

    /// What is at a path. A server that needs longer for it is asked again, as it says.
    pub async fn json(&self, path: &str) -> Value {
        let ready = async {
            loop {
                let response = self.get(path).send().await.unwrap();
                if response.status() != 503 {
                    return response;
                }
                let after = response.headers()["retry-after"].to_str().unwrap();
                sleep(Duration::from_secs(after.parse().unwrap())).await;
            }
        };
        let response = timeout(PATIENCE, ready).await.expect("it is ready");
        assert_eq!(response.status(), 200, "{path}");
        response.json().await.unwrap()
    }

    pub async fn metrics(&self) -> HashMap<String, f64> {
        metrics(self.get("/metrics").send().await.unwrap()).await
    }

    /// Waits until one of the metrics has a value.
    pub async fn until(&self, name: &str, value: f64) {
        let what = format!("{name} is {value}");
        eventually(&what, async || {
            self.metrics().await.get(name) == Some(&value)
        })
        .await;
    }

    /// Waits until a job is in a state.
    pub async fn until_state(&self, path: &str, state: &str) {
        let what = format!("{path} is {state}");
        eventually(&what, async || self.json(path).await["state"] == state).await;
    }

    /// Stops the server and waits until it has ended.
    pub async fn stop(mut self) {
        self.stop.take().unwrap().send(()).unwrap();
        let served = timeout(PATIENCE, self.served).await.expect("it stops");
        served.unwrap().unwrap();
    }
}

/// The values of `/metrics` by names with labels, which are sorted by name.
pub async fn metrics(response: Response) -> HashMap<String, f64> {
    let text = response.text().await.unwrap();
    assert_no_token(&text);
    assert!(text.ends_with("# EOF\n"));
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let pair = |line: &str| {
        let (name, value) = line.rsplit_once(' ').unwrap();
        (name.to_owned(), value.parse().unwrap())
    };
    lines.map(pair).collect()
}

/// An event as a client sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    pub name: String,
    pub id: String,
    pub data: Value,
}

/// The events of a response, as they come.
pub fn events(response: Response) -> impl Stream<Item = Event> + Unpin {
    let events = response.bytes_stream().eventsource();
    Box::pin(events.map(|event| {
        let event = event.expect("a well-formed event");
        Event {
            name: event.event,
            id: event.id,
            data: serde_json::from_str(&event.data).expect("data are JSON"),
        }
    }))
}

/// A whole event stream.
#[derive(Debug)]
pub struct Story {
    pub job: Value,
    pub iterations: Vec<Value>,
    pub end: Value,
}

impl Story {
    /// Reads a stream to its end and checks its grammar: `job`, iterations without gaps, `end`.
    pub async fn read(response: Response) -> Self {
        let mut events = events(response);
        let job = events.next().await.expect("a job event");
        assert_eq!((job.name.as_str(), job.id.as_str()), ("job", ""));
        let mut iterations: Vec<Value> = Vec::new();
        loop {
            let event = events.next().await.expect("an event before the end");
            if event.name == "end" {
                assert_eq!(event.id, "end");
                assert!(events.next().await.is_none(), "nothing follows the end");
                return Self {
                    job: job.data,
                    iterations,
                    end: event.data,
                };
            }
            assert_eq!(event.name, "iteration");
            assert_eq!(event.id, event.data["iteration"].to_string());
            if let Some(last) = iterations.last() {
                let before = last["iteration"].as_u64().unwrap();
                assert_eq!(event.data["iteration"], json!(before + 1), "no gaps");
            }
            iterations.push(event.data);
        }
    }

    /// The largest distance at level `k` of a stream from 0 on.
    pub fn error(&self, k: usize) -> f64 {
        assert_eq!(self.iterations[k]["iteration"], json!(k));
        self.iterations[k]["error"]["max"].as_f64().unwrap()
    }

    pub fn state(&self) -> &str {
        self.end["state"].as_str().unwrap()
    }
}

/// Levels of a stream's iterations.
pub fn levels(iterations: &[Value]) -> Vec<u64> {
    let level = |iteration: &Value| iteration["iteration"].as_u64().unwrap();
    iterations.iter().map(level).collect()
}

/// The iterations of a stream that may leave some out, and its end.
pub async fn thinned(server: &Server, path: &str, after: Option<&str>) -> (Vec<Value>, Value) {
    let mut request = server.get(path);
    if let Some(id) = after {
        request = request.header("last-event-id", id);
    }
    read_thinned(request.send().await.unwrap()).await
}

/// The same of a response.
pub async fn read_thinned(response: Response) -> (Vec<Value>, Value) {
    assert_eq!(response.status(), 200);
    let mut stream = events(response);
    let mut iterations = Vec::new();
    while let Some(event) = stream.next().await {
        match event.name.as_str() {
            "iteration" => iterations.push(event.data),
            "end" => return (iterations, event.data),
            _ => {}
        }
    }
    panic!("the stream has no end");
}

/// The path of a job, of its resource or of its `job` event.
pub fn base(job: &Value) -> &str {
    job["links"]["self"].as_str().unwrap()
}

/// Checks that a path is rejected with a query: the parameter named, and a part of the reason.
pub async fn assert_query_refused(
    server: &Server,
    path: &str,
    query: &str,
    parameter: &str,
    reason: &str,
) {
    let request = server.get(&format!("{path}?{query}"));
    let (status, problem) = problem(request.send().await.unwrap()).await;
    assert_eq!(status, 400, "{query}");
    assert_eq!(problem["errors"][0]["parameter"], parameter, "{problem:#}");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains(reason), "{problem:#}");
}

/// A problem object, after checking what all of them have.
pub async fn problem(response: Response) -> (u16, Value) {
    let status = response.status().as_u16();
    assert_eq!(
        response.headers()["content-type"],
        "application/problem+json"
    );
    let id = response.headers()["x-request-id"]
        .to_str()
        .unwrap()
        .to_owned();
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["status"], json!(status));
    assert_eq!(problem["request_id"], json!(id));
    assert!(problem["type"].as_str().unwrap().starts_with("/problems/"));
    assert!(!problem["title"].as_str().unwrap().is_empty());
    assert!(!problem["detail"].as_str().unwrap().is_empty());
    assert_no_token(&problem.to_string());
    (status, problem)
}
