//! Reads the JSON of requests, with plain error messages and their locations.

use serde::de::DeserializeOwned;
use serde_json::Deserializer as Json;
use serde_json::error::{Category, Error};
use serde_path_to_error::{Deserializer, Track};

use super::long_strings;
use crate::api::problem::{Kind, Problem};
use crate::model::list_limits::within;
use crate::model::serde_helpers::{MARK, pointer};
use piad_files::json::ListLimits;
use piad_files::text::{cut, plain, quoted, without_mark};

/// Reads a body with at most about `most_points` points. If that fails, it is read once more to find the location of
/// the error.
pub(crate) fn parse<T: DeserializeOwned>(body: &[u8], most_points: usize) -> Result<T, Problem> {
    let body = without_mark(body);
    if body.trim_ascii().is_empty() {
        let detail = "the body is empty; a job is expected";
        return Err(Problem::new(Kind::NotJson, detail));
    }
    let cut = long_strings::cut(body);
    let body = &*cut;
    let limits = ListLimits::new(body, most_points);
    within(limits, || serde_json::from_slice(body)).map_err(|error| {
        let mut track = Track::new();
        let mut json = Json::from_slice(body);
        let again = || T::deserialize(Deserializer::new(&mut json, &mut track));
        let _ = within(limits, again);
        problem(body, &error, pointer(&track.path()))
    })
}

/// An error, at a location about which its text has more.
fn problem(body: &[u8], error: &Error, mut pointer: String) -> Problem {
    let text = error.to_string();
    // 1e999 is JSON, but no 64-bit number.
    if let Some(place) = text.strip_prefix("number out of range") {
        let detail = format!(
            "the number{place} is beyond the 64-bit floating-point numbers, which end at 1.8e308"
        );
        return Problem::at_pointer(Kind::InvalidFit, pointer, detail);
    }
    if error.classify() != Category::Data {
        let hint = match is_about_nan(body, error) {
            true => "; JSON has no NaN and no Infinity",
            false => "",
        };
        let detail = format!("{}{hint}", syntax(&text));
        return Problem::at_pointer(Kind::NotJson, pointer, cut(&detail, 200));
    }
    let position = format!(" at line {} column {}", error.line(), error.column());
    let mut text = text.strip_suffix(&position).unwrap_or(&text);
    while let Some((place, rest)) = text.strip_prefix(MARK).and_then(|it| it.split_once(MARK)) {
        pointer.push_str(place);
        text = rest;
    }
    if let Some(name) = between(text, "duplicate field `", "`") {
        pointer = format!("{pointer}/{name}");
    }
    Problem::at_pointer(Kind::InvalidFit, pointer, words(text))
}

/// Beginnings of serde_json's syntax errors, and their replacements. The texts are all that serde_json reveals of an
/// error beyond its [`Category`]: its code is private. Other texts are passed on as they are.
const SYNTAX: [(&str, &str); 8] = [
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
        "lists and objects are nested too deep",
    ),
];

/// The message of a syntax error.
fn syntax(text: &str) -> String {
    let known = SYNTAX.iter().find_map(|(words, plain)| {
        let rest = text.strip_prefix(words)?;
        Some(format!("{plain}{rest}"))
    });
    known.unwrap_or_else(|| text.replace('`', "\""))
}

/// Returns true if invalid JSON looks like a number that is not finite.
fn is_about_nan(body: &[u8], error: &Error) -> bool {
    if error.classify() != Category::Syntax {
        return false;
    }
    let mut lines = body.split(|byte| *byte == b'\n');
    let line = lines.nth(error.line().saturating_sub(1)).unwrap_or(&[]);
    // The column is that of the wrong byte, or of a neighbour.
    let around = line.iter().skip(error.column().saturating_sub(3)).take(12);
    let around: Vec<u8> = around.map(u8::to_ascii_lowercase).collect();
    let has = |word: &[u8]| around.windows(word.len()).any(|part| part == word);
    has(b"nan") || has(b"inf")
}

/// The message of a serde error, in the words of users. Messages of the readers of this program are passed on.
fn words(text: &str) -> String {
    let invalid = ["invalid type: ", "invalid value: ", "invalid length: "];
    if let Some(rest) = invalid.iter().find_map(|it| text.strip_prefix(it))
        && let Some((found, expected)) = rest.rsplit_once(", expected ")
    {
        return mismatch(found, expected);
    }
    if let Some(rest) = text.strip_prefix("unknown field `") {
        let (name, names) = match rest.rsplit_once("`, expected ") {
            Some((name, names)) => (name, names.split('`').skip(1).step_by(2).collect()),
            None => (
                rest.strip_suffix("`, there are no fields").unwrap_or(rest),
                vec![],
            ),
        };
        let known = match names.is_empty() {
            true => "there are no settings".to_owned(),
            false => format!("expected one of {}", names.join(", ")),
        };
        return format!("unknown field {}; {known}", quoted(name));
    }
    if let Some(name) = between(text, "missing field `", "`") {
        return format!("the field {name:?} is missing");
    }
    match text.starts_with("duplicate field `") {
        true => "this field is given twice".to_owned(),
        false => text.to_owned(),
    }
}

/// A value of another type than the one that is expected.
fn mismatch(found: &str, expected: &str) -> String {
    let expected = match expected {
        "f64" | "f32" => "a number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        other => other,
    };
    let number = |prefix| between(found, prefix, "`");
    let found = match found {
        "null" | "unit value" if expected == "a number" => {
            "null (what many writers make of NaN and Infinity)".to_owned()
        }
        "null" | "unit value" => "null".to_owned(),
        "map" => "an object".to_owned(),
        "sequence" => "a list".to_owned(),
        _ => match found.strip_prefix("string \"") {
            // It is escaped already.
            Some(rest) => format!("\"{}\"", plain(rest.strip_suffix('"').unwrap_or(rest))),
            None => match number("floating point `").map(str::parse::<f64>) {
                Some(Ok(x)) => format!("{x:?}"),
                _ => number("integer `")
                    .or(number("boolean `"))
                    .unwrap_or(found)
                    .to_owned(),
            },
        },
    };
    format!("expected {expected}, found {found}")
}

/// The text between these, if it begins with the first.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    text.strip_prefix(start)?.split_once(end).map(|it| it.0)
}
