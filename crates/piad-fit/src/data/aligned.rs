//! Arrays of numbers, aligned in memory for fast vector loads.
//!
//! Each holds one coordinate of many points, or one diagonal of a matrix. A sweep reads and writes a dozen of them side
//! by side, and their start addresses decide how fast that is.

use std::borrow::Borrow;
use std::ops::{Deref, DerefMut};
use std::slice::{Iter, IterMut};
use std::sync::atomic::{AtomicUsize, Ordering};

use aligned_vec::{AVec, CACHELINE_ALIGN};
use rayon::prelude::*;
#[cfg(feature = "serde")]
use serde::de::{Deserialize, Deserializer, Error};
#[cfg(feature = "serde")]
use serde::ser::{Serialize, Serializer};

/// From this length on, in numbers, lanes start at different offsets of a memory page.
const STAGGERED_NUMBERS: usize = 1024;

/// From this length on, in numbers, lanes are made by several threads.
const PARALLEL: usize = 100_000;

/// A third of a memory page, in numbers and whole cache lines: long lanes start at the beginning of a page, after a
/// third of it or after two thirds.
const THIRD: usize = 168;

/// Zeros to be copied, which is faster than writing numbers one by one.
static ZEROS: [f64; 1024] = [0.0; 1024];

/// Counts the long lanes, which take turns in their offsets.
static LANES: AtomicUsize = AtomicUsize::new(0);

/// All values of a coordinate, or of a diagonal of a matrix: 8 bytes each, and at most 2.7 kB
/// before them.
///
/// Lanes start at a cache line: a SIMD vector that lies across two of them takes twice as long to load, which is as
/// much as everything else in a sweep. Long lanes start at different offsets of a memory page. Allocators would start
/// all of them at the same offset, but equal offsets share few cache lines, and a load waits for an earlier store to
/// the same offset of another page as if it were the same address ("4K aliasing").
#[derive(Debug)]
pub struct Lane {
    numbers: AVec<f64>,
    /// The index of the first number; those before it are not used.
    start: usize,
}

impl Lane {
    /// A lane without numbers, to be filled.
    pub fn new() -> Self {
        Self::with_room(0)
    }

    /// A lane of `count` zeros.
    pub fn zeros(count: usize) -> Self {
        let mut lane = Self::with_room(count);
        // Copied: a loop over numbers takes several times as long.
        let mut left = count;
        while left > 0 {
            let some = left.min(ZEROS.len());
            lane.numbers.extend_from_slice(&ZEROS[..some]);
            left -= some;
        }
        lane
    }

    /// A lane without numbers, and with room for `count` of them.
    pub(crate) fn with_room(count: usize) -> Self {
        let start = match count {
            STAGGERED_NUMBERS.. => LANES.fetch_add(1, Ordering::Relaxed) % 3 * THIRD,
            _ => 0,
        };
        let mut numbers = AVec::with_capacity(CACHELINE_ALIGN, start + count);
        numbers.resize(start, 0.0);
        Self { numbers, start }
    }

    /// Appends a number.
    pub fn push(&mut self, value: f64) {
        self.numbers.push(value);
    }

    /// Appends numbers.
    pub fn extend_from_slice(&mut self, values: &[f64]) {
        self.numbers.extend_from_slice(values);
    }

    /// Makes room for `more` numbers, and for no others.
    pub(crate) fn make_room(&mut self, more: usize) {
        // If this much memory is not available, the capacity doubles when it is full.
        let _ = self.numbers.try_reserve_exact(more);
    }

    /// Keeps the first `count` numbers.
    pub fn truncate(&mut self, count: usize) {
        self.numbers.truncate(self.start + count);
    }

    /// Releases memory that growing has left over.
    pub fn shrink_to_fit(&mut self) {
        self.numbers.shrink_to_fit();
    }
}

/// Makes `count` lanes of a length by `lane`, long ones by several threads: the first use of memory
/// takes longer than writing it, as the operating system clears every page.
pub(crate) fn lanes(
    count: usize,
    length: usize,
    lane: impl Fn(usize) -> Lane + Send + Sync,
) -> Vec<Lane> {
    if length < PARALLEL {
        (0..count).map(lane).collect()
    } else {
        (0..count).into_par_iter().map(lane).collect()
    }
}

impl Clone for Lane {
    /// A copy starts at another place of a page than the original.
    fn clone(&self) -> Self {
        Self::from(&self[..])
    }
}

impl PartialEq for Lane {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl Default for Lane {
    fn default() -> Self {
        Self::new()
    }
}

impl From<&[f64]> for Lane {
    fn from(values: &[f64]) -> Self {
        let mut lane = Self::with_room(values.len());
        lane.numbers.extend_from_slice(values);
        lane
    }
}

impl From<Vec<f64>> for Lane {
    fn from(values: Vec<f64>) -> Self {
        Self::from(values.as_slice())
    }
}

impl FromIterator<f64> for Lane {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let values = values.into_iter();
        let mut lane = Self::with_room(values.size_hint().0);
        values.for_each(|value| lane.push(value));
        lane
    }
}

/// Written as its bytes, little-endian, which binary formats copy as they are; as numbers in formats for people.
#[cfg(feature = "serde")]
impl Serialize for Lane {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return serializer.collect_seq(self.iter());
        }
        let mut bytes = vec![0; size_of_val(&self[..])];
        let (places, _) = bytes.as_chunks_mut();
        for (place, x) in places.iter_mut().zip(self) {
            *place = x.to_le_bytes();
        }
        serializer.serialize_bytes(&bytes)
    }
}

#[cfg(feature = "serde")]
impl<'de> Deserialize<'de> for Lane {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return Ok(Vec::<f64>::deserialize(deserializer)?.into_iter().collect());
        }
        let (numbers, rest) = <&[u8]>::deserialize(deserializer)?.as_chunks();
        if !rest.is_empty() {
            return Err(D::Error::custom("a number is cut off"));
        }
        let mut lane = Self::zeros(numbers.len());
        for (x, bytes) in lane.iter_mut().zip(numbers) {
            *x = f64::from_le_bytes(*bytes);
        }
        Ok(lane)
    }
}

impl Deref for Lane {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.numbers[self.start..]
    }
}

impl DerefMut for Lane {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.start..]
    }
}

impl AsMut<[f64]> for Lane {
    fn as_mut(&mut self) -> &mut [f64] {
        self
    }
}

impl Borrow<[f64]> for Lane {
    fn borrow(&self) -> &[f64] {
        self
    }
}

impl<'a> IntoIterator for &'a Lane {
    type Item = &'a f64;
    type IntoIter = Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Lane {
    type Item = &'a mut f64;
    type IntoIter = IterMut<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}
