//! A step of the knots towards places where the sum of squares is smaller.
//!
//! The control points follow the knots, as they are the minimum over them, so the knots alone are unknown (variable
//! projection; Golub, Pereyra 1973). With the residual r of each coordinate, and its derivatives D by the knots, a
//! step of Gauss and Newton is (Kaufman 1975)
//!
//! ```text
//! S δ = Σ_c D_cᵀ W r_c,   S = Σ_c D_cᵀ W D_c − (AᵀW D_c)ᵀ (AᵀWA)⁻¹ (AᵀW D_c)
//! ```
//!
//! The derivative of a spline by its knot `u_s` is a spline, too, over the knots with `u_s` twice (Piegl, Tiller,
//! *Computing the derivative of NURBS with respect to a knot*, CAGD 15 (1998)):
//!
//! ```text
//! ∂C/∂u_s = Σ_{i = s−p … s} (c_{i−1} − c_i) / (u_{i+p} − u_i) N̄_i
//! ```

use nalgebra::{Cholesky, DMatrix, DVector};

use super::breaks::Breaks;
use super::gram::Gram;
use super::values::Values;
use crate::basis::bspline;
use crate::data::points::{Points, normalizing_scale};

/// Curves of more spans, or of a higher degree, keep their knots.
const MOST_SPANS: usize = 128;

/// See [`MOST_SPANS`].
const MOST_DEGREE: usize = 10;

/// More data would take too long: a step takes O(n p³).
const MOST_DATA: usize = 20_000;

/// Returns true if the knots of a curve through this number of data can move: its number of spans and its degree must
/// not be too large, and the degree not 1.
pub(super) fn can_move(line: &Breaks, data: usize) -> bool {
    line.spans() <= MOST_SPANS && (2..=MOST_DEGREE).contains(&line.degree()) && data <= MOST_DATA
}

/// The largest move of a knot towards its neighbours, as a part of the way.
const PART: f64 = 0.4;

/// The derivative of a curve by one of its knots, at the data where it is not zero.
struct Slope {
    /// Which data.
    data: Vec<usize>,
    /// For each coordinate a number for each of these.
    lanes: Vec<Vec<f64>>,
}

/// The knots after a step, which is shorter with more `damping`. `None` where the data do not determine it.
pub(super) fn moved(
    values: &Values,
    points: &Points,
    weights: Option<&[f64]>,
    control_points: &Points,
    damping: f64,
) -> Option<Breaks> {
    let line = values.line();
    let unit = normalizing_scale(points.magnitude());
    let mut residual = values.residual(control_points, points);
    let lanes = residual.lanes_mut().iter_mut();
    lanes.for_each(|lane| lane.iter_mut().for_each(|left| *left *= unit));
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let slopes: Vec<Slope> = (1..line.spans())
        .map(|q| slope(values, control_points, q, unit))
        .collect();
    let (mut system, right) = without_control_points(values, weights, &slopes, |slope| {
        let lanes = slope.lanes.iter().zip(residual.lanes());
        let each = lanes.flat_map(|(slopes, residual)| {
            let pairs = slope.data.iter().zip(slopes);
            pairs.map(|(&i, slope)| weight(i) * slope * residual[i])
        });
        each.sum()
    })?;
    for q in 0..system.nrows() {
        system[(q, q)] *= 1.0 + damping;
    }
    let step = Cholesky::new(system)?.solve(&right);
    let breaks = line.breaks();
    let length = breaks[line.spans()] - breaks[0];
    let mut moved = breaks.to_vec();
    for (q, step) in (1..line.spans()).zip(step.iter()) {
        let [back, ahead] = [breaks[q - 1], breaks[q + 1]].map(|it| PART * (it - breaks[q]));
        moved[q] += (step * length).clamp(back, ahead);
    }
    Breaks::new(line.degree(), line.is_closed(), moved)
}

/// The matrix S and the right side of the step, from the products of the slope of each knot and the residual.
fn without_control_points(
    values: &Values,
    weights: Option<&[f64]>,
    slopes: &[Slope],
    right: impl Fn(&Slope) -> f64,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let (line, count) = (values.line(), slopes.len());
    let fixed = line.fixed_ends();
    let moving = line.control_points() - 2 * fixed;
    let factor = Gram::of(values, weights, &[]).factor()?;
    let rows = values.clone().into_rows();
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let mut system = DMatrix::zeros(count, count);
    for c in 0..slopes.first().map_or(0, |slope| slope.lanes.len()) {
        let mut products = Vec::with_capacity(count);
        for (q, slope) in slopes.iter().enumerate() {
            let mut product = vec![0.0; line.control_points()];
            for (&i, slope) in slope.data.iter().zip(&slope.lanes[c]) {
                let (first, row) = rows.at(i);
                for (k, value) in row.iter().enumerate() {
                    let j = line.control_point(first + k);
                    product[j] += weight(i) * value * slope;
                }
            }
            let product = product[fixed..fixed + moving].to_vec();
            let mut solved = product.clone();
            factor.solve(&mut solved);
            products.push(product);
            for (r, product) in products.iter().enumerate() {
                let shared = inner(&slopes[r], slope, c, weight);
                let dot: f64 = product.iter().zip(&solved).map(|(a, b)| a * b).sum();
                system[(q, r)] += shared - dot;
            }
        }
    }
    for q in 0..count {
        for r in 0..q {
            system[(r, q)] = system[(q, r)];
        }
    }
    let right = DVector::from_iterator(count, slopes.iter().map(right));
    Some((system, right))
}

/// The sum over the data that two slopes share; both have their data in increasing order.
fn inner(a: &Slope, b: &Slope, c: usize, weight: impl Fn(usize) -> f64) -> f64 {
    let (mut i, mut j, mut sum) = (0, 0, 0.0);
    if a.data.last() < b.data.first() {
        return sum;
    }
    while let (Some(&datum), Some(&other)) = (a.data.get(i), b.data.get(j)) {
        if datum == other {
            sum += weight(datum) * a.lanes[c][i] * b.lanes[c][j];
        }
        i += usize::from(datum <= other);
        j += usize::from(other <= datum);
    }
    sum
}

/// The derivative by knot q of the breaks, in lengths of all of them, at the data of the p spans on either side.
fn slope(values: &Values, control_points: &Points, q: usize, unit: f64) -> Slope {
    let (line, t) = (values.line(), values.parameters());
    let (degree, spans) = (line.degree() as isize, line.spans() as isize);
    let (at, length) = (
        q as isize + degree,
        line.breaks()[line.spans()] - line.breaks()[0],
    );
    let knots: Vec<f64> = (at - 2 * degree..=at)
        .chain(at..=at + 2 * degree)
        .map(|i| line.knot(i))
        .collect();
    let factors: Vec<Vec<f64>> = control_points
        .lanes()
        .iter()
        .map(|lane| {
            let x = |j: isize| lane[line.control_point(j as usize)] * unit;
            let factor = |i: isize| {
                let width = (line.knot(i + degree) - line.knot(i)) / length;
                (x(i - 1) - x(i)) / width
            };
            (at - degree..=at).map(factor).collect()
        })
        .collect();
    let mut slope = Slope {
        data: Vec::new(),
        lanes: vec![Vec::new(); factors.len()],
    };
    let mut functions = vec![0.0; line.degree() + 1];
    for off in -degree..degree {
        let span = q as isize + off;
        if !line.is_closed() && !(0..spans).contains(&span) {
            continue;
        }
        let turns = span.div_euclid(spans) as f64;
        let span = span.rem_euclid(spans) as usize;
        // The knot stands twice in the middle.
        let place = (2 * degree + off + isize::from(off >= 0)) as usize;
        for i in values.starts()[span]..values.starts()[span + 1] {
            bspline::evaluate(
                line.degree(),
                &knots,
                place,
                t[i] + turns * length,
                &mut functions,
            );
            slope.data.push(i);
            // Of the functions on this span those that have a factor.
            let first = place - line.degree();
            for (lane, factors) in slope.lanes.iter_mut().zip(&factors) {
                let terms = functions.iter().enumerate().filter_map(|(k, value)| {
                    let factor = factors.get((first + k).checked_sub(line.degree())?)?;
                    Some(value * factor)
                });
                lane.push(terms.sum());
            }
        }
    }
    if line.is_closed() {
        slope = slope.sorted();
    }
    slope
}

impl Slope {
    /// The same with the data of a closed curve in their order; what spans add that were met twice is added up.
    fn sorted(self) -> Self {
        let mut order: Vec<usize> = (0..self.data.len()).collect();
        order.sort_by_key(|&k| self.data[k]);
        let groups = || order.chunk_by(|&j, &k| self.data[j] == self.data[k]);
        let lanes = self.lanes.iter();
        Self {
            data: groups().map(|group| self.data[group[0]]).collect(),
            lanes: lanes
                .map(|lane| {
                    groups()
                        .map(|group| group.iter().map(|&k| lane[k]).sum())
                        .collect()
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::knot_selection::equations::{LeastSquares, Minimum};

    /// A curve of some degree, at its data.
    fn curve(line: &Breaks, t: &Arc<Vec<f64>>) -> Points {
        let numbers = |seed: f64| {
            let count = line.control_points();
            (0..count).map(move |i| (seed * i as f64).sin() + 0.3 * i as f64)
        };
        let points = Points::from_lanes([3.7, 5.1].map(|seed| numbers(seed).collect::<Vec<f64>>()));
        Values::new(line, t).points(&points)
    }

    /// The derivative by a knot is the limit of differences, of open and closed curves.
    #[test]
    fn slopes_equal_quotients_of_differences() {
        let t: Arc<Vec<f64>> = Arc::new((0..500).map(|i| i as f64 / 100.0).collect());
        for (degree, closed) in [(2, false), (3, false), (4, false), (2, true), (3, true)] {
            let breaks = [0.0, 0.7, 1.1, 1.9, 2.5, 3.1, 3.3, 4.2, 5.0];
            let at = |q: usize, off: f64| {
                let mut breaks = breaks.to_vec();
                breaks[q] += off;
                Breaks::new(degree, closed, breaks).unwrap()
            };
            let line = at(1, 0.0);
            let numbers = (0..line.control_points()).map(|i| (3.7 * i as f64).sin());
            let points = Points::from_lanes([numbers.collect::<Vec<f64>>()]);
            let evaluated = |line: &Breaks| Values::new(line, &t).points(&points);
            for q in 1..8 {
                let slope = slope(&Values::new(&line, &t), &points, q, 1.0);
                let h = 1e-6;
                let [before, after] = [-h, h].map(|off| evaluated(&at(q, off)));
                let mut expected: Vec<f64> = (0..t.len())
                    .map(|i| (after.lane(0)[i] - before.lane(0)[i]) / (2.0 * h) * 5.0)
                    .collect();
                for (&i, value) in slope.data.iter().zip(&slope.lanes[0]) {
                    expected[i] -= value;
                }
                // Next to the knot the quotient of a quadratic curve is that of one of two pieces.
                let off = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                assert!(off < 1e-4, "{degree} {closed} {q}: {off}");
            }
        }
    }

    /// From knots near those of a curve, steps converge to them.
    #[test]
    fn steps_find_the_knots_of_a_curve() {
        let t: Arc<Vec<f64>> = Arc::new((0..400).map(|i| i as f64 / 399.0).collect());
        for (degree, closed) in [(2, false), (3, false), (3, true)] {
            let breaks = |off: f64| vec![0.0, 0.21 + off, 0.35 - off, 0.6 + off, 0.82, 1.0];
            let [exact, mut line] =
                [0.0, 0.02].map(|off| Breaks::new(degree, closed, breaks(off)).unwrap());
            let minimum = LeastSquares::of(&Arc::new(curve(&exact, &t)));
            for _ in 0..12 {
                let values = Values::new(&line, &t);
                let control_points = minimum.minimum(&values, None).unwrap();
                line = minimum.moved_knots(&values, &control_points, 0.0).unwrap();
            }
            for (found, expected) in line.breaks().iter().zip(exact.breaks()) {
                assert!(
                    (found - expected).abs() < 1e-6,
                    "{degree} {closed}: {line:?}"
                );
            }
        }
    }
}
