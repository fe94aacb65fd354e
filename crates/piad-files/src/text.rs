//! Quoting of client text: without a byte-order mark, and cut to a length that can be repeated in
//! an answer.

use std::borrow::Cow;

/// The most characters of a client's text that are repeated.
const LONGEST: usize = 100;

/// A text without the byte-order mark that some programs write before UTF-8.
pub fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// The first `most` characters of the text, with an ellipsis if it is longer.
pub fn cut(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", text.get(..end).unwrap_or(""))),
    }
}

/// The text in quotation marks, escaped as in JSON, and cut.
pub fn quoted(text: &str) -> String {
    format!("{:?}", cut(text, LONGEST))
}

/// The text itself, cut.
pub fn plain(text: &str) -> Cow<'_, str> {
    cut(text, LONGEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_between_characters() {
        assert_eq!(cut("λμν", 3), "λμν");
        assert_eq!(cut("λμν", 2), "λμ…");
        assert_eq!(quoted("a\"b\n"), r#""a\"b\n""#);
        assert_eq!(quoted(&"x".repeat(1 << 20)).len(), LONGEST + 2 + "…".len());
    }
}
