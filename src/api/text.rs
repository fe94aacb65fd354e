//! Checks how the bytes of a body are encoded: what is compressed must say so, and JSON must be UTF-8.

use crate::api::problem::{Kind, Problem};

/// The first bytes of compression formats, with their names.
const COMPRESSED: [(&[u8], &str); 6] = [
    (b"\x1f\x8b", "gzip"),
    (b"\x28\xb5\x2f\xfd", "zstd"),
    (b"\x78\x01", "deflate"),
    (b"\x78\x9c", "deflate"),
    (b"\x78\xda", "deflate"),
    (b"PK\x03\x04", "zip"),
];

/// Byte-order marks of other encodings than UTF-8. The longer marks come first.
const MARKED: [(&[u8], &str); 4] = [
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
];

/// The byte-order mark that some programs write before UTF-8.
const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// Refuses compressed bodies without a Content-Encoding. For protobuf only gzip is recognised, as no
/// message begins with its two bytes.
pub(super) fn check_compression(body: &[u8], is_message: bool) -> Result<(), Problem> {
    let known = if is_message { 1 } else { COMPRESSED.len() };
    let found = COMPRESSED.iter().take(known);
    let found = found.filter(|(start, _)| body.starts_with(start));
    match found.map(|(_, name)| name).next() {
        None => Ok(()),
        Some(name) => {
            let detail = match *name {
                "gzip" | "zstd" => {
                    format!("the body is compressed with {name}; say so: Content-Encoding: {name}")
                }
                _ => format!(
                    "the body is compressed with {name}; send it as it is, or with gzip or zstd"
                ),
            };
            Err(Problem::new(Kind::UnsupportedEncoding, detail))
        }
    }
}

/// The JSON of a body without a byte-order mark; other encodings than UTF-8 are refused.
pub(super) fn utf8(body: &[u8]) -> Result<&[u8], Problem> {
    check_compression(body, false)?;
    let marked = MARKED.iter().find(|(mark, _)| body.starts_with(mark));
    if let Some(name) = marked.map(|(_, name)| *name).or_else(|| unmarked(body)) {
        let detail = format!("the body is {name}; JSON and other texts are sent in UTF-8");
        return Err(Problem::new(Kind::UnsupportedMediaType, detail));
    }
    Ok(body.strip_prefix(UTF8_MARK).unwrap_or(body))
}

/// The encoding of a text without a byte-order mark. As JSON begins with ASCII characters, the zero
/// bytes beside them tell UTF-16 and UTF-32 from UTF-8.
fn unmarked(body: &[u8]) -> Option<&'static str> {
    match *body {
        [0, 0, 0, x, ..] | [x, 0, 0, 0, ..] if x != 0 => Some("UTF-32"),
        [0, x, ..] | [x, 0, ..] if x != 0 => Some("UTF-16"),
        _ => None,
    }
}
