//! `piad store check`, `repair` and `export`: files that are damaged in two hundred ways.
//!
//! Everything read from a damaged file is unchanged, or reported as lost: no number differs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

use crate::data;
use crate::program::{PROGRAM, Program};

/// Jobs of all kinds: with results, without, and one that waits.
async fn store(directory: &Path, in_order: bool) -> Vec<u8> {
    let mut program = Program::start(directory);
    for count in [3, 40, 400, 3000] {
        program.fit(&curve(count)).await;
    }
    program
        .fit(&json!({"surface": {"points": data::peaks(30)}}))
        .await;
    for _ in 0..10 {
        program.fit(&data::small_job()).await;
    }
    let cancelled = endless(&program).await;
    let cancel = program.post(&format!("{cancelled}/cancel"));
    assert!(cancel.send().await.unwrap().status().is_success());
    endless(&program).await;
    match in_order {
        true => program.signal("-TERM"),
        false => program.signal("-KILL"),
    }
    program.wait();
    fs::read(directory.join("piad.redb")).unwrap()
}

fn curve(count: usize) -> Value {
    json!({"curve": {"points": data::wave(count)}, "stop": {"relative_tolerance": 1e-9}})
}

async fn endless(program: &Program) -> String {
    let key = uuid::Uuid::new_v4().to_string();
    let request = program.post("/v1/jobs").header("idempotency-key", key);
    let answer = request.json(&data::endless_job()).send().await.unwrap();
    let job: Value = answer.json().await.unwrap();
    job["links"]["self"].as_str().unwrap().to_owned()
}

fn run(arguments: &[&str]) -> (bool, String) {
    let mut command = Command::new(PROGRAM);
    let Output {
        status,
        stdout,
        stderr,
    } = command.arg("store").args(arguments).output().unwrap();
    let said = [stdout, stderr].concat();
    (status.success(), String::from_utf8(said).unwrap())
}

/// The files that a store is exported to.
fn exported(store: &str, whole: bool) -> BTreeMap<String, Vec<u8>> {
    let directory = tempfile::tempdir().unwrap();
    let (done, said) = run(&["export", store, directory.path().to_str().unwrap()]);
    assert_eq!(done, whole, "{said}");
    let files = fs::read_dir(directory.path()).unwrap();
    let files = files.map(|entry| entry.unwrap());
    let name = |entry: &fs::DirEntry| entry.file_name().into_string().unwrap();
    files
        .map(|entry| (name(&entry), fs::read(entry.path()).unwrap()))
        .collect()
}

/// How many files of each kind of end there were.
#[derive(Debug, Default)]
struct Counts {
    whole: usize,
    repaired: usize,
    refused: usize,
    jobs_lost: usize,
}

/// Checks, exports and repairs a file that is damaged in this way.
fn salvage(
    directory: &Path,
    damaged: &[u8],
    before: &BTreeMap<String, Vec<u8>>,
    undone: usize,
    counts: &mut Counts,
    what: &str,
) {
    let store = directory.to_str().unwrap();
    let path = directory.join("piad.redb");
    fs::write(&path, damaged).unwrap();
    let (is_whole, said) = run(&["check", store]);
    assert_eq!(fs::read(&path).unwrap(), damaged, "{what}: it was changed");
    assert_eq!(
        said.contains("nothing is damaged"),
        is_whole,
        "{what}: {said}"
    );
    let files = exported(store, is_whole);
    for (name, bytes) in &files {
        assert!(
            before.get(name) == Some(bytes),
            "{what}: {name} is another one"
        );
    }
    let inputs = |files: &BTreeMap<String, Vec<u8>>| {
        files.keys().filter(|name| !name.contains("result")).count()
    };
    let (kept, all) = (inputs(&files), inputs(before));
    if is_whole {
        assert!(files.len() + undone >= before.len(), "{what}: {said}");
        counts.whole += 1;
        return;
    }
    let (repaired, said) = run(&["repair", store]);
    assert_eq!(repaired, kept > 0, "{what}: {said}");
    if !repaired {
        assert!(said.contains("restore it from a backup"), "{what}: {said}");
        assert_eq!(fs::read(&path).unwrap(), damaged, "{what}: it was changed");
        counts.refused += 1;
        return;
    }
    assert!(said.contains("is repaired"), "{what}: {said}");
    assert!(said.contains(&format!("{kept} ")), "{what}: {said}");
    assert_eq!(fs::read(directory.join("piad.damaged")).unwrap(), damaged);
    assert!(exported(store, true) == files, "{what}: {said}");
    fs::remove_file(directory.join("piad.damaged")).unwrap();
    counts.repaired += 1;
    counts.jobs_lost += all - kept;
}

/// Numbers that look random and are the same each time (xorshift).
fn numbers() -> impl FnMut(usize) -> usize {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    move |below| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn intact_parts_of_damaged_files_are_kept() {
    damage_in_a_hundred_ways(true).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn intact_parts_of_files_damaged_after_a_crash_are_kept() {
    damage_in_a_hundred_ways(false).await;
}

async fn damage_in_a_hundred_ways(in_order: bool) {
    const PAGE: usize = 4096;
    let (mut counts, mut below) = (Counts::default(), numbers());
    let directory = tempfile::tempdir().unwrap();
    let file = store(directory.path(), in_order).await;
    let before = exported(directory.path().to_str().unwrap(), true);
    assert!(before.len() > 25, "{}", before.len());
    // After a crash, a damaged last commit is taken for one that was cut off, and has not happened.
    let undone = if in_order { 0 } else { 1 };
    // Where something stands.
    let used: Vec<usize> = (0..file.len() / PAGE)
        .filter(|page| file[page * PAGE..][..PAGE].iter().any(|byte| *byte != 0))
        .collect();
    let mut try_file = |damaged: &[u8], what: &str| {
        salvage(
            directory.path(),
            damaged,
            &before,
            undone,
            &mut counts,
            what,
        );
    };
    for _ in 0..60 {
        let at = used[below(used.len())] * PAGE + below(PAGE);
        let (bit, mut flipped) = (below(8), file.clone());
        flipped[at] ^= 1 << bit;
        try_file(&flipped, &format!("bit {bit} of byte {at} flipped"));
    }
    for _ in 0..20 {
        let page = used[below(used.len())];
        let mut zeroed = file.clone();
        zeroed[page * PAGE..][..PAGE].fill(0);
        try_file(&zeroed, &format!("page {page} zeroed"));
    }
    for k in 0..20 {
        let length = match k {
            0 => 0,
            k => (file.len() * k / 20).saturating_sub(below(2 * PAGE)),
        };
        try_file(
            &file[..length],
            &format!("{length} bytes of {}", file.len()),
        );
    }
    eprintln!("{counts:?}");
    let Counts {
        whole,
        repaired,
        refused,
        ..
    } = counts;
    assert!(whole > 0 && repaired > 25 && refused > 0, "{counts:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_repaired_store_serves_the_intact_parts() {
    let directory = tempfile::tempdir().unwrap();
    let mut program = Program::start(directory.path());
    let first = program.fit(&curve(500)).await;
    let second = program.fit(&curve(700)).await;
    let result = async |program: &Program, job: &Value| {
        program.json(job["links"]["result"].as_str().unwrap()).await
    };
    let kept = result(&program, &second).await;
    program.signal("-TERM");
    program.wait();
    // The first result has another number.
    let path = directory.path().join("piad.redb");
    let mut file = fs::read(&path).unwrap();
    let id = uuid::Uuid::parse_str(first["id"].as_str().unwrap()).unwrap();
    let mark = [b"\x89piadjobr".as_slice(), id.as_bytes()].concat();
    let places: Vec<usize> = (0..file.len() - mark.len())
        .filter(|&at| file[at..].starts_with(&mark))
        .collect();
    assert!(!places.is_empty());
    for at in places {
        file[at + 2000] ^= 1;
    }
    fs::write(&path, &file).unwrap();
    let store = directory.path().to_str().unwrap();
    let (whole, said) = run(&["check", store]);
    assert!(!whole && said.contains(&id.to_string()), "{said}");
    assert!(
        said.contains("2 jobs can be read, 1 of them without the result"),
        "{said}"
    );
    let (repaired, said) = run(&["repair", store]);
    assert!(repaired, "{said}");
    let program = Program::start(directory.path());
    assert_eq!(result(&program, &second).await, kept);
    // It runs again, to the same end.
    let events = program.get(first["links"]["events"].as_str().unwrap());
    let events = events.send().await.unwrap().text().await.unwrap();
    assert!(events.contains(r#""state":"converged""#), "{events}");
    let list = program.json("/v1/jobs").await;
    assert_eq!(list["jobs"].as_array().unwrap().len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn intact_used_or_missing_stores_are_reported() {
    let directory = tempfile::tempdir().unwrap();
    let store = directory.path().to_str().unwrap();
    for command in ["check", "repair"] {
        let (done, said) = run(&[command, store]);
        assert!(!done && said.contains("piad.redb"), "{said}");
        let (done, said) = run(&[command, ":memory:"]);
        assert!(!done, "{said}");
    }
    let mut program = Program::start(directory.path());
    let job = program.fit(&data::small_job()).await;
    for command in ["check", "repair"] {
        let (done, said) = run(&[command, store]);
        assert!(!done && said.contains("in use"), "{said}");
    }
    program.signal("-TERM");
    program.wait();
    for command in ["check", "repair"] {
        let (done, said) = run(&[command, store]);
        assert!(
            done && said.contains("1 job can be read, nothing is damaged"),
            "{said}"
        );
    }
    let files = exported(store, true);
    let id = job["id"].as_str().unwrap();
    let input: Value = serde_json::from_slice(&files[&format!("{id}.json")]).unwrap();
    let result: Value = serde_json::from_slice(&files[&format!("{id}.result.json")]).unwrap();
    assert_eq!(result["id"], json!(id));
    // What was exported can be posted again.
    let program = Program::start(directory.path());
    let again = program.fit(&input).await;
    let again = program
        .json(again["links"]["result"].as_str().unwrap())
        .await;
    assert_eq!(again["control_points"], result["control_points"]);
}
