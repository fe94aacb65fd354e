//! JSON objects with large arrays of numbers, which are written straight into the bytes to be sent.

use base64_simd::STANDARD;
use bytes::Bytes;
use serde::Serialize;

use super::decimal::{self, Rounding};

/// How many bytes are encoded at a time: a multiple of the sizes of numbers, and of 3, so that only
/// the last ones need padding.
const CHUNK: usize = 24 * 256;

/// How arrays of numbers are written.
#[derive(Clone, Copy, Debug)]
pub enum Numbers {
    /// As nested lists, in full or rounded.
    Decimal(Option<Rounding>),
    /// Flat, as little-endian numbers of 64 bits in base64.
    Binary64,
    /// The same with 32 bits.
    Binary32,
}

impl Numbers {
    fn encoding(self) -> Option<&'static str> {
        match self {
            Self::Decimal(_) => None,
            Self::Binary64 => Some("base64"),
            Self::Binary32 => Some("base64_f32"),
        }
    }

    /// How many bytes a number rarely exceeds, commas and brackets included: growing would take
    /// twice the memory of a large frame.
    fn size(self) -> usize {
        match self {
            Self::Decimal(_) => 24,
            Self::Binary64 => 11,
            Self::Binary32 => 6,
        }
    }
}

/// A JSON object that is being written.
#[derive(Debug)]
pub struct Document {
    json: Vec<u8>,
    numbers: Numbers,
    /// A number was too large for 32 bits.
    overflow: bool,
}

impl Document {
    /// Begins with the fields of `head`, which are small and at least one. Arrays of `count`
    /// numbers will follow.
    pub fn new(head: &impl Serialize, numbers: Numbers, count: usize) -> Self {
        let mut document = Self {
            json: Vec::with_capacity(512 + count.saturating_mul(numbers.size())),
            numbers,
            overflow: false,
        };
        document.value(head);
        document.json.pop();
        document
    }

    /// Writes fields with arrays of numbers; binary ones after their encoding and the shape of
    /// the first of them. If one of the numbers is too large for 32 bits all of them get 64,
    /// so that none becomes infinite.
    pub fn arrays(&mut self, shape: &[usize], fields: impl Fn(&mut Self)) {
        let start = self.json.len();
        self.encoding(shape);
        fields(self);
        if self.overflow {
            self.json.truncate(start);
            self.numbers = Numbers::Binary64;
            self.encoding(shape);
            fields(self);
        }
    }

    fn encoding(&mut self, shape: &[usize]) {
        if let Some(encoding) = self.numbers.encoding() {
            self.field("encoding", &encoding);
            self.field("shape", &shape);
        }
    }

    /// Writes a field that is small.
    pub fn field(&mut self, name: &str, value: &impl Serialize) {
        self.key(name);
        self.value(value);
    }

    /// Writes a field with an array of coordinates of this shape, the last index running fastest.
    /// Coordinates are what may be rounded.
    pub fn coordinates(&mut self, name: &str, shape: &[usize], numbers: impl Iterator<Item = f64>) {
        self.key(name);
        self.numbers(shape, numbers, self.numbers);
    }

    /// Writes a field with an array of other numbers.
    pub fn array(&mut self, name: &str, shape: &[usize], numbers: impl Iterator<Item = f64>) {
        self.key(name);
        let form = match self.numbers {
            Numbers::Decimal(_) => Numbers::Decimal(None),
            binary => binary,
        };
        self.numbers(shape, numbers, form);
    }

    /// Writes a field with an object.
    pub fn object(&mut self, name: &str, fields: impl FnOnce(&mut Self)) {
        self.key(name);
        self.json.push(b'{');
        fields(self);
        self.json.push(b'}');
    }

    /// Writes a field with a list of lists.
    pub fn lists<T>(
        &mut self,
        name: &str,
        items: impl Iterator<Item = T>,
        mut elements: impl FnMut(&mut Self, T),
    ) {
        self.key(name);
        self.json.push(b'[');
        for item in items {
            self.separate(b'[');
            self.json.push(b'[');
            elements(self, item);
            self.json.push(b']');
        }
        self.json.push(b']');
    }

    /// Writes an element of a list.
    pub fn element(&mut self, value: &impl Serialize) {
        self.separate(b'[');
        self.value(value);
    }

    /// Writes a point as an element of a list.
    pub fn point(&mut self, coordinates: impl ExactSizeIterator<Item = f64>) {
        self.separate(b'[');
        self.numbers(&[coordinates.len()], coordinates, self.numbers);
    }

    /// The object is complete.
    pub fn finish(mut self) -> Bytes {
        self.json.push(b'}');
        self.json.shrink_to_fit();
        self.json.into()
    }

    fn key(&mut self, name: &str) {
        self.separate(b'{');
        self.value(&name);
        self.json.push(b':');
    }

    /// A comma, unless nothing stands before it.
    fn separate(&mut self, open: u8) {
        if self.json.last() != Some(&open) {
            self.json.push(b',');
        }
    }

    /// The values that are written here always have a JSON form.
    fn value(&mut self, value: &impl Serialize) {
        if let Err(error) = serde_json::to_writer(&mut self.json, value) {
            tracing::error!(%error, "a value has no JSON form");
        }
    }

    fn numbers(&mut self, shape: &[usize], mut numbers: impl Iterator<Item = f64>, form: Numbers) {
        let json = &mut self.json;
        match form {
            Numbers::Decimal(None) => nested(json, shape, &mut numbers, &decimal::write),
            Numbers::Decimal(Some(rounding)) => {
                let write = |x, json: &mut Vec<u8>| rounding.write(x, json);
                nested(json, shape, &mut numbers, &write);
            }
            Numbers::Binary64 => base64(json, numbers.map(f64::to_le_bytes)),
            Numbers::Binary32 => {
                let overflow = &mut self.overflow;
                let narrow = numbers.map(|x| {
                    let narrow = x as f32;
                    *overflow |= narrow.is_infinite() && x.is_finite();
                    narrow.to_le_bytes()
                });
                base64(json, narrow);
            }
        }
    }
}

/// Writes lists of lists… of numbers, of this shape.
fn nested<I: Iterator<Item = f64>>(
    json: &mut Vec<u8>,
    shape: &[usize],
    numbers: &mut I,
    write: &impl Fn(f64, &mut Vec<u8>),
) {
    let [count, inner @ ..] = shape else { return };
    json.push(b'[');
    for index in 0..*count {
        if index > 0 {
            json.push(b',');
        }
        if inner.is_empty() {
            // There are as many numbers as the shape says.
            write(numbers.next().unwrap_or(f64::NAN), json);
        } else {
            nested(json, inner, numbers, write);
        }
    }
    json.push(b']');
}

/// Writes a string: the bytes of all numbers in base64.
fn base64<const N: usize>(json: &mut Vec<u8>, numbers: impl Iterator<Item = [u8; N]>) {
    let mut chunk = Vec::with_capacity(CHUNK);
    json.push(b'"');
    for number in numbers {
        chunk.extend_from_slice(&number);
        if chunk.len() == CHUNK {
            STANDARD.encode_append(&chunk, json);
            chunk.clear();
        }
    }
    STANDARD.encode_append(&chunk, json);
    json.push(b'"');
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `[0, 1, …]` as binary numbers, with chunks that are full, and one number more or less.
    #[test]
    fn long_arrays_are_one_string() {
        for count in [0, 1, 767, 768, 769, 1536, 2000] {
            let numbers = || (0..count).map(f64::from);
            let mut document = Document::new(&[0], Numbers::Binary64, 0);
            document.json.clear();
            document.numbers(&[count as usize], numbers(), Numbers::Binary64);
            let text = document.json.strip_prefix(b"\"").unwrap();
            let text = text.strip_suffix(b"\"").unwrap();
            let bytes: Vec<u8> = numbers().flat_map(f64::to_le_bytes).collect();
            assert_eq!(STANDARD.decode_to_vec(text).unwrap(), bytes);
        }
    }
}
