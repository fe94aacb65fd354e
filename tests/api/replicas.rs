//! Several replicas with one database, behind one proxy: killed, paused, cut off, and all the time under load.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::cluster::Cluster;
use crate::data;
use crate::fault_proxy::{FaultProxy, Target};
use crate::load::{all_jobs, random, undisturbed, work};
use crate::program::Program;
use crate::support::{PATIENCE, Story, client, events, eventually};

/// How many times something happens; `PIAD_TEST_ROUNDS` sets another number.
fn rounds() -> usize {
    let set = std::env::var("PIAD_TEST_ROUNDS");
    set.map_or(10, |rounds| {
        rounds.parse().expect("PIAD_TEST_ROUNDS is a number")
    })
}

/// A replica with its own way to the database.
pub struct Replica {
    pub program: Program,
    wire: FaultProxy,
}

/// Some replicas behind a proxy.
pub struct Replicas {
    pub cluster: Cluster,
    pub replicas: Vec<Replica>,
    addresses: watch::Sender<Vec<String>>,
    front: FaultProxy,
    client: reqwest::Client,
}

fn launch(wire: &FaultProxy) -> Program {
    let url = format!("postgres://piad@{}/postgres?sslmode=disable", wire.address);
    Program::with(Path::new(&url), &["--retain-jobs", "1000000"])
}

impl Replicas {
    pub async fn start(count: usize) -> Self {
        let cluster = Cluster::start();
        let mut replicas = Vec::new();
        for _ in 0..count {
            let wire = FaultProxy::to(Target::Socket(cluster.socket())).await;
            let program = launch(&wire);
            replicas.push(Replica { program, wire });
        }
        let all = replicas.iter().map(|it| it.program.address.clone());
        let (addresses, servers) = watch::channel(all.collect());
        let front = FaultProxy::to(Target::Servers(servers)).await;
        let client = client().pool_max_idle_per_host(0).build().unwrap();
        Self {
            cluster,
            replicas,
            addresses,
            front,
            client,
        }
    }

    fn base(&self) -> String {
        format!("http://{}", self.front.address)
    }

    /// A replica is killed, and another one started in its place.
    fn kill(&mut self, index: usize) {
        let replica = &mut self.replicas[index];
        replica.program.kill();
        replica.program = launch(&replica.wire);
        let address = replica.program.address.clone();
        self.addresses.send_modify(|all| all[index] = address);
    }

    /// Waits until all jobs have ended that are there now.
    async fn everything_ends(&self) {
        for state in ["queued", "running"] {
            let list = format!("{}/v1/jobs?limit=1000&state={state}", self.base());
            let list = self.json(&list).await;
            for job in list["jobs"].as_array().unwrap() {
                let path = job["links"]["self"].as_str().unwrap();
                let url = format!("{}{path}", self.base());
                eventually("a job ends", async || {
                    !self.json(&url).await["finished_at"].is_null()
                })
                .await;
            }
        }
    }

    /// Requests a resource until there is a response.
    async fn json(&self, url: &str) -> Value {
        loop {
            if let Ok(response) = self.client.get(url).send().await
                && response.status() == 200
                && let Ok(json) = response.json().await
            {
                return json;
            }
            sleep(Duration::from_millis(50)).await;
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whatever_happens_nothing_is_lost() {
    let expected = Arc::new(undisturbed().await);
    let mut all = Replicas::start(3).await;
    let (place, address) = watch::channel(Some(all.front.address.clone()));
    let mut workers = JoinSet::new();
    for worker in 0..6 {
        workers.spawn(work(worker, Arc::clone(&expected), address.clone()));
    }
    let mut state = 2026;
    for round in 0..rounds() {
        let which = random(&mut state, 3) as usize;
        let pause = Duration::from_millis(500 + random(&mut state, 2500));
        let wire = &all.replicas[which].wire;
        match round % 6 {
            0 => all.kill(which),
            1 => {
                all.replicas[which].program.signal("-STOP");
                sleep(pause).await;
                all.replicas[which].program.signal("-CONT");
            }
            2 => all.cluster.stop(false),
            3 => wire.cut(),
            4 => {
                wire.freeze();
                sleep(pause).await;
                wire.thaw();
            }
            _ => {
                all.cluster.stop(true);
                sleep(pause).await;
                all.cluster.come_back();
            }
        }
        // What is running when three replicas go is given up.
        all.everything_ends().await;
        sleep(Duration::from_millis(random(&mut state, 300))).await;
    }
    drop(place);
    let paths: Vec<String> = workers.join_all().await.concat();
    assert!(paths.len() >= 2 * rounds(), "only {} jobs", paths.len());
    let acknowledged: HashSet<String> = paths.iter().cloned().collect();
    assert_eq!(acknowledged.len(), paths.len());
    let kept = all_jobs(&all.client, &all.base()).await;
    let missing: Vec<_> = acknowledged.difference(&kept).collect();
    assert!(missing.is_empty(), "{missing:?}");
    // A job that was stored without a response was requested again with its key.
    assert_eq!(kept, acknowledged, "none lost, none twice");
    eprintln!("{} rounds, {} jobs", rounds(), paths.len());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_is_read_and_ended_at_any_replica() {
    let all = Replicas::start(2).await;
    let [owner, reader] = &all.replicas[..] else {
        panic!("two replicas");
    };
    // Frames are the same wherever they are read.
    let done = owner.program.fit(&data::small_job()).await;
    let path = format!("{}/events", done["links"]["self"].as_str().unwrap());
    let mut stories = Vec::new();
    for program in [&owner.program, &reader.program] {
        let response = program.get(&path).send().await.unwrap();
        stories.push(Story::read(response).await);
    }
    assert_eq!(stories[0].iterations, stories[1].iterations);
    assert_eq!(stories[0].end, stories[1].end);
    // One that runs at the other replica, read from its middle on, and cancelled from there.
    let job: Value = owner
        .program
        .post("/v1/jobs")
        .json(&data::endless_job())
        .send()
        .await
        .unwrap()
        .json()
        .await
        .unwrap();
    let path = job["links"]["self"].as_str().unwrap();
    let read = reader
        .program
        .get(&format!("{path}/events"))
        .header("last-event-id", "7");
    let mut stream = events(read.send().await.unwrap());
    let mut seen = Vec::new();
    while seen.len() < 5 {
        let event = timeout(PATIENCE, stream.next()).await.unwrap().unwrap();
        if event.name == "iteration" {
            seen.push(event.id);
        }
    }
    assert_eq!(seen, ["8", "9", "10", "11", "12"]);
    // Each replica reports its progress, as of the last renewal of its lease.
    eventually(
        "a replica reports the progress of the job of another one",
        async || {
            let job = reader.program.json(path).await;
            job["state"] == "running" && job["iteration"].as_u64() > Some(0)
        },
    )
    .await;
    let cancelled = reader
        .program
        .post(&format!("{path}/cancel"))
        .send()
        .await
        .unwrap();
    assert_eq!(cancelled.status(), 200);
    let mut last = None;
    while let Some(event) = timeout(PATIENCE, stream.next()).await.unwrap() {
        last = Some(event);
    }
    let end = last.unwrap();
    assert_eq!(
        (end.name.as_str(), &end.data["state"]),
        ("end", &json!("cancelled"))
    );
    assert_eq!(owner.program.json(path).await["state"], "cancelled");
    // Deleted at one, it is gone at all.
    assert_eq!(
        reader.program.delete(path).send().await.unwrap().status(),
        204
    );
    for program in [&owner.program, &reader.program] {
        assert_eq!(program.get(path).send().await.unwrap().status(), 404);
    }
}

/// A job that takes a second or so.
fn slow_job() -> Value {
    json!({"curve": {"points": data::wave(4000)}, "method": {"kind": "weighted", "omega": 1e-6},
        "stop": {"tolerance": 0, "max_iterations": 10_000}})
}

/// A replica that is paused while it runs a job, for longer than its lease: another one takes the job over
/// and ends it, and what the first one writes when it comes back is refused.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_end_of_a_job_that_was_taken_over_is_refused() {
    let all = Replicas::start(2).await;
    let [paused, other] = &all.replicas[..] else {
        panic!("two replicas");
    };
    let job = paused
        .program
        .post("/v1/jobs")
        .json(&slow_job())
        .send()
        .await
        .unwrap();
    let job: Value = job.json().await.unwrap();
    assert_eq!(job["state"], "running");
    let path = job["links"]["self"].as_str().unwrap();
    let stream = paused.program.get(&format!("{path}/events?view=errors"));
    let stream = stream.send().await.unwrap();
    paused.program.signal("-STOP");
    eventually("another replica ends it", async || {
        other.program.json(path).await["state"] == "exhausted"
    })
    .await;
    let ended = other.program.json(path).await;
    assert_eq!(
        other.program.metrics().await["piad_jobs_recovered_total"],
        1.0
    );
    paused.program.signal("-CONT");
    eventually("its end is refused", async || {
        paused.program.metrics().await["piad_store_stale_writes_total"] == 1.0
    })
    .await;
    assert!(
        paused
            .program
            .log()
            .contains("the end of a job was refused")
    );
    assert_eq!(paused.program.json(path).await, ended);
    assert_eq!(other.program.json(path).await, ended);
    // It resumes, though its replica has given up the job.
    let story = timeout(PATIENCE, Story::read(stream))
        .await
        .expect("an end");
    assert_eq!(story.iterations.len(), 10_001);
    assert_eq!(story.end["state"], "exhausted");
}

/// A job that is stored while the response is lost: the client gets an error and retries at another replica. Readers at
/// the first replica also get its end.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_whose_acknowledgement_was_lost_has_an_end_for_its_readers() {
    let all = Replicas::start(2).await;
    let [first, other] = &all.replicas[..] else {
        panic!("two replicas");
    };
    let job = json!({"curve": {"points": data::wave(2000)}});
    // Each connection that is there knows the statement: it is stored without a question before.
    for _ in 0..10 {
        first.program.fit(&job).await;
    }
    first.wire.mute_next();
    let job = json!({"name": "wing", "curve": {"points": data::wave(2000)},
        "stop": {"tolerance": 0, "max_iterations": 1_000_000_000}});
    let post = first.program.post("/v1/jobs").json(&job).send();
    let read = async {
        let mut path = String::new();
        eventually("it is stored", async || {
            let list = other.program.json("/v1/jobs").await;
            let mut jobs = list["jobs"].as_array().unwrap().iter();
            let found = jobs.find(|job| job["name"] == "wing");
            found.is_some_and(|job| {
                path = job["links"]["events"].as_str().unwrap().to_owned();
                true
            })
        })
        .await;
        let stream = first.program.get(&path).send().await.unwrap();
        (path.replace("/events", "/cancel"), stream)
    };
    let (refused, (cancel, stream)) = tokio::join!(post, read);
    let refused = refused.unwrap();
    assert_eq!(
        (refused.status().as_u16(), stream.status().as_u16()),
        (503, 200)
    );
    let cancelled = other.program.post(&cancel).send().await.unwrap();
    assert_eq!(cancelled.status(), 200);
    let story = timeout(PATIENCE, Story::read(stream)).await;
    assert_eq!(story.expect("an end").end["state"], "cancelled");
}

/// A job whose end is stored while the answer is lost: others know the end, and its own replica looks for it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_end_whose_acknowledgement_was_lost_is_the_end_everywhere() {
    let all = Replicas::start(2).await;
    let [owner, other] = &all.replicas[..] else {
        panic!("two replicas");
    };
    let post = owner.program.post("/v1/jobs").json(&slow_job());
    let job: Value = post.send().await.unwrap().json().await.unwrap();
    assert_eq!(job["state"], "running");
    owner.wire.mute_next();
    let path = job["links"]["self"].as_str().unwrap();
    eventually("another replica knows its end", async || {
        other.program.json(path).await["state"] == "exhausted"
    })
    .await;
    assert_eq!(owner.program.json(path).await["state"], "exhausted");
    let list = owner.program.json("/v1/jobs").await;
    assert_eq!(list["jobs"][0]["state"], "exhausted");
    let result = owner.program.json(&format!("{path}/result")).await;
    assert_eq!(result["iteration"], 10_000);
}

/// Replicas are replaced one at a time: some work with the schema of the next version already.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_later_schema_is_no_obstacle() {
    let expected = Arc::new(undisturbed().await);
    let mut all = Replicas::start(2).await;
    let (place, address) = watch::channel(Some(all.front.address.clone()));
    let mut workers = JoinSet::new();
    for worker in 0..4 {
        workers.spawn(work(worker, Arc::clone(&expected), address.clone()));
    }
    all.cluster.run(
        "BEGIN; ALTER TABLE jobs ADD COLUMN later text NOT NULL DEFAULT ''; CREATE INDEX ON jobs (later);
         INSERT INTO _sqlx_migrations VALUES (1000, 'later', now(), true, '\\x00', 0); COMMIT",
    );
    for index in 0..2 {
        all.kill(index);
        all.everything_ends().await;
    }
    drop(place);
    let paths: HashSet<String> = workers.join_all().await.concat().into_iter().collect();
    assert!(!paths.is_empty());
    assert_eq!(all_jobs(&all.client, &all.base()).await, paths);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_makes_one_job_among_replicas() {
    let all = Replicas::start(2).await;
    let post = async |program: &Program, job: &Value| {
        let request = program.post("/v1/jobs").header("idempotency-key", "wing");
        let response = request.json(job).send().await.unwrap();
        let status = response.status().as_u16();
        let id = response.json::<Value>().await.unwrap()["id"].clone();
        (status, id)
    };
    let job = data::small_job();
    let both = tokio::join!(
        post(&all.replicas[0].program, &job),
        post(&all.replicas[1].program, &job)
    );
    assert_eq!(both.0.1, both.1.1);
    let other = json!({"curve": {"points": [[0, 0], [1, 1], [2, 0]]}});
    assert_eq!(post(&all.replicas[1].program, &other).await.0, 422);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_its_database_a_server_reports_it_and_continues() {
    let all = Replicas::start(1).await;
    let program = &all.replicas[0].program;
    let endless = program
        .post("/v1/jobs")
        .header("accept", "text/event-stream");
    let mut stream = events(endless.json(&data::endless_job()).send().await.unwrap());
    stream.next().await.unwrap();
    all.cluster.stop(true);
    let refused = program
        .post("/v1/jobs")
        .json(&data::small_job())
        .send()
        .await
        .unwrap();
    assert_eq!(refused.status(), 503);
    assert!(refused.headers().contains_key("retry-after"));
    let problem: Value = refused.json().await.unwrap();
    assert_eq!(problem["type"], "/problems/store-away", "{problem}");
    assert_eq!(program.get("/readyz").send().await.unwrap().status(), 503);
    assert_eq!(program.get("/livez").send().await.unwrap().status(), 200);
    // Streams continue meanwhile.
    for _ in 0..100 {
        timeout(PATIENCE, stream.next()).await.unwrap().unwrap();
    }
    all.cluster.come_back();
    eventually("it is ready again", async || {
        program.get("/readyz").send().await.unwrap().status() == 200
    })
    .await;
    assert_eq!(program.fit(&data::small_job()).await["state"], "converged");
}
