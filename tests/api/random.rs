//! Numbers that look random, the same in each run.

/// Splitmix64, from a seed.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Between 0 and 1.
    pub fn part(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From `low` to `high`, both included.
    pub fn from(&mut self, low: usize, high: usize) -> usize {
        low + self.next() as usize % (high + 1 - low)
    }

    pub fn chance(&mut self, part: f64) -> bool {
        self.part() < part
    }

    pub fn vector(&mut self) -> Vec<f64> {
        (0..3).map(|_| 4.0 * self.part() - 2.0).collect()
    }

    pub fn below(&mut self, count: usize) -> usize {
        self.from(0, count.max(1) - 1)
    }

    pub fn one<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}
