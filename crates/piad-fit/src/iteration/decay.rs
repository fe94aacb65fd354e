//! The decay of the errors of a fit, and a prediction of when they will be within its tolerance.
//!
//! The error e(k) of level k is a sum of parts `c_i (1 − λ_i)ᵏ`, of which those with large eigenvalues λ
//! vanish first, so that its rate
//!
//! ```text
//! g(k) = −d ln e / dk
//! ```
//!
//! falls, too. Between the last quarters of the levels it is measured and modelled as a power,
//! `g(x) = g(k) (x/k)^(−a)`. With a = 0 that is one eigenvalue, `e ~ exp(−g k)`; with a = 1 many,
//! and the error a power of the level, `e ~ k^(−g k)`. It never falls below the rate of the least
//! eigenvalue, where that is known. The level at which the error has fallen to the tolerance
//! follows from the integral of g.

/// The most errors that are remembered: of long fits every second, fourth … one.
const MAX_ERRORS: usize = 256;

/// The least number of levels that allow an estimate.
const LEAST: usize = 4;

/// The greatest ratio of a forecast's last level to the last level that is known.
const HORIZON: f64 = 8.0;

/// The errors of the levels so far.
#[derive(Clone, Debug)]
pub(crate) struct Decay {
    /// Logarithms of the errors of every `stride`-th level.
    logs: Vec<f64>,
    /// A power of two.
    stride: usize,
}

impl Default for Decay {
    fn default() -> Self {
        Self {
            logs: Vec::new(),
            stride: 1,
        }
    }
}

impl Decay {
    /// Notes the error of a level, in any unit. Levels come one after the other, from 0 on.
    pub(crate) fn record(&mut self, level: usize, error: f64) {
        if !level.is_multiple_of(self.stride) {
            return;
        }
        if self.logs.len() == MAX_ERRORS {
            let mut index = 0;
            self.logs.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
        if level.is_multiple_of(self.stride) {
            self.logs.push(error.ln());
        }
    }

    /// The last remembered level up to this one, and the logarithm of its error.
    fn before(&self, level: usize) -> Option<(f64, f64)> {
        let index = level / self.stride;
        let log = *self.logs.get(index)?;
        Some(((index * self.stride) as f64, log))
    }

    /// The level at which the error will be within the tolerance, if the errors so far determine it. Both are in the
    /// same unit. In the long run each level reduces the error at least by the factor `slowest`, if that is known.
    pub(crate) fn end(
        &self,
        level: usize,
        error: f64,
        tolerance: f64,
        slowest: Option<f64>,
    ) -> Option<usize> {
        if error <= tolerance {
            return Some(level);
        }
        let left = (error / tolerance).ln();
        let slowest = slowest.map_or(0.0, |rate| -rate.ln()).max(0.0);
        let end = self.falling(level, error.ln())?.end(left, slowest);
        (end.is_finite() && end <= HORIZON * level as f64).then_some(end.ceil() as usize)
    }

    /// How the error falls at a level, by what its logarithm has lost between a quarter, a half and
    /// all of the levels.
    fn falling(&self, level: usize, log: f64) -> Option<Falling> {
        if level < LEAST {
            return None;
        }
        let now = (level as f64, log);
        let (early, middle) = (self.before(level / 4)?, self.before(level / 2)?);
        let rate = |from: (f64, f64), to: (f64, f64)| (from.1 - to.1) / (to.0 - from.0);
        let (first, last) = (rate(early, middle), rate(middle, now));
        let centre = |from: (f64, f64), to: (f64, f64)| f64::midpoint(from.0, to.0).max(0.5);
        let ratio = (centre(middle, now) / centre(early, middle)).ln();
        let slowing = (first / last).ln() / ratio;
        let slowing = if slowing.is_finite() {
            slowing.clamp(0.0, 1.0)
        } else {
            0.0
        };
        let known = last > 0.0 && last.is_finite();
        known.then(|| Falling {
            level: now.0,
            rate: last * (centre(middle, now) / now.0).powf(slowing),
            slowing,
        })
    }
}

/// The model of the rate at a level.
struct Falling {
    /// The level k.
    level: f64,
    /// The rate g(k), per level.
    rate: f64,
    /// The exponent a, from 0 to 1.
    slowing: f64,
}

impl Falling {
    /// The level at which the logarithm of the error has fallen by `left`, while the rate is at
    /// least `slowest`.
    fn end(&self, left: f64, slowest: f64) -> f64 {
        let Self {
            level,
            rate,
            slowing,
        } = *self;
        // The long run has not begun where errors fall more slowly than they will.
        let slowest = if rate < slowest { 0.0 } else { slowest };
        if slowing < 1e-3 {
            return level + left / rate;
        }
        // ∫ g from k to x = g k ((x/k)^(1−a) − 1) / (1 − a)
        let fallen = |x: f64| match 1.0 - slowing {
            rest if rest < 1e-3 => rate * level * (x / level).ln(),
            rest => rate * level * ((x / level).powf(rest) - 1.0) / rest,
        };
        let constant_from = level * (rate / slowest).powf(1.0 / slowing);
        if constant_from.is_finite() && fallen(constant_from) < left {
            return constant_from + (left - fallen(constant_from)) / slowest;
        }
        let part = left / (rate * level);
        match 1.0 - slowing {
            rest if rest < 1e-3 => level * part.exp(),
            rest => level * (1.0 + rest * part).powf(1.0 / rest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records errors until `level` and forecasts.
    fn forecast(
        error: impl Fn(f64) -> f64,
        level: usize,
        tolerance: f64,
        slowest: Option<f64>,
    ) -> Option<usize> {
        let mut decay = Decay::default();
        (0..=level).for_each(|k| decay.record(k, error(k as f64)));
        decay.end(level, error(level as f64), tolerance, slowest)
    }

    /// The forecast is right to a level or two.
    #[test]
    fn one_eigenvalue_is_a_geometric_sequence() {
        let error = |k: f64| 3.0 * 0.9_f64.powf(k);
        let needed = (3.0 / 1e-9_f64).ln() / -(0.9_f64.ln());
        for level in [30, 100, 200] {
            let found = forecast(error, level, 1e-9, None).unwrap();
            assert!(
                (found as f64 - needed).abs() < 2.0,
                "{level}: {found} {needed}"
            );
        }
    }

    /// The forecast is right to a tenth.
    #[test]
    fn many_eigenvalues_are_a_power_law() {
        let error = |k: f64| (1.0 + k).powf(-1.5);
        let needed = 1e-4_f64.powf(-1.0 / 1.5);
        for level in [100, 200, 400] {
            let found = forecast(error, level, 1e-4, None).unwrap() as f64;
            assert!(
                (found / needed - 1.0).abs() < 0.1,
                "{level}: {found} {needed}"
            );
        }
    }

    /// A fast component that vanishes, and a slow one of which the eigenvalue is known.
    #[test]
    fn the_least_eigenvalue_bounds_the_forecast() {
        let error = |k: f64| 0.5_f64.powf(k) + 1e-3 * 0.95_f64.powf(k);
        let needed = (1e-3 / 1e-6_f64).ln() / -(0.95_f64.ln());
        let found = forecast(error, 20, 1e-6, Some(0.95)).unwrap() as f64;
        assert!((found / needed - 1.0).abs() < 0.4, "{found} {needed}");
    }

    /// Neither are errors that are no numbers, nor ends at a tolerance of zero.
    #[test]
    fn far_or_constant_errors_are_not_predicted() {
        assert_eq!(forecast(|_| 1.0, 50, 1e-3, None), None);
        assert_eq!(forecast(|k| 0.999_f64.powf(k), 50, 1e-9, None), None);
        assert_eq!(forecast(|k| 0.5_f64.powf(k), 2, 1e-9, None), None);
        assert_eq!(forecast(|k| 0.5_f64.powf(k), 20, 0.0, None), None);
        assert_eq!(forecast(|_| f64::NAN, 20, 1e-3, None), None);
        assert_eq!(forecast(|k| 0.5_f64.powf(k), 20, 1.0, None), Some(20));
    }

    /// However many levels there are, and wherever one is searched for.
    #[test]
    fn little_is_remembered_of_long_fits() {
        let mut decay = Decay::default();
        (0..100_000).for_each(|k| decay.record(k, (-1e-3 * k as f64).exp()));
        assert!(decay.logs.len() <= MAX_ERRORS);
        let (level, log) = decay.before(70_000).unwrap();
        assert!((70_000.0 - level) < decay.stride as f64 && (log + 1e-3 * level).abs() < 1e-9);
    }
}
