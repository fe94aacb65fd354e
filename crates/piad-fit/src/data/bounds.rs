//! The minimum and the maximum of many numbers, and if all are finite, in one pass.
//!
//! Every fit reads all of its coordinates before anything else: for the bounding box, which scales
//! errors, and for infinite numbers and NaN. These are found by the sum of all numbers times zero,
//! which needs no branch: it is zero unless one of them is infinite or NaN.

/// The number of comparisons side by side.
const LANES: usize = 8;

/// The least and the largest of some numbers. An empty array has the extent from infinity to minus
/// infinity. NaN is ignored, but for [`is_finite`](Self::is_finite).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// The least.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// True if all numbers are finite: none of them is infinite or NaN.
    pub is_finite: bool,
}

impl Extent {
    /// The extent of all values.
    pub(crate) fn of(values: &[f64]) -> Self {
        pulp::Arch::new().dispatch(Look(values))
    }

    /// The difference of the largest and the least number, or 0 for an empty array.
    pub(crate) fn length(&self) -> f64 {
        if self.low <= self.high {
            self.high - self.low
        } else {
            0.0
        }
    }
}

/// The pass over all values, compiled for several instruction sets.
struct Look<'a>(&'a [f64]);

impl pulp::NullaryFnOnce for Look<'_> {
    type Output = Extent;

    #[inline(always)]
    fn call(self) -> Extent {
        let mut low = [f64::INFINITY; LANES];
        let mut high = [f64::NEG_INFINITY; LANES];
        let mut zero = [0.0; LANES];
        let (chunks, rest) = self.0.as_chunks::<LANES>();
        for chunk in chunks {
            for k in 0..LANES {
                let x = chunk[k];
                low[k] = if x < low[k] { x } else { low[k] };
                high[k] = if x > high[k] { x } else { high[k] };
                // Zero, unless the number is infinite or NaN; then NaN.
                zero[k] += x * 0.0;
            }
        }
        for (k, &x) in rest.iter().enumerate() {
            low[k] = if x < low[k] { x } else { low[k] };
            high[k] = if x > high[k] { x } else { high[k] };
            zero[k] += x * 0.0;
        }
        Extent {
            low: low.into_iter().fold(f64::INFINITY, f64::min),
            high: high.into_iter().fold(f64::NEG_INFINITY, f64::max),
            is_finite: zero.iter().all(|x| *x == 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least number, infinity and NaN at every place of arrays of every length.
    #[test]
    fn every_place_counts() {
        for n in 0..40 {
            for at in 0..n {
                let mut values = vec![1.0; n];
                values[at] = -3.0;
                let extent = Extent::of(&values);
                assert_eq!((extent.low, extent.is_finite), (-3.0, true));
                assert_eq!(extent.high, if n == 1 { -3.0 } else { 1.0 });
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    values[at] = bad;
                    assert!(!Extent::of(&values).is_finite);
                }
            }
        }
        assert_eq!(Extent::of(&[]).length(), 0.0);
        assert_eq!(Extent::of(&[2.0, -1.0]).length(), 3.0);
    }
}
