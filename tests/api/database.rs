//! The tests with a database instead of a file, if PIAD_TEST_STORE is `database`: each store is a schema of
//! the database that tests/postgres starts.

use std::env;
use std::ffi::OsString;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use piad::config::Storage;
use uuid::Uuid;

/// Jobs of a server that was killed are taken over soon.
pub const LEASE: Duration = Duration::from_secs(1);

/// A schema in place of this store, if the tests are to have one.
pub fn instead_of(store: Storage) -> Storage {
    let data = match &store {
        Storage::Memory => Path::new(":memory:"),
        Storage::Directory(path) => path,
        Storage::Database(_) => return store,
    };
    match is_asked_for() {
        true => Storage::Database(schema(data)),
        false => store,
    }
}

/// The value of --store for a store in a directory.
pub fn argument(data: &Path) -> OsString {
    match is_asked_for() && !data.to_string_lossy().contains("://") {
        true => schema(data).into(),
        false => data.into(),
    }
}

/// The URL of a new schema.
pub fn new() -> String {
    schema(Path::new(":memory:"))
}

fn is_asked_for() -> bool {
    env::var("PIAD_TEST_STORE").is_ok_and(|store| store == "database")
}

/// The URL of the schema for this directory, and of a new one in place of the memory.
fn schema(data: &Path) -> String {
    let name = match data == Path::new(":memory:") {
        true => format!("test_{}", Uuid::new_v4().simple()),
        false => {
            let mut hasher = DefaultHasher::new();
            data.hash(&mut hasher);
            format!("test_{:x}", hasher.finish())
        }
    };
    run(&format!("CREATE SCHEMA IF NOT EXISTS {name}"));
    format!("{}&options[search_path]={name}", url())
}

/// The database that tests/postgres has started.
pub fn url() -> String {
    env::var("PIAD_TEST_DATABASE").expect("PIAD_TEST_DATABASE: these tests run in tests/postgres")
}

/// Runs a statement, and gives what it says.
pub fn run(statement: &str) -> String {
    let cluster = env::var("PIAD_TEST_CLUSTER").expect("PIAD_TEST_CLUSTER");
    run_in(Path::new(&cluster), statement)
}

/// Runs a statement in the cluster of this directory.
pub fn run_in(cluster: &Path, statement: &str) -> String {
    let psql = Command::new("psql")
        .arg("-h")
        .arg(cluster)
        .args(["-U", "piad", "-d", "postgres", "-q", "-t", "-A"])
        .args(["-v", "ON_ERROR_STOP=1", "-c", statement])
        .output()
        .unwrap();
    assert!(
        psql.status.success(),
        "{}",
        String::from_utf8_lossy(&psql.stderr)
    );
    String::from_utf8(psql.stdout).unwrap()
}
