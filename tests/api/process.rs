//! The program itself: its flags, its signals, its health check.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use futures_util::StreamExt;

use crate::data;
use crate::program::{PROGRAM, Program};
use crate::support::{events, eventually};

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

/// The niceness of the threads of a process with this name prefix, read from the operating system.
fn niceness(process: u32, name: &str) -> Vec<i32> {
    let tasks = std::fs::read_dir(format!("/proc/{process}/task")).unwrap();
    // A thread may end meanwhile.
    let stats =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
    let named = stats.filter(|stat| stat.contains(&format!("({name}-")));
    let nice = named.map(|stat| {
        let (_, numbers) = stat.rsplit_once(')').unwrap();
        numbers.split_whitespace().nth(16).unwrap().parse().unwrap()
    });
    nice.collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn each_lane_and_the_loops_have_their_threads() {
    let program = Program::with(Path::new(":memory:"), &["--workers", "3"]);
    let lanes = [
        ("quick", 0),
        ("wire", 0),
        ("heavy", 5),
        ("long", 5),
        ("loops", 5),
    ];
    for (lane, nice) in lanes {
        // They may not have set it yet.
        eventually(lane, async || {
            niceness(program.id(), &format!("piad-{lane}")) == [nice; 3]
        })
        .await;
    }
}

#[test]
fn help_names_every_flag_and_its_variable() {
    let help = Command::new(PROGRAM).arg("--help").output().unwrap();
    assert!(help.status.success());
    let help = String::from_utf8(help.stdout).unwrap();
    for name in [
        "listen",
        "allowed-host",
        "cors-origin",
        "workers",
        "max-body",
        "max-points",
        "max-iterations",
        "max-jobs",
        "max-jobs-per-peer",
        "max-connections",
        "max-connections-per-peer",
        "store",
        "store-connections",
        "lease",
        "memory",
        "ring",
        "recent",
        "retain-jobs",
        "retain-bytes",
        "retain-age",
        "heartbeat",
        "body-timeout",
        "min-body-rate",
        "header-timeout",
        "idle-timeout",
        "write-timeout",
        "grace",
        "log-format",
        "log",
    ] {
        assert!(help.contains(&format!("--{name} ")), "{name}\n{help}");
        let variable = name.to_uppercase().replace('-', "_");
        // Values are shown, except a URL that may have a password.
        assert!(
            help.contains(&format!("[env: PIAD_{variable}")),
            "{variable}"
        );
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
        vec!["--store", ""],
        vec!["--store", "mysql://db/piad"],
        vec!["--store-connections", "0"],
        vec!["--lease", "0"],
        vec!["--allowed-host", "*example.org"],
        vec!["--trusted-proxy", "10.0.0.0/33"],
        vec!["--cors-origin", "https://cad.example/path"],
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

#[test]
fn the_version_is_printed() {
    let version = Command::new(PROGRAM).arg("--version").output().unwrap();
    let version = String::from_utf8(version.stdout).unwrap();
    // With the commit, if the build knew it.
    let expected = match option_env!("PIAD_BUILD_COMMIT") {
        None | Some("") => concat!("piad ", env!("CARGO_PKG_VERSION")).to_owned(),
        Some(commit) => format!("piad {} ({commit})", env!("CARGO_PKG_VERSION")),
    };
    let lines: Vec<&str> = version.lines().collect();
    assert_eq!(lines[0], expected);
    assert!(
        lines[1].starts_with("features: http, grpc, fit, tls; "),
        "{version}"
    );
    assert_eq!(lines.len(), 2, "{version}");
}

#[tokio::test]
async fn names_are_resolved() {
    let mut child = Command::new(PROGRAM)
        .args(["--listen", "localhost:0", "--store", ":memory:"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let log = BufReader::new(child.stderr.take().unwrap());
    // One line for each of the addresses, all of them on the same port.
    let reported = log.lines().map_while(Result::ok);
    let address = reported
        .filter_map(|line| Some(line.split_once("listening on http://")?.1.to_owned()))
        .next()
        .unwrap();
    let (_, port) = address.rsplit_once(':').unwrap();
    let named = format!("localhost:{port}");
    assert!(health(&named));
    let url = format!("http://{address}/livez");
    let answer = reqwest::get(url).await.unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(answer.status(), 200);
    assert!(!health(&named));
    assert!(!health("no-such-host.invalid:80"));
}

/// As in containers that hide it.
#[tokio::test]
async fn it_starts_without_proc() {
    let hidden = Command::new("unshare")
        .args(["-rm", "mount", "-t", "tmpfs", "none", "/proc"])
        .status();
    if !hidden.is_ok_and(|status| status.success()) {
        eprintln!("hiding /proc is not permitted here");
        return;
    }
    let program = Program::in_shell(
        r#"exec unshare -rm sh -c 'mount -t tmpfs none /proc && exec "$@"' sh "$@""#,
        Path::new(":memory:"),
    );
    let capabilities = program.json("/v1/capabilities").await;
    assert_eq!(capabilities["limits"]["memory_bytes"], 512 << 20);
    let job = program.fit(&data::small_job()).await;
    assert_eq!(job["state"], "converged");
}

/// A group of processes with a limit of memory, which goes away with this.
struct MemoryGroup(PathBuf);

impl MemoryGroup {
    /// A group below that of this process, where that is possible.
    fn new(limit: u64) -> Option<Self> {
        let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
        let own = groups.lines().find_map(|it| it.split_once(":memory:"))?.1;
        let place = format!(
            "/sys/fs/cgroup/memory{own}/piad-test-{}",
            std::process::id()
        );
        std::fs::create_dir(&place).ok()?;
        let group = Self(place.into());
        let limited = std::fs::write(group.0.join("memory.limit_in_bytes"), limit.to_string());
        limited.ok().map(|()| group)
    }
}

impl Drop for MemoryGroup {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// The limit of a group below the one that is mounted counts, as systemd and containers make them.
#[tokio::test]
async fn the_memory_is_that_of_its_own_group() {
    let Some(group) = MemoryGroup::new(512 << 20) else {
        eprintln!("limiting memory is not permitted here");
        return;
    };
    let script = format!("echo $$ > {}/cgroup.procs; exec \"$@\"", group.0.display());
    let program = Program::in_shell(&script, Path::new(":memory:"));
    let capabilities = program.json("/v1/capabilities").await;
    assert_eq!(capabilities["limits"]["memory_bytes"], 256 << 20);
    drop(program);
}
