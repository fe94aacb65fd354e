//! A directory in which the program is run.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_piad");

/// A directory of its own.
pub struct Folder(TempDir);

/// What the program has said, and how it ended.
pub struct Finished {
    pub status: i32,
    pub out: Vec<u8>,
    pub err: String,
}

impl Finished {
    pub fn of(output: Output) -> Self {
        Self {
            status: output.status.code().unwrap(),
            out: output.stdout,
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.out).unwrap_or_else(|_| panic!("{}", self.err))
    }
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder with a curve in it.
    pub fn with_curve() -> Self {
        let folder = Self::new();
        folder.write("curve.csv", &curve(40));
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// The names of the files, in order.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let name = |entry: fs::DirEntry| entry.file_name().into_string().unwrap();
        let mut names: Vec<String> = entries.map(|entry| name(entry.unwrap())).collect();
        names.sort();
        names
    }

    /// The program with these arguments, in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).current_dir(self.0.path());
        command.stdin(Stdio::null());
        command
    }

    pub fn fit(&self, arguments: &[&str]) -> Finished {
        let mut command = self.command(&["fit"]);
        Finished::of(command.args(arguments).output().unwrap())
    }

    /// The result as JSON of a fit that converges.
    #[track_caller]
    pub fn result(&self, arguments: &[&str]) -> Value {
        let finished = self.fit(arguments);
        assert_eq!(finished.status, 0, "{arguments:?}: {}", finished.err);
        finished.json()
    }

    /// The same with a standard input.
    pub fn fit_from(&self, input: &str, arguments: &[&str]) -> Finished {
        let mut command = self.command(&["fit"]);
        command.args(arguments).stdin(Stdio::piped());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(input.as_bytes()).unwrap();
        drop(stdin);
        Finished::of(child.wait_with_output().unwrap())
    }
}

/// Points of a spiral as CSV.
pub fn curve(count: u32) -> String {
    (0..count).fold("x,y\n".to_owned(), |mut text, i| {
        let t = f64::from(i) / 10.0;
        writeln!(text, "{},{}", t.cos() * (1.0 + t / 5.0), t.sin()).unwrap();
        text
    })
}

/// A height field of 6 rows and 5 columns, with something between the rows.
pub fn field(between: &str) -> String {
    let row = |i: u32| {
        let point = |j: u32| format!("{i} {j} {}\n", f64::from(i * j).sin());
        (0..5).map(point).collect::<String>()
    };
    (0..6).map(row).collect::<Vec<_>>().join(between)
}
