//! Shortens overlong strings, as errors would repeat them several times.

use std::borrow::Cow;

/// Strings up to this many bytes stay as they are.
const SHORT_STRING_BYTES: usize = 64 * 1024;

/// The replacement of longer ones: still too long for every field, and what errors show of them.
const LEFT: usize = 1000;

/// JSON whose long strings are cut.
pub(super) fn cut(json: &[u8]) -> Cow<'_, [u8]> {
    let mut cut = Vec::new();
    let (mut copied, mut at) = (0, 0);
    while let Some((start, end)) = next_string(json, at) {
        at = end + 1;
        let text = json.get(start..end).unwrap_or_default();
        if text.len() > SHORT_STRING_BYTES {
            cut.extend_from_slice(json.get(copied..start).unwrap_or_default());
            let is_plain = |byte: &&u8| (b' '..=b'~').contains(*byte) && **byte != b'\\';
            let length = cut.len() + LEFT;
            cut.extend(text.iter().take(LEFT).take_while(is_plain));
            cut.resize(length, b'x');
            copied = end;
        }
    }
    if copied == 0 {
        return Cow::Borrowed(json);
    }
    cut.extend_from_slice(json.get(copied..).unwrap_or_default());
    Cow::Owned(cut)
}

/// The range of the next string, without its quotes.
fn next_string(json: &[u8], at: usize) -> Option<(usize, usize)> {
    let start = at + memchr::memchr(b'"', json.get(at..)?)? + 1;
    let mut end = start;
    loop {
        end += memchr::memchr2(b'"', b'\\', json.get(end..)?)?;
        match json.get(end) {
            Some(b'"') => return Some((start, end)),
            _ => end += 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_strings_are_cut_and_others_stay() {
        let json = br#"{"a\"":"\\","b":[1,2],"":"x"}"#;
        assert!(matches!(cut(json), Cow::Borrowed(_)));
        let long = "y".repeat(SHORT_STRING_BYTES + 1);
        let json = format!(r#"{{"a":"\"{long}","{long}":[1],"b":"\\"}}"#);
        let (padded, cut_key) = ("x".repeat(LEFT), "y".repeat(LEFT));
        let expected = format!(r#"{{"a":"{padded}","{cut_key}":[1],"b":"\\"}}"#);
        assert_eq!(cut(json.as_bytes()), expected.as_bytes());
        // One that does not end is left to the parser.
        let open = format!(r#"{{"{long}\"#);
        assert!(matches!(cut(open.as_bytes()), Cow::Borrowed(_)));
    }
}
