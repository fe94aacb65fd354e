//! Servers on Unix domain sockets, beside ports.

use std::fs;
use std::io::Write;
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::path::Path;
use std::process::{Command, Stdio};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::UnixStream;

use crate::program::{PROGRAM, Program};
use crate::support::eventually;

/// Asks for something on a socket, and gives the whole answer.
async fn ask(socket: &Path, request: &str) -> String {
    let mut stream = UnixStream::connect(socket).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer
}

const READY: &str = "GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";

fn is_socket(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|it| it.file_type().is_socket())
}

#[tokio::test]
async fn a_socket_is_served_beside_a_port() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("piad.sock");
    let place = format!("unix:{}", socket.display());
    let mut server = Program::with(folder.path(), &["--listen", &place]);
    assert_eq!(server.get("/readyz").send().await.unwrap().status(), 200);
    let answer = ask(&socket, READY).await;
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    // As on a loopback address, names of others are refused.
    let answer = ask(
        &socket,
        &READY
            .replace("localhost", "evil.example")
            .replace("/readyz", "/v1/jobs"),
    )
    .await;
    assert!(answer.starts_with("HTTP/1.1 421"), "{answer}");

    let health = |places: &str| {
        let mut command = Command::new(PROGRAM);
        command
            .args(["health", "--listen", places])
            .output()
            .unwrap()
    };
    assert!(health(&place).status.success());
    assert!(health(&format!("127.0.0.1:1,{place}")).status.success());

    // One server for each socket.
    let other = tempfile::tempdir().unwrap();
    let refused = refused(&place, other.path());
    assert!(refused.contains("in use"), "{refused}");

    // What a killed one has left is replaced, and removed by one that ends.
    server.kill();
    assert!(is_socket(&socket));
    let output = health(&place);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains(&place), "{said}");
    let mut server = Program::with(folder.path(), &["--listen", &place]);
    let answer = ask(&socket, READY).await;
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    server.signal("-TERM");
    assert!(server.wait().success());
    assert!(!socket.exists());
}

#[test]
fn files_that_are_no_sockets_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("notes");
    fs::write(&file, "mine").unwrap();
    let refused = refused(&format!("unix:{}", file.display()), folder.path());
    assert!(refused.contains("notes"), "{refused}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[tokio::test]
async fn a_server_ends_with_its_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("made");
    let socket = directory.join("piad.sock");
    let mut command = Command::new(PROGRAM);
    command.args(["--exit-with-stdin", "--store", ":memory:", "--listen"]);
    command.arg(format!("unix:{}", socket.display()));
    let mut server = command.stdin(Stdio::piped()).spawn().unwrap();
    eventually("it listens", async || socket.exists()).await;
    let mode = fs::metadata(&directory).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o700);
    let mut input = server.stdin.take().unwrap();
    input.write_all(b"ignored").unwrap();
    let answer = ask(&socket, READY).await;
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    assert!(server.try_wait().unwrap().is_none());
    drop(input);
    assert!(server.wait().unwrap().success());
    assert!(!directory.exists());
}

#[test]
fn only_the_directory_of_a_socket_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("a/b/piad.sock");
    let refused = refused(&format!("unix:{}", socket.display()), folder.path());
    assert!(refused.contains("cannot listen"), "{refused}");
}

/// What a server says that cannot listen there.
fn refused(place: &str, data: &Path) -> String {
    let mut command = Command::new(PROGRAM);
    command.args(["--listen", place, "--store"]);
    let output = command.arg(data).output().unwrap();
    assert!(!output.status.success());
    String::from_utf8_lossy(&output.stderr).into_owned()
}
