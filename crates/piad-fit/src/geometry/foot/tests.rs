//! Foot points against closed forms, and against the nearest of many points.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use super::*;
use crate::basis::bspline;
use crate::geometry::nurbs::KnotVector;

fn clamped(degree: usize, breaks: &[f64]) -> KnotVector {
    let (low, high) = (breaks[0], breaks[breaks.len() - 1]);
    let inside = breaks[1..breaks.len() - 1].iter().copied();
    let ends = |t: f64| vec![t; degree + 1].into_iter();
    KnotVector {
        degree,
        knots: ends(low).chain(inside).chain(ends(high)).collect(),
        closed: false,
    }
}

/// The surface with control points by the numbers of their row and column.
fn surface(
    u: KnotVector,
    v: KnotVector,
    point: impl Fn(usize, usize) -> [f64; 3],
    weights: Option<Vec<f64>>,
) -> Nurbs {
    let mut points = Points::new(3);
    for i in 0..u.count() {
        (0..v.count()).for_each(|j| points.push(&point(i, j)));
    }
    Nurbs {
        u,
        v: Some(v),
        points,
        weights,
    }
}

/// The point of a surface.
fn evaluate(surface: &Nurbs, at: [f64; 2]) -> [f64; 3] {
    let v = surface.v.as_ref().unwrap();
    let functions = |direction: &KnotVector, t: f64| {
        let (degree, knots) = (direction.degree, &direction.knots);
        let span = bspline::find_span(degree, knots, t);
        let mut values = vec![0.0; degree + 1];
        bspline::evaluate(degree, knots, span, t, &mut values);
        (span - degree, values)
    };
    let ((i, along), (j, across)) = (functions(&surface.u, at[0]), functions(v, at[1]));
    let (mut sum, mut weight) = ([0.0; 3], 0.0);
    for (k, a) in along.iter().enumerate() {
        for (l, b) in across.iter().enumerate() {
            let index = (i + k) * v.count() + j + l;
            let w = a * b * surface.weight(index);
            weight += w;
            (0..3).for_each(|c| sum[c] += w * surface.points.lane(c)[index]);
        }
    }
    sum.map(|x| x / weight)
}

fn points(all: impl IntoIterator<Item = [f64; 3]>) -> Points {
    let mut points = Points::new(3);
    all.into_iter().for_each(|point| points.push(&point));
    points
}

fn pairs(surface: &Nurbs, all: impl IntoIterator<Item = [f64; 3]>) -> Vec<[f64; 2]> {
    let found = foot_points(surface, &points(all)).unwrap().values;
    (0..found.len())
        .map(|i| [found.lane(0)[i], found.lane(1)[i]])
        .collect()
}

/// Hills over [0, 6]², by control points that are heights.
fn hills(degree: usize) -> Nurbs {
    let breaks: Vec<f64> = (0..=7).map(|i| f64::from(i) * 6.0 / 7.0).collect();
    let knots = clamped(degree, &breaks);
    let greville = |i: usize| knots.knots[i + 1..=i + degree].iter().sum::<f64>() / degree as f64;
    let point = |i, j| {
        let (x, y): (f64, f64) = (greville(i), greville(j));
        [x, y, (1.3 * x).sin() * (0.9 * y + 1.0).cos()]
    };
    surface(knots.clone(), knots.clone(), point, None)
}

/// A quarter of a cylinder of radius 1 and height 2.
fn cylinder() -> Nurbs {
    let arc = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let point = |i: usize, j: usize| [arc[i][0], arc[i][1], 2.0 * j as f64];
    let weights = [1.0, 1.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 1.0, 1.0].to_vec();
    let (u, v) = (clamped(2, &[0.0, 1.0]), clamped(1, &[0.0, 1.0]));
    surface(u, v, point, Some(weights))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Numbers of [0, 1) that look random.
fn random(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// Above a plane the foot has the same x and y, beside it the nearest of the border.
#[test]
fn plane() {
    let knots = clamped(1, &[0.0, 1.0, 2.0, 4.0]);
    let at = [0.0, 1.0, 2.0, 4.0];
    let plane = surface(knots.clone(), knots, |i, j| [at[i], at[j], 0.0], None);
    let given = (0..200).map(|i| {
        [
            6.0 * random(i, 0.618) - 1.0,
            6.0 * random(i, 0.755) - 1.0,
            random(i, 0.57),
        ]
    });
    for (point, pair) in given.clone().zip(pairs(&plane, given)) {
        for (t, x) in pair.into_iter().zip(point) {
            assert!((t - x.clamp(0.0, 4.0)).abs() < 1e-14, "{point:?} {pair:?}");
        }
    }
}

/// Points inside and outside a cylinder, at known angles and heights.
#[test]
fn rational() {
    let cylinder = cylinder();
    let known = |i: usize| {
        let angle = FRAC_PI_2 * random(i, 0.618);
        (
            angle,
            3.0 * random(i, 0.755) - 0.5,
            0.05 + 3.0 * random(i, 0.57),
        )
    };
    let given = (0..300).map(|i| {
        let (angle, height, radius) = known(i);
        [radius * angle.cos(), radius * angle.sin(), height]
    });
    for (i, pair) in pairs(&cylinder, given).into_iter().enumerate() {
        let (angle, height, _) = known(i);
        let [x, y, z] = evaluate(&cylinder, pair);
        assert!((y.atan2(x) - angle).abs() < 1e-13, "{i}");
        assert!((z - height.clamp(0.0, 2.0)).abs() < 1e-13, "{i}");
    }
    // All of the arc is equally far from the axis: the least u counts, but for rounding.
    let [on_axis] = pairs(&cylinder, [[0.0, 0.0, 1.0]])[..] else {
        panic!("one point");
    };
    assert_eq!(on_axis[1], 0.5);
    assert_eq!(on_axis, pairs(&cylinder, [[0.0, 0.0, 1.0]])[0]);
}

/// Points that were moved along normals come back, on surfaces of several degrees.
#[test]
fn along_normals() {
    for degree in [2, 3, 4, 7] {
        let hills = hills(degree);
        let known = |i: usize| [random(i, 0.618), random(i, 0.755)].map(|t| 0.01 + 5.98 * t);
        let given = (0..500).map(|i| {
            let at = known(i);
            let h = 1e-5;
            let difference = |k: usize| {
                let [mut low, mut high] = [at; 2];
                (low[k], high[k]) = (at[k] - h, at[k] + h);
                let (low, high) = (evaluate(&hills, low), evaluate(&hills, high));
                [0, 1, 2].map(|c| (high[c] - low[c]) / (2.0 * h))
            };
            let (a, b) = (difference(0), difference(1));
            let normal = [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ];
            let far = 0.2 * (random(i, 0.57) - 0.5);
            let place = evaluate(&hills, at);
            [0, 1, 2].map(|c| place[c] + far * normal[c])
        });
        for (i, pair) in pairs(&hills, given).into_iter().enumerate() {
            let known = known(i);
            for (found, known) in pair.into_iter().zip(known) {
                // Differences have errors of h² and of rounding over h.
                assert!((found - known).abs() < 1e-8, "degree {degree}: {pair:?}");
            }
        }
        // Points on the surface: to rounding.
        let on = (0..500).map(|i| evaluate(&hills, known(i)));
        for (i, pair) in pairs(&hills, on).into_iter().enumerate() {
            for (found, known) in pair.into_iter().zip(known(i)) {
                assert!((found - known).abs() < 1e-13, "degree {degree}: {pair:?}");
            }
        }
    }
}

/// No point of a dense grid of the surface on [0, end]² is nearer, wherever the points are.
fn assert_nothing_is_nearer(surface: &Nurbs, end: f64) {
    let grid: Vec<[f64; 3]> = (0..=240)
        .flat_map(|i| (0..=240).map(move |j| [i, j].map(|i| end * f64::from(i) / 240.0)))
        .map(|at| evaluate(surface, at))
        .collect();
    let given: Vec<[f64; 3]> = (0..200)
        .map(|i| {
            let [x, y] = [random(i, 0.618), random(i, 0.755)].map(|t| end * (5.0 * t - 1.0) / 3.0);
            [x, y, end * (random(i, 0.57) - 0.5)]
        })
        .collect();
    for (&point, pair) in given.iter().zip(pairs(surface, given.clone())) {
        let found = distance(evaluate(surface, pair), point);
        let sampled = grid.iter().map(|&place| distance(place, point));
        let nearest = sampled.fold(f64::INFINITY, f64::min);
        assert!(found <= nearest + 1e-12, "{point:?} {found} {nearest}");
    }
}

#[test]
fn nothing_is_nearer() {
    for degree in [1, 2, 3, 5] {
        assert_nothing_is_nearer(&hills(degree), 6.0);
    }
}

/// Spans that bend to and fro have several points that are nearer than those beside them.
#[test]
fn strongly_bent_spans() {
    let knots = clamped(3, &[0.0, 1.0, 2.0, 3.0]);
    for (seed, height) in (0..12).zip([0.3, 1.0, 3.0].into_iter().cycle()) {
        let number = |k: usize| random(1000 * seed + k, 0.618_033_988_749_895);
        let at = |i: usize, j: usize| {
            let up = number(31 * (6 * i + j)) - 0.5;
            [i as f64 / 2.0, j as f64 / 2.0, height * up]
        };
        assert_nothing_is_nearer(&surface(knots.clone(), knots.clone(), at, None), 3.0);
    }
}

/// A closed direction has no ends: near its seam points have feet on both sides.
#[test]
fn closed() {
    let (count, degree) = (8, 3);
    let knots = (0..count + 2 * degree + 1).map(|i| (i as f64 - degree as f64) / count as f64);
    let u = KnotVector {
        degree,
        knots: knots.collect(),
        closed: true,
    };
    let point = |i: usize, j: usize| {
        let angle = 2.0 * PI * i as f64 / count as f64;
        [angle.cos(), angle.sin(), j as f64]
    };
    let tube = surface(u, clamped(1, &[0.0, 1.0]), point, None);
    let known = |i: usize| [random(i, 0.618), random(i, 0.755)];
    let given = (0..300).map(|i| evaluate(&tube, known(i)));
    for (i, pair) in pairs(&tube, given).into_iter().enumerate() {
        for (found, known) in pair.into_iter().zip(known(i)) {
            assert!((found - known).abs() < 1e-13, "{i}: {pair:?}");
        }
    }
    let [u, v] = pairs(&tube, [evaluate(&tube, [1.0, 0.5])])[0];
    assert_eq!(u, 0.0);
    assert!((v - 0.5).abs() < 1e-15);
}

/// A large scale and a far place lose no more digits than the coordinates have.
#[test]
fn any_magnitude() {
    let hills = hills(3);
    let given: Vec<[f64; 3]> = (0..50)
        .map(|i| [6.0 * random(i, 0.618), 6.0 * random(i, 0.755), 1.0])
        .collect();
    let expected = pairs(&hills, given.clone());
    for scale in [1e-200, 1e200] {
        let scaled = |point: [f64; 3]| point.map(|x| x * scale);
        let large = Nurbs {
            points: Points::from_lanes(
                hills
                    .points
                    .lanes()
                    .iter()
                    .map(|lane| lane.iter().map(|x| x * scale).collect::<Vec<_>>()),
            ),
            ..hills.clone()
        };
        for (found, expected) in pairs(&large, given.iter().copied().map(scaled))
            .iter()
            .zip(&expected)
        {
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12));
        }
    }
}

/// What has no foot points.
#[test]
fn refusals() {
    let one = points([[0.0; 3]]);
    let mut curve = cylinder();
    curve.v = None;
    assert_eq!(foot_points(&curve, &one), Err(NoFootPoints::Curve));
    let plane = Points::from_flat(2, &[0.0, 1.0]);
    let dimensions = NoFootPoints::Dimension {
        surface: 3,
        points: 2,
    };
    assert_eq!(foot_points(&cylinder(), &plane), Err(dimensions));
    let mut pole = cylinder();
    pole.weights = Some(vec![1.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
    assert_eq!(foot_points(&pole, &one), Err(NoFootPoints::Weight));
    let mut infinite = cylinder();
    infinite.points = points(vec![[f64::INFINITY; 3]; 6]);
    assert_eq!(foot_points(&infinite, &one), Err(NoFootPoints::NotFinite));
    let high = clamped(33, &[0.0, 1.0]);
    let high = surface(
        high,
        clamped(1, &[0.0, 1.0]),
        |i, j| [i as f64, j as f64, 0.0],
        None,
    );
    let degree = NoFootPoints::Degree {
        degree: 33,
        most: 32,
    };
    assert_eq!(foot_points(&high, &one), Err(degree));
    assert!(pairs(&cylinder(), [[f64::NAN; 3]])[0][0].is_nan());
}
