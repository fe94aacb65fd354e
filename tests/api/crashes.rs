//! `kill -9` at random moments under load: nothing that was acknowledged is lost, done twice or
//! done otherwise, and streams go on where they were.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use eventsource_stream::Eventsource;
use futures_util::StreamExt;
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::task::JoinSet;

use crate::program::Program;
use crate::support::Server;

/// How often the server is killed; `PIAD_TEST_KILLS` sets another number.
fn kills() -> usize {
    let set = std::env::var("PIAD_TEST_KILLS");
    set.map_or(10, |kills| {
        kills.parse().expect("PIAD_TEST_KILLS is a number")
    })
}

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
            "fairness": 1e-9, "constraints": [{"index": 700}, {"at": "end", "tangent": [0, 0, 1]}]}}),
        json!({"curve": {"points": spiral(6000)}, "method": {"kind": "least_squares", "control_points": "auto"}, "stop": {"tolerance": 1e-5}}),
        json!({"curve": {"points": spiral(500)}, "method": {"kind": "transpose"},
            "stop": {"relative_tolerance": 1e-6, "max_iterations": 100_000}}),
    ]
}

/// What an undisturbed server makes of a job.
struct Expected {
    job: Value,
    result: Value,
    iterations: usize,
}

async fn undisturbed() -> Vec<Expected> {
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
type Address = watch::Receiver<Option<String>>;

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

/// One client: creates jobs one after the other and follows each to its end, until there are no
/// more kills; gives the paths of its jobs.
async fn work(worker: usize, expected: Arc<Vec<Expected>>, address: Address) -> Vec<String> {
    let client = reqwest::Client::new();
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
        assert_eq!(seen, all, "{path}: every iteration once, in order");
        let result = persist(&address, async |base| {
            let response = client
                .get(format!("{base}{path}/result"))
                .send()
                .await
                .ok()?;
            assert_eq!(response.status(), 200, "{path}: it has ended");
            response.json::<Value>().await.ok()
        });
        let same = result.await["control_points"] == expected.result;
        assert!(same, "{path}: the same result as without kills");
        paths.push(path);
    }
    paths
}

/// A number below `limit` that looks random, the same in every run.
fn random(state: &mut u64, limit: u64) -> u64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) % limit
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn kills_lose_nothing() {
    let expected = Arc::new(undisturbed().await);
    let data = tempfile::tempdir().unwrap();
    let (place, address) = watch::channel(None);
    let mut workers = JoinSet::new();
    for worker in 0..6 {
        workers.spawn(work(worker, Arc::clone(&expected), address.clone()));
    }
    let mut state = 2006;
    for kill in 0..kills() {
        let mut program = Program::with(data.path(), &["--retain-jobs", "1000000"]);
        place.send_replace(Some(program.address.clone()));
        // What is running in three crashes is given up: every second life is long enough for all
        // that was there to end.
        if kill % 2 == 1 {
            everything_ends(&program).await;
        }
        let life = random(&mut state, 300);
        tokio::time::sleep(Duration::from_millis(life)).await;
        place.send_replace(None);
        program.kill();
    }
    let program = Program::with(data.path(), &["--retain-jobs", "1000000"]);
    place.send_replace(Some(program.address.clone()));
    // Workers end when nobody can change the address any more, with what they are at.
    drop(place);
    let paths: Vec<String> = workers.join_all().await.concat();
    assert!(paths.len() >= 2 * kills(), "only {} jobs", paths.len());
    let acknowledged: HashSet<String> = paths.iter().cloned().collect();
    assert_eq!(acknowledged.len(), paths.len());
    assert_eq!(
        all_jobs(&program).await,
        acknowledged,
        "none lost, none twice"
    );
    eprintln!("{} kills, {} jobs", kills(), paths.len());
}

/// Waits until the jobs that the server found at its start have ended.
async fn everything_ends(program: &Program) {
    for state in ["queued", "running"] {
        let list = program
            .json(&format!("/v1/jobs?limit=1000&state={state}"))
            .await;
        for job in list["jobs"].as_array().unwrap() {
            let path = job["links"]["self"].as_str().unwrap();
            while program.json(path).await["finished_at"].is_null() {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        }
    }
}

async fn all_jobs(program: &Program) -> HashSet<String> {
    let mut jobs = HashSet::new();
    let mut next = Some("/v1/jobs?limit=1000".to_owned());
    while let Some(page) = next {
        let page = program.json(&page).await;
        for job in page["jobs"].as_array().unwrap() {
            assert_eq!(job["state"], "converged", "{job}");
            jobs.insert(job["links"]["self"].as_str().unwrap().to_owned());
        }
        next = page["next"].as_str().map(str::to_owned);
    }
    jobs
}
