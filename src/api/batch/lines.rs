//! A batch in lines: each is a JSON object, the first of which may have the defaults.

use bytes::{Buf, Bytes, BytesMut};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::pieces::Piece;
use piad_files::text::without_mark;

/// The state of the parser.
#[derive(Default)]
pub(super) struct Lines {
    /// The number of waiting bytes known to hold no line end.
    searched: usize,
    /// A line that is not blank has been read.
    begun: bool,
}

/// The first line of a batch with defaults.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct First<'a> {
    #[serde(borrow)]
    defaults: &'a RawValue,
}

impl Lines {
    /// The next line that is not blank, if all of it is there.
    pub(super) fn next(&mut self, bytes: &mut BytesMut) -> Option<Piece> {
        loop {
            let rest = bytes.get(self.searched..).unwrap_or_default();
            let Some(end) = memchr::memchr(b'\n', rest) else {
                self.searched = bytes.len();
                return None;
            };
            let line = bytes.split_to(self.searched + end).freeze();
            bytes.advance(1);
            self.searched = 0;
            let piece = self.piece(line);
            if piece.is_some() {
                return piece;
            }
        }
    }

    /// The last line, which may have no end.
    pub(super) fn finish(&mut self, bytes: &mut BytesMut) -> Option<Piece> {
        let line = bytes.split().freeze();
        self.piece(line)
    }

    fn piece(&mut self, line: Bytes) -> Option<Piece> {
        let text = match self.begun {
            true => line.trim_ascii(),
            false => without_mark(&line).trim_ascii(),
        };
        if text.is_empty() {
            return None;
        }
        let first = match self.begun {
            true => None,
            false => serde_json::from_slice::<First<'_>>(text).ok(),
        };
        self.begun = true;
        Some(match first {
            Some(first) => Piece::Defaults(line.slice_ref(first.defaults.get().as_bytes())),
            None => Piece::Item(line.slice_ref(text)),
        })
    }
}
