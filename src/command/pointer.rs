//! Parts of a JSON text: the line at which one stands, and its value.

use serde_json::{Deserializer, Value};

/// The line, from 1, of the value at a JSON pointer (RFC 6901), or of the nearest part that it is in.
pub(super) fn line(text: &[u8], pointer: &str) -> usize {
    let mut scanner = Scanner { text, at: 0 };
    let mut place = scanner.value();
    for name in names(pointer) {
        match scanner.enter(&name) {
            Some(inner) => place = inner,
            None => break,
        }
    }
    let before = text.get(..place).unwrap_or(text);
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

/// The value at a JSON pointer in a JSON text, without reading the rest.
pub(super) fn value(text: &[u8], pointer: &str) -> Option<Value> {
    let mut scanner = Scanner { text, at: 0 };
    let mut place = scanner.value();
    for name in names(pointer) {
        place = scanner.enter(&name)?;
    }
    let mut values = Deserializer::from_slice(text.get(place..)?).into_iter();
    values.next()?.ok()
}

/// The names in a JSON pointer.
fn names(pointer: &str) -> impl Iterator<Item = String> {
    let names = pointer.split('/').skip(1);
    names.map(|name| name.replace("~1", "/").replace("~0", "~"))
}

/// Goes through a text that is JSON.
struct Scanner<'a> {
    text: &'a [u8],
    at: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// Skips separators, up to the next value.
    fn value(&mut self) -> usize {
        while self
            .peek()
            .is_some_and(|byte| byte.is_ascii_whitespace() || matches!(byte, b',' | b':'))
        {
            self.at += 1;
        }
        self.at
    }

    /// Goes to a member or an element of the value that begins here.
    fn enter(&mut self, name: &str) -> Option<usize> {
        let object = match self.peek()? {
            b'{' => true,
            b'[' => false,
            _ => return None,
        };
        let (start, mut index) = (self.at, 0);
        self.at += 1;
        loop {
            self.value();
            if matches!(self.peek(), None | Some(b'}' | b']')) {
                self.at = start;
                return None;
            }
            let found = match object {
                true => {
                    let key = self.at;
                    self.skip();
                    let key = self.text.get(key..self.at)?;
                    serde_json::from_slice::<String>(key).is_ok_and(|key| key == name)
                }
                false => name.parse() == Ok(index),
            };
            let value = self.value();
            if found {
                return Some(value);
            }
            self.skip();
            index += 1;
        }
    }

    /// Skips the value that begins here.
    fn skip(&mut self) {
        let mut depth = 0_usize;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => self.skip_text(),
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth == 0 => return,
                b'}' | b']' => depth -= 1,
                b',' | b':' if depth == 0 => return,
                _ => {}
            }
            self.at += 1;
            if depth == 0 && matches!(byte, b'"' | b'}' | b']') {
                return;
            }
        }
    }

    /// Skips to the end of a string, which begins here.
    fn skip_text(&mut self) {
        self.at += 1;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => return,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_found_at_their_lines() {
        let text = b"{\n \"a\\\"b,\": [1,\n 2, {\"c\": \"}\"}],\n\n \"d\": {\n  \"e/f\": [\n   [0, 0],\n   [1, 1]\n  ]}}\n";
        for (pointer, expected) in [
            ("", 1),
            ("/a\"b,", 2),
            ("/a\"b,/1", 3),
            ("/a\"b,/2/c", 3),
            ("/d", 5),
            ("/d/e~1f/0", 7),
            ("/d/e~1f/1/1", 8),
            ("/d/e~1f/9", 6),
            ("/nowhere", 1),
        ] {
            assert_eq!(line(text, pointer), expected, "{pointer}");
        }
        assert_eq!(value(text, "/d/e~1f/1"), Some(serde_json::json!([1, 1])));
        assert_eq!(value(text, "/d/e~1f/9"), None);
        assert_eq!(value(b"", "/a"), None);
        assert_eq!(line(b"", "/a"), 1);
        assert_eq!(line(b"{\"a", "/a"), 1);
    }
}
