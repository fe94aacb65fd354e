//! Curves as cubic Bézier curves of the plane.

use crate::export::error::ExportError;
use crate::export::nurbs::{KnotVector, Nurbs};

/// The control points of a cubic Bézier curve.
pub(super) type Cubic = [[f64; 2]; 4];

/// The largest distance of approximations, as a fraction of the size of the curve: half of what files promise, as it is
/// measured at sample points only.
const TOLERANCE: f64 = 5e-5;

/// The most cubics for a span; each time twice as many are sixteen times nearer.
const MOST_IN_SPAN: usize = 1 << 12;

/// Points inside of each cubic where its distance is measured.
const MEASURED: usize = 7;

/// A curve in pieces, one after another.
#[derive(Debug)]
pub(super) struct Pieces {
    pub(super) cubics: Vec<Cubic>,
    /// True if they are the exact curve.
    pub(super) is_exact: bool,
    /// True if they are straight lines.
    pub(super) is_straight: bool,
}

/// The pieces of a curve: exact for polynomial curves up to degree 3, approximations for all others.
pub(super) fn pieces(nurbs: &Nurbs) -> Result<Pieces, ExportError> {
    let is_exact = nurbs.weights.is_none() && (1..=3).contains(&nurbs.u.degree);
    let cubics = match is_exact {
        true => nurbs
            .u
            .spans()
            .into_iter()
            .map(|span| exact(nurbs, span))
            .collect(),
        false => approximate(nurbs),
    };
    let is_finite = |cubic: &Cubic| cubic.as_flattened().iter().all(|x| x.is_finite());
    if !cubics.iter().all(is_finite) {
        return Err(ExportError::Extent);
    }
    Ok(Pieces {
        cubics,
        is_exact,
        is_straight: is_exact && nurbs.u.degree == 1,
    })
}

/// The part of a polynomial curve between two knots: its Bézier points, raised to degree 3.
fn exact(nurbs: &Nurbs, span: usize) -> Cubic {
    let knots = &nurbs.u;
    let p = knots.degree;
    let ends = (knots.knots[span], knots.knots[span + 1]);
    let bezier = |j: usize| {
        let arguments = [ends.0, ends.0, ends.0, ends.1, ends.1, ends.1];
        let arguments = &arguments[3 - (p - j)..3 + j];
        [0, 1].map(|axis| blossom(knots, nurbs.points.lane(axis), span, arguments))
    };
    let between = |a: [f64; 2], b: [f64; 2], part: f64| [0, 1].map(|c| a[c] + part * (b[c] - a[c]));
    match p {
        1 => {
            let (a, b) = (bezier(0), bezier(1));
            [a, between(a, b, 1.0 / 3.0), between(b, a, 1.0 / 3.0), b]
        }
        2 => {
            let (a, middle, b) = (bezier(0), bezier(1), bezier(2));
            [
                a,
                between(a, middle, 2.0 / 3.0),
                between(b, middle, 2.0 / 3.0),
                b,
            ]
        }
        _ => [0, 1, 2, 3].map(bezier),
    }
}

/// The blossom (polar form) of a span, by the algorithm of de Boor with another argument in each step.
fn blossom(knots: &KnotVector, lane: &[f64], span: usize, arguments: &[f64]) -> f64 {
    let (p, u) = (knots.degree, &knots.knots);
    let mut values = [0.0; 4];
    values[..=p].copy_from_slice(&lane[span - p..=span]);
    for (step, argument) in (1..).zip(arguments) {
        for j in (step..=p).rev() {
            let (low, high) = (u[span - p + j], u[span + 1 + j - step]);
            let part = (argument - low) / (high - low);
            values[j] = (1.0 - part) * values[j - 1] + part * values[j];
        }
    }
    values[p]
}

/// In each span as few cubics, with the points and tangents of the curve at their ends, as are near enough.
fn approximate(nurbs: &Nurbs) -> Vec<Cubic> {
    let tolerance = TOLERANCE * size(nurbs);
    let mut cubics = Vec::new();
    for span in nurbs.u.spans() {
        let mut parts = 1;
        let pieces = loop {
            let (pieces, distance) = hermite(nurbs, span, parts);
            if distance <= tolerance || parts >= MOST_IN_SPAN {
                break pieces;
            }
            parts *= 2;
        };
        cubics.extend(pieces);
    }
    cubics
}

/// A span in equal parts, and the largest measured distance between them and the curve.
fn hermite(nurbs: &Nurbs, span: usize, parts: usize) -> (Vec<Cubic>, f64) {
    let each = MEASURED + 1;
    let count = parts * each;
    let sites: Vec<_> = (0..=count)
        .map(|i| nurbs.u.site(span, i as f64 / count as f64))
        .collect();
    let jets = nurbs.evaluate(&sites, &[]);
    let third = (nurbs.u.knots[span + 1] - nurbs.u.knots[span]) / parts as f64 / 3.0;
    let mut largest = 0.0_f64;
    let pieces = (0..parts).map(|part| {
        let jets = &jets[part * each..=(part + 1) * each];
        let along = |end: usize, h: f64| [0, 1].map(|c| jets[end].point[c] + h * jets[end].du[c]);
        let cubic = [
            along(0, 0.0),
            along(0, third),
            along(each, -third),
            along(each, 0.0),
        ];
        for (i, jet) in jets.iter().enumerate() {
            let [x, y] = at(&cubic, i as f64 / each as f64);
            largest = largest.max((x - jet.point[0]).hypot(y - jet.point[1]));
        }
        cubic
    });
    (pieces.collect(), largest)
}

fn at(cubic: &Cubic, t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    let factors = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    [0, 1].map(|c| (0..4).map(|i| factors[i] * cubic[i][c]).sum())
}

/// The diagonal of the box around samples of a curve. Control points of high degrees can be far from it.
fn size(nurbs: &Nurbs) -> f64 {
    let steps = nurbs.u.steps(1 << 10);
    let jets = nurbs.evaluate(&nurbs.u.sites(steps), &[]);
    let extent = |c: usize| {
        let range = jets
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |it, jet| {
                (it.0.min(jet.point[c]), it.1.max(jet.point[c]))
            });
        range.1 - range.0
    };
    extent(0).hypot(extent(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::cylinder::line_of;
    use piad_fit::data::Points;

    fn curve(degree: usize, knots: &[f64], weights: Option<Vec<f64>>) -> Nurbs {
        let u = line_of(degree, knots);
        let mut points = Points::new(2);
        for i in 0..u.count() {
            points.push(&[(i as f64).sin(), (2.0 * i as f64).cos()]);
        }
        Nurbs {
            u,
            v: None,
            points,
            weights,
        }
    }

    #[test]
    fn low_degrees_are_exact() {
        for nurbs in [
            curve(1, &[0.0, 0.0, 1.0, 3.0, 3.0], None),
            curve(2, &[-2.0, -1.0, 0.0, 1.5, 2.0, 4.0, 5.5, 6.0, 7.0], None),
            curve(
                3,
                &[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0],
                None,
            ),
        ] {
            let found = pieces(&nurbs).unwrap();
            assert!(found.is_exact);
            let spans = nurbs.u.spans();
            assert_eq!(found.cubics.len(), spans.len());
            for (cubic, span) in found.cubics.iter().zip(spans) {
                for part in [0.0, 0.3, 0.7, 1.0] {
                    let [x, y] = at(cubic, part);
                    let point = nurbs.evaluate(&[nurbs.u.site(span, part)], &[])[0].point;
                    assert!(
                        (x - point[0]).abs() < 1e-15 * 8.0 && (y - point[1]).abs() < 1e-15 * 8.0
                    );
                }
            }
        }
    }

    #[test]
    fn other_curves_are_near() {
        let weights = Some(vec![1.0, 10.0, 0.1, 1.0]);
        for nurbs in [
            curve(3, &[[0.0; 4], [1.0; 4]].concat(), weights),
            curve(7, &[[0.0; 8], [2.0; 8]].concat(), None),
        ] {
            let found = pieces(&nurbs).unwrap();
            assert!(!found.is_exact && !found.is_straight);
            let size = size(&nurbs);
            let ends = found.cubics.windows(2).all(|it| it[0][3] == it[1][0]);
            assert!(ends);
            let span = nurbs.u.spans()[0];
            let count = found.cubics.len();
            for (index, cubic) in found.cubics.iter().enumerate() {
                for i in 0..100 {
                    let part = f64::from(i) / 100.0;
                    let [x, y] = at(cubic, part);
                    let part = (index as f64 + part) / count as f64;
                    let point = nurbs.evaluate(&[nurbs.u.site(span, part)], &[])[0].point;
                    assert!((x - point[0]).hypot(y - point[1]) < 1e-4 * size);
                }
            }
        }
    }
}
