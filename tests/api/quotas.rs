//! Quotas of tenants: exact, however many ask at a time.

use futures_util::future::join_all;
use reqwest::Response;
use serde_json::{Value, json};
use tonic::transport::Endpoint;
use tonic::{Code, Request};

use crate::data;
use crate::messages::WatchJobRequest;
use crate::messages::fitting_service_client::FittingServiceClient;
use crate::program::Program;
use crate::support::{base, eventually, problem};
use crate::tokens_file::TokensFile;

const SCOPES: &str = "jobs:read,jobs:write";

/// The number of simultaneous requests.
const CROWD: usize = 100;

/// Two tenants, of which the first one has a quota.
struct Tenants {
    file: TokensFile,
    limited: String,
    free: String,
}

impl Tenants {
    fn with(quota: &str) -> Self {
        let file = TokensFile::new();
        let (limited, free) = (file.token("limited", SCOPES), file.token("free", SCOPES));
        let tenants = Self {
            file,
            limited,
            free,
        };
        tenants.append(&format!("[tenant.limited]\n{quota}\n"));
        tenants
    }

    fn append(&self, text: &str) {
        self.file.add(text);
    }

    fn server(&self) -> Program {
        self.file.server(&["--max-jobs-per-peer", "1000"])
    }
}

async fn create(server: &Program, token: &str, job: &Value) -> Response {
    let request = server.post("/v1/jobs").bearer_auth(token);
    request.json(job).send().await.unwrap()
}

/// Creates many jobs at the same time; returns those that were created. The others were rejected with a reason.
async fn crowd(server: &Program, token: &str, job: &Value, detail: &str) -> Vec<Value> {
    let answers = join_all((0..CROWD).map(|_| create(server, token, job))).await;
    let mut made = Vec::new();
    for answer in answers {
        match answer.status().as_u16() {
            201 => made.push(answer.json().await.unwrap()),
            _ => refused(answer, detail).await,
        }
    }
    made
}

/// It is beyond the quota, for now.
async fn refused(answer: Response, detail: &str) {
    assert_eq!(answer.headers()["retry-after"], "5");
    let (status, problem) = problem(answer).await;
    assert_eq!(
        (status, &problem["type"]),
        (429, &json!("/problems/quota-exceeded"))
    );
    let reported = problem["detail"].as_str().unwrap();
    assert!(reported.contains(detail), "{reported}");
}

async fn delete(server: &Program, token: &str, job: &Value) {
    let request = server.delete(base(job)).bearer_auth(token);
    assert_eq!(request.send().await.unwrap().status(), 204);
}

#[tokio::test]
async fn unfinished_jobs_are_exact() {
    let tenants = Tenants::with("jobs = 7");
    let server = tenants.server();
    let detail = "tenant limited may have 7 unfinished jobs and would have 8";
    let job = data::endless_job();
    let made = crowd(&server, &tenants.limited, &job, detail).await;
    assert_eq!(made.len(), 7);
    let others = crowd(&server, &tenants.free, &job, "").await;
    assert_eq!(others.len(), CROWD);
    // Two end, one of them in a row with its deletion.
    let cancel = format!("{}/cancel", base(&made[0]));
    let cancel = server.post(&cancel).bearer_auth(&tenants.limited);
    assert_eq!(cancel.send().await.unwrap().status(), 200);
    delete(&server, &tenants.limited, &made[1]).await;
    let mut again = Vec::new();
    eventually("there is room again", async || {
        again.extend(crowd(&server, &tenants.limited, &job, detail).await);
        again.len() >= 2
    })
    .await;
    assert_eq!(again.len(), 2);
}

#[tokio::test]
async fn points_of_unfinished_jobs_are_exact() {
    let tenants = Tenants::with("points = 599");
    let server = tenants.server();
    let detail = "tenant limited may have 599 points of unfinished jobs and would have 600";
    let made = crowd(&server, &tenants.limited, &data::endless_job(), detail).await;
    assert_eq!(made.len(), 5);
    // No end of other jobs makes room for this one.
    let job = json!({"curve": {"points": data::wave(600)}});
    let answer = create(&server, &tenants.limited, &job).await;
    assert!(!answer.headers().contains_key("retry-after"));
    assert_eq!(problem(answer).await.0, 429);
    // What fits in does, a replayed request too.
    let job = json!({"curve": {"points": data::wave(99)}, "stop": {"tolerance": 0}});
    for replayed in [false, true] {
        let request = server.post("/v1/jobs").bearer_auth(&tenants.limited);
        let request = request.header("idempotency-key", "one").json(&job);
        let answer = request.send().await.unwrap();
        assert_eq!(answer.status(), 201);
        assert_eq!(
            answer.headers().contains_key("idempotency-replayed"),
            replayed
        );
    }
}

#[tokio::test]
async fn bytes_count_until_jobs_are_deleted() {
    let tenants = Tenants::with("bytes = \"20 kB\"");
    let server = tenants.server();
    let detail = "tenant limited may have 20000 bytes of jobs and would have";
    let job = data::small_job();
    let made = crowd(&server, &tenants.limited, &job, detail).await;
    // A hundred points of two coordinates of eight bytes, and as much of those that have ended meanwhile.
    let some = 4..13;
    assert!(some.contains(&made.len()), "{}", made.len());
    for job in &made {
        let events = format!("{}/events?view=errors", base(job));
        let events = server.get(&events).bearer_auth(&tenants.limited);
        assert!(
            events
                .send()
                .await
                .unwrap()
                .text()
                .await
                .unwrap()
                .contains("event: end")
        );
    }
    // Their results count, too: nothing has become free, and after a restart nothing is forgotten.
    refused(create(&server, &tenants.limited, &job).await, detail).await;
    drop(server);
    let server = tenants.server();
    refused(create(&server, &tenants.limited, &job).await, detail).await;
    for job in &made {
        delete(&server, &tenants.limited, job).await;
    }
    let again = crowd(&server, &tenants.limited, &job, detail).await;
    assert!(some.contains(&again.len()), "{}", again.len());
}

#[tokio::test]
async fn open_streams_are_exact() {
    let tenants = Tenants::with("streams = 3");
    let server = tenants.server();
    let detail = "tenant limited may have 3 open streams and would have 4";
    let job = data::endless_job();
    let job: Value = create(&server, &tenants.limited, &job)
        .await
        .json()
        .await
        .unwrap();
    let events = format!("{}/events?view=errors", base(&job));
    let open = async || {
        server
            .get(&events)
            .bearer_auth(&tenants.limited)
            .send()
            .await
            .unwrap()
    };
    let answers = join_all((0..CROWD).map(|_| open())).await;
    let mut streams = Vec::new();
    for answer in answers {
        match answer.status().as_u16() {
            200 => streams.push(answer),
            _ => refused(answer, detail).await,
        }
    }
    assert_eq!(streams.len(), 3);
    // A job is not made without its stream; a fit for one answer counts as one.
    for path in ["/v1/jobs/stream", "/v1/fit"] {
        let request = server.post(path).bearer_auth(&tenants.limited);
        refused(
            request.json(&data::small_job()).send().await.unwrap(),
            detail,
        )
        .await;
    }
    // So does a batch, whatever it has.
    let batch = server.post("/v1/batch").bearer_auth(&tenants.limited);
    let batch = batch.json(&json!({"items": [data::small_job()]}));
    refused(batch.send().await.unwrap(), detail).await;
    let list = server.get("/v1/jobs").bearer_auth(&tenants.limited);
    let list: Value = list.send().await.unwrap().json().await.unwrap();
    assert_eq!(list["jobs"].as_array().unwrap().len(), 1);
    let endpoint = Endpoint::from_shared(format!("http://{}", server.address)).unwrap();
    let mut client = FittingServiceClient::new(endpoint.connect().await.unwrap());
    let mut watch = async || {
        let mut request = Request::new(WatchJobRequest {
            id: job["id"].as_str().unwrap().to_owned(),
            ..WatchJobRequest::default()
        });
        let token = format!("Bearer {}", tenants.limited);
        request
            .metadata_mut()
            .insert("authorization", token.parse().unwrap());
        client.watch_job(request).await
    };
    let status = watch().await.unwrap_err();
    assert_eq!(status.code(), Code::ResourceExhausted);
    assert!(status.message().contains(detail), "{status:?}");
    streams.pop();
    eventually("a stream is free", async || watch().await.is_ok()).await;
}

#[tokio::test]
async fn quotas_are_loaded_again() {
    let tenants = Tenants::with("jobs = 1");
    let server = tenants.server();
    let job = data::endless_job();
    let free = async || create(&server, &tenants.free, &job).await;
    assert_eq!(free().await.status(), 201);
    tenants.append("[tenant.free]\njobs = 0\n");
    eventually("the quota holds", async || free().await.status() == 429).await;
    let list = tenants.file.run("list", &[]);
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(list.contains("quota of limited: jobs = 1\n"), "{list}");
    // Invalid values change nothing, and are reported.
    tenants.append("[tenant.other]\njob = 3\n");
    eventually("it is reported", async || {
        server.log().contains("stay in use")
    })
    .await;
    assert!(
        server.log().contains("unknown field `job`"),
        "{}",
        server.log()
    );
    assert_eq!(free().await.status(), 429);
    // Tokens that are made later leave quotas as they are.
    let list = tenants.file.run("create", &[]);
    assert!(!list.status.success());
}
