//! Equal shares of a range of indices, the same for both directions of counting.
//!
//! Share k of n of the indices 0 … m ends at the position `k m / n`, which is m less that of share
//! n − k: what lies there is the same for reversed data. Between two indices it is interpolated from
//! the nearer one, so that neither rounding nor a large value puts it beyond them:
//!
//! ```text
//! i = ⌊k m / n⌋,   α = k m / n − i,   (1 − α) x_i + α x_{i+1}
//! ```

/// A position among indices: `part / parts` of the way from `index` to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Position {
    index: usize,
    part: usize,
    parts: usize,
}

impl Position {
    /// The end of share `k` of `parts` shares of the indices 0 … `last`.
    pub(crate) fn new(k: usize, parts: usize, last: usize) -> Self {
        Self {
            index: k * last / parts,
            part: k * last % parts,
            parts,
        }
    }

    /// At an index.
    pub(crate) fn at(index: usize) -> Self {
        Self {
            index,
            part: 0,
            parts: 1,
        }
    }

    /// Interpolates here between the values at both indices.
    pub(crate) fn between(self, value: impl Fn(usize) -> f64) -> f64 {
        let here = value(self.index);
        if self.part == 0 {
            return here;
        }
        let next = value(self.index + 1);
        let part = |part: usize| part as f64 / self.parts as f64;
        let rest = self.parts - self.part;
        if self.part <= rest {
            here + part(self.part) * (next - here)
        } else {
            next - part(rest) * (next - here)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Position;

    /// Values at positions, counted from either end.
    #[test]
    fn both_directions_agree() {
        for (parts, last) in (1..30).flat_map(|n| (n..60).map(move |m| (n, m))) {
            let value = |i: usize| (i as f64).powi(3);
            for k in 0..=parts {
                let forth = Position::new(k, parts, last).between(value);
                let back = Position::new(parts - k, parts, last);
                let back = back.between(|i| value(last - i));
                assert!(
                    (forth - back).abs() <= 1e-15 * value(last),
                    "{k} {parts} {last}"
                );
            }
            assert_eq!(Position::new(0, parts, last).between(value), 0.0);
            let end = Position::new(parts, parts, last).between(value);
            assert_eq!(end, value(last));
        }
    }
}
