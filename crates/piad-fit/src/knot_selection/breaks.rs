//! Knots of one direction during the search: simple ones, between both ends of the parameters.
//!
//! *Breaks* are the ends and the knots between them, each once; successive ones bound a *span*.
//!
//! ```text
//! open     spans + p control points, both ends p + 1 times
//! closed   as many control points as spans; function j has control point j mod spans
//! ```

use std::sync::Arc;

/// The knots of one direction.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Breaks {
    degree: usize,
    closed: bool,
    breaks: Vec<f64>,
}

impl Breaks {
    /// Knots at some breaks, which must increase; `None` if they do not, or if a closed curve has
    /// too few of them for its degree.
    pub(crate) fn new(degree: usize, closed: bool, breaks: Vec<f64>) -> Option<Self> {
        let spans = breaks.len().checked_sub(1)?;
        let least = if closed { degree + 1 } else { 1 };
        let increase = breaks.windows(2).all(|pair| pair[0] < pair[1]);
        (spans >= least && increase).then_some(Self {
            degree,
            closed,
            breaks,
        })
    }

    /// The fewest control points, p + 1, on equal spans.
    pub(crate) fn coarsest(degree: usize, closed: bool, start: f64, end: f64) -> Option<Self> {
        let spans = if closed { degree + 1 } else { 1 };
        let at = |k: usize| start + (end - start) * (k as f64 / spans as f64);
        let mut breaks: Vec<f64> = (0..spans).map(at).collect();
        breaks.push(end);
        Self::new(degree, closed, breaks)
    }

    /// The same with a knot in the middle of each span, unless spans are too short for that.
    pub(crate) fn halved(&self) -> Option<Self> {
        let middles = self.breaks.windows(2);
        let middles = middles.map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0);
        let mut breaks: Vec<f64> = self.breaks.iter().copied().chain(middles).collect();
        breaks.sort_by(f64::total_cmp);
        Self::new(self.degree, self.closed, breaks)
    }

    /// The degree p.
    pub(crate) fn degree(&self) -> usize {
        self.degree
    }

    /// Returns true if the last span is followed by the first.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Both ends and the knots between them.
    pub(crate) fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// The number of spans.
    pub(crate) fn spans(&self) -> usize {
        self.breaks.len() - 1
    }

    /// The number of control points.
    pub(crate) fn control_points(&self) -> usize {
        self.spans() + control_points_beyond_spans(self.degree, self.closed)
    }

    /// The number of control points that are fixed at each end: those of an open line, which passes through its ends.
    pub(super) fn fixed_ends(&self) -> usize {
        usize::from(!self.closed)
    }

    /// The control point that function `j` is multiplied with.
    pub(crate) fn control_point(&self, j: usize) -> usize {
        if self.closed { j % self.spans() } else { j }
    }

    /// Knot `i` of the clamped or periodic vector, of which index p is the start of the parameters. Beyond both ends a
    /// closed line continues periodically, an open one repeats its ends.
    pub(crate) fn knot(&self, i: isize) -> f64 {
        let (spans, k) = (self.spans() as isize, i - self.degree as isize);
        if self.closed {
            let period = self.breaks[self.spans()] - self.breaks[0];
            self.breaks[k.rem_euclid(spans) as usize] + k.div_euclid(spans) as f64 * period
        } else {
            self.breaks[k.clamp(0, spans) as usize]
        }
    }

    /// All spans + 2 p + 1 knots.
    pub(crate) fn knots(&self) -> Arc<Vec<f64>> {
        let count = (self.spans() + 2 * self.degree + 1) as isize;
        Arc::new((0..count).map(|i| self.knot(i)).collect())
    }

    /// Where the parameters of each span start among `t`, which increases, and after them the
    /// number of parameters. The end of an open line belongs to its last span.
    pub(crate) fn starts(&self, t: &[f64]) -> Vec<usize> {
        let mut starts = Vec::with_capacity(self.breaks.len());
        let mut at = 0;
        for &knot in &self.breaks[..self.spans()] {
            at += run_length(&t[at..], |t| t < knot);
            starts.push(at);
        }
        starts[0] = 0;
        starts.push(t.len());
        starts
    }

    /// Returns true if every control point has its own parameter (Schoenberg–Whitney), so that least squares have
    /// one solution. The ends of an open line count for its first and last control point.
    pub(crate) fn is_determined(&self, t: &[f64]) -> bool {
        let count = self.control_points();
        if count > t.len() {
            return false;
        }
        if self.closed {
            return self.is_determined_around(t);
        }
        let mut i = 1;
        (1..count - 1).all(|j| {
            let (low, high) = (
                self.knot(j as isize),
                self.knot((j + self.degree + 1) as isize),
            );
            i += run_length(t.get(i..t.len() - 1).unwrap_or_default(), |t| t <= low);
            let inside = i + 1 < t.len() && t[i] < high;
            i += 1;
            inside
        })
    }

    /// The same for a closed line: the functions take turns from some first parameter on.
    fn is_determined_around(&self, t: &[f64]) -> bool {
        let count = self.control_points();
        let period = self.breaks[self.spans()] - self.breaks[0];
        let turned = |i: usize| t[i % t.len()] + (i / t.len()) as f64 * period;
        // For any choice of the first parameter, a greedy choice works for the others.
        let first = t.partition_point(|&t| t <= self.knot(self.degree as isize));
        (0..=self.degree).any(|skip| {
            let mut i = first + skip;
            let end = i + t.len();
            (0..count).all(|j| {
                let low = self.knot((j + self.degree) as isize);
                let high = self.knot((j + 2 * self.degree + 1) as isize);
                while i < end && turned(i) <= low {
                    i += 1;
                }
                let inside = i < end && turned(i) < high;
                i += 1;
                inside
            })
        })
    }
}

/// The number of control points beyond that of spans.
pub(crate) fn control_points_beyond_spans(degree: usize, closed: bool) -> usize {
    if closed { 0 } else { degree }
}

/// The number of increasing parameters that satisfy a condition, which the first ones do. Most runs are short compared
/// with the rest: doubling steps find where one ends.
fn run_length(t: &[f64], is_within: impl Fn(f64) -> bool) -> usize {
    let mut step = 1;
    while step < t.len() && is_within(t[step]) {
        step *= 2;
    }
    let from = if step == 1 { 0 } else { step / 2 };
    let to = t.len().min(step + 1);
    from + t[from..to].partition_point(|&t| is_within(t))
}
