//! The words of comments and texts.

use std::fs;
use std::path::Path;

/// Private words, separated by commas, and what to write instead. Names in backquotes do not count.
const PRIVATE: [(&str, &str); 8] = [
    ("Whether", "True if, Returns true if"),
    ("told,tells,foretold", "reported, returned, predicted"),
    ("so many", "this many, the number of"),
    ("nobody,whoever,for whom", "the client, the tenant, a task"),
    ("goes on,go on,comes again", "continues, restarts"),
    ("broke off,breaks off", "disconnects"),
    ("in the end,for ever", "at the end, forever"),
    ("mistake,mistakes,asked for", "error, requested"),
];

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

/// Adds the private words of each file below a folder.
fn find(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            find(&path, found);
            continue;
        }
        for (k, line) in (1..).zip(words(&fs::read_to_string(&path).unwrap())) {
            let lines = [line.to_lowercase(), line];
            let has = |word: &&str| lines.iter().any(|it| it.contains(&format!(" {word} ")));
            for (words, better) in PRIVATE {
                let bad = words.split(',').filter(has);
                found.extend(bad.map(|it| format!("{}:{k}: {it}: {better}", path.display())));
            }
        }
    }
}

#[test]
fn comments_and_messages_have_no_private_words() {
    let mut found = Vec::new();
    for folder in super::CRATES {
        find(Path::new(folder), &mut found);
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
