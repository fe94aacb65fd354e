//! JSON objects with large arrays of numbers.

use serde::Serialize;

use super::source::Source;
use super::writer::{Digits, Writer, fits_32_bits};
use crate::job::content::Content;

/// A JSON object that is being written.
pub struct Document {
    writer: Writer,
    digits: Digits,
    /// Nothing stands in the innermost object or list yet.
    is_fresh: bool,
    /// Numbers are not written, but looked at: whether 32 bits are enough for all.
    measured: Option<bool>,
}

impl Document {
    /// Begins with the fields of `head`, which are small and at least one. Arrays of about `count`
    /// numbers will follow.
    pub fn new(head: &impl Serialize, digits: Digits, count: usize) -> Self {
        let mut document = Self {
            writer: Writer::with_capacity(512 + count.saturating_mul(digits.size())),
            digits,
            is_fresh: false,
            measured: None,
        };
        document.value(head);
        document.text().pop();
        document
    }

    /// Writes fields with arrays of numbers; binary ones after their encoding and the shape of
    /// the first of them. If one of the numbers is too large for 32 bits all of them get 64,
    /// so that none becomes infinite.
    pub fn arrays(&mut self, shape: &[usize], fields: impl Fn(&mut Self)) {
        if matches!(self.digits, Digits::Base64F32) {
            let start = self.text().len();
            self.measured = Some(true);
            fields(self);
            self.text().truncate(start);
            if self.measured.take() == Some(false) {
                self.digits = Digits::Base64;
            }
        }
        let encoding = match self.digits {
            Digits::Decimal(_) | Digits::Raw => None,
            Digits::Base64 => Some("base64"),
            Digits::Base64F32 => Some("base64_f32"),
        };
        if let Some(encoding) = encoding {
            self.field("encoding", &encoding);
            self.field("shape", &shape);
        }
        fields(self);
    }

    /// Writes fields with arrays of numbers that have 64 bits in any encoding.
    pub fn precise(&mut self, fields: impl FnOnce(&mut Self)) {
        let digits = self.digits;
        if matches!(digits, Digits::Base64F32) {
            self.digits = Digits::Base64;
        }
        fields(self);
        self.digits = digits;
    }

    /// Writes a field that is small.
    pub fn field(&mut self, name: &str, value: &impl Serialize) {
        self.key(name);
        self.value(value);
    }

    /// Writes a field with an array of coordinates of this shape, the last index running fastest.
    /// Coordinates are what may be rounded.
    pub fn coordinates(&mut self, name: &str, shape: &[usize], numbers: impl Source) {
        self.key(name);
        self.numbers(shape, numbers, self.digits);
    }

    /// Writes a field with an array of other numbers.
    pub fn array(&mut self, name: &str, shape: &[usize], numbers: impl Source) {
        self.key(name);
        let digits = match self.digits {
            Digits::Decimal(_) => Digits::Decimal(None),
            binary => binary,
        };
        self.numbers(shape, numbers, digits);
    }

    /// Writes a field with an object.
    pub fn object(&mut self, name: &str, fields: impl FnOnce(&mut Self)) {
        self.key(name);
        self.within(b'{', b'}', fields);
    }

    /// Writes a field with a list of lists.
    pub fn lists<T>(
        &mut self,
        name: &str,
        items: impl Iterator<Item = T>,
        mut elements: impl FnMut(&mut Self, T),
    ) {
        self.key(name);
        self.within(b'[', b']', |document| {
            for item in items {
                document.separate();
                document.within(b'[', b']', |document| elements(document, item));
            }
        });
    }

    /// Writes an element of a list.
    pub fn element(&mut self, value: &impl Serialize) {
        self.separate();
        self.value(value);
    }

    /// Writes a point as an element of a list.
    pub fn point(&mut self, coordinates: impl Iterator<Item = f64>) {
        self.separate();
        let coordinates: Vec<f64> = coordinates.collect();
        self.numbers(&[coordinates.len()], coordinates, self.digits);
    }

    /// The object is complete.
    pub fn finish(mut self) -> Content {
        self.text().push(b'}');
        self.writer.finish()
    }

    fn text(&mut self) -> &mut Vec<u8> {
        self.writer.text()
    }

    fn within(&mut self, open: u8, close: u8, inner: impl FnOnce(&mut Self)) {
        self.text().push(open);
        self.is_fresh = true;
        inner(self);
        self.is_fresh = false;
        self.text().push(close);
    }

    fn key(&mut self, name: &str) {
        self.separate();
        self.value(&name);
        self.text().push(b':');
    }

    /// A comma, unless nothing stands before it.
    fn separate(&mut self) {
        if !std::mem::take(&mut self.is_fresh) {
            self.text().push(b',');
        }
    }

    /// The values that are written here always have a JSON form.
    fn value(&mut self, value: &impl Serialize) {
        if let Err(error) = serde_json::to_writer(self.text(), value) {
            tracing::error!(%error, "a value has no JSON form");
        }
    }

    fn numbers(&mut self, shape: &[usize], numbers: impl Source, digits: Digits) {
        match &mut self.measured {
            Some(fits) => *fits &= fits_32_bits(shape.iter().product(), &numbers),
            None => self.writer.array(shape.into(), numbers, digits),
        }
    }
}
