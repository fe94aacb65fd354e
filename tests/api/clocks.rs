//! Clocks of machines that are behind, and are set right: what has just been computed is not old.
//!
//! They need libfaketime; without it they check nothing.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::Value;
use tokio::time::sleep;

use crate::data::small_job;
use crate::database;
use crate::program::Program;
use crate::support::base;

/// The library that sets the clock of a program.
fn library() -> Option<PathBuf> {
    let places = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu"];
    let library = |place| Path::new(place).join("faketime/libfaketimeMT.so.1");
    places.into_iter().map(library).find(|path| path.exists())
}

/// A server whose clock is as a file says.
fn start(library: &Path, clock: &Path, store: &Path) -> Program {
    let (library, clock) = (library.display(), clock.display());
    let script = format!(
        "export LD_PRELOAD={library} FAKETIME_TIMESTAMP_FILE={clock} FAKETIME_NO_CACHE=1 \
         DONT_FAKE_MONOTONIC=1; exec \"$@\""
    );
    Program::in_shell(&script, store)
}

/// A job with a key, and whether it was there already.
async fn fit(program: &Program, key: &str) -> (Value, bool) {
    let request = program.post("/v1/jobs").header("idempotency-key", key);
    let request = request.header("prefer", "wait=100");
    let answer = request.json(&small_job()).send().await.unwrap();
    assert_eq!(answer.status(), 201);
    let replayed = answer.headers().contains_key("idempotency-replayed");
    (answer.json().await.unwrap(), replayed)
}

/// The retention looks at the jobs when others end.
async fn others_end(program: &Program) {
    for _ in 0..2 {
        program.fit(&small_job()).await;
        sleep(Duration::from_millis(500)).await;
    }
}

async fn is_there(program: &Program, job: &Value) -> bool {
    program.get(base(job)).send().await.unwrap().status() == 200
}

#[tokio::test(flavor = "multi_thread")]
async fn a_clock_that_is_set_right_makes_nothing_old() {
    let Some(library) = library() else { return };
    for behind in ["-8d", "+8d"] {
        let data = tempfile::tempdir().unwrap();
        let clock = data.path().join("clock");
        fs::write(&clock, behind).unwrap();
        let program = start(&library, &clock, &data.path().join("jobs"));
        let (job, _) = fit(&program, "key").await;
        fs::write(&clock, "+0").unwrap();
        others_end(&program).await;
        assert!(is_there(&program, &job).await, "{behind}");
        let (again, replayed) = fit(&program, "key").await;
        assert!(replayed && again["id"] == job["id"], "{behind}");
    }
}

/// A replica of a database whose own clock is behind.
#[tokio::test(flavor = "multi_thread")]
async fn the_clock_of_the_database_determines_ages() {
    let Some(library) = library() else { return };
    let data = tempfile::tempdir().unwrap();
    let url = database::new();
    let right = Program::with_store(Path::new(&url));
    for off in ["-8d", "+8d"] {
        let clock = data.path().join("clock");
        fs::write(&clock, off).unwrap();
        let wrong = start(&library, &clock, Path::new(&url));
        let (job, _) = fit(&wrong, off).await;
        others_end(&right).await;
        others_end(&wrong).await;
        for program in [&right, &wrong] {
            assert!(is_there(program, &job).await, "{off}");
            let (again, replayed) = fit(program, off).await;
            assert!(replayed && again["id"] == job["id"], "{off}");
        }
    }
}
