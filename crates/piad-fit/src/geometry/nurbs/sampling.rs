//! Points and derivatives of a B-spline curve or surface.

use super::{KnotVector, Nurbs};
use crate::basis::{bernstein, bspline};
use crate::data::vectors::in_space;
use crate::interrupt::Meter;

/// The most values of basis functions that are held at a time, and as many derivatives.
pub(super) const MOST_VALUES: usize = 1 << 20;

/// A parameter in a knot span. At a knot the span decides from which side derivatives are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanParameter {
    pub(super) span: usize,
    /// The parameter.
    pub t: f64,
}

impl SpanParameter {
    /// A parameter in a span that it lies in.
    pub fn new(span: usize, t: f64) -> Self {
        Self { span, t }
    }

    /// The span.
    pub(crate) fn span(self) -> usize {
        self.span
    }
}

/// A point with its partial derivatives, or three coordinates of one that has more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// The point.
    pub point: [f64; 3],
    /// The derivative by the first parameter.
    pub du: [f64; 3],
    /// The derivative by the second parameter; zero for curves.
    pub dv: [f64; 3],
}

/// The number of steps between this many samples; at least one.
pub fn steps_between(samples: usize) -> usize {
    samples.saturating_sub(1).max(1)
}

impl KnotVector {
    /// A number of steps, at most `most`, for sampling: enough to see what the control points do,
    /// and equally many in each span, as long as there are fewer spans than `most`.
    pub fn steps(&self, most: usize) -> usize {
        let spans = self.spans().len();
        // Polynomials of high degree are smoother than their number of control points suggests.
        let wanted = (4 * self.count()).min((4 * spans).max(1024)).max(64);
        match most / spans {
            0 => most,
            fitting => spans * (wanted / spans).clamp(1, fitting),
        }
    }

    /// `steps + 1` sites from one end of the domain to the other. All spans get equally many steps, so
    /// short spans get short ones.
    pub fn sites(&self, steps: usize) -> Vec<SpanParameter> {
        let spans = self.spans();
        let site = |i: usize| {
            let place = i as f64 * spans.len() as f64 / steps as f64;
            let index = (place as usize).min(spans.len() - 1);
            self.site(spans[index], place - index as f64)
        };
        (0..=steps).map(site).collect()
    }

    /// The site of a parameter of the domain.
    pub fn site_at(&self, t: f64) -> SpanParameter {
        let (low, high) = self.domain();
        let t = t.clamp(low, high);
        SpanParameter::new(bspline::find_span(self.degree, &self.knots, t), t)
    }

    /// The site at a part of a span, from 0 at its left end to 1 at its right end.
    pub fn site(&self, span: usize, part: f64) -> SpanParameter {
        let (low, high) = (self.knots[span], self.knots[span + 1]);
        let t = (1.0 - part) * low + part * high;
        SpanParameter { span, t }
    }

    /// The site moved inside, at least a thousandth of its span from both ends.
    pub fn inside(&self, site: SpanParameter) -> SpanParameter {
        let part = self.part(site);
        self.site(site.span, part.clamp(1e-3, 1.0 - 1e-3))
    }

    /// Where in its span a site is, from 0 to 1.
    pub(super) fn part(&self, site: SpanParameter) -> f64 {
        let low = self.knots[site.span];
        ((site.t - low) / self.width(site)).clamp(0.0, 1.0)
    }

    /// Returns true if there is one span, so that the functions are Bernstein polynomials.
    pub(super) fn is_bezier(&self) -> bool {
        self.count() == self.degree + 1
    }

    /// The multiplications for the functions at a site, with their derivatives.
    pub(super) fn multiplications(&self) -> usize {
        let width = self.degree + 1;
        if self.is_bezier() {
            4 * width
        } else {
            2 * width * width
        }
    }

    /// How long a span is.
    pub fn width(&self, site: SpanParameter) -> f64 {
        self.knots[site.span + 1] - self.knots[site.span]
    }

    /// The functions that can differ from zero at a site, with their derivatives.
    fn functions(&self, site: SpanParameter) -> BasisValues {
        let (p, knots, span) = (self.degree, &self.knots, site.span);
        let (mut values, mut lower) = (vec![0.0; p + 1], vec![0.0; p]);
        if self.is_bezier() {
            // The same functions, much faster at high degrees.
            bernstein::evaluate(p, self.part(site), &mut values);
            if p > 0 {
                bernstein::evaluate(p - 1, self.part(site), &mut lower);
            }
        } else {
            bspline::evaluate_with_lower(p, knots, span, site.t, &mut values, &mut lower);
        }
        // N'_i = p (M_i / (u_{i+p} − u_i) − M_{i+1} / (u_{i+p+1} − u_{i+1})), where the M are
        // those of degree p − 1 (PT97 (2.7)); only M_{span−p+1} … M_span differ from zero.
        let first = span - p;
        let quotient = |r: usize| match r.checked_sub(1).and_then(|r| lower.get(r)) {
            Some(value) => value / (knots[first + r + p] - knots[first + r]),
            None => 0.0,
        };
        let derivatives = (0..=p).map(|r| p as f64 * (quotient(r) - quotient(r + 1)));
        BasisValues {
            first,
            derivatives: derivatives.collect(),
            values,
        }
    }
}

/// The functions of one direction at one site.
#[derive(Debug)]
struct BasisValues {
    first: usize,
    values: Vec<f64>,
    derivatives: Vec<f64>,
}

/// A point in homogeneous coordinates `(w x, w y, w z, w)`.
pub(super) type Homogeneous = [f64; 4];

impl Nurbs {
    /// Points and derivatives on the grid `u × v`, row by row, in space. A curve ignores `v`.
    pub fn evaluate(&self, u: &[SpanParameter], v: &[SpanParameter]) -> Vec<Jet> {
        self.evaluate_from(0, u, v)
    }

    /// The same of the three coordinates from the `first` on.
    pub fn evaluate_from(
        &self,
        first: usize,
        u: &[SpanParameter],
        v: &[SpanParameter],
    ) -> Vec<Jet> {
        let Some(knots) = &self.v else {
            let end = BasisValues {
                first: 0,
                values: vec![1.0],
                derivatives: vec![0.0],
            };
            return self.evaluate_block(first, u, &[end]);
        };
        // With a high degree there are thousands of functions at each site.
        let block = (MOST_VALUES / (knots.degree + 1)).max(1);
        let functions = |sites: &[SpanParameter]| -> Vec<BasisValues> {
            let mut meter = Meter::default();
            let each = sites.iter().map(|&site| {
                meter.add(knots.multiplications());
                knots.functions(site)
            });
            each.collect()
        };
        if v.len() <= block {
            return self.evaluate_block(first, u, &functions(v));
        }
        let mut jets = vec![Jet::default(); u.len() * v.len()];
        for (index, sites) in v.chunks(block).enumerate() {
            let across = functions(sites);
            let some = self.evaluate_block(first, u, &across);
            let rows = jets.chunks_exact_mut(v.len());
            for (row, some) in rows.zip(some.chunks_exact(across.len())) {
                row[index * block..][..some.len()].copy_from_slice(some);
            }
        }
        jets
    }

    /// Points and derivatives at the sites `u`, for these functions of the other direction.
    fn evaluate_block(
        &self,
        first: usize,
        u: &[SpanParameter],
        across: &[BasisValues],
    ) -> Vec<Jet> {
        let lifted = self.lifted(first, u.len());
        let mut line = vec![Homogeneous::default(); self.columns()];
        let mut line_du = line.clone();
        let mut jets = Vec::with_capacity(u.len() * across.len());
        let mut meter = Meter::default();
        let for_line = self.u.multiplications() + (self.u.degree + 1) * line.len() * 12;
        for &site in u {
            let along = self.u.functions(site);
            contract(&along, &lifted, &mut line, &mut line_du);
            meter.add(for_line);
            for across in across {
                meter.add(across.values.len() * 12);
                let window = across.first..across.first + across.values.len();
                let (line, line_du) = (&line[window.clone()], &line_du[window]);
                let point = combine(&across.values, line);
                let du = combine(&across.values, line_du);
                let dv = combine(&across.derivatives, line);
                jets.push(project(point, du, dv));
            }
        }
        jets
    }

    /// Three coordinates of the control points in homogeneous coordinates, for sites in this many lines.
    fn lifted(&self, first: usize, lines: usize) -> Lifted<'_> {
        let used = lines.saturating_mul(self.u.degree + 1);
        match used > self.u.count() {
            true => Lifted::All(
                (0..self.points.len())
                    .map(|index| self.lift(first, index))
                    .collect(),
            ),
            false => Lifted::EachTime(self, first),
        }
    }

    pub(super) fn lift(&self, first: usize, index: usize) -> Homogeneous {
        let [x, y, z] = in_space(self.points.point(index).skip(first));
        let w = self.weight(index);
        [w * x, w * y, w * z, w]
    }
}

/// Control points in homogeneous coordinates: made once where each is needed more than once.
enum Lifted<'a> {
    All(Vec<Homogeneous>),
    EachTime(&'a Nurbs, usize),
}

/// The control points of the curve `u = const`, and of its derivative by u.
fn contract(
    along: &BasisValues,
    lifted: &Lifted<'_>,
    line: &mut [Homogeneous],
    line_du: &mut [Homogeneous],
) {
    let columns = line.len();
    line.fill(Homogeneous::default());
    line_du.fill(Homogeneous::default());
    for (r, (value, derivative)) in along.values.iter().zip(&along.derivatives).enumerate() {
        let start = (along.first + r) * columns;
        let mut add = |j: usize, control: Homogeneous| {
            for c in 0..4 {
                line[j][c] += value * control[c];
                line_du[j][c] += derivative * control[c];
            }
        };
        match lifted {
            Lifted::All(points) => {
                let row = &points[start..start + columns];
                row.iter()
                    .enumerate()
                    .for_each(|(j, &control)| add(j, control));
            }
            Lifted::EachTime(nurbs, first) => {
                (0..columns).for_each(|j| add(j, nurbs.lift(*first, start + j)));
            }
        }
    }
}

/// The sum of points, each multiplied with a value.
pub(super) fn combine(values: &[f64], points: &[Homogeneous]) -> Homogeneous {
    let mut sum = Homogeneous::default();
    for (value, point) in values.iter().zip(points) {
        for (sum, x) in sum.iter_mut().zip(point) {
            *sum += value * x;
        }
    }
    sum
}

/// From homogeneous coordinates: `S = A / w`, `S' = (A' − w' S) / w` (PT97 (4.8), (4.20)).
fn project(point: Homogeneous, du: Homogeneous, dv: Homogeneous) -> Jet {
    let [.., w] = point;
    let place = |c: usize| point[c] / w;
    let derivative = |d: Homogeneous, c: usize| (d[c] - d[3] * place(c)) / w;
    let axes = [0, 1, 2];
    Jet {
        point: axes.map(place),
        du: axes.map(|c| derivative(du, c)),
        dv: axes.map(|c| derivative(dv, c)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::points::Points;

    /// Knots of multiplicity two and three, and of a closed direction.
    #[test]
    fn derivatives_equal_quotients_of_differences() {
        let knots = |degree: usize, knots: &[f64]| KnotVector {
            degree,
            knots: knots.to_vec(),
            closed: false,
        };
        for u in [
            knots(
                3,
                &[
                    0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0, 4.0, 4.0,
                ],
            ),
            knots(2, &[-2.0, -1.0, 0.0, 1.5, 2.0, 4.0, 5.5, 6.0, 7.0]),
            knots(7, &[[0.0; 8], [2.0; 8]].concat()),
        ] {
            let mut points = Points::new(2);
            for i in 0..u.count() {
                points.push(&[(i as f64).sin(), (2.0 * i as f64).cos()]);
            }
            let curve = Nurbs {
                u,
                v: None,
                points,
                weights: None,
            };
            for span in curve.u.spans() {
                let h = 1e-6;
                for part in [h, 0.25, 0.5, 0.75, 1.0 - h] {
                    let near = [part, part - h, part + h].map(|part| curve.u.site(span, part));
                    let jets = curve.evaluate(&near, &[]);
                    let width = curve.u.width(near[0]);
                    for c in 0..2 {
                        let quotient = (jets[2].point[c] - jets[1].point[c]) / (2.0 * h * width);
                        assert!((jets[0].du[c] - quotient).abs() < 1e-7, "{part}");
                    }
                }
            }
        }
    }

    #[test]
    fn sites_are_dense_where_spans_are_short() {
        let knots = KnotVector {
            degree: 1,
            knots: vec![0.0, 0.0, 1.0, 1.5, 1.5],
            closed: false,
        };
        let t: Vec<f64> = knots.sites(4).iter().map(|site| site.t).collect();
        assert_eq!(t, [0.0, 0.5, 1.0, 1.25, 1.5]);
        assert!(knots.steps(1000).is_multiple_of(2));
        assert_eq!(knots.steps(1), 1);
    }
}
