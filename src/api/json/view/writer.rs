//! Text that contains large arrays of numbers, which are written while they are sent.

use std::ops::Range;
use std::sync::Arc;

use base64_simd::STANDARD;
use bytes::Bytes;

use super::decimal::{BATCH, LONGEST};
use super::lists::{SCRATCH, decimals};
use super::rounding::{Batch, Rounding};
use super::shape::NestedShape;
use super::source::{Source, all_fit_32_bits};
use crate::job::content::{Content, Piece, Pieces};

/// The most numbers that are written at a time.
const CHUNK: usize = 768;

/// The number of chunks of a piece of an array; arrays that are not longer are written at once.
const CHUNKS: usize = 16;

/// The most numbers of a piece.
const PIECE: usize = CHUNKS * CHUNK;

/// The notation of numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Digits {
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
    /// The number of bytes to reserve for each number, including commas and brackets.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Decimal(_) => LONGEST + 3,
            Self::Base64 => 11,
            Self::Base64F32 => 6,
            Self::Raw => 8,
        }
    }
}

/// Text that is written now, and large arrays that are written later.
#[derive(Default)]
pub(crate) struct ArrayWriter {
    text: Vec<u8>,
    pieces: Vec<Piece>,
    /// The bytes of all pieces, as long as they are known.
    length: Option<usize>,
    /// Some pieces take longer to write than to send.
    is_slow: bool,
}

impl ArrayWriter {
    /// A writer with room for this many bytes.
    pub(crate) fn with_capacity(bytes: usize) -> Self {
        Self {
            text: Vec::with_capacity(bytes.min(512 + PIECE * Digits::Decimal(None).size())),
            pieces: Vec::new(),
            length: Some(0),
            is_slow: false,
        }
    }

    /// The text after the last large array.
    pub(crate) fn text(&mut self) -> &mut Vec<u8> {
        &mut self.text
    }

    /// Writes an array, now or later.
    pub(crate) fn array(&mut self, shape: NestedShape, source: impl Source, digits: Digits) {
        let count = shape.count();
        let piece = CHUNKS * chunk(shape);
        if count <= piece {
            return write(shape, 0..count, &source, digits, &mut self.text);
        }
        self.cut();
        self.length = match digits {
            Digits::Raw => self.length.map(|length| length + 8 * count),
            _ => None,
        };
        self.is_slow |= matches!(digits, Digits::Decimal(_)) || source.is_computed();
        let source = Arc::new(source);
        for start in (0..count).step_by(piece) {
            let source = Arc::clone(&source);
            let range = start..count.min(start + piece);
            self.pieces.push(Piece::Later(Box::new(move || {
                let mut text = Vec::with_capacity(range.len() * digits.size());
                write(shape, range.clone(), &*source, digits, &mut text);
                text.into()
            })));
        }
    }

    /// Turns the text so far into a piece.
    fn cut(&mut self) {
        let text = std::mem::take(&mut self.text);
        self.length = self.length.map(|length| length + text.len());
        self.pieces.push(Piece::Made(text.into()));
    }

    /// The content of the text and all arrays.
    pub(crate) fn finish(mut self) -> Content {
        if self.pieces.is_empty() {
            return Bytes::from(self.text).into();
        }
        self.cut();
        let mut pieces = self.pieces.into_iter();
        let Some(Piece::Made(head)) = pieces.next() else {
            return Bytes::new().into();
        };
        let length = self.length.map(|length| length - head.len());
        let pieces = Pieces::new(pieces.collect(), length).quick(!self.is_slow);
        Content::new(head, Some(Arc::new(pieces)))
    }
}

/// The number of numbers of an array that are written at a time: a multiple of 3, so that only its end needs padding in
/// base64, and whole points, which sources yield. Of longer lists of numbers sources yield any part.
fn chunk(shape: NestedShape) -> usize {
    let whole = 3 * shape.innermost().max(1);
    match CHUNK / whole {
        0 => CHUNK,
        most => most * whole,
    }
}

/// The number of points with this many coordinates that are written at a time. Samples of surfaces differ in the last
/// bit with the number that is evaluated together.
pub(crate) fn points_at_once(dimension: usize) -> usize {
    chunk([usize::MAX / dimension.max(1), dimension].as_slice().into()) / dimension.max(1)
}

/// Returns true if all finite numbers of an array stay finite in 32 bits.
pub(super) fn fits_32_bits(shape: NestedShape, source: &impl Source) -> bool {
    if let Some(fits) = source.fits_32_bits() {
        return fits;
    }
    let mut fits = true;
    each_chunk(shape, 0..shape.count(), source, |_, numbers| {
        fits &= all_fit_32_bits(numbers)
    });
    fits
}

/// Writes a part of an array that begins with a [`chunk`].
fn write(
    shape: NestedShape,
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
    match digits {
        Digits::Decimal(rounding) => {
            let mut batch = rounding.map(Batch::new);
            let mut scratch = [0; SCRATCH];
            each_chunk(shape, range, source, |start, numbers| {
                for (index, numbers) in numbers.chunks(BATCH).enumerate() {
                    let start = start + index * BATCH;
                    let used = decimals(shape, start, numbers, &mut batch, &mut scratch);
                    text.extend_from_slice(&scratch[..used]);
                }
            });
        }
        Digits::Base64 => each_chunk(shape, range, source, |_, numbers| {
            base64(numbers, f64::to_le_bytes, text)
        }),
        Digits::Base64F32 => each_chunk(shape, range, source, |_, numbers| {
            base64(numbers, |x| (x as f32).to_le_bytes(), text)
        }),
        Digits::Raw => each_chunk(shape, range, source, |_, numbers| {
            text.extend(numbers.iter().flat_map(|x| x.to_le_bytes()))
        }),
    }
    if is_string && is_last {
        text.push(b'"');
    }
}

fn each_chunk(
    shape: NestedShape,
    range: Range<usize>,
    source: &impl Source,
    mut visit: impl FnMut(usize, &[f64]),
) {
    let mut numbers = [0.0; CHUNK];
    let chunk = chunk(shape);
    for start in range.clone().step_by(chunk) {
        let numbers = &mut numbers[..chunk.min(range.end - start)];
        source.fill(start, numbers);
        visit(start, numbers);
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
        let mut writer = ArrayWriter::with_capacity(0);
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

    /// The same lists with all numbers in floating point.
    fn as_floats(lists: &Value) -> Value {
        match lists {
            Value::Array(elements) => elements.iter().map(as_floats).collect(),
            number => json!(number.as_f64()),
        }
    }

    /// Sizes of which multiples are parts of chunks and pieces, whole ones, and a little more.
    fn size(most: usize) -> impl Strategy<Value = usize> {
        let near = [1, 2, CHUNK / 2, CHUNK, 2 * CHUNK, PIECE, 2 * PIECE].map(|size| size.min(most));
        let near = prop::sample::select(near.to_vec());
        let near = (near, -1..=1_isize).prop_map(|(size, off)| size.saturating_add_signed(off));
        prop_oneof![1..=most, near.prop_map(move |size| size.clamp(1, most))]
    }

    /// Every kind of shape: numbers, points, numbers of a net, points of a net.
    fn shape() -> impl Strategy<Value = Vec<usize>> {
        let net = || {
            let rows = |columns| (size(40_000 / columns), Just(columns));
            let counts = size(40_000).prop_flat_map(rows);
            counts.prop_map(|(rows, columns)| vec![rows, columns])
        };
        let with_points = |counts: Vec<usize>| {
            let points = move |d| [&counts[..], &[d]].concat();
            (1..=17_usize).prop_map(points)
        };
        prop_oneof![
            (0..40_000_usize).prop_map(|count| vec![count]),
            size(40_000).prop_map(|count| vec![count]),
            size(5_000).prop_flat_map(move |count| with_points(vec![count])),
            net(),
            net().prop_flat_map(with_points),
        ]
    }

    /// Wherever a part ends and the next one begins.
    #[test]
    fn parts_may_begin_and_end_anywhere() {
        let counts = 1..=6_usize;
        let one = counts.clone().map(|a| vec![a]);
        let two = counts
            .clone()
            .flat_map(|a| (1..=6).map(move |b| vec![a, b]));
        let three = two
            .clone()
            .flat_map(|ab| (1..=4).map(move |c| [&ab[..], &[c]].concat()));
        for shape in one.chain(two).chain(three) {
            let count = shape.iter().product::<usize>();
            let numbers: Vec<f64> = (0..count).map(|i| i as f64 / 4.0).collect();
            let expected = nested(&shape, &numbers);
            for cut in 0..=count {
                let (mut text, mut scratch) = (Vec::new(), [0; SCRATCH]);
                for (start, part) in [(0, &numbers[..cut]), (cut, &numbers[cut..])] {
                    for (index, part) in part.chunks(BATCH).enumerate() {
                        let start = start + index * BATCH;
                        let shape = shape.as_slice().into();
                        let used = decimals(shape, start, part, &mut None, &mut scratch);
                        text.extend_from_slice(&scratch[..used]);
                    }
                }
                let read: Value = serde_json::from_slice(&text).unwrap();
                assert_eq!(read, expected, "{shape:?} cut at {cut}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

        #[test]
        fn arrays_are_what_they_are_in_one_piece(
            shape in shape(),
        ) {
            let count = shape.iter().product::<usize>();
            let numbers: Vec<f64> = (0..count).map(|i| i as f64 / 7.0).collect();
            let decimal = written(&shape, &numbers, Digits::Decimal(None));
            let read: Value = serde_json::from_slice(&decimal).unwrap();
            prop_assert!(read == nested(&shape, &numbers));
            let rounded = written(&shape, &numbers, Digits::Decimal(Rounding::for_error(0.6)));
            let hundredths: Vec<f64> = numbers.iter().map(|x| (100.0 * x).round() / 100.0).collect();
            let read: Value = serde_json::from_slice(&rounded).unwrap();
            prop_assert!(as_floats(&read) == nested(&shape, &hundredths));
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
