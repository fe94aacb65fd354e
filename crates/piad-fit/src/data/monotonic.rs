//! Order and zero tests of long arrays of numbers.
//!
//! Most inputs satisfy these tests, so that every number has to be compared: many at a time,
//! without a branch for each, and long arrays by several threads. If a test fails, the caller
//! searches for the index. The arrays are explicit parameters and knots, and diagonals of matrices.

use rayon::prelude::*;

/// The number of comparisons that a thread does at a time.
const CHUNK: usize = 1 << 16;

/// Returns true if each number is less than the one after it. If so, two or more numbers have no
/// NaN among them.
pub(crate) fn increases(values: &[f64]) -> bool {
    values.len() < 2 || all_less(&values[..values.len() - 1], &values[1..])
}

/// Returns true if each number is at most the one after it. If so, two or more numbers have no NaN
/// among them.
pub(crate) fn never_decreases(values: &[f64]) -> bool {
    values.len() < 2 || all(&values[..values.len() - 1], &values[1..], |a, b| a <= b)
}

/// Returns true if each number is less than the one at the same index, as far as both arrays
/// reach.
pub(crate) fn all_less(these: &[f64], others: &[f64]) -> bool {
    all(these, others, |a, b| a < b)
}

/// Returns true if all numbers are zero. It stops at the first chunk that has another one.
pub(crate) fn is_zero(values: &[f64]) -> bool {
    /// The numbers of a chunk.
    const LOOK: usize = 256;
    let mut looks = values.chunks(LOOK);
    looks.all(|values| values.iter().fold(true, |all, x| all & (*x == 0.0)))
}

/// Returns true if a comparison is true for all pairs.
fn all(these: &[f64], others: &[f64], compare: impl Fn(f64, f64) -> bool + Copy + Sync) -> bool {
    let chunk = |(these, others): (&[f64], &[f64])| {
        let pairs = these.iter().zip(others);
        // Without a branch for each, so that they are compared side by side.
        pairs.fold(true, |all, (a, b)| all & compare(*a, *b))
    };
    if these.len() <= CHUNK {
        return chunk((these, others));
    }
    let chunks = these.par_chunks(CHUNK).zip(others.par_chunks(CHUNK));
    chunks.all(chunk)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the ends and in the middle of chunks.
    #[test]
    fn every_number_can_differ_from_zero() {
        for count in [0, 1, 255, 256, 257, 1000] {
            let mut values = vec![0.0; count];
            assert!(is_zero(&values));
            for at in [0, count / 2, count.saturating_sub(1)] {
                for x in [1e-300, f64::NAN] {
                    if let Some(place) = values.get_mut(at) {
                        *place = x;
                        assert!(!is_zero(&values));
                        values[at] = 0.0;
                    }
                }
            }
        }
    }

    /// Equal neighbours, descents and NaN at any place, also where threads meet.
    #[test]
    fn every_place_counts() {
        for count in [1, 2, 9, CHUNK + 3, 3 * CHUNK] {
            let ordered: Vec<f64> = (0..count).map(|i| i as f64).collect();
            assert!(increases(&ordered) && never_decreases(&ordered));
            for at in [1, 2, count / 2, count - 1]
                .into_iter()
                .filter(|at| (1..count).contains(at))
            {
                let with = |value: f64| {
                    let mut values = ordered.clone();
                    values[at] = value;
                    values
                };
                let equal = with(ordered[at - 1]);
                assert!(!increases(&equal) && never_decreases(&equal));
                for bad in [ordered[at - 1] - 0.5, f64::NAN] {
                    assert!(!increases(&with(bad)) && !never_decreases(&with(bad)));
                }
            }
        }
    }
}
