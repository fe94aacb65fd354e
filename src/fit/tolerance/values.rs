//! The values of all functions at all parameters, and sums of them: where a fit spends its time.
//!
//! In a span the p + 1 functions that differ from zero are the same, and so are the widths that the
//! recurrence divides by: their inverses are computed once. For the usual degrees the width of a row
//! is known to the compiler.

use std::ops::Range;

use super::line::KnotLine;

/// The values of the functions at parameters: p + 1 numbers for each of them, of those of its span
/// on.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    width: usize,
    /// Where the parameters of each span start.
    starts: Vec<usize>,
    values: Vec<f64>,
}

/// Calls a function with the width of rows as a constant, 0 for unusual ones.
macro_rules! with_width {
    ($width:expr, $name:ident ( $($argument:expr),* )) => {
        match $width {
            2 => $name::<2>($($argument),*),
            3 => $name::<3>($($argument),*),
            4 => $name::<4>($($argument),*),
            5 => $name::<5>($($argument),*),
            6 => $name::<6>($($argument),*),
            _ => $name::<0>($($argument),*),
        }
    };
}

impl Values {
    /// Evaluates all functions at increasing parameters.
    pub(crate) fn new(line: &KnotLine, t: &[f64]) -> Self {
        let (starts, width) = (line.starts(t), line.degree() + 1);
        let knots = line.knots();
        let mut values = vec![0.0; t.len() * width];
        let mut inverses = vec![0.0; width * width];
        for (span, range) in starts.windows(2).enumerate() {
            let near = &knots[span..span + 2 * width];
            invert_widths(near, width, &mut inverses);
            let rows = &mut values[range[0] * width..range[1] * width];
            let t = &t[range[0]..range[1]];
            with_width!(width, evaluate(width, near, &inverses, t, rows));
        }
        Self {
            width,
            starts,
            values,
        }
    }

    /// p + 1.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Where the parameters of each span start, and the number of parameters.
    pub(crate) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// For each span which parameters lie in it, and the p + 1 values at each of them, of functions
    /// span … span + p.
    pub(crate) fn spans(&self) -> impl Iterator<Item = (usize, Range<usize>, &[f64])> {
        self.starts.windows(2).enumerate().map(|(span, range)| {
            let rows = &self.values[range[0] * self.width..range[1] * self.width];
            (span, range[0]..range[1], rows)
        })
    }

    /// `y = A x` for one coordinate of the control points.
    pub(crate) fn apply(&self, line: &KnotLine, x: &[f64], y: &mut [f64]) {
        let mut local = vec![0.0; self.width];
        for (span, range, rows) in self.spans() {
            for (k, local) in local.iter_mut().enumerate() {
                *local = x[line.control_point(span + k)];
            }
            with_width!(self.width, multiply(rows, &local, &mut y[range]));
        }
    }

    /// `y = Aᵀ x` for one coordinate of the data.
    pub(crate) fn apply_transposed(&self, line: &KnotLine, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let mut local = vec![0.0; self.width];
        for (span, range, rows) in self.spans() {
            local.fill(0.0);
            with_width!(self.width, add(rows, &x[range], &mut local));
            for (k, sum) in local.iter().enumerate() {
                y[line.control_point(span + k)] += sum;
            }
        }
    }
}

/// The inverses of the widths of the recurrence on the span in the middle of 2 p + 2 knots: of its
/// step r and function j in place `r (p + 1) + j`.
fn invert_widths(knots: &[f64], width: usize, inverses: &mut [f64]) {
    for r in 1..width {
        for j in 0..r {
            inverses[r * width + j] = 1.0 / (knots[width + j] - knots[width + j - r]);
        }
    }
}

/// The values at parameters of a span, by the recurrence of PT97, algorithm A2.2.
fn evaluate<const W: usize>(
    width: usize,
    knots: &[f64],
    inverses: &[f64],
    t: &[f64],
    rows: &mut [f64],
) {
    let width = if W > 0 { W } else { width };
    let (knots, inverses) = (&knots[..2 * width], &inverses[..width * width]);
    for (&t, row) in t.iter().zip(rows.chunks_exact_mut(width)) {
        row[0] = 1.0;
        for r in 1..width {
            let mut carried = 0.0;
            for j in 0..r {
                let lower = row[j] * inverses[r * width + j];
                row[j] = carried + (knots[width + j] - t) * lower;
                carried = (t - knots[width + j - r]) * lower;
            }
            row[r] = carried;
        }
    }
}

/// The products of rows with the control points of their span.
fn multiply<const W: usize>(rows: &[f64], local: &[f64], y: &mut [f64]) {
    if W == 0 {
        for (y, row) in y.iter_mut().zip(rows.chunks_exact(local.len())) {
            *y = row.iter().zip(local).map(|(b, x)| b * x).sum();
        }
        return;
    }
    let (rows, _) = rows.as_chunks::<W>();
    if let Some(local) = local.first_chunk::<W>() {
        for (y, row) in y.iter_mut().zip(rows) {
            *y = (1..W).fold(row[0] * local[0], |sum, k| sum + row[k] * local[k]);
        }
    }
}

/// Adds multiples of rows.
fn add<const W: usize>(rows: &[f64], x: &[f64], local: &mut [f64]) {
    if W == 0 {
        for (x, row) in x.iter().zip(rows.chunks_exact(local.len())) {
            local.iter_mut().zip(row).for_each(|(sum, b)| *sum += b * x);
        }
        return;
    }
    let (rows, _) = rows.as_chunks::<W>();
    let mut sums = [0.0; W];
    for (x, row) in x.iter().zip(rows) {
        for k in 0..W {
            sums[k] += row[k] * x;
        }
    }
    local.copy_from_slice(&sums);
}
