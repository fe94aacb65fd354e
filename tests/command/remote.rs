//! Fits on a server give what fits in the process give.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::process::{Child, Stdio};

use crate::support::{Finished, Folder, field};

/// The span of the caller of the program.
const PARENT: &str = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

/// A server, and its address.
pub struct Server(Child, pub String);

impl Server {
    pub fn start(folder: &Folder) -> Self {
        let mut command = folder.command(&["--listen", "127.0.0.1:0", "--store", ":memory:"]);
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let mut finished = lines.map_while(Result::ok);
        let line = finished.find(|line| line.contains("listening on")).unwrap();
        let url = line
            .split_once("listening on ")
            .unwrap()
            .1
            .trim()
            .to_owned();
        std::thread::spawn(move || finished.for_each(drop));
        Self(child, url)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

#[test]
fn a_server_gives_the_same_bits() {
    let folder = Folder::with_curve();
    folder.write("field.csv", &field("\n"));
    let job = r#"{"curve": {"points": [[0,0],[1,2],[3,1],[4,3]]}}"#;
    folder.write("job.json", job);
    let server = Server::start(&folder);
    for arguments in [
        vec!["curve.csv"],
        vec!["curve.csv", "--method", "chebyshev", "--degree", "5"],
        vec!["field.csv", "--degree", "3,2"],
        vec!["job.json"],
    ] {
        let here = folder.result(&arguments);
        let there = folder.result(&[arguments.clone(), vec!["--server", &server.1]].concat());
        for part in ["control_points", "knots", "error", "iteration"] {
            assert_eq!(here[part], there[part], "{arguments:?}");
        }
    }
    let finished = folder.fit(&[
        "curve.csv",
        "--server",
        &server.1,
        "-o",
        "a.step",
        "--iterations",
        "all",
    ]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert!(
        finished.err.contains(&format!("job {}/v1/jobs/", server.1)),
        "{}",
        finished.err
    );
    assert!(folder.read("a.step").starts_with(b"ISO-10303-21;"));
    let finished = folder.fit(&["curve.csv", "--server", &server.1, "--degree", "0"]);
    assert_eq!(finished.status, 2);
    assert!(finished.err.starts_with("--degree: "), "{}", finished.err);
}

#[test]
fn a_server_that_is_not_there_is_a_failure() {
    let folder = Folder::with_curve();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    drop(listener);
    let finished = folder.fit(&["curve.csv", "--server", &url]);
    assert_eq!(finished.status, 1);
    assert!(finished.err.contains(&url), "{}", finished.err);
}

#[test]
fn the_token_and_the_parent_are_sent() {
    let folder = Folder::with_curve();
    folder.write("token", "secret-7\n");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/fits/", listener.local_addr().unwrap());
    let door = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut head = Vec::new();
        while !head.windows(4).any(|it| it == b"\r\n\r\n") {
            let mut more = [0; 1024];
            let count = stream.read(&mut more).unwrap();
            head.extend_from_slice(&more[..count]);
        }
        let problem = r#"{"detail": "who are you?"}"#;
        let length = problem.len();
        write!(stream, "HTTP/1.1 401 Unauthorized\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{problem}").unwrap();
        String::from_utf8_lossy(&head).into_owned()
    });
    let mut command = folder.command(&["fit", "curve.csv", "--server", &url]);
    command.args(["--token-file", "token"]);
    command.env("TRACEPARENT", PARENT);
    let finished = Finished::of(command.output().unwrap());
    assert_eq!(
        (finished.status, finished.err.as_str()),
        (1, "piad: who are you?\n")
    );
    let head = door.join().unwrap();
    assert!(head.starts_with("POST /fits/v1/jobs/stream?"), "{head}");
    let head = head.to_lowercase();
    assert!(
        head.contains("authorization: bearer secret-7\r\n"),
        "{head}"
    );
    assert!(
        head.contains(&format!("traceparent: {PARENT}\r\n")),
        "{head}"
    );
}
