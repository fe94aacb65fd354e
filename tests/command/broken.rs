//! Event streams that disconnect.

use serde_json::Value;

use crate::remote::Server;
use crate::support::{Finished, Folder, curve};
use crate::tls_proxy::{Break, TlsProxy};

/// The end of the first whole event of an iteration, with a part of what follows it.
fn after_an_iteration(answer: &[u8]) -> Option<usize> {
    let event = find(answer, b"{\"event\":\"iteration\"")?;
    let length = answer[event..].iter().position(|byte| *byte == b'\n')?;
    Some(event + length + 1)
}

/// In the middle of the first event, which describes the job.
fn inside_of_the_job(answer: &[u8]) -> Option<usize> {
    Some(find(answer, b"{\"event\":\"job\"")? + 20).filter(|end| *end <= answer.len())
}

fn find(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len()).position(|it| it == part)
}

/// Many slow iterations, which take longer than all connections that break.
const SLOW: [&str; 8] = [
    "--method",
    "weighted",
    "--set",
    "method.omega=0.002",
    "--tolerance",
    "1e-9",
    "--max-iterations",
    "50000",
];

/// What a fit behind a proxy whose connections break so gives, beside a fit in the process.
fn same_behind(proxy: impl Fn(&str, &[Break]) -> TlsProxy, breaks: &[Break]) -> (String, String) {
    let folder = Folder::new();
    // Large enough that it runs while connections break.
    folder.write("curve.csv", &curve(300));
    let server = Server::start(&folder);
    let proxy = proxy(&server.1, breaks);
    folder.write("authorities.pem", &proxy.authority);
    let here = folder.result(&[&["curve.csv"], &SLOW[..]].concat());
    let mut command = folder.command(&["fit", "curve.csv", "--server", &proxy.url]);
    command.args(SLOW);
    command.env("SSL_CERT_FILE", folder.path("authorities.pem"));
    let finished = Finished::of(command.output().unwrap());
    assert_eq!(finished.status, 0, "{}", finished.err);
    let there = finished.json();
    for part in ["control_points", "error", "iteration"] {
        assert_eq!(here[part], there[part]);
    }
    proxy.seen()
}

/// The numbers of the iterations that have gone through.
fn iterations(answered: &str) -> Vec<u64> {
    let events = answered
        .lines()
        .filter(|line| line.starts_with("{\"event\":\"iteration\""));
    let events = events.map(|line| serde_json::from_str::<Value>(line).unwrap());
    events
        .map(|event| event["data"]["iteration"].as_u64().unwrap())
        .collect()
}

#[test]
fn a_broken_stream_resumes_after_its_last_iteration() {
    for proxy in [TlsProxy::that_breaks, TlsProxy::plain_that_breaks] {
        let breaks: [Break; 4] = [
            after_an_iteration,
            inside_of_the_job,
            after_an_iteration,
            inside_of_the_job,
        ];
        let (asked, answered) = same_behind(proxy, &breaks);
        let posts = asked.matches("POST /v1/jobs/stream?").count();
        assert_eq!(posts, 1, "{asked}");
        // Each time from the last iteration on that had come.
        let seen = iterations(&answered);
        let resumed: Vec<u64> = asked
            .split("&last_event_id=")
            .skip(1)
            .map(|rest| rest.split(' ').next().unwrap().parse().unwrap())
            .collect();
        assert_eq!(resumed, [seen[0], seen[0], seen[1], seen[1]], "{asked}");
        assert!(
            seen.is_sorted_by(|before, after| before < after),
            "{seen:?}"
        );
    }
}

#[test]
fn a_stream_that_breaks_before_the_job_is_known_is_a_failure() {
    let folder = Folder::with_curve();
    let server = Server::start(&folder);
    let proxy = TlsProxy::plain_that_breaks(&server.1, &[inside_of_the_job]);
    let finished = folder.fit(&["curve.csv", "--server", &proxy.url]);
    assert_eq!(finished.status, 1);
    assert!(
        finished.err.contains("the event stream was interrupted"),
        "{}",
        finished.err
    );
}
