//! Store files that are damaged: the program says so in a line, or does without what is damaged.

use std::path::Path;

use serde_json::Value;

use crate::data;
use crate::program::Program;

/// A store with a few jobs, which was closed in order or not.
async fn store(data: &Path, in_order: bool) -> Vec<u8> {
    let mut program = Program::start(data);
    for _ in 0..20 {
        program.fit(&data::small_job()).await;
    }
    match in_order {
        true => program.signal("-TERM"),
        false => program.signal("-KILL"),
    }
    program.wait();
    std::fs::read(data.join("piad.redb")).unwrap()
}

/// Starts the program with this file: it works, or reports the error and a remedy in one line.
async fn try_file(data: &Path, bytes: &[u8], what: &str) -> bool {
    std::fs::write(data.join("piad.redb"), bytes).unwrap();
    match Program::attempt(data) {
        Ok(program) => {
            let list: Value = program.json("/v1/jobs?limit=1000").await;
            for job in list["jobs"].as_array().unwrap() {
                let path = job["links"]["result"].as_str().unwrap();
                let response = program.get(path).send().await.unwrap();
                let status = response.status().as_u16();
                assert!([200, 404, 409, 500].contains(&status), "{what}: {status}");
            }
            true
        }
        Err((code, said)) => {
            assert_eq!(code, Some(1), "{what}: {said}");
            // The database itself may have panicked before.
            let said = said.trim().lines().last().unwrap_or_default();
            for advice in [
                "piad.redb",
                "cannot be opened",
                "restore it",
                "move it away",
            ] {
                assert!(said.contains(advice), "{what}: {said}");
            }
            false
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn damaged_files_are_refused_in_a_line() {
    const PAGE: usize = 4096;
    let data = tempfile::tempdir().unwrap();
    for in_order in [true, false] {
        let whole = store(data.path(), in_order).await;
        assert!(!try_file(data.path(), &[], "an empty file").await);
        for length in [1, 100, 320, PAGE, whole.len() / 3, whole.len() - PAGE] {
            let what = format!("{length} bytes of {}", whole.len());
            // After a crash the file may be longer than what stands in it.
            let works = try_file(data.path(), &whole[..length], &what).await;
            assert!(!works || length > whole.len() / 2, "{what}");
        }
        let mut overwritten = whole.clone();
        overwritten[..PAGE].fill(b'x');
        assert!(!try_file(data.path(), &overwritten, "no header").await);
        let mut overwritten = whole.clone();
        overwritten[PAGE..].fill(0);
        assert!(!try_file(data.path(), &overwritten, "zeros").await);
        // Pages that are in use, at the front of the file.
        let used: Vec<usize> = (1..whole.len() / PAGE)
            .filter(|page| whole[page * PAGE..][..PAGE].iter().any(|byte| *byte != 0))
            .collect();
        let mut refused = 0;
        let pairs = used
            .iter()
            .zip(used.iter().skip(3))
            .step_by(used.len().div_ceil(12));
        for (&one, &other) in pairs {
            let mut swapped = whole.clone();
            let (front, back) = swapped.split_at_mut(other * PAGE);
            front[one * PAGE..][..PAGE].swap_with_slice(&mut back[..PAGE]);
            let what = format!("pages {one} and {other} swapped");
            refused += usize::from(!try_file(data.path(), &swapped, &what).await);
        }
        eprintln!("{refused} files with swapped pages refused");
        std::fs::remove_file(data.path().join("piad.redb")).unwrap();
    }
}

/// A start that was cut off has left an unfinished file behind; there are no jobs in it.
#[tokio::test(flavor = "multi_thread")]
async fn a_file_that_was_never_finished_is_made_anew() {
    let data = tempfile::tempdir().unwrap();
    for leftover in [&b""[..], b"something", &[0; 100_000]] {
        std::fs::write(data.path().join("piad.new"), leftover).unwrap();
        let program = Program::start(data.path());
        assert_eq!(
            program.json("/v1/jobs").await["jobs"],
            serde_json::json!([])
        );
        assert!(!data.path().join("piad.new").exists());
        drop(program);
        std::fs::remove_file(data.path().join("piad.redb")).unwrap();
    }
}
