//! What the image is built from (`Dockerfile`), and what is in it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::PROGRAM;

const PROJECT: &str = env!("CARGO_MANIFEST_DIR");

fn text_of(name: &str) -> String {
    fs::read_to_string(Path::new(PROJECT).join(name)).unwrap()
}

/// The places in the project that the Dockerfile copies.
fn copied() -> Vec<PathBuf> {
    let text = text_of("Dockerfile");
    let lines = text.lines().filter_map(|line| line.strip_prefix("COPY "));
    let lines = lines.filter(|line| !line.starts_with("--from="));
    let sources = lines.flat_map(|line| {
        let mut sources: Vec<&str> = line.split_whitespace().collect();
        sources.pop();
        sources
    });
    sources.map(PathBuf::from).collect()
}

/// True if a file is part of the build of the image.
fn is_there(file: &Path) -> bool {
    let ignored = text_of(".dockerignore");
    assert!(!ignored.contains(['*', '!', '?']), "the test knows paths");
    let mut ignored = ignored.lines().filter(|line| !line.is_empty());
    copied().iter().any(|source| file.starts_with(source))
        && !ignored.any(|line| file.starts_with(line))
}

/// The files of the project that this program was built from: those that the compiler has noted beside
/// what it made, and those that the build script has finished. Cargo itself writes one note of all only for
/// `cargo build`, not for tests.
fn sources() -> BTreeSet<PathBuf> {
    let mut files = compiled();
    files.extend(embedded());
    let inside = files.into_iter().filter_map(|file| {
        let file = Path::new(PROJECT).join(file);
        let inside = file.strip_prefix(PROJECT).ok()?;
        // Older notes may name files that are gone.
        (!inside.starts_with("target") && file.is_file()).then(|| inside.to_owned())
    });
    inside.collect()
}

/// What the compiler has read.
fn compiled() -> Vec<PathBuf> {
    let made = Path::new(PROGRAM).parent().unwrap().join("deps");
    let notes = fs::read_dir(&made).unwrap().filter_map(|entry| {
        let path = entry.unwrap().path();
        let unit = path.file_name()?.to_str()?.strip_suffix(".d")?;
        // Checks leave notes as well, of files that they alone read.
        let is_there = |name: &str| made.join(name).exists();
        let is_built = is_there(unit) || is_there(&format!("lib{unit}.rlib"));
        (unit.starts_with("piad-") && is_built).then(|| fs::read_to_string(&path).unwrap())
    });
    notes.flat_map(|note| noted(&note)).collect()
}

/// The files that a note of the compiler names.
fn noted(note: &str) -> Vec<PathBuf> {
    let (_, files) = note.lines().next().unwrap().split_once(": ").unwrap();
    let files = files.replace("\\ ", "\0");
    let files = files.split_whitespace();
    files.map(|file| file.replace('\0', " ").into()).collect()
}

/// What the build script has made part of the program.
fn embedded() -> Vec<PathBuf> {
    let finished = Path::new(env!("OUT_DIR")).with_file_name("output");
    let finished = fs::read_to_string(finished).unwrap();
    let files = finished.lines();
    let files = files.filter_map(|line| line.strip_prefix("cargo::rerun-if-changed="));
    files.map(PathBuf::from).collect()
}

#[test]
fn all_that_the_program_is_built_from_is_copied() {
    let mut sources = sources();
    for file in ["src/main.rs", "src/lib.rs", "viewer/dist/app.js"] {
        assert!(sources.contains(Path::new(file)), "{file}");
    }
    let by_cargo = ["Cargo.toml", "Cargo.lock", "build.rs", "proto"];
    sources.extend(by_cargo.map(PathBuf::from));
    for file in sources {
        assert!(is_there(&file), "{}", file.display());
    }
    // The page is copied as it is served.
    for file in ["viewer/src/app.ts", "README.md", "target/debug/piad"] {
        assert!(!is_there(Path::new(file)), "{file}");
    }
}

#[test]
fn the_image_trusts_the_authorities_of_its_build() {
    let text = text_of("Dockerfile");
    let (_, image) = text.split_once("FROM scratch").unwrap();
    let authorities = "/etc/ssl/certs/ca-certificates.crt";
    let copied = format!("COPY --from=build {authorities} {authorities}\n");
    assert!(image.contains(&copied));
}
