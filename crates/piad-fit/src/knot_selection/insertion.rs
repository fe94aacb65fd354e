//! Inserting knots: the same curve with more control points.
//!
//! Control point j of a curve is the value of its blossom (polar form) at the knots j + 1 … j + p.
//! With more knots it is the blossom at those of the new vector, evaluated on a span of the old one
//! that these knots enclose (the Oslo algorithm; Cohen, Lyche, Riesenfeld 1980). One new knot by
//! itself is Boehm's. It costs O(p²) for each control point, however many knots are inserted.

use super::breaks::Breaks;
use crate::data::points::Points;

/// The control points of the same curve over `fine` knots, which must hold all of the `coarse`
/// ones.
pub(crate) fn refine(coarse: &Breaks, fine: &Breaks, control_points: &Points) -> Points {
    Points::from_lanes(
        control_points
            .lanes()
            .iter()
            .map(|lane| refine_line(coarse, fine, lane)),
    )
}

/// The same for one coordinate.
pub(crate) fn refine_line(coarse: &Breaks, fine: &Breaks, x: &[f64]) -> Vec<f64> {
    let degree = coarse.degree();
    let (start, end) = (coarse.breaks()[0], coarse.breaks()[coarse.spans()]);
    let period = end - start;
    let mut local = vec![0.0; degree + 1];
    let mut span = 0;
    (0..fine.control_points())
        .map(|j| {
            // On a closed line control point j is also that of function j + spans, whose knots are
            // not before the start.
            let j = if fine.is_closed() && j < degree {
                j + fine.spans()
            } else {
                j
            } as isize;
            let middle = fine.knot(j + 1 + degree as isize / 2);
            let turned = if fine.is_closed() && middle >= end {
                period
            } else {
                0.0
            };
            span = span_of(coarse, middle - turned, span);
            for (k, local) in local.iter_mut().enumerate() {
                *local = x[coarse.control_point(span + k)];
            }
            let argument = |r: usize| fine.knot(j + 1 + r as isize) - turned;
            blossom(coarse, span, &mut local, argument)
        })
        .collect()
}

/// The span of a parameter, at the end of the line the last one; near `guess` it is found at once.
fn span_of(line: &Breaks, t: f64, guess: usize) -> usize {
    let breaks = line.breaks();
    let holds = |span: usize| breaks[span] <= t && t < breaks[span + 1];
    let near = (guess..line.spans().min(guess + 3)).find(|&span| holds(span));
    near.unwrap_or_else(|| {
        let behind = breaks.partition_point(|&knot| knot <= t);
        behind.saturating_sub(1).min(line.spans() - 1)
    })
}

/// The blossom of the polynomial on a span at p arguments, by de Boor's scheme, of its p + 1
/// control points.
fn blossom(line: &Breaks, span: usize, local: &mut [f64], argument: impl Fn(usize) -> f64) -> f64 {
    let degree = line.degree();
    for r in 0..degree {
        let t = argument(r);
        for k in (r + 1..=degree).rev() {
            let low = line.knot((span + k) as isize);
            let high = line.knot((span + k + degree - r) as isize);
            let alpha = (t - low) / (high - low);
            local[k] = (1.0 - alpha) * local[k - 1] + alpha * local[k];
        }
    }
    local[degree]
}
