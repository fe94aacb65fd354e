//! Text with large arrays of numbers in it, which are written when they are sent.

use std::ops::Range;
use std::sync::Arc;

use base64_simd::STANDARD;
use bytes::Bytes;

use super::decimal::{self, LONGEST, Rounding};
use super::source::Source;
use crate::job::content::{Content, Piece, Pieces};

/// How many numbers are written at a time: a multiple of 3, so that only the last ones of an array
/// need padding in base64, and of the dimensions of points.
const CHUNK: usize = 768;

/// How many numbers are a piece of an array; arrays that are shorter are written at once.
const PIECE: usize = 16 * CHUNK;

/// How numbers are written.
#[derive(Clone, Copy, Debug)]
pub enum Digits {
    /// As nested lists of decimal numbers, in full or rounded.
    Decimal(Option<Rounding>),
    /// As a string: little-endian numbers of 64 bits in base64.
    Base64,
    /// The same with 32 bits.
    Base64F32,
    /// As they are: little-endian numbers of 64 bits.
    Raw,
}

impl Digits {
    /// How many bytes are made ready for a number of a point, commas and brackets included.
    pub fn size(self) -> usize {
        match self {
            Self::Decimal(_) => LONGEST + 3,
            Self::Base64 => 11,
            Self::Base64F32 => 6,
            Self::Raw => 8,
        }
    }
}

/// The shape of an array: rows of columns of coordinates; the last index runs fastest.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    counts: [usize; 3],
    depth: usize,
}

impl From<&[usize]> for Shape {
    /// Of at most three numbers.
    fn from(counts: &[usize]) -> Self {
        let depth = counts.len().min(3);
        let mut shape = Self {
            counts: [1; 3],
            depth,
        };
        shape.counts[..depth].copy_from_slice(&counts[..depth]);
        shape
    }
}

impl Shape {
    /// How many numbers there are.
    pub fn count(self) -> usize {
        self.counts.iter().product()
    }

    /// How many numbers the innermost lists have, and the lists around these.
    fn sizes(self) -> (usize, Option<usize>) {
        let [_, b, c] = self.counts;
        match self.depth {
            3 => (c, Some(b * c)),
            2 => (b, None),
            _ => (1, None),
        }
    }
}

/// Bytes that are being written, and arrays that will be.
#[derive(Default)]
pub struct Writer {
    text: Vec<u8>,
    pieces: Vec<Piece>,
    /// The bytes of all pieces, as long as they are known.
    length: Option<usize>,
}

impl Writer {
    /// With room for so many bytes.
    pub fn with_capacity(bytes: usize) -> Self {
        Self {
            text: Vec::with_capacity(bytes.min(512 + PIECE * Digits::Decimal(None).size())),
            pieces: Vec::new(),
            length: Some(0),
        }
    }

    /// What stands behind the last large array.
    pub fn text(&mut self) -> &mut Vec<u8> {
        &mut self.text
    }

    /// Writes an array, now or later.
    pub fn array(&mut self, shape: Shape, source: impl Source, digits: Digits) {
        let count = shape.count();
        if count <= PIECE {
            return write(shape, 0..count, &source, digits, &mut self.text);
        }
        self.cut();
        self.length = match digits {
            Digits::Raw => self.length.map(|length| length + 8 * count),
            _ => None,
        };
        let source = Arc::new(source);
        for start in (0..count).step_by(PIECE) {
            let source = Arc::clone(&source);
            let range = start..count.min(start + PIECE);
            self.pieces.push(Piece::Later(Box::new(move || {
                let mut text = Vec::with_capacity(range.len() * digits.size());
                write(shape, range.clone(), &*source, digits, &mut text);
                text.into()
            })));
        }
    }

    /// The text so far becomes a piece.
    fn cut(&mut self) {
        let text = std::mem::take(&mut self.text);
        self.length = self.length.map(|length| length + text.len());
        self.pieces.push(Piece::Made(text.into()));
    }

    /// Everything is written, or said how.
    pub fn finish(mut self) -> Content {
        if self.pieces.is_empty() {
            return Bytes::from(self.text).into();
        }
        self.cut();
        let mut pieces = self.pieces.into_iter();
        let Some(Piece::Made(head)) = pieces.next() else {
            return Bytes::new().into();
        };
        let length = self.length.map(|length| length - head.len());
        let rest = Some(Arc::new(Pieces::new(pieces.collect(), length)));
        Content { head, rest }
    }
}

/// Whether all numbers of an array are finite in 32 bits, as far as they are in 64.
pub fn fits_32_bits(count: usize, source: &impl Source) -> bool {
    let mut fits = true;
    each_chunk(0..count, source, |_, numbers| {
        // Without a branch for each, so that they are looked at side by side.
        fits &= numbers.iter().fold(true, |fits, &x| {
            fits & ((x as f32).is_finite() | !x.is_finite())
        });
    });
    fits
}

/// Writes a part of an array, which begins and ends with whole points or at multiples of a chunk.
fn write(
    shape: Shape,
    range: Range<usize>,
    source: &impl Source,
    digits: Digits,
    text: &mut Vec<u8>,
) {
    let (is_first, is_last) = (range.start == 0, range.end == shape.count());
    let is_string = matches!(digits, Digits::Base64 | Digits::Base64F32);
    if is_string && is_first {
        text.push(b'"');
    }
    if range.is_empty() && matches!(digits, Digits::Decimal(_)) {
        return text.extend_from_slice(b"[]");
    }
    each_chunk(range, source, |start, numbers| match digits {
        Digits::Decimal(None) => lists(shape, start, numbers, text, decimal::write),
        Digits::Decimal(Some(rounding)) => {
            lists(shape, start, numbers, text, |x, room| {
                rounding.write(x, room)
            });
        }
        Digits::Base64 => base64(numbers, f64::to_le_bytes, text),
        Digits::Base64F32 => base64(numbers, |x| (x as f32).to_le_bytes(), text),
        Digits::Raw => text.extend(numbers.iter().flat_map(|x| x.to_le_bytes())),
    });
    if is_string && is_last {
        text.push(b'"');
    }
}

fn each_chunk(range: Range<usize>, source: &impl Source, mut visit: impl FnMut(usize, &[f64])) {
    let mut numbers = [0.0; CHUNK];
    for start in range.clone().step_by(CHUNK) {
        let numbers = &mut numbers[..CHUNK.min(range.end - start)];
        source.fill(start, numbers);
        visit(start, numbers);
    }
}

/// Writes the numbers from `start` on in their lists, with the brackets that open and close there.
#[inline(always)]
fn lists(
    shape: Shape,
    start: usize,
    numbers: &[f64],
    text: &mut Vec<u8>,
    write: impl Fn(f64, &mut [u8]) -> usize,
) {
    let (total, (inner, outer)) = (shape.count(), shape.sizes());
    let nested = shape.depth > 1;
    let opens = |at: usize| outer.is_some_and(|outer| at.is_multiple_of(outer));
    // Room for all of it at once: a number with its comma, and the brackets and the comma of a row.
    let length = text.len();
    let rows = numbers.len().div_ceil(inner);
    text.resize(length + numbers.len() * (LONGEST + 1) + rows * 6, 0);
    let mut room = Room {
        bytes: &mut text[length..],
        used: 0,
    };
    let mut at = start;
    for row in numbers.chunks(inner) {
        if at == 0 {
            room.push(b'[');
        }
        if opens(at) {
            room.push(b'[');
        }
        if nested {
            room.push(b'[');
        }
        for (k, &x) in row.iter().enumerate() {
            if k > 0 {
                room.push(b',');
            }
            room.used += write(x, &mut room.bytes[room.used..]);
        }
        at += inner;
        if nested {
            room.push(b']');
        }
        if opens(at) {
            room.push(b']');
        }
        room.push(if at == total { b']' } else { b',' });
    }
    let used = room.used;
    text.truncate(length + used);
}

/// Bytes that are filled from the start on.
struct Room<'a> {
    bytes: &'a mut [u8],
    used: usize,
}

impl Room<'_> {
    #[inline(always)]
    fn push(&mut self, byte: u8) {
        self.bytes[self.used] = byte;
        self.used += 1;
    }
}

fn base64<const N: usize>(numbers: &[f64], bytes: impl Fn(f64) -> [u8; N], text: &mut Vec<u8>) {
    let mut chunk = [0; 8 * CHUNK];
    for (to, &x) in chunk.chunks_exact_mut(N).zip(numbers) {
        to.copy_from_slice(&bytes(x));
    }
    STANDARD.encode_append(&chunk[..N * numbers.len()], text);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Value, json};

    use super::*;

    fn written(shape: &[usize], numbers: &[f64], digits: Digits) -> Vec<u8> {
        let mut writer = Writer::with_capacity(0);
        writer.text().push(b'!');
        writer.array(shape.into(), numbers.to_vec(), digits);
        writer.text().push(b'.');
        let content = writer.finish();
        if let Some(length) = content.length() {
            assert_eq!(length, content.clone().whole().len());
        }
        let text = content.whole();
        text.strip_prefix(b"!")
            .unwrap()
            .strip_suffix(b".")
            .unwrap()
            .to_vec()
    }

    /// The same by serde.
    fn nested(shape: &[usize], numbers: &[f64]) -> Value {
        match shape {
            [_] => json!(numbers),
            [0, ..] => json!([]),
            [count, inner @ ..] => numbers
                .chunks(numbers.len() / count)
                .map(|numbers| nested(inner, numbers))
                .collect(),
            [] => Value::Null,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

        #[test]
        fn arrays_are_what_they_are_in_one_piece(
            shape in prop_oneof![
                prop::collection::vec(0..40_000_usize, 1),
                (0..15_000_usize, 1..=3_usize).prop_map(|(n, d)| vec![n, d]),
                (1..120_usize, 1..120_usize, 1..=3_usize).prop_map(|(r, c, d)| vec![r, c, d]),
            ],
        ) {
            let count = shape.iter().product::<usize>();
            let numbers: Vec<f64> = (0..count).map(|i| i as f64 / 7.0).collect();
            let decimal = written(&shape, &numbers, Digits::Decimal(None));
            let read: Value = serde_json::from_slice(&decimal).unwrap();
            prop_assert!(read == nested(&shape, &numbers));
            let raw: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            prop_assert!(written(&shape, &numbers, Digits::Raw) == raw);
            let narrow: Vec<u8> = numbers.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
            for (digits, bytes) in [(Digits::Base64, raw), (Digits::Base64F32, narrow)] {
                let text: String = serde_json::from_slice(&written(&shape, &numbers, digits)).unwrap();
                prop_assert!(STANDARD.decode_to_vec(text).unwrap() == bytes);
            }
        }
    }
}
