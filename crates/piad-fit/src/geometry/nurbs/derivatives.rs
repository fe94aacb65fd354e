//! Points of a B-spline curve or surface with their first and second derivatives.
//!
//! The derivative of a B-spline of degree q is a difference of two of degree q − 1 (PT97 (2.7)), so that second
//! derivatives are made of functions of degree p − 2. Rational ones follow from those of the homogeneous coordinates
//! `A = w S` by the rule for products (PT97 (4.20)):
//!
//! ```text
//! S_a  = (A_a − w_a S) / w
//! S_ab = (A_ab − w_a S_b − w_b S_a − w_ab S) / w
//! ```

use std::ops::Range;

use super::sampling::{Homogeneous, Jet, MOST_VALUES, SpanParameter, combine};
use super::{KnotVector, Nurbs};
use crate::basis::{bernstein, bspline};
use crate::interrupt::Meter;

/// A point with its first and second partial derivatives, or three coordinates of one that has more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SecondJet {
    /// The point with its first derivatives.
    pub jet: Jet,
    /// The second derivative by the first parameter.
    pub duu: [f64; 3],
    /// The mixed derivative; zero for curves.
    pub duv: [f64; 3],
    /// The second derivative by the second parameter; zero for curves.
    pub dvv: [f64; 3],
}

/// The functions of one direction at one parameter, and their first two derivatives.
#[derive(Debug)]
struct BasisDerivatives {
    first: usize,
    orders: [Vec<f64>; 3],
}

impl BasisDerivatives {
    /// The one function of a curve across it.
    fn constant() -> Self {
        Self {
            first: 0,
            orders: [vec![1.0], vec![0.0], vec![0.0]],
        }
    }

    /// The control points on which the values depend.
    fn window(&self) -> Range<usize> {
        self.first..self.first + self.orders[0].len()
    }
}

impl KnotVector {
    /// The functions that can differ from zero at a parameter, with their derivatives.
    fn derivatives(&self, site: SpanParameter) -> BasisDerivatives {
        BasisDerivatives {
            first: site.span - self.degree,
            orders: [0, 1, 2].map(|order| self.derivatives_of_order(site, order)),
        }
    }

    fn derivatives_of_order(&self, site: SpanParameter, order: usize) -> Vec<f64> {
        let degree = self.degree;
        let mut values = vec![0.0; degree + 1];
        // Polynomials of a lower degree have no such derivative but zero.
        let Some(low) = degree.checked_sub(order) else {
            return values;
        };
        if self.is_bezier() {
            bernstein::evaluate(low, self.part(site), &mut values[..=low]);
        } else {
            bspline::evaluate(low, &self.knots, site.span, site.t, &mut values[..=low]);
        }
        (low + 1..=degree).for_each(|q| self.differentiate(q, site.span, &mut values[..=q]));
        values
    }

    /// Makes the derivatives of the functions of degree q on a span of what stands in front: the functions of degree
    /// q − 1, or derivatives of these.
    fn differentiate(&self, q: usize, span: usize, values: &mut [f64]) {
        let mut next = 0.0;
        for r in (0..=q).rev() {
            let i = span - q + r;
            let quotient = match r {
                0 => 0.0,
                _ => values[r - 1] / (self.knots[i + q] - self.knots[i]),
            };
            values[r] = q as f64 * (quotient - next);
            next = quotient;
        }
    }
}

impl Nurbs {
    /// Points with first and second derivatives on the grid `u × v`, row by row: the three coordinates from the
    /// `first` on. A curve ignores `v`.
    pub fn second_jets(
        &self,
        first: usize,
        u: &[SpanParameter],
        v: &[SpanParameter],
    ) -> Vec<SecondJet> {
        let Some(knots) = &self.v else {
            return self.second_block(first, u, &[BasisDerivatives::constant()]);
        };
        // With a high degree there are thousands of functions at each site.
        let block = (MOST_VALUES / (3 * (knots.degree + 1))).max(1);
        let mut jets = vec![SecondJet::default(); u.len() * v.len()];
        let mut meter = Meter::default();
        for (index, sites) in v.chunks(block).enumerate() {
            let across = sites.iter().map(|&site| {
                meter.add(3 * knots.multiplications());
                knots.derivatives(site)
            });
            let across: Vec<BasisDerivatives> = across.collect();
            let some = self.second_block(first, u, &across);
            let rows = jets.chunks_exact_mut(v.len());
            for (row, some) in rows.zip(some.chunks_exact(across.len())) {
                row[index * block..][..some.len()].copy_from_slice(some);
            }
        }
        jets
    }

    fn second_block(
        &self,
        first: usize,
        u: &[SpanParameter],
        across: &[BasisDerivatives],
    ) -> Vec<SecondJet> {
        // Few sites need few of the columns.
        let windows = across.iter().map(BasisDerivatives::window);
        let needed = windows.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
        let needed = needed.unwrap_or_default();
        let mut lines = [0, 1, 2].map(|_| vec![Homogeneous::default(); needed.len()]);
        let mut jets = Vec::with_capacity(u.len() * across.len());
        let mut meter = Meter::default();
        let for_line = 3 * self.u.multiplications() + (self.u.degree + 1) * needed.len() * 16;
        for &site in u {
            meter.add(for_line);
            let along = self.u.derivatives(site);
            self.contract(first, &along, &needed, &mut lines);
            for across in across {
                let window = across.window();
                meter.add(window.len() * 24);
                let window = window.start - needed.start..window.end - needed.start;
                let of = |along: usize, order: usize| {
                    combine(&across.orders[order], &lines[along][window.clone()])
                };
                jets.push(project([
                    of(0, 0),
                    of(1, 0),
                    of(0, 1),
                    of(2, 0),
                    of(1, 1),
                    of(0, 2),
                ]));
            }
        }
        jets
    }

    /// The control points of the curve `u = const` in these columns, and of its derivatives by u.
    fn contract(
        &self,
        first: usize,
        along: &BasisDerivatives,
        columns: &Range<usize>,
        lines: &mut [Vec<Homogeneous>; 3],
    ) {
        let count = self.columns();
        for line in lines.iter_mut() {
            line.fill(Homogeneous::default());
        }
        for (r, row) in along.window().enumerate() {
            for (j, column) in columns.clone().enumerate() {
                let control = self.lift(first, row * count + column);
                for (line, order) in lines.iter_mut().zip(&along.orders) {
                    for (sum, x) in line[j].iter_mut().zip(control) {
                        *sum += order[r] * x;
                    }
                }
            }
        }
    }
}

/// From homogeneous coordinates: those of the point, of its derivatives by u and v, and by uu, uv and vv.
fn project([a, au, av, auu, auv, avv]: [Homogeneous; 6]) -> SecondJet {
    let w = a[3];
    let axes = [0, 1, 2];
    let point = axes.map(|c| a[c] / w);
    let first = |d: Homogeneous| axes.map(|c| (d[c] - d[3] * point[c]) / w);
    let (du, dv) = (first(au), first(av));
    let second = |d: Homogeneous, (wa, sb): (f64, [f64; 3]), (wb, sa): (f64, [f64; 3])| {
        axes.map(|c| (d[c] - wa * sb[c] - wb * sa[c] - d[3] * point[c]) / w)
    };
    let (u, v) = ((au[3], du), (av[3], dv));
    SecondJet {
        jet: Jet { point, du, dv },
        duu: second(auu, u, u),
        duv: second(auv, (au[3], dv), (av[3], du)),
        dvv: second(avv, v, v),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::points::Points;

    fn knots(degree: usize, knots: &[f64]) -> KnotVector {
        KnotVector {
            degree,
            knots: knots.to_vec(),
            closed: false,
        }
    }

    /// A rational surface with double knots, clamped in u and not in v.
    fn surface() -> Nurbs {
        let u = knots(3, &[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 4.0, 4.0, 4.0, 4.0]);
        let v = knots(2, &[-2.0, -1.0, 0.0, 1.5, 2.0, 4.0, 5.5, 6.0]);
        let mut points = Points::new(3);
        let count = u.count() * v.count();
        for i in 0..count {
            let x = i as f64;
            points.push(&[x.sin(), (2.0 * x).cos(), (0.3 * x * x).sin()]);
        }
        Nurbs {
            u,
            v: Some(v),
            points,
            weights: Some((0..count).map(|i| 1.0 + 0.5 * (i as f64).cos()).collect()),
        }
    }

    /// First derivatives are those of the other evaluation, and second ones quotients of their differences.
    #[test]
    fn second_derivatives_equal_quotients_of_differences() {
        let surface = surface();
        let across = surface.v.clone().unwrap();
        let h = 1e-5;
        for u in surface.u.spans() {
            for v in across.spans() {
                let near = |knots: &KnotVector, span| {
                    [0.4, 0.4 - h, 0.4 + h].map(|part| knots.site(span, part))
                };
                let (u, v) = (near(&surface.u, u), near(&across, v));
                let found = surface.second_jets(0, &u, &v);
                let plain = surface.evaluate(&u, &v);
                for (found, plain) in found.iter().zip(&plain) {
                    for c in 0..3 {
                        assert!((found.jet.point[c] - plain.point[c]).abs() < 1e-14);
                        assert!((found.jet.du[c] - plain.du[c]).abs() < 1e-12);
                        assert!((found.jet.dv[c] - plain.dv[c]).abs() < 1e-12);
                    }
                }
                let (hu, hv) = (u[2].t - u[1].t, v[2].t - v[1].t);
                for c in 0..3 {
                    let quotients = [
                        (found[0].duu[c], plain[6].du[c] - plain[3].du[c], hu),
                        (found[0].duv[c], plain[2].du[c] - plain[1].du[c], hv),
                        (found[0].dvv[c], plain[2].dv[c] - plain[1].dv[c], hv),
                    ];
                    for (second, difference, step) in quotients {
                        assert!((second - difference / step).abs() < 1e-7, "{second}");
                    }
                }
            }
        }
    }

    /// Straight lines have no second derivative, constants none at all.
    #[test]
    fn low_degrees_have_few_derivatives() {
        let mut points = Points::new(1);
        points.push(&[1.0]);
        points.push(&[3.0]);
        let line = Nurbs {
            u: knots(1, &[0.0, 0.0, 2.0, 2.0]),
            v: None,
            points,
            weights: None,
        };
        let jet = line.second_jets(0, &[line.u.site(1, 0.5)], &[])[0];
        assert_eq!(
            (jet.jet.point[0], jet.jet.du[0], jet.duu[0]),
            (2.0, 1.0, 0.0)
        );
    }
}
