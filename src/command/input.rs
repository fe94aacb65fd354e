//! The input: where it comes from, and what it is by what is in it.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use bytes::Bytes;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::failure::Failure;
use crate::import::{self, Hints};
use crate::model::short::without_mark;

/// What an input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Points as text, which `import` reads.
    Text,
    /// A JSON array of points.
    Points,
    /// A whole job in JSON.
    Job,
}

/// What is fitted.
#[derive(Debug)]
pub(super) struct Input {
    /// The name of the file, for people.
    pub name: String,
    /// What is in it.
    pub bytes: Bytes,
    /// What that is.
    pub content: Content,
}

impl Input {
    /// Reads a file, or the standard input.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let (name, bytes) = match path.to_str() {
            Some("-") => ("<stdin>".to_owned(), standard_input()),
            _ => (path.display().to_string(), fs::read(path)),
        };
        let bytes = bytes.map_err(|reason| Failure::usage(format!("{name}: {reason}")))?;
        let content = content(&bytes);
        let input = Self {
            name,
            bytes: bytes.into(),
            content,
        };
        if content != Content::Text {
            let checked = serde_json::from_slice::<IgnoredAny>(input.json());
            checked.map_err(|error| input.not_json(&error))?;
        }
        Ok(input)
    }

    /// The JSON that it is.
    pub(super) fn value(&self) -> Result<Value, Failure> {
        serde_json::from_slice(self.json()).map_err(|error| self.not_json(&error))
    }

    /// Its bytes without a mark before them.
    pub(super) fn json(&self) -> &[u8] {
        without_mark(&self.bytes)
    }

    fn not_json(&self, error: &serde_json::Error) -> Failure {
        not_json(&self.name, error)
    }
}

/// What is wrong with a file of JSON, at its line.
pub(super) fn not_json(name: &str, error: &serde_json::Error) -> Failure {
    let line = error.line().max(1);
    // The line and column are told at the end, too.
    let told = error.to_string();
    let detail = told.split(" at line ").next().unwrap_or(&told);
    Failure::usage(format!("{name}:{line}: {detail}"))
}

/// What is found out about a file of points, in sentences.
pub(super) fn notices(bytes: &[u8], hints: &Hints) -> Vec<String> {
    let read = import::read(bytes, hints);
    read.map(|read| read.notices).unwrap_or_default()
}

fn standard_input() -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    io::stdin().lock().read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn content(bytes: &[u8]) -> Content {
    match without_mark(bytes).trim_ascii_start().first() {
        Some(b'{') => Content::Job,
        Some(b'[') => Content::Points,
        _ => Content::Text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_are_recognised() {
        for (text, expected) in [
            ("x,y\n1,2\n", Content::Text),
            ("", Content::Text),
            ("NACA 2412\n1 0\n", Content::Text),
            (" \n[[1, 2]]", Content::Points),
            ("\u{feff}[[1, 2]]", Content::Points),
            ("{\"curve\": {}}", Content::Job),
        ] {
            assert_eq!(content(text.as_bytes()), expected, "{text:?}");
        }
    }
}
