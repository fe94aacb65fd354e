//! The program itself: its flags, its signals, its health check.

use std::path::Path;
use std::process::Command;

use futures_util::StreamExt;

use crate::data;
use crate::program::{PROGRAM, Program};
use crate::support::events;

fn health(address: &str) -> bool {
    let check = Command::new(PROGRAM)
        .args(["health", "--listen", address])
        .output()
        .unwrap();
    check.status.success()
}

#[tokio::test(flavor = "multi_thread")]
async fn signals_end_it_with_open_streams() {
    for signal in ["-TERM", "-INT"] {
        let mut program = Program::start(Path::new(":memory:"));
        assert!(health(&program.address));
        let mut streams = Vec::new();
        for _ in 0..3 {
            let request = program
                .post("/v1/jobs")
                .header("accept", "text/event-stream")
                .json(&data::endless_job());
            let mut stream = events(request.send().await.unwrap());
            stream.next().await.unwrap();
            streams.push(stream);
        }
        program.signal(signal);
        assert_eq!(program.wait().code(), Some(0));
        assert!(!health(&program.address));
    }
}

#[test]
fn help_names_every_flag_and_its_variable() {
    let help = Command::new(PROGRAM).arg("--help").output().unwrap();
    assert!(help.status.success());
    let help = String::from_utf8(help.stdout).unwrap();
    for name in [
        "listen",
        "workers",
        "max-body",
        "max-points",
        "max-iterations",
        "max-jobs",
        "max-jobs-per-peer",
        "max-connections",
        "max-connections-per-peer",
        "data-dir",
        "memory",
        "ring",
        "recent",
        "retain-jobs",
        "retain-bytes",
        "retain-age",
        "heartbeat",
        "body-timeout",
        "header-timeout",
        "idle-timeout",
        "write-timeout",
        "grace",
        "log-format",
        "log",
    ] {
        assert!(help.contains(&format!("--{name} ")), "{name}\n{help}");
        let variable = name.to_uppercase().replace('-', "_");
        assert!(help.contains(&format!("PIAD_{variable}=")), "{variable}");
    }
    assert!(help.contains("health") && help.contains("serve"));
}

#[test]
fn wrong_settings_are_refused() {
    for arguments in [
        vec!["--listen", "nowhere"],
        vec!["--workers", "0"],
        vec!["--max-body", "lots"],
        vec!["--grace", "-1"],
        vec!["--heartbeat", "0"],
        vec!["--log", "="],
        vec!["--retain-age", "long"],
        vec!["--data-dir", ""],
        vec!["--speed", "9"],
        vec!["fly"],
    ] {
        let refused = Command::new(PROGRAM).args(&arguments).output().unwrap();
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(!refused.stderr.is_empty());
    }
}

#[test]
fn a_port_in_use_is_an_error() {
    let program = Program::start(Path::new(":memory:"));
    let second = Command::new(PROGRAM)
        .args(["serve", "--listen", &program.address])
        .output()
        .unwrap();
    assert_eq!(second.status.code(), Some(1));
    let message = String::from_utf8(second.stderr).unwrap();
    assert!(message.contains("cannot listen on"), "{message}");
}
