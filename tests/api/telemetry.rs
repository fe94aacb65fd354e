//! Traces: what a collector gets of requests and jobs, the headers for clients, and collectors that do not respond.

use std::process::Command;

use opentelemetry_proto::tonic::trace::v1::Span;
use opentelemetry_proto::tonic::trace::v1::span::SpanKind;
use reqwest::Response;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::time::Duration;

use crate::collector::{Collector, attribute, exporting, hex};
use crate::data;
use crate::messages::GetJobRequest;
use crate::program::{PROGRAM, Program};
use crate::rpc;
use crate::support::{NEVER, base, eventually};

const TRACE: &str = "0af7651916cd43dd8448eb211c80319c";
const PARENT: &str = "b7ad6b7169203331";

/// The trace, the span and the flags that an answer names.
fn traced(response: &Response) -> [String; 3] {
    let header = response.headers()["traceresponse"].to_str().unwrap();
    let parts: Vec<_> = header.split('-').map(str::to_owned).collect();
    let [version, trace, span, flags] = parts.try_into().unwrap();
    assert_eq!(
        (version.as_str(), trace.len(), span.len()),
        ("00", 32, 16),
        "{header}"
    );
    [trace, span, flags]
}

fn children<'a>(spans: &'a [Span], of: &Span) -> Vec<&'a Span> {
    let children = spans.iter().filter(|it| it.parent_span_id == of.span_id);
    let children: Vec<_> = children.collect();
    assert!(children.iter().all(|it| it.trace_id == of.trace_id));
    children
}

fn named<'a>(spans: &[&'a Span], name: &str) -> Vec<&'a Span> {
    spans.iter().filter(|it| it.name == name).copied().collect()
}

#[tokio::test]
async fn a_job_is_a_child_of_its_request_and_has_children() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let server = collector.server_with(
        "OTEL_SERVICE_NAME=fits OTEL_RESOURCE_ATTRIBUTES=deployment.environment.name=test",
        folder.path(),
    );
    let job = json!({"name": "one", "curve": {"points": data::wave(3000)}, "stop": {"tolerance": 0, "max_iterations": 30}});
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let response = request.json(&job).send().await.unwrap();
    assert_eq!(response.status(), 201);
    let [trace, span, flags] = traced(&response);
    assert_eq!(flags, "01");
    let job: Value = response.json().await.unwrap();

    let ended = collector.wait_for("job", 1).await.remove(0);
    let request = collector.wait_for("POST /v1/jobs", 1).await.remove(0);
    assert_eq!(
        (hex(&request.trace_id), hex(&request.span_id)),
        (trace, span)
    );
    assert_eq!(request.kind, SpanKind::Server as i32);
    assert!(request.parent_span_id.is_empty());
    for (name, expected) in [
        ("http.request.method", json!("POST")),
        ("http.route", json!("/v1/jobs")),
        ("http.response.status_code", json!(201)),
    ] {
        assert_eq!(attribute(&request, name), expected, "{name}");
    }
    assert_eq!(ended.trace_id, request.trace_id);
    assert_eq!(ended.parent_span_id, request.span_id);
    for (name, expected) in [
        ("piad.job.id", job["id"].clone()),
        ("piad.job.kind", json!("curve")),
        ("piad.job.points", json!(3000)),
        ("piad.job.method", job["method"]["kind"].clone()),
        ("piad.job.state", json!("exhausted")),
        ("piad.job.iterations", json!(30)),
    ] {
        assert_eq!(attribute(&ended, name), expected, "{name} of {job:#}");
    }
    collector.wait_for("store", 2).await;
    let spans = collector.spans();
    let parts = children(&spans, &ended);
    assert_eq!(named(&parts, "set-up").len(), 1);
    let slices = named(&parts, "slice").len();
    assert!(slices >= 1);
    assert_eq!(attribute(&ended, "piad.job.slices"), json!(slices));
    let changes = named(&parts, "store").into_iter();
    let mut changes: Vec<_> = changes
        .map(|it| attribute(it, "piad.store.change"))
        .collect();
    changes.sort_by_key(Value::to_string);
    assert_eq!(changes, ["finish", "insert"]);
    for part in parts {
        assert!(part.start_time_unix_nano >= ended.start_time_unix_nano);
        assert!(part.end_time_unix_nano <= ended.end_time_unix_nano);
    }
    let resource = &collector.resources()[0];
    assert_eq!(resource["service.name"], "fits");
    assert_eq!(resource["deployment.environment.name"], "test");
    assert_eq!(resource["service.version"], env!("CARGO_PKG_VERSION"));

    // The job has ended: what is encoded now is done for the request.
    let path = format!("{}/iterations/7", base(&job));
    let response = server.get(&path).send().await.unwrap();
    let [_, span, _] = traced(&response);
    response.bytes().await.unwrap();
    let encoded = collector.wait_for("encode", 1).await.remove(0);
    assert_eq!(hex(&encoded.parent_span_id), span);
}

/// The request has ended long before the job, which has spans of its first slices only.
#[tokio::test]
async fn an_endless_job_has_spans_of_its_first_slices() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let server = collector.server(folder.path());
    let request = server.post("/v1/jobs").json(&data::endless_job());
    let job: Value = request.send().await.unwrap().json().await.unwrap();
    let request = collector.wait_for("POST /v1/jobs", 1).await.remove(0);
    collector.wait_for("slice", 32).await;
    let iteration = async || server.json(base(&job)).await["iteration"].as_u64();
    let before = iteration().await;
    eventually("it continues", async || iteration().await > before).await;
    let cancel = server.post(&format!("{}/cancel", base(&job)));
    cancel.send().await.unwrap();
    let ended = collector.wait_for("job", 1).await.remove(0);
    assert_eq!(ended.parent_span_id, request.span_id);
    assert!(request.end_time_unix_nano < ended.end_time_unix_nano);
    assert_eq!(attribute(&ended, "piad.job.state"), "cancelled");
    assert!(attribute(&ended, "piad.job.slices").as_i64().unwrap() > 32);
    assert_eq!(collector.wait_for("slice", 32).await.len(), 32);
}

/// A job that waits, of a server that ends; after the next start it is the first span of a trace.
#[tokio::test(flavor = "multi_thread")]
async fn waiting_is_a_span_and_the_end_of_the_process_exports_the_rest() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let variables = "OTEL_BSP_SCHEDULE_DELAY=3600000";
    let mut server = collector.server_with(variables, folder.path());
    let request = server.post("/v1/jobs").json(&data::endless_job());
    let job: Value = request.send().await.unwrap().json().await.unwrap();
    assert_eq!(collector.spans(), []);
    server.signal("-TERM");
    assert!(server.wait().success());
    let ended = collector.wait_for("job", 1).await.remove(0);
    assert_eq!(attribute(&ended, "piad.job.id"), job["id"]);

    let server = collector.server(folder.path());
    let cancel = server.post(&format!("{}/cancel", base(&job)));
    let running = async || server.json(base(&job)).await["state"] == "running";
    eventually("it runs again", running).await;
    cancel.send().await.unwrap();
    let again = collector.wait_for("job", 2).await.remove(1);
    assert_eq!(attribute(&again, "piad.job.id"), job["id"]);
    assert!(again.parent_span_id.is_empty());
    let spans = collector.spans();
    let parts = children(&spans, &again);
    assert_eq!(named(&parts, "queue").len(), 1);
    let started = |it: &&Span| attribute(it, "piad.store.change") == "start";
    assert!(parts.iter().any(started));
}

#[tokio::test]
async fn the_parent_is_that_of_the_client() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let server = collector.server(folder.path());
    let asked = async |parents: &[&str]| {
        let request = parents.iter().fold(server.get("/livez"), |request, it| {
            request.header("traceparent", *it)
        });
        let request = request.header("tracestate", "vendor=1");
        traced(&request.send().await.unwrap())
    };
    let sampled = format!("00-{TRACE}-{PARENT}-01");
    let [trace, span, flags] = asked(&[&sampled]).await;
    assert_eq!((trace.as_str(), flags.as_str()), (TRACE, "01"));
    let got = collector.wait_for("GET /livez", 1).await.remove(0);
    assert_eq!(hex(&got.span_id), span);
    assert_eq!(hex(&got.parent_span_id), PARENT);
    assert_eq!(got.trace_state, "vendor=1");

    // Not to be exported, neither the request nor the job that it makes.
    let unsampled = format!("00-{TRACE}-{PARENT}-00");
    let [trace, _, flags] = asked(&[&unsampled]).await;
    assert_eq!((trace.as_str(), flags.as_str()), (TRACE, "00"));
    let request = server.post("/v1/jobs").json(&data::small_job());
    let request = request.header("prefer", "wait=100");
    let response = request.header("traceparent", &unsampled).send();
    assert_eq!(response.await.unwrap().status(), 201);

    // Invalid contexts have no parent.
    for parents in [
        &["00-0-0-01"][..],
        &[&sampled, &sampled],
        &["00-00000000000000000000000000000000-b7ad6b7169203331-01"],
    ] {
        let [trace, _, flags] = asked(parents).await;
        assert_ne!(trace, TRACE);
        assert_eq!(flags, "01");
    }
    let got = collector.wait_for("GET /livez", 4).await;
    assert_eq!(got.len(), 4);
    assert_eq!(collector.spans().len(), 4);
}

#[tokio::test]
async fn problems_the_log_and_metrics_name_the_trace() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let server = collector.server_with("PIAD_LOG=debug", folder.path());
    let response = server.get("/v1/jobs/none").send().await.unwrap();
    let [trace, span, _] = traced(&response);
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["trace_id"], json!(trace));

    let metrics = server.get("/metrics").send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    let exemplar = format!("# {{trace_id=\"{trace}\",span_id=\"{span}\"}} ");
    let with: Vec<_> = metrics.lines().filter(|it| it.contains(" # {")).collect();
    let bucket = |line: &&str| line.starts_with("piad_http_request_duration_seconds_bucket{");
    assert!(with.iter().all(bucket), "{with:#?}");
    let of_this = with.iter().find(|line| line.contains(&exemplar)).unwrap();
    assert!(of_this.contains("route=\"/v1/jobs/{id}\""), "{of_this}");
    let seconds = of_this.rsplit_once(' ').unwrap().1;
    assert!(seconds.parse::<f64>().unwrap() > 0.0);
    assert!(metrics.ends_with("# EOF\n"));
    let exported = async || {
        let metrics = server.get("/metrics").send().await.unwrap();
        let metrics = metrics.text().await.unwrap();
        let line = |it: &&str| it.starts_with("piad_trace_spans_exported_total ");
        !metrics.lines().find(line).unwrap().ends_with(" 0")
    };
    eventually("spans are counted", exported).await;

    server.fit(&data::small_job()).await;
    collector.wait_for("job", 1).await;
    let logged = async || server.log().contains(&format!("\"trace_id\":\"{trace}\""));
    eventually("the log has the trace", logged).await;
    // The spans of traces are not those of the log.
    assert!(!server.log().contains("\"name\":\"job\""));
    assert!(!server.log().contains("piad::trace"));
}

#[tokio::test]
async fn calls_have_the_status_of_grpc() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let server = collector.server(folder.path());
    let url = format!("http://{}", server.address);
    let mut client = rpc::connect_to(url).await;
    let id = "019aa7a4-6a3c-7c5e-8a55-5b9d2c5f1f10".to_owned();
    let status = client.get_job(GetJobRequest { id }).await.unwrap_err();
    let header = status.metadata().get("traceresponse").unwrap();
    let spans = || collector.spans();
    eventually("a span", async || !spans().is_empty()).await;
    let call = spans().remove(0);
    assert!(header.to_str().unwrap().contains(&hex(&call.span_id)));
    assert!(call.name.starts_with("POST /piad.v1.FittingService/"));
    assert_eq!(attribute(&call, "rpc.grpc.status_code"), json!(5));
}

#[tokio::test]
async fn without_a_collector_nothing_is_different() {
    let folder = tempfile::tempdir().unwrap();
    let server = Program::in_shell(
        "export OTEL_EXPORTER_OTLP_ENDPOINT=http://127.0.0.1:1 OTEL_SDK_DISABLED=true PIAD_LOG=trace; exec \"$@\"",
        folder.path(),
    );
    let request = server.get("/v1/jobs/none");
    let request = request.header("traceparent", format!("00-{TRACE}-{PARENT}-01"));
    let response = request.send().await.unwrap();
    assert!(!response.headers().contains_key("traceresponse"));
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["trace_id"], Value::Null);
    let metrics = server.get("/metrics").send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    assert!(!metrics.contains("piad_trace_") && !metrics.contains(" # {"));
    server.fit(&data::small_job()).await;
    assert!(!server.log().contains("piad::trace"));
    assert!(!server.log().contains("\"trace_id\""));
}

#[tokio::test(flavor = "multi_thread")]
async fn the_standard_variables_hold() {
    let collector = Collector::start().await;
    let folder = tempfile::tempdir().unwrap();
    let start = |more: &str| {
        let url = collector.url();
        let script = format!(
            "export OTEL_EXPORTER_OTLP_ENDPOINT={url} OTEL_BSP_SCHEDULE_DELAY=20 {more}; exec \"$@\""
        );
        Program::in_shell(&script, folder.path())
    };
    let mut server = start("OTEL_TRACES_SAMPLER=always_off");
    let response = server.get("/livez").send().await.unwrap();
    assert_eq!(traced(&response)[2], "00");
    server.fit(&data::small_job()).await;
    server.signal("-TERM");
    assert!(server.wait().success());
    assert_eq!(collector.spans(), []);
    let server = start("PIAD_OTLP_ENDPOINT=");
    let response = server.get("/livez").send().await.unwrap();
    assert!(!response.headers().contains_key("traceresponse"));
    drop(server);
    let server = start("");
    server.get("/livez").send().await.unwrap();
    collector.wait_for("GET /livez", 1).await;
    assert_eq!(collector.resources()[0]["service.name"], "piad");
}

#[tokio::test]
async fn a_collector_behind_tls_must_be_trusted() {
    let (collector, certificate) = Collector::secure().await;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("certificates.pem");
    std::fs::write(&file, certificate).unwrap();
    let trust = format!("SSL_CERT_FILE={}", file.display());
    let server = collector.server_with(&trust, folder.path());
    server.get("/livez").send().await.unwrap();
    let got = collector.wait_for("GET /livez", 1).await;
    drop(server);
    // Trusting others is not enough.
    let (other, _) = Collector::secure().await;
    let server = other.server_with(&trust, folder.path());
    server.get("/livez").send().await.unwrap();
    until_spans_are_lost(&server).await;
    assert_eq!((got.len(), other.spans().len()), (1, 0));
}

/// What is logged, but for times, ids and addresses, in any order.
fn lines(server: &Program) -> Vec<String> {
    let line = |line: &str| {
        let line: Value = serde_json::from_str(line).unwrap();
        let names = |spans: &Value| -> Vec<_> {
            let spans = spans.as_array().into_iter().flatten();
            spans.map(|it| it["name"].clone()).collect()
        };
        let (level, target) = (&line["level"], &line["target"]);
        let message = &line["fields"]["message"];
        format!("{level} {target} {message} {:?}", names(&line["spans"]))
    };
    let log = server.log();
    // How connections end depends on who closes them first.
    let lines = log.lines().map(line);
    let mut lines: Vec<_> = lines
        .filter(|it| !it.contains("piad::server::connection"))
        .collect();
    lines.sort();
    lines
}

#[tokio::test(flavor = "multi_thread")]
async fn the_log_is_the_same_with_and_without_traces() {
    let collector = Collector::start().await;
    let log = "PIAD_LOG=piad=trace,tower_http=trace";
    let run = async |script: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Program::in_shell(script, folder.path());
        server.get("/v1/jobs/none").send().await.unwrap();
        server.fit(&data::small_job()).await;
        server.signal("-TERM");
        assert!(server.wait().success());
        let ended = async || server.log().contains("\"stopped\"");
        eventually("it has said so", ended).await;
        lines(&server)
    };
    let without = run(&format!("export {log}; exec \"$@\"")).await;
    let url = collector.url();
    let with = run(&format!("export {log}; exec \"$@\" --otlp-endpoint {url}")).await;
    assert_eq!(with, without);
    assert!(with.iter().any(|it| it.contains("[String(\"request\")]")));
    collector.wait_for("job", 1).await;
}

#[test]
fn an_address_that_is_none_is_refused_at_the_start() {
    let refused = |flag: &[&str], variable: &str| {
        let mut command = Command::new(PROGRAM);
        command.args(["--listen", "127.0.0.1:0", "--store", ":memory:"]);
        command.env("OTEL_EXPORTER_OTLP_ENDPOINT", variable);
        let output = command.args(flag).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let reported = refused(&["--otlp-endpoint", "localhost:4317"], "");
    assert!(
        reported.starts_with("piad: --otlp-endpoint \"localhost:4317\": "),
        "{reported}"
    );
    assert!(
        reported.contains("such as http://localhost:4317"),
        "{reported}"
    );
    let reported = refused(&[], "http://localhost:4318/v1/traces");
    assert!(
        reported.starts_with("piad: OTEL_EXPORTER_OTLP_ENDPOINT "),
        "{reported}"
    );
    assert!(reported.contains("OTLP over HTTP"), "{reported}");
    for url in [
        "http://me:secret@localhost:4317",
        "http://secret@localhost:4317/v1/traces",
        "http://localhost:4317/?password=secret",
        "http:/me:secret@localhost",
        "me:secret@localhost:4317",
    ] {
        for reported in [refused(&["--otlp-endpoint", url], ""), refused(&[], url)] {
            assert!(
                reported.contains("***") && !reported.contains("secret"),
                "{reported}"
            );
        }
    }
}

async fn until_spans_are_lost(server: &Program) {
    let failed = async || {
        let metrics = server.get("/metrics").send().await.unwrap();
        let metrics = metrics.text().await.unwrap();
        let line = |it: &&str| it.starts_with("piad_trace_spans_failed_total ");
        !metrics.lines().find(line).unwrap().ends_with(" 0")
    };
    eventually("lost spans are counted", failed).await;
}

/// Answers many more requests than the queue has room for, with one thread and with two; ends although an export
/// may take an hour.
async fn is_not_held_up_by(url: &str) {
    for threads in [1, 2] {
        let folder = tempfile::tempdir().unwrap();
        let variables = format!(
            "TOKIO_WORKER_THREADS={threads} OTEL_BSP_MAX_QUEUE_SIZE=50 OTEL_BSP_MAX_EXPORT_BATCH_SIZE=10 \
             OTEL_EXPORTER_OTLP_TIMEOUT=3600000"
        );
        let mut server = exporting(url, &variables, folder.path());
        for _ in 0..300 {
            let response = server.get("/livez").send().await.unwrap();
            assert_eq!(traced(&response)[2], "01");
        }
        let job = server.fit(&data::small_job()).await;
        assert_eq!(job["state"], "converged");
        server.signal("-TERM");
        assert!(server.wait().success());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_dead_collector_holds_nothing_up() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    drop(listener);
    is_not_held_up_by(&url).await;
    let folder = tempfile::tempdir().unwrap();
    let server = exporting(&url, "OTEL_EXPORTER_OTLP_TIMEOUT=1000", folder.path());
    server.get("/livez").send().await.unwrap();
    until_spans_are_lost(&server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_hanging_collector_holds_nothing_up() {
    // The operating system accepts connections that are never read.
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    is_not_held_up_by(&format!("http://{}", listener.local_addr().unwrap())).await;
    // One that reads, and never answers.
    is_not_held_up_by(Collector::slow(NEVER).await.url()).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_slow_collector_holds_nothing_up() {
    let collector = Collector::slow(Duration::from_millis(300)).await;
    is_not_held_up_by(collector.url()).await;
    assert!(!collector.spans().is_empty());
}
