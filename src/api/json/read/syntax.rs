//! What is no JSON, in plain words.

use serde_json::error::Category;

use crate::api::problem::Kind;

/// How the texts of syntax errors begin, and how they begin in plain words. The texts are all that serde_json tells
/// about an error beyond its [`Category`]: its code is private. Other texts are passed on as they are.
const PLAIN: [(&str, &str); 8] = [
    (
        "EOF while parsing a string",
        "the body ends within a string",
    ),
    ("EOF while parsing a list", "the body ends within a list"),
    (
        "EOF while parsing an object",
        "the body ends within an object",
    ),
    (
        "EOF while parsing a value",
        "the body ends where a value should be",
    ),
    ("expected ident", "expected true, false or null"),
    (
        "trailing characters",
        "something follows the end of the JSON",
    ),
    ("trailing comma", "a comma with nothing after it"),
    (
        "recursion limit exceeded",
        "lists and objects stand within one another too often",
    ),
];

/// What kind of problem it is, and what to say of it.
pub(super) fn explain(body: &[u8], error: &serde_json::Error) -> (Kind, String) {
    let text = error.to_string();
    if body.trim_ascii().is_empty() {
        return (
            Kind::NotJson,
            "the body is empty; a job is expected".to_owned(),
        );
    }
    // 1e999 is JSON, but no 64-bit number.
    if text.starts_with("number out of range") {
        let detail = format!("the {text}: numbers are finite 64-bit floating-point numbers");
        return (Kind::InvalidFit, detail);
    }
    let plain = PLAIN.iter().find_map(|(words, plain)| {
        let rest = text.strip_prefix(words)?;
        Some(format!("{plain}{rest}"))
    });
    let detail = plain.unwrap_or(text).replace('`', "\"");
    let hint = if is_about_nan(body, error) {
        "; JSON has no NaN and no Infinity"
    } else {
        ""
    };
    (Kind::NotJson, format!("{detail}{hint}"))
}

/// Whether what is no JSON looks like a number that is not finite.
fn is_about_nan(body: &[u8], error: &serde_json::Error) -> bool {
    if error.classify() != Category::Syntax {
        return false;
    }
    let mut lines = body.split(|byte| *byte == b'\n');
    let line = lines.nth(error.line().saturating_sub(1)).unwrap_or(&[]);
    // The column is that of the byte that is wrong, or of one next to it.
    let around = line.iter().skip(error.column().saturating_sub(3)).take(12);
    let around: Vec<u8> = around.map(u8::to_ascii_lowercase).collect();
    let has = |word: &[u8]| around.windows(word.len()).any(|part| part == word);
    has(b"nan") || has(b"inf")
}
