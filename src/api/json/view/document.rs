//! JSON documents with large arrays of numbers.
//!
//! Arrays are registered with the document, which returns a placeholder for each; an answer has these
//! in its fields. When the answer is serialised, the numbers replace the placeholders: small arrays at
//! once, large ones while they are sent.

use std::io;

use base64_simd::STANDARD;
use bytes::Bytes;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;

use super::arrays::{ArraySlot, NumberArray, PointArray, WeightArray};
use super::shape::NestedShape;
use super::source::Source;
use super::writer::{ArrayWriter, Digits, fits_32_bits};
use crate::job::content::Content;

/// Arrays are little-endian numbers of 64 or 32 bits in base64, the last index running fastest; of `delta`, in streams, packed whole numbers, by how many steps each number has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[schemars(example = Self::Base64)]
pub(super) enum BinaryEncoding {
    #[serde(rename = "base64")]
    Base64,
    #[serde(rename = "base64_f32")]
    Base64F32,
    #[serde(rename = "delta")]
    Delta,
}

/// The arrays of a JSON document.
pub(super) struct Document {
    digits: Digits,
    arrays: Vec<Array>,
}

enum Array {
    Numbers {
        shape: NestedShape,
        numbers: Box<dyn Source>,
        precision: Precision,
    },
    /// Whole numbers, packed.
    Packed(Bytes),
}

/// The precision of the numbers of an array.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Precision {
    /// Coordinates, which may be rounded.
    Rounded,
    /// Other numbers, which are written in full, or in 32 bits.
    Full,
    /// Numbers that may lie close together, which have 64 bits in any encoding.
    Exact,
}

impl Document {
    /// A document without arrays.
    pub(super) fn new(digits: Digits) -> Self {
        Self {
            digits,
            arrays: Vec::new(),
        }
    }

    /// An array of points with this shape: the numbers of points and of coordinates.
    pub(super) fn points(&mut self, shape: &[usize], coordinates: impl Source) -> PointArray {
        PointArray(self.array(shape, coordinates, Precision::Rounded))
    }

    /// An array of weights with this shape.
    pub(super) fn weights(&mut self, shape: &[usize], weights: impl Source) -> WeightArray {
        WeightArray(self.array(shape, weights, Precision::Full))
    }

    /// A list of this many numbers.
    pub(super) fn numbers(&mut self, count: usize, numbers: impl Source) -> NumberArray {
        NumberArray(self.array(&[count], numbers, Precision::Full))
    }

    /// A list of this many numbers, which have 64 bits in any encoding.
    pub(super) fn exact_numbers(&mut self, count: usize, numbers: impl Source) -> NumberArray {
        NumberArray(self.array(&[count], numbers, Precision::Exact))
    }

    /// Points that have moved by these packed numbers of steps.
    pub(super) fn packed_points(&mut self, numbers: Bytes) -> PointArray {
        PointArray(self.push(Array::Packed(numbers)))
    }

    /// Weights that have moved by these packed numbers of steps.
    pub(super) fn packed_weights(&mut self, numbers: Bytes) -> WeightArray {
        WeightArray(self.push(Array::Packed(numbers)))
    }

    fn array(&mut self, shape: &[usize], numbers: impl Source, precision: Precision) -> ArraySlot {
        // If a number is too large for 32 bits, all arrays get 64, so that none becomes infinite.
        if matches!(self.digits, Digits::Base64F32)
            && precision != Precision::Exact
            && !fits_32_bits(shape.into(), &numbers)
        {
            self.digits = Digits::Base64;
        }
        self.push(Array::Numbers {
            shape: shape.into(),
            numbers: Box::new(numbers),
            precision,
        })
    }

    fn push(&mut self, array: Array) -> ArraySlot {
        self.arrays.push(array);
        ArraySlot(self.arrays.len() as u8 - 1)
    }

    /// The encoding of the arrays so far, if it is binary.
    pub(super) fn encoding(&self) -> Option<BinaryEncoding> {
        match self.digits {
            Digits::Decimal(_) | Digits::Raw => None,
            Digits::Base64 => Some(BinaryEncoding::Base64),
            Digits::Base64F32 => Some(BinaryEncoding::Base64F32),
        }
    }

    /// The JSON of this answer, with the arrays in place of their placeholders.
    pub(super) fn finish(self, answer: &impl Serialize) -> Content {
        let mut text = Vec::with_capacity(1024);
        let mut serializer = Serializer::with_formatter(&mut text, Marks);
        if let Err(error) = answer.serialize(&mut serializer) {
            tracing::error!(%error, "an answer has no JSON form");
        }
        let sizes = self.arrays.iter().map(|array| array.size(self.digits));
        let bytes = sizes.fold(text.len(), usize::saturating_add);
        let mut writer = ArrayWriter::with_capacity(bytes);
        let mut arrays: Vec<Option<Array>> = self.arrays.into_iter().map(Some).collect();
        let mut parts = text.split(|byte| *byte == MARK);
        writer.text().extend(parts.next().unwrap_or_default());
        for part in parts {
            let Some((place, after)) = part.split_first() else {
                continue;
            };
            let array = arrays
                .get_mut(usize::from(*place) - 1)
                .and_then(Option::take);
            if let Some(array) = array {
                array.write(self.digits, &mut writer);
            }
            writer.text().extend(after);
        }
        writer.finish()
    }
}

impl Array {
    /// Its approximate number of bytes.
    fn size(&self, digits: Digits) -> usize {
        match self {
            Self::Numbers { shape, .. } => shape.count().saturating_mul(digits.size()),
            Self::Packed(bytes) => bytes.len() / 3 * 4 + 6,
        }
    }

    fn write(self, digits: Digits, writer: &mut ArrayWriter) {
        match self {
            Self::Numbers {
                shape,
                numbers,
                precision,
            } => writer.array(shape, numbers, precision.digits(digits)),
            Self::Packed(bytes) => {
                let text = writer.text();
                text.push(b'"');
                STANDARD.encode_append(&bytes, text);
                text.push(b'"');
            }
        }
    }
}

impl Precision {
    fn digits(self, digits: Digits) -> Digits {
        match (self, digits) {
            (Self::Full | Self::Exact, Digits::Decimal(_)) => Digits::Decimal(None),
            (Self::Exact, Digits::Base64F32) => Digits::Base64,
            (_, digits) => digits,
        }
    }
}

/// JSON as usual, but that an [`ArraySlot`] is a mark with the number of its array, counted from 1.
struct Marks;

/// A byte that JSON does not contain: control characters are escaped in strings, and occur nowhere else.
const MARK: u8 = 0;

impl Formatter for Marks {
    fn write_byte_array<W>(&mut self, writer: &mut W, value: &[u8]) -> io::Result<()>
    where
        W: ?Sized + io::Write,
    {
        let place = value.first().copied().unwrap_or_default();
        writer.write_all(&[MARK, place + 1])
    }
}
