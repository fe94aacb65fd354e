//! The innermost loops over the values of the functions of a span.
//!
//! In a span the p + 1 functions that differ from zero are the same, and so are the widths that the
//! recurrence divides by: their inverses are computed once. For the usual degrees the width of a row
//! is known to the compiler.

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
pub(super) use with_width;

/// The inverses of the widths of the recurrence on the span in the middle of 2 p + 2 knots: of its
/// step r and function j in place `r (p + 1) + j`.
pub(super) fn invert_widths(knots: &[f64], width: usize, inverses: &mut [f64]) {
    for r in 1..width {
        for j in 0..r {
            inverses[r * width + j] = 1.0 / (knots[width + j] - knots[width + j - r]);
        }
    }
}

/// The values at parameters of a span, by the recurrence of PT97, algorithm A2.2.
pub(super) fn evaluate<const W: usize>(
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
pub(super) fn multiply<const W: usize>(rows: &[f64], local: &[f64], y: &mut [f64]) {
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
pub(super) fn add<const W: usize>(rows: &[f64], x: &[f64], local: &mut [f64]) {
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

/// The products of functions j ≤ i at each datum, times its weight, added up.
pub(super) fn multiply_all<const W: usize>(rows: &[f64], weights: Option<&[f64]>, all: &mut [f64]) {
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    if W == 0 {
        let width = all.len().isqrt();
        for (i, row) in rows.chunks_exact(width).enumerate() {
            for (k, sums) in all.chunks_exact_mut(width).enumerate() {
                let value = weight(i) * row[k];
                let pairs = sums[..=k].iter_mut().zip(row);
                pairs.for_each(|(sum, b)| *sum += value * b);
            }
        }
        return;
    }
    let mut sums = [[0.0; W]; W];
    let (rows, _) = rows.as_chunks::<W>();
    for (i, row) in rows.iter().enumerate() {
        for a in 0..W {
            let value = weight(i) * row[a];
            for b in 0..=a {
                sums[a][b] += value * row[b];
            }
        }
    }
    all.copy_from_slice(sums.as_flattened());
}
