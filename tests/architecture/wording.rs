//! The words of comments and texts.

use std::fs;
use std::path::Path;

/// Lines of words, separated by commas, a colon and what to write instead. Names in backquotes do not count.
const AVOIDED: &str = include_str!("../words.txt");

/// Folders of Rust files besides the crates.
const OTHERS: [&str; 4] = ["benches", "fuzz/decoders", "fuzz/fuzz_targets", "tests"];

/// The words of the comments and string literals of each line.
fn words(text: &str) -> Vec<String> {
    let (mut in_string, mut lines) = (false, Vec::new());
    for line in text.replace("\\\\", "").replace("'\"'", "").lines() {
        let line = line.replace("\\\"", "");
        let in_comment = !in_string && line.trim_start().starts_with("//");
        let mut prose = String::new();
        for (k, part) in line.split('"').enumerate() {
            in_string ^= k > 0 && !in_comment;
            prose += if in_string || in_comment { part } else { " " };
        }
        let unnamed = prose.split('`').step_by(2).collect::<Vec<_>>().join("`");
        let is_other = |it: char| !it.is_alphanumeric() && it != '_';
        lines.push(format!(" {} ", unnamed.replace(is_other, " ")));
    }
    lines
}

/// The words of each line, and what to write instead.
fn avoided() -> impl Iterator<Item = (&'static str, &'static str)> {
    let lines = AVOIDED.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| line.split_once(": "))
}

/// Adds the avoided words of each file below a folder.
fn find(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            find(&path, found);
        }
        if path.extension().is_none_or(|it| it != "rs") {
            continue;
        }
        for (k, line) in (1..).zip(words(&fs::read_to_string(&path).unwrap())) {
            let lines = [line.to_lowercase(), line];
            let has = |word: &&str| lines.iter().any(|it| it.contains(&format!(" {word} ")));
            for (words, better) in avoided() {
                let bad = words.split(", ").filter(has);
                found.extend(bad.map(|it| format!("{}:{k}: {it}: {better}", path.display())));
            }
        }
    }
}

#[test]
fn comments_and_messages_avoid_words() {
    let mut found = Vec::new();
    for folder in super::CRATES.into_iter().chain(OTHERS) {
        find(Path::new(folder), &mut found);
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
