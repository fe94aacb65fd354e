//! Text output, with numbers that are read back exactly.

use std::fmt::{Arguments, Write};

/// A text that grows.
#[derive(Debug, Default)]
pub(super) struct Text(String);

impl Text {
    /// Appends formatted text.
    pub(super) fn put(&mut self, arguments: Arguments<'_>) {
        // Writing to a string has no error.
        let _ = self.0.write_fmt(arguments);
    }

    /// Appends text as it is.
    pub(super) fn push(&mut self, text: &str) {
        self.0.push_str(text);
    }

    /// Appends the shortest decimal number that is read as exactly `x` (17 digits at most), with a decimal point, as
    /// STEP and IGES require for real numbers, and with this letter before an exponent.
    pub(super) fn real(&mut self, x: f64, exponent: char) {
        let start = self.0.len();
        self.put(format_args!("{x:?}"));
        let Some(e) = self.0[start..].find('e') else {
            return;
        };
        let mut power = [0; 8];
        let tail = &self.0.as_bytes()[start + e + 1..];
        let length = tail.len().min(power.len());
        power[..length].copy_from_slice(&tail[..length]);
        self.0.truncate(start + e);
        if !self.0[start..].contains('.') {
            self.0.push('.');
        }
        self.0.push(exponent);
        self.0
            .extend(power[..length].iter().map(|&byte| char::from(byte)));
    }

    /// Appends a list in parentheses, with a line break after every tenth item.
    pub(super) fn list<T>(
        &mut self,
        items: impl IntoIterator<Item = T>,
        mut write: impl FnMut(&mut Self, T),
    ) {
        self.push("(");
        for (i, item) in items.into_iter().enumerate() {
            match i {
                0 => {}
                _ if i % 10 == 0 => self.push(",\n"),
                _ => self.push(","),
            }
            write(self, item);
        }
        self.push(")");
    }

    /// What was written so far.
    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    /// Empties the text and keeps its memory.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// The text itself.
    pub(super) fn into_string(self) -> String {
        self.0
    }

    /// The text as bytes of UTF-8.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0.into_bytes()
    }
}

/// A name as part of one line of text: line breaks and other control characters become spaces.
pub(super) fn one_line(name: &str) -> String {
    name.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

/// A name as part of one line of ASCII, for formats without escapes, such as IGES (section 2.2.2): other characters
/// become question marks.
pub(super) fn ascii(name: &str) -> String {
    name.chars()
        .map(|c| match c {
            ' '..='~' => c,
            c if c.is_control() => ' ',
            _ => '?',
        })
        .collect()
}

/// Text content of XML: markup as entities; control characters, which XML 1.0 does not allow
/// (section 2.2), as spaces.
pub(super) fn escape(value: &str) -> String {
    let mut escaped = String::with_capacity(value.len());
    for c in one_line(value).chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(x: f64) -> String {
        let mut text = Text::default();
        text.real(x, 'E');
        text.0
    }

    #[test]
    fn reals_have_a_point_and_are_read_back() {
        assert_eq!(real(1.0), "1.0");
        assert_eq!(real(-0.25), "-0.25");
        assert_eq!(real(1e-7), "1.E-7");
        assert_eq!(real(-1.5e300), "-1.5E300");
        assert_eq!(real(5e-324), "5.E-324");
        assert_eq!(real(0.1 + 0.2), "0.30000000000000004");
        let mut x = 1.234_567_890_123_456_7e-300;
        for _ in 0..2000 {
            let text = real(x);
            assert!(text.contains('.') && !text.contains('e'));
            assert_eq!(text.parse(), Ok(x), "{text}");
            x *= -1.953_125_001_7;
        }
    }

    #[test]
    fn lists_break_their_lines() {
        let mut text = Text::default();
        text.list(0..12, |text, i| text.put(format_args!("{i}")));
        assert_eq!(text.as_str(), "(0,1,2,3,4,5,6,7,8,9,\n10,11)");
    }

    #[test]
    fn names_stay_on_their_line() {
        assert_eq!(one_line("a\r\nb\tç"), "a  b ç");
        assert_eq!(ascii("Flügel\n'1'"), "Fl?gel '1'");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(
            escape("<a href=\"x\">'&'\u{0}\n"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;  "
        );
        assert_eq!(escape("翼 ü"), "翼 ü");
    }
}
