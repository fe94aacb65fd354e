//! The program as a process of its own: started, signalled, killed.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use reqwest::{Client, RequestBuilder};
use serde_json::Value;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::database;
use crate::support::{self, PATIENCE};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_piad");

/// A running server.
pub struct Program {
    child: Child,
    log: Arc<Mutex<String>>,
    pub address: String,
    pub client: Client,
}

impl Program {
    /// Starts a server that keeps its jobs in a directory, on a free port.
    pub fn start(data: &Path) -> Self {
        Self::with(data, &[])
    }

    /// Starts a server with more arguments.
    pub fn with(data: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(arguments);
        Self::launch(command, data)
    }

    /// Starts a server in a shell that prepares its environment; `exec "$@"` is the server.
    pub fn in_shell(script: &str, data: &Path) -> Self {
        let mut command = Command::new("sh");
        command.args(["-c", script, "sh", PROGRAM]);
        Self::launch(command, data)
    }

    fn launch(command: Command, data: &Path) -> Self {
        let started = Self::try_launch(command, data);
        started.unwrap_or_else(|(_, said)| panic!("it has not started: {said}"))
    }

    /// Starts a server; gives its exit code and what it has said if it does not start.
    pub fn attempt(data: &Path) -> Result<Self, (Option<i32>, String)> {
        Self::try_launch(Command::new(PROGRAM), data)
    }

    /// Starts a server with this store, whatever other tests have.
    pub fn with_store(store: &Path) -> Self {
        let started = Self::launch_with(Command::new(PROGRAM), store.as_os_str());
        started.unwrap_or_else(|(_, said)| panic!("it has not started: {said}"))
    }

    fn try_launch(command: Command, data: &Path) -> Result<Self, (Option<i32>, String)> {
        Self::launch_with(command, &database::argument(data))
    }

    fn launch_with(mut command: Command, store: &OsStr) -> Result<Self, (Option<i32>, String)> {
        let mut child = command
            .args(["--listen", "127.0.0.1:0", "--log-format", "json"])
            .args(["--max-iterations", "1000000000"])
            .args([OsStr::new("--store"), store])
            .args(["--lease", &database::LEASE.as_secs().to_string()])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let address = match address(&mut log) {
            Ok(address) => address,
            Err(said) => return Err((child.wait().unwrap().code(), said)),
        };
        // An unread pipe would fill up.
        let lines = Arc::new(Mutex::new(String::new()));
        let kept = Arc::clone(&lines);
        std::thread::spawn(move || {
            for line in log.lines().map_while(Result::ok) {
                *kept.lock().unwrap() += &format!("{line}\n");
            }
        });
        Ok(Self {
            child,
            log: lines,
            address,
            client: support::client().build().unwrap(),
        })
    }

    /// Starts a server that must refuse to start, and gives what it has said.
    pub fn refused(data: &Path) -> Output {
        let mut command = Command::new(PROGRAM);
        command.args(["--listen", "127.0.0.1:0", "--store"]);
        command.arg(data).output().unwrap()
    }

    /// What it has logged since it listens.
    pub fn log(&self) -> String {
        self.log.lock().unwrap().clone()
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The memory that it has, in bytes: its resident size.
    pub fn memory(&self) -> usize {
        self.status("VmRSS:")
    }

    /// The most memory that it has had since it started, or since [`Self::forget_most_memory`].
    pub fn most_memory(&self) -> usize {
        self.status("VmHWM:")
    }

    /// The most memory is counted from now on.
    pub fn forget_most_memory(&self) {
        std::fs::write(format!("/proc/{}/clear_refs", self.id()), "5").unwrap();
    }

    /// A size of the process in bytes, read from the operating system.
    fn status(&self, name: &str) -> usize {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let kib = line.unwrap().trim().strip_suffix(" kB").unwrap();
        1024 * kib.parse::<usize>().unwrap()
    }

    /// A client with a small receive buffer that has sent its request and reads nothing yet.
    pub async fn stalled_client(&self, path: &str) -> TcpStream {
        let socket = tokio::net::TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(4096).unwrap();
        let address = self.address.parse().unwrap();
        let mut stream = socket.connect(address).await.unwrap();
        // In HTTP/1.0 the body is what comes until the end.
        let request = format!("GET {path} HTTP/1.0\r\nHost: localhost\r\n\r\n");
        stream.write_all(request.as_bytes()).await.unwrap();
        stream
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(format!("http://{}{path}", self.address))
    }

    pub fn post(&self, path: &str) -> RequestBuilder {
        self.client.post(format!("http://{}{path}", self.address))
    }

    pub fn delete(&self, path: &str) -> RequestBuilder {
        self.client.delete(format!("http://{}{path}", self.address))
    }

    pub async fn json(&self, path: &str) -> Value {
        let response = self.get(path).send().await.unwrap();
        assert_eq!(response.status(), 200, "{path}");
        response.json().await.unwrap()
    }

    /// Posts a job and waits for its end.
    pub async fn fit(&self, job: &Value) -> Value {
        let request = self.post("/v1/jobs").header("prefer", "wait=100");
        let response = request.json(job).send().await.unwrap();
        assert_eq!(response.status(), 201, "{job}");
        response.json().await.unwrap()
    }

    pub async fn metrics(&self) -> HashMap<String, f64> {
        support::metrics(self.get("/metrics").send().await.unwrap()).await
    }

    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let killed = Command::new("kill").args([name, &id]).status().unwrap();
        assert!(killed.success());
    }

    /// `kill -9`, and waits until it is dead.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits for it to end by itself.
    pub fn wait(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < PATIENCE, "it does not stop");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // If a test has failed the process is still there.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if !std::thread::panicking() {
            support::assert_no_token(&self.log());
        }
    }
}

/// Reads the log up to the line with the address; returns other output instead, without warnings.
fn address(log: &mut impl BufRead) -> Result<String, String> {
    let mut said = String::new();
    loop {
        let mut line = String::new();
        if log.read_line(&mut line).unwrap() == 0 {
            return Err(said);
        }
        let Ok(entry) = serde_json::from_str::<Value>(&line) else {
            said += &line;
            continue;
        };
        let message = entry["fields"]["message"].as_str().unwrap_or(&line);
        let place = message.strip_prefix("listening on ");
        if let Some((_, address)) = place.and_then(|place| place.split_once("://")) {
            return Ok(address.to_owned());
        }
        if entry["level"] == "ERROR" {
            said += &format!("{message}\n");
        }
    }
}
