//! What the README shows of `piad fit`, as it is there.

use std::fs;
use std::path::Path;

use crate::support::{Folder, PROGRAM, Told};

#[test]
fn its_second_minute_is_what_a_terminal_shows() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(project.join("README.md")).unwrap();
    let (_, part) = readme.split_once("\n## The second minute").unwrap();
    let (part, _) = part.split_once("\n## ").unwrap();
    let mut blocks = part.split("```").skip(1).step_by(2);
    let (commands, shown) = (blocks.next().unwrap(), blocks.next().unwrap());
    let folder = Folder::new();
    let examples = fs::read_dir(project.join("examples")).unwrap();
    fs::create_dir(folder.path("examples")).unwrap();
    for example in examples.map(|entry| entry.unwrap().path()) {
        let name = Path::new("examples").join(example.file_name().unwrap());
        if example.is_file() {
            fs::copy(&example, folder.path(name.to_str().unwrap())).unwrap();
        }
    }
    let mut told = String::new();
    for line in commands.lines().filter(|line| line.contains("piad")) {
        let line = line.replace("target/release/piad", PROGRAM);
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &line]).current_dir(folder.path(""));
        let done = Told::of(shell.output().unwrap());
        assert_eq!(done.status, 0, "{}", done.err);
        told += &done.err;
    }
    for line in shown.trim().lines() {
        // How long it takes is another matter, and lines elsewhere are for a bar.
        let (begin, end) = match line.split_once(" in ") {
            Some((begin, rest)) => (begin, rest.split_once(": ").unwrap().1),
            None => (line, ""),
        };
        let is_told = |it: &str| it.starts_with(begin) && it.ends_with(end);
        assert!(told.lines().any(is_told), "{line}\n{told}");
    }
    assert!(folder.read("curve.csv").starts_with(b"t,x,y\n"));
}
