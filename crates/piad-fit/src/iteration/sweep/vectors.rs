//! Arrays and sums as vectors of whatever length the processor has.
//!
//! Code in a loop that is compiled for every width, dimension and instruction set is compiled as
//! often; these functions are compiled for few types.

use std::array::from_fn;

use pulp::Simd;

use crate::data::blocks::{LANES, Sums};

/// The first n vectors of each array from place `from` on.
#[inline(always)]
pub(super) fn vectors_of<S: Simd, const N: usize>(
    arrays: [&[f64]; N],
    from: usize,
    n: usize,
) -> [&[S::f64s]; N] {
    arrays.map(|array| &S::as_simd_f64s(&array[from..]).0[..n])
}

/// The first n vectors of each array from place `from` on, to be written.
#[inline(always)]
pub(super) fn vectors_of_mut<'a, S: Simd, const N: usize>(
    arrays: &'a mut [&mut [f64]; N],
    from: usize,
    n: usize,
) -> [&'a mut [S::f64s]; N] {
    let arrays = arrays.each_mut();
    arrays.map(|array| &mut S::as_mut_simd_f64s(&mut array[from..]).0[..n])
}

/// For each array its first n vectors from place `from + k` on, k = 0 … W − 1: what entry k of a
/// row is multiplied with. Vectors that are not aligned are loaded as quickly on today's
/// processors.
#[inline(always)]
pub(super) fn shifted<S: Simd, const D: usize, const W: usize>(
    arrays: [&[f64]; D],
    from: usize,
    n: usize,
) -> [[&[S::f64s]; W]; D] {
    arrays.map(|array| vectors_of::<S, W>(from_fn(|k| &array[k..]), from, n))
}

/// The i-th vector of each array.
#[inline(always)]
pub(super) fn at<V: Copy, const N: usize>(arrays: &[&[V]; N], i: usize) -> [V; N] {
    arrays.map(|array| array[i])
}

/// [`Sums`] in the making: as many vectors as fill the [`LANES`] lanes.
pub(super) struct VectorSums<S: Simd> {
    max: [S::f64s; LANES],
    squares: [S::f64s; LANES],
    roots: [S::f64s; LANES],
}

impl<S: Simd> VectorSums<S> {
    /// Vectors that continue from these sums.
    #[inline(always)]
    pub(super) fn new(sums: &Sums) -> Self {
        let vectors = |lanes: &[f64; LANES]| {
            let vectors = S::as_simd_f64s(lanes).0;
            from_fn(|k| vectors[k % vectors.len()])
        };
        Self {
            max: vectors(&sums.max),
            squares: vectors(&sums.squares),
            roots: vectors(&sums.roots),
        }
    }

    /// Adds a vector of squares to the lanes that vector number `vector` of a round stands for.
    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, vector: usize, square: S::f64s) {
        let max = self.max[vector];
        // NaN is never the largest: the comparison is false.
        self.max[vector] = simd.select_f64s(simd.greater_than_f64s(square, max), square, max);
        self.squares[vector] = simd.add_f64s(self.squares[vector], square);
        self.roots[vector] = simd.add_f64s(self.roots[vector], simd.sqrt_f64s(square));
    }

    /// Writes the vectors back to the sums.
    #[inline(always)]
    pub(super) fn store(self, sums: &mut Sums) {
        let store = |vectors: [S::f64s; LANES], lanes: &mut [f64; LANES]| {
            let places = S::as_mut_simd_f64s(lanes).0.iter_mut();
            places
                .zip(vectors)
                .for_each(|(place, vector)| *place = vector);
        };
        store(self.max, &mut sums.max);
        store(self.squares, &mut sums.squares);
        store(self.roots, &mut sums.roots);
    }
}
