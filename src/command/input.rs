//! The input: its source, and its kind, detected by its content.

use std::io;
use std::path::Path;

use bytes::Bytes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::failure::Failure;
use crate::files;
use piad_files::import::is_geojson;
use piad_files::text::without_mark;

/// The kind of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Points in any form, which `import` reads.
    Points,
    /// A whole job in JSON.
    Job,
    /// Several jobs in JSON, with defaults.
    Batch,
}

/// The field that batches have, and jobs do not.
#[derive(Deserialize)]
struct Jobs {
    items: Option<IgnoredAny>,
}

/// An input to fit.
#[derive(Debug)]
pub(super) struct Input {
    /// The name of the file, for people.
    pub name: String,
    /// Its content.
    pub bytes: Bytes,
    /// Its kind.
    pub content: Content,
}

impl Input {
    /// Reads a file, or the standard input, of at most `max_bytes` bytes.
    pub(super) fn read(path: &Path, max_bytes: u64) -> Result<Self, Failure> {
        let (name, bytes) = match path.to_str() {
            Some("-") => {
                let bytes = files::read_from(io::stdin().lock(), max_bytes);
                ("<stdin>".to_owned(), bytes)
            }
            _ => (path.display().to_string(), files::read(path, max_bytes)),
        };
        let bytes = bytes.map_err(|reason| not_read(&name, &reason))?;
        let mut input = Self {
            name,
            content: content(&bytes),
            bytes: bytes.into(),
        };
        if input.content == Content::Job {
            let checked = serde_json::from_slice(input.json());
            let jobs: Jobs = checked.map_err(|error| input.not_json(&error))?;
            if jobs.items.is_some() {
                input.content = Content::Batch;
            }
        }
        Ok(input)
    }

    /// Its JSON.
    pub(super) fn value(&self) -> Result<Value, Failure> {
        serde_json::from_slice(self.json()).map_err(|error| self.not_json(&error))
    }

    /// Its bytes without a byte-order mark.
    pub(super) fn json(&self) -> &[u8] {
        without_mark(&self.bytes)
    }

    fn not_json(&self, error: &serde_json::Error) -> Failure {
        not_json(&self.name, error)
    }
}

/// The error of a JSON file, at its line.
pub(super) fn not_json(name: &str, error: &serde_json::Error) -> Failure {
    let line = error.line().max(1);
    // The line and column also stand at the end.
    let message = error.to_string();
    let detail = message.split(" at line ").next().unwrap_or(&message);
    Failure::usage(format!("{name}:{line}: {detail}"))
}

/// Why a file was not read.
pub(super) fn not_read(name: &str, reason: &io::Error) -> Failure {
    let advice = match reason.kind() {
        io::ErrorKind::FileTooLarge => "; --max-input sets another limit",
        _ => "",
    };
    Failure::usage(format!("{name}: {reason}{advice}"))
}

fn content(bytes: &[u8]) -> Content {
    match without_mark(bytes).trim_ascii_start().first() {
        Some(b'{') if !is_geojson(bytes) => Content::Job,
        _ => Content::Points,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_are_recognised() {
        for (text, expected) in [
            ("x,y\n1,2\n", Content::Points),
            ("", Content::Points),
            ("NACA 2412\n1 0\n", Content::Points),
            (" \n[[1, 2]]", Content::Points),
            ("\u{feff}[[1, 2]]", Content::Points),
            ("{\"curve\": {}}", Content::Job),
            (
                "{\"type\": \"LineString\", \"coordinates\": [[0, 0], [1, 2]]}",
                Content::Points,
            ),
        ] {
            assert_eq!(content(text.as_bytes()), expected, "{text:?}");
        }
    }
}
