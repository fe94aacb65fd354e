//! Numbers in a row, from the start of a cache line on.

use std::borrow::Borrow;
use std::ops::{Deref, DerefMut};
use std::slice::{Iter, IterMut};

use aligned_vec::{AVec, CACHELINE_ALIGN, avec};

/// All values of a coordinate, or of a diagonal of a matrix.
///
/// They start at a cache line: a vector of numbers that lies across two of them takes twice as long
/// to load, which is as much as everything else in a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane(AVec<f64>);

impl Lane {
    /// No numbers yet.
    pub fn new() -> Self {
        Self(avec![])
    }

    /// So many zeros.
    pub fn zeros(count: usize) -> Self {
        Self(avec![0.0; count])
    }

    /// Appends a number.
    pub fn push(&mut self, value: f64) {
        self.0.push(value);
    }

    /// Gives back memory that growing has left over.
    pub fn shrink_to_fit(&mut self) {
        self.0.shrink_to_fit();
    }
}

impl Default for Lane {
    fn default() -> Self {
        Self::new()
    }
}

impl From<&[f64]> for Lane {
    fn from(values: &[f64]) -> Self {
        Self(AVec::from_slice(CACHELINE_ALIGN, values))
    }
}

impl From<Vec<f64>> for Lane {
    fn from(values: Vec<f64>) -> Self {
        Self::from(values.as_slice())
    }
}

impl FromIterator<f64> for Lane {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self(AVec::from_iter(CACHELINE_ALIGN, values))
    }
}

impl Deref for Lane {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Lane {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl AsMut<[f64]> for Lane {
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl Borrow<[f64]> for Lane {
    fn borrow(&self) -> &[f64] {
        &self.0
    }
}

impl<'a> IntoIterator for &'a Lane {
    type Item = &'a f64;
    type IntoIter = Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a> IntoIterator for &'a mut Lane {
    type Item = &'a mut f64;
    type IntoIter = IterMut<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}
