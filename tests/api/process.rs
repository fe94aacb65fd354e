//! The program itself: its flags, its signals, its health check.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use futures_util::StreamExt;
use serde_json::Value;

use crate::data;
use crate::support::events;

const PROGRAM: &str = env!("CARGO_BIN_EXE_piad");

struct Program {
    child: Child,
    address: String,
}

impl Program {
    /// Starts the server on a free port and waits until it says which.
    fn start() -> Self {
        let mut child = Command::new(PROGRAM)
            .args([
                "--listen",
                "127.0.0.1:0",
                "--log-format",
                "json",
                "--max-iterations",
                "1000000000",
            ])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        log.read_line(&mut line).unwrap();
        let line: Value = serde_json::from_str(&line).unwrap();
        let message = line["fields"]["message"].as_str().unwrap();
        let address = message
            .strip_prefix("listening on http://")
            .unwrap()
            .to_owned();
        // A pipe that nobody reads would fill up.
        std::thread::spawn(move || std::io::copy(&mut log, &mut std::io::sink()));
        Self { child, address }
    }

    fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(
            Command::new("kill")
                .args([name, &id])
                .status()
                .unwrap()
                .success()
        );
    }

    fn wait(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < Duration::from_secs(5), "it does not stop");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // If a test has failed the process is still there.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

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
        let mut program = Program::start();
        assert!(health(&program.address));
        let client = reqwest::Client::new();
        let mut streams = Vec::new();
        for _ in 0..3 {
            let request = client
                .post(format!("http://{}/v1/jobs", program.address))
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
        "memory",
        "ring",
        "retain-jobs",
        "retain-bytes",
        "heartbeat",
        "body-timeout",
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
        vec!["--log", "="],
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
    let program = Program::start();
    let second = Command::new(PROGRAM)
        .args(["serve", "--listen", &program.address])
        .output()
        .unwrap();
    assert_eq!(second.status.code(), Some(1));
    let message = String::from_utf8(second.stderr).unwrap();
    assert!(message.contains("cannot listen on"), "{message}");
}
