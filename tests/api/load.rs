//! A load of mixed jobs, each created, followed and compared with what an undisturbed server makes of it.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use eventsource_stream::Eventsource;
use futures_util::StreamExt;
use serde_json::{Value, json};
use tokio::sync::watch;

use crate::support::{Server, client};

/// Jobs of a millisecond to a tenth of a second. Each ends `converged`.
fn mix() -> Vec<Value> {
    let spiral = |count: usize| -> Vec<_> {
        let angle = |i: usize| i as f64 / 20.0;
        let point = |a: f64| json!([a.cos() * a, a.sin() * a, a]);
        (0..count).map(|i| point(angle(i))).collect()
    };
    let grid: Vec<Vec<_>> = (0..15)
        .map(|i| {
            (0..12)
                .map(|j| json!([i, j, f64::from(i * j % 7)]))
                .collect()
        })
        .collect();
    let close = json!({"relative_tolerance": 1e-12, "max_iterations": 5000});
    vec![
        json!({"curve": {"points": spiral(40)}}),
        json!({"curve": {"points": spiral(2000)}, "stop": close}),
        json!({"curve": {"points": spiral(6000)}, "method": {"kind": "weighted", "omega": 0.5}}),
        json!({"surface": {"points": grid}, "stop": close}),
        json!({"curve": {"points": spiral(12), "basis": {"kind": "bernstein"}},
            "stop": {"tolerance": 0.001, "max_iterations": 100_000}}),
        json!({"curve": {"points": spiral(2000)}, "method": {"kind": "least_squares", "control_points": 300, "variant": "diagonal",
            "fairness": 1e-15, "constraints": [{"index": 700}, {"at": "end", "tangent": [0, 0, 1]}]}}),
        json!({"curve": {"points": spiral(6000)}, "method": {"kind": "least_squares", "control_points": "auto"}, "stop": {"tolerance": 1e-5}}),
        json!({"curve": {"points": spiral(500)}, "method": {"kind": "transpose"},
            "stop": {"relative_tolerance": 1e-6, "max_iterations": 100_000}}),
    ]
}

/// What an undisturbed server makes of a job.
pub struct Expected {
    job: Value,
    result: Value,
    iterations: usize,
}

pub async fn undisturbed() -> Vec<Expected> {
    let server = Server::start().await;
    let mut expected = Vec::new();
    for job in mix() {
        let done = server.fit(&job).await;
        assert_eq!(done["state"], "converged", "{}", done);
        let path = done["links"]["result"].as_str().unwrap();
        let result = server.json(path).await["control_points"].clone();
        let iterations = done["iteration"].as_u64().unwrap() as usize;
        expected.push(Expected {
            job,
            result,
            iterations,
        });
    }
    server.stop().await;
    expected
}

/// Where the server is now; `None` while there is none.
pub type Address = watch::Receiver<Option<String>>;

/// Tries until a server answers.
async fn persist<T, F: Future<Output = Option<T>>>(
    address: &Address,
    attempt: impl Fn(String) -> F,
) -> T {
    loop {
        let current = address.borrow().clone();
        if let Some(current) = current
            && let Some(value) = attempt(format!("http://{current}")).await
        {
            return value;
        }
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

/// Posts the job until it is acknowledged; with a key, so that it is made once.
async fn create(client: &reqwest::Client, address: &Address, job: &Value, key: &str) -> String {
    persist(address, async |base| {
        let request = client
            .post(format!("{base}/v1/jobs"))
            .header("idempotency-key", key);
        let response = request.json(job).send().await.ok()?;
        assert!([201, 503].contains(&response.status().as_u16()));
        let job: Value = response.json().await.ok()?;
        job["links"]["self"].as_str().map(str::to_owned)
    })
    .await
}

/// Follows a job from server to server; gives the iterations in the order in which they came.
async fn follow(client: &reqwest::Client, address: &Address, path: &str) -> (Vec<usize>, Value) {
    let mut seen: Vec<usize> = Vec::new();
    loop {
        let last = seen.last().copied();
        let response = persist(address, async |base| {
            let mut request = client.get(format!("{base}{path}/events?view=errors"));
            if let Some(last) = last {
                request = request.header("last-event-id", last.to_string());
            }
            let response = request.send().await.ok()?;
            if response.status() == 503 {
                return None;
            }
            assert_eq!(response.status(), 200, "{path} is lost");
            Some(response)
        })
        .await;
        let mut events = response.bytes_stream().eventsource();
        // A server that is killed ends its streams anywhere.
        while let Some(Ok(event)) = events.next().await {
            let data: Value = serde_json::from_str(&event.data).unwrap();
            match event.event.as_str() {
                "iteration" => seen.push(data["iteration"].as_u64().unwrap() as usize),
                "end" => return (seen, data),
                _ => {}
            }
        }
    }
}

/// One client: creates jobs one after the other and watches each to its end, until the sender of addresses is dropped;
/// returns the paths of its jobs.
pub async fn work(worker: usize, expected: Arc<Vec<Expected>>, address: Address) -> Vec<String> {
    // Each request has a connection of its own, which may lead to another server.
    let client = client().pool_max_idle_per_host(0).build().unwrap();
    let mut paths = Vec::new();
    for turn in 0.. {
        if address.has_changed().is_err() {
            break;
        }
        let expected = &expected[(worker + turn) % expected.len()];
        let key = format!("{worker}-{turn}");
        let path = create(&client, &address, &expected.job, &key).await;
        let (seen, end) = follow(&client, &address, &path).await;
        assert_eq!(end["state"], "converged", "{path}: {end}");
        let all: Vec<usize> = (0..=expected.iterations).collect();
        assert_eq!(seen, all, "{path}: every iteration once, in order: {end}");
        let result = persist(&address, async |base| {
            let response = client
                .get(format!("{base}{path}/result"))
                .send()
                .await
                .ok()?;
            if response.status() == 503 {
                return None;
            }
            let status = response.status();
            let answer = response.json::<Value>().await.ok()?;
            assert_eq!(status, 200, "{path} has ended: {answer}");
            Some(answer)
        });
        let same = result.await["control_points"] == expected.result;
        assert!(same, "{path}: the same result as without kills");
        paths.push(path);
    }
    paths
}

/// A number below `limit` that looks random, the same in every run.
pub fn random(state: &mut u64, limit: u64) -> u64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) % limit
}

/// The paths of all jobs of a server; each has converged.
pub async fn all_jobs(client: &reqwest::Client, base: &str) -> HashSet<String> {
    let mut jobs = HashSet::new();
    let mut next = Some("/v1/jobs?limit=1000".to_owned());
    while let Some(path) = next {
        let page = client.get(format!("{base}{path}")).send().await.unwrap();
        assert_eq!(page.status(), 200);
        let page: Value = page.json().await.unwrap();
        for job in page["jobs"].as_array().unwrap() {
            assert_eq!(job["state"], "converged", "{job}");
            jobs.insert(job["links"]["self"].as_str().unwrap().to_owned());
        }
        next = page["next"].as_str().map(str::to_owned);
    }
    jobs
}
