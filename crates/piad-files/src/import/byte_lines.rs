//! Lines of files that may have binary data below them, and the numbers in such lines.

/// The lines of a file from some place on, with their numbers from 1, without blanks around them.
#[derive(Clone, Debug)]
pub(super) struct ByteLines<'a> {
    rest: &'a [u8],
    end: u8,
    /// The number of the last line.
    pub(super) number: usize,
}

impl<'a> ByteLines<'a> {
    /// The lines of a file. They end as the first one does: binary data may begin with any byte.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let first = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let end = match first.and_then(|place| bytes.get(place..)) {
            Some([b'\r', b'\n', ..]) | None => b'\n',
            Some(end) => end.first().copied().unwrap_or(b'\n'),
        };
        Self {
            rest: bytes,
            end,
            number: 0,
        }
    }

    /// The bytes below the lines that were passed.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The next line that is not blank.
    pub(super) fn next_filled(&mut self) -> Option<&'a [u8]> {
        self.find(|line| !line.is_empty())
    }
}

impl<'a> Iterator for ByteLines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(self.end, self.rest).unwrap_or(self.rest.len());
        let (line, below) = self.rest.split_at_checked(end)?;
        self.rest = below.get(1..).unwrap_or_default();
        self.number += 1;
        Some(line.trim_ascii())
    }
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// A word as text that can be quoted.
pub(super) fn text(word: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(word)
}

/// A number, which may be infinite or NaN, also as old Windows programs write these.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let number = fast_float2::parse(word).ok();
    number.or_else(|| {
        let bare = word.strip_prefix(b"-").unwrap_or(word);
        let is_nan = bare
            .get(..3)
            .is_some_and(|it| it.eq_ignore_ascii_case(b"nan"));
        (is_nan || bare.starts_with(b"1.#")).then_some(f64::NAN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_as_the_first_one_does() {
        for (file, second) in [
            (&b"a\nb \r\n\r\n\nc"[..], &b"b"[..]),
            (b"a\r\nb\r\n\n\nc", b"b"),
            (b"a\rb\r\r\rc", b"b"),
        ] {
            let mut lines = ByteLines::new(file);
            assert_eq!(lines.next(), Some(&b"a"[..]));
            assert_eq!(lines.next(), Some(second));
            assert_eq!((lines.next_filled(), lines.number), (Some(&b"c"[..]), 5));
            assert_eq!((lines.next(), lines.number), (None, 5));
        }
        let mut binary = ByteLines::new(b"a\r\n\n\0");
        binary.next();
        assert_eq!(binary.rest(), b"\n\0");
    }

    #[test]
    fn numbers_may_be_none() {
        for word in [
            "nan",
            "NaN",
            "-nan",
            "nan(ind)",
            "-nan(ind)",
            "1.#QNAN",
            "-1.#IND",
        ] {
            assert!(number(word.as_bytes()).unwrap().is_nan(), "{word}");
        }
        for word in ["1", "+1", "1.0", "1e0", ".1e1"] {
            assert_eq!(number(word.as_bytes()), Some(1.0), "{word}");
        }
        assert!(number(b"1e999").unwrap().is_infinite());
        for word in ["", "-", "x", "1x", "1,5"] {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
    }
}
