//! `kill -9` at random moments under load: nothing that was acknowledged is lost, repeated or changed, and streams
//! resume.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinSet;

use crate::load::{all_jobs, random, undisturbed, work};
use crate::program::Program;

/// How often the server is killed; `PIAD_TEST_KILLS` sets another number.
fn kills() -> usize {
    let set = std::env::var("PIAD_TEST_KILLS");
    set.map_or(10, |kills| {
        kills.parse().expect("PIAD_TEST_KILLS is a number")
    })
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn kills_lose_nothing() {
    let expected = Arc::new(undisturbed().await);
    let data = tempfile::tempdir().unwrap();
    let (place, address) = watch::channel(None);
    let mut workers = JoinSet::new();
    for worker in 0..6 {
        workers.spawn(work(worker, Arc::clone(&expected), address.clone()));
    }
    let mut state = 2006;
    for kill in 0..kills() {
        let mut program = Program::with(data.path(), &["--retain-jobs", "1000000"]);
        place.send_replace(Some(program.address.clone()));
        // What is running in three crashes is given up: every second life is long enough for all
        // that was there to end.
        if kill % 2 == 1 {
            everything_ends(&program).await;
        }
        let life = random(&mut state, 300);
        tokio::time::sleep(Duration::from_millis(life)).await;
        place.send_replace(None);
        program.kill();
    }
    let program = Program::with(data.path(), &["--retain-jobs", "1000000"]);
    place.send_replace(Some(program.address.clone()));
    // Workers finish their current job and end when the sender of addresses is dropped.
    drop(place);
    let paths: Vec<String> = workers.join_all().await.concat();
    assert!(paths.len() >= 2 * kills(), "only {} jobs", paths.len());
    let acknowledged: HashSet<String> = paths.iter().cloned().collect();
    assert_eq!(acknowledged.len(), paths.len());
    assert_eq!(
        all_jobs(&program.client, &format!("http://{}", program.address)).await,
        acknowledged,
        "none lost, none twice"
    );
    eprintln!("{} kills, {} jobs", kills(), paths.len());
}

/// Waits until the jobs that the server found at its start have ended.
async fn everything_ends(program: &Program) {
    for state in ["queued", "running"] {
        let list = program
            .json(&format!("/v1/jobs?limit=1000&state={state}"))
            .await;
        for job in list["jobs"].as_array().unwrap() {
            let path = job["links"]["self"].as_str().unwrap();
            while program.json(path).await["finished_at"].is_null() {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        }
    }
}
