//! A database that is restarted, and that is away.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::database;

/// A PostgreSQL cluster of its own, which can be stopped.
pub struct Cluster {
    script: Child,
    directory: PathBuf,
}

impl Cluster {
    pub fn start() -> Self {
        let mut script = Command::new("tests/postgres")
            .args(["sh", "-c", "echo $PIAD_TEST_CLUSTER; cat"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut directory = String::new();
        let mut said = BufReader::new(script.stdout.take().unwrap());
        said.read_line(&mut directory).unwrap();
        let directory = directory.trim().into();
        Self { script, directory }
    }

    pub fn socket(&self) -> PathBuf {
        self.directory.join(".s.PGSQL.5432")
    }

    /// Is killed; restarts soon, or on request.
    pub fn stop(&self, stays_away: bool) {
        if stays_away {
            fs::write(self.directory.join("away"), "").unwrap();
        }
        let pid = fs::read_to_string(self.directory.join("data/postmaster.pid"));
        if let Ok(pid) = pid {
            let pid = pid.lines().next().unwrap();
            Command::new("kill").args(["-QUIT", pid]).status().unwrap();
            // Its processes answer until they have got their own signals.
            while stays_away && Path::new("/proc").join(pid).exists() {
                thread::sleep(Duration::from_millis(10));
            }
        }
    }

    /// Runs a statement.
    pub fn run(&self, statement: &str) {
        database::run_in(&self.directory, statement);
    }

    pub fn come_back(&self) {
        fs::remove_file(self.directory.join("away")).unwrap();
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        drop(self.script.stdin.take());
        let _ = self.script.wait();
    }
}
