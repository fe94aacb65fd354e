//! The places where a value along a curve or surface is least and largest.

/// A place of a curve or surface with a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// The parameter, of a surface that of its first direction.
    pub u: f64,
    /// The parameter of the second direction of a surface.
    pub v: Option<f64>,
    /// The point there.
    pub point: Vec<f64>,
    /// The value there.
    pub value: f64,
}

/// The least and the largest value; `None` if there is no value at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extremes {
    /// The least.
    pub smallest: Option<Extreme>,
    /// The largest.
    pub largest: Option<Extreme>,
}

/// An interval of a knot span in which a value is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bracket {
    pub span: usize,
    pub low: f64,
    pub high: f64,
}

impl Bracket {
    /// Equally many steps from one end to the other.
    pub(super) fn steps(self, count: usize) -> impl Iterator<Item = f64> + Clone {
        let part = move |k: usize| k as f64 / count as f64;
        (0..=count).map(move |k| (1.0 - part(k)) * self.low + part(k) * self.high)
    }

    /// The part around one step.
    pub(super) fn around(self, k: usize, count: usize) -> Self {
        let at = |k: usize| {
            let part = k as f64 / count as f64;
            (1.0 - part) * self.low + part * self.high
        };
        Self {
            span: self.span,
            low: at(k.saturating_sub(1)),
            high: at((k + 1).min(count)),
        }
    }
}

/// The best value so far, and where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best<P> {
    /// 1 to look for the largest value, −1 for the least.
    pub sign: f64,
    /// It, and its place.
    pub found: Option<(f64, P)>,
}

impl<P: Copy> Best<P> {
    /// One for the least value, and one for the largest.
    pub(super) fn both() -> [Self; 2] {
        [-1.0, 1.0].map(|sign| Self { sign, found: None })
    }

    /// Keeps a value if it is better than the one before; NaN is ignored.
    pub(super) fn offer(&mut self, value: f64, place: impl FnOnce() -> P) {
        if value.is_finite() && self.is_below(value) {
            self.found = Some((value, place()));
        }
    }

    /// Returns true if a value is better than the one that was found.
    pub(super) fn is_below(&self, value: f64) -> bool {
        let before = self.found.map(|(value, _)| self.sign * value);
        before.is_none_or(|before| self.sign * value > before)
    }
}

/// A place, and its neighbourhood, in which the value may be better.
impl<S: Copy, B: Copy> Best<(S, Option<B>)> {
    /// Without a value yet.
    pub(super) fn again(&self) -> Self {
        Self {
            sign: self.sign,
            found: None,
        }
    }

    /// Takes what was found around the place: a better one, or a smaller part around the same. Returns false if there is
    /// no value any more.
    pub(super) fn improve(&mut self, round: &Self) -> bool {
        let Some((value, place)) = round.found else {
            return false;
        };
        // A difference within rounding is not better.
        let is_better =
            |before: f64| self.sign * (value - before) > 4.0 * f64::EPSILON * before.abs();
        let (value, site) = match self.found {
            Some((before, (site, _))) if !is_better(before) => (before, site),
            _ => (value, place.0),
        };
        self.found = Some((value, (site, place.1)));
        true
    }
}
