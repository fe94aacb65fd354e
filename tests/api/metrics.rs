//! The content of `/metrics` after known events, in the format of OpenMetrics.

use futures_util::StreamExt;
use reqwest::Method;

use crate::data;
use crate::support::{Server, base, events};

#[tokio::test]
async fn jobs_and_open_connections_are_counted() {
    // There is memory for one of these jobs at a time.
    let server = Server::with(|config| config.memory = Some(bytesize::ByteSize::kib(240))).await;
    let names = ["piad_jobs_running", "piad_jobs_queued", "piad_streams_open"];
    let all = server.metrics().await;
    assert_eq!(names.map(|name| all[name]), [0.0; 3]);
    assert_eq!(all["piad_connections_open"], 1.0);
    let build = |name: &&String| name.starts_with("piad_build_info{");
    let build = all.keys().find(build).unwrap();
    let version = format!("version=\"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(
        build.contains(&version) && build.contains("commit=\""),
        "{build}"
    );
    assert_eq!(all[build], 1.0);

    let mut jobs = Vec::new();
    let mut all = server.metrics().await;
    while all["piad_jobs_queued"] == 0.0 {
        jobs.push(server.create(&data::endless_job()).await);
        all = server.metrics().await;
    }
    assert_eq!(all["piad_jobs_queued"], 1.0);
    assert_eq!(all["piad_jobs_running"], (jobs.len() - 1) as f64);
    let path = format!("{}/events", base(&jobs[0]));
    let mut stream = events(server.get(&path).send().await.unwrap());
    stream.next().await.unwrap();
    server.until("piad_streams_open", 1.0).await;
    drop(stream);
    server.until("piad_streams_open", 0.0).await;
    for job in &jobs {
        let cancel = server.post(&format!("{}/cancel", base(job)));
        cancel.send().await.unwrap();
    }
    server.until("piad_jobs_queued", 0.0).await;
    server.until("piad_jobs_running", 0.0).await;
}

#[tokio::test]
async fn requests_are_counted_by_route() {
    let server = Server::start().await;
    for path in [
        "/v1/jobs/a",
        "/v1/jobs/b",
        "/v1/jobs/c",
        "/nothing",
        "/nowhere",
    ] {
        assert!(
            server
                .get(path)
                .send()
                .await
                .unwrap()
                .status()
                .is_client_error()
        );
    }
    let brew = Method::from_bytes(b"BREW").unwrap();
    for path in ["/livez", "/readyz"] {
        let request = server
            .client
            .request(brew.clone(), format!("{}{path}", server.url));
        assert_eq!(request.send().await.unwrap().status(), 405);
    }
    let all = server.metrics().await;
    let requests = |method: &str, route: &str, status: u16| {
        let name = format!(
            "piad_http_requests_total{{method=\"{method}\",route=\"{route}\",status=\"{status}\"}}"
        );
        all.get(&name).copied()
    };
    assert_eq!(requests("GET", "/v1/jobs/{id}", 404), Some(3.0));
    assert_eq!(requests("GET", "none", 404), Some(2.0));
    assert_eq!(requests("other", "/livez", 405), Some(1.0));
    let of = |name: &str, more: &str| {
        let labels = "method=\"GET\",route=\"/v1/jobs/{id}\"";
        all[&format!("piad_http_request_duration_seconds_{name}{{{more}{labels}}}")]
    };
    assert_eq!(of("count", ""), 3.0);
    assert_eq!(of("bucket", "le=\"+Inf\","), 3.0);
    assert!(of("bucket", "le=\"0.001\",") <= of("bucket", "le=\"0.5\","));
    assert!(of("sum", "") > 0.0);
    // Nothing of what clients make up.
    let own = ["nothing", "nowhere", "BREW"];
    assert!(
        !all.keys()
            .any(|name| own.iter().any(|it| name.contains(it)))
    );
}
