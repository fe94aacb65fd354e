//! Meshes that are surfaces, and meshes that are not.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::invalid::Place;
use crate::parameters::{Domain, Scattered};

/// The triangles of a grid of rows and columns of points, of which the last row meets the first one if it goes around.
fn grid(rows: u32, columns: u32, is_closed: bool) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for i in 0..if is_closed { rows } else { rows - 1 } {
        for j in 0..columns - 1 {
            let at = |di: u32, dj: u32| (i + di) % rows * columns + j + dj;
            triangles.push([at(0, 0), at(1, 0), at(1, 1)]);
            triangles.push([at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
    triangles
}

fn places(rows: u32, columns: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Points {
    let mut points = Points::new(3);
    for i in 0..rows {
        for j in 0..columns {
            points.push(&place(
                f64::from(i) / f64::from(rows),
                f64::from(j) / f64::from(columns - 1),
            ));
        }
    }
    points
}

fn mesh(triangles: Vec<[u32; 3]>, unfolding: MeshUnfolding) -> Scattered {
    Scattered::Mesh(Mesh {
        triangles: Arc::new(triangles),
        unfolding,
    })
}

fn mean_values(triangles: &[[u32; 3]], points: &Points) -> Pairs {
    let rule = mesh(triangles.to_vec(), MeshUnfolding::MeanValue);
    rule.parameters(points, [false; 2]).unwrap()
}

fn refused(triangles: Vec<[u32; 3]>, points: &Points) -> (Place, String) {
    let error = mesh(triangles, MeshUnfolding::Auto).parameters(points, [false; 2]);
    let error = error.unwrap_err();
    (error.place, error.to_string())
}

/// Checks mean value coordinates of a mesh.
fn folded(triangles: &[[u32; 3]], points: &Points) -> Option<FoldedTriangles> {
    let mesh = Mesh {
        triangles: Arc::new(triangles.to_vec()),
        unfolding: MeshUnfolding::MeanValue,
    };
    mesh.solved(points, false).unwrap().folded
}

/// The triangles that hold, and their points under new numbers.
fn cut_out(
    triangles: &[[u32; 3]],
    points: &Points,
    holds: impl Fn([f64; 3]) -> bool,
) -> (Vec<[u32; 3]>, Points) {
    let at = |index: u32| [0, 1, 2].map(|axis| points.lane(axis)[index as usize]);
    let middle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(at);
        [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
    };
    let kept: Vec<[u32; 3]> = triangles
        .iter()
        .copied()
        .filter(|it| holds(middle(it)))
        .collect();
    let mut numbers = vec![u32::MAX; points.len()];
    let mut left = Points::new(3);
    let mut number = |index: u32| {
        let known = &mut numbers[index as usize];
        if *known == u32::MAX {
            *known = left.len() as u32;
            left.push(&at(index));
        }
        *known
    };
    let triangles = kept.into_iter().map(|it| it.map(&mut number)).collect();
    (triangles, left)
}

/// A flat rectangle has itself, turned to its longer side.
#[test]
fn a_rectangle_stays_one() {
    let points = places(20, 11, |s, t| [7.0 + 3.0 * t, 2.0, 20.0 * s]);
    let triangles = grid(20, 11, false);
    let pairs = mean_values(&triangles, &points);
    assert_eq!(folded(&triangles, &points), None);
    let [u, v] = [0, 1].map(|axis| pairs.values.lane(axis));
    for i in 0..points.len() {
        assert!((u[i] - points.lane(2)[i]).abs() < 1e-9, "{}", u[i]);
        let across = points.lane(0)[i] - 7.0;
        assert!(
            (v[i] - across).abs().min((3.0 - v[i] - across).abs()) < 1e-9,
            "{}",
            v[i]
        );
    }
}

/// A disc with stairs along its boundary fills a rectangle without a fold, whatever the magnitude and the sense of
/// single triangles.
#[test]
fn a_disc_fills_a_rectangle() {
    let points = places(30, 31, |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        [x, y, 0.5 - 0.5 * x * x]
    });
    let (mut triangles, points) =
        cut_out(&grid(30, 31, false), &points, |[x, y, _]| x.hypot(y) < 0.9);
    let pairs = mean_values(&triangles, &points);
    assert_eq!(folded(&triangles, &points), None);
    assert_eq!(pairs.domains, [Domain::Data; 2]);
    for triangle in triangles.iter_mut().step_by(3) {
        triangle.swap(0, 2);
    }
    for scale in [1e-150, 1.0, 1e150] {
        let lanes = points.lanes().iter();
        let scaled = lanes.map(|lane| lane.iter().map(|x| x * scale).collect::<Vec<_>>());
        let again = mean_values(&triangles, &Points::from_lanes(scaled));
        let [before, after] = [&pairs, &again].map(|it| it.values.lane(0));
        for (a, b) in before.iter().zip(after) {
            assert!((a - b / scale).abs() < 1e-9);
        }
    }
    let rule = mesh(triangles, MeshUnfolding::Auto)
        .chosen(&points)
        .unwrap();
    assert_eq!(rule, Scattered::Plane);
}

/// Half a tube is unrolled by a cylinder; a strongly curved strip that no simple surface unfolds by mean values.
#[test]
fn simple_surfaces_are_preferred() {
    let triangles = grid(30, 10, false);
    let half = |s: f64, t: f64| {
        let angle = 1.1 * PI * s;
        [5.0 * angle.cos(), 5.0 * angle.sin(), 9.0 * t]
    };
    let points = places(30, 10, half);
    let rule = mesh(triangles.clone(), MeshUnfolding::Auto)
        .chosen(&points)
        .unwrap();
    assert!(matches!(rule, Scattered::Cylinder(_)), "{rule:?}");
    // A spiral goes over itself.
    let spiral = |s: f64, t: f64| {
        let angle = 3.0 * PI * s;
        [
            (2.0 + angle) * angle.cos(),
            (2.0 + angle) * angle.sin(),
            9.0 * t,
        ]
    };
    let points = places(30, 10, spiral);
    let rule = mesh(triangles.clone(), MeshUnfolding::Auto)
        .chosen(&points)
        .unwrap();
    assert!(matches!(rule, Scattered::Mesh(_)), "{rule:?}");
    let pairs = rule.parameters(&points, [false; 2]).unwrap();
    assert_eq!(folded(&triangles, &points), None);
    // Rows of points along the spiral have one u.
    let u = pairs.values.lane(0);
    for row in u.chunks(10) {
        assert!(row.iter().all(|it| (it - row[0]).abs() < 0.2), "{row:?}");
    }
}

/// A patch whose four sides are curved fills a rectangle, from corner to corner.
#[test]
fn patches_fill_their_rectangle() {
    let patch = |s: f64, t: f64| {
        [
            20.0 * s + 1.5 * t * t,
            10.0 * t + 1.2 * (3.0 * s).sin(),
            4.0 * (4.0 * s).sin(),
        ]
    };
    let points = places(40, 25, patch);
    let triangles = grid(40, 25, false);
    let rule = mesh(triangles.clone(), MeshUnfolding::Auto)
        .chosen(&points)
        .unwrap();
    assert!(matches!(rule, Scattered::Mesh(_)), "{rule:?}");
    assert_eq!(folded(&triangles, &points), None);
    let pairs = mean_values(&triangles, &points);
    let [u, v] = [0, 1].map(|axis| pairs.values.lane(axis));
    let high = [u, v].map(|lane| lane.iter().copied().fold(0.0, f64::max));
    for corner in [0, 24, 39 * 25, 39 * 25 + 24] {
        let is_end = |value: f64, high: f64| value.min(high - value).abs() < 1e-9 * high;
        assert!(is_end(u[corner], high[0]) && is_end(v[corner], high[1]));
    }
}

/// A bent tube goes around: u has a period, no triangle folds, and rings have one v.
#[test]
fn two_loops_are_closed() {
    let bent = |s: f64, t: f64| {
        let (angle, bend) = (TAU * s, 2.5 * t);
        let out = 10.0 + 3.0 * angle.cos();
        [out * bend.cos(), out * bend.sin(), 3.0 * angle.sin()]
    };
    let points = places(24, 30, bent);
    let triangles = grid(24, 30, true);
    let rule = mesh(triangles.clone(), MeshUnfolding::Auto)
        .chosen(&points)
        .unwrap();
    assert!(matches!(rule, Scattered::Mesh(_)), "{rule:?}");
    let pairs = rule.parameters(&points, [true, false]).unwrap();
    assert_eq!(folded(&triangles, &points), None);
    let Domain::Closed(period) = pairs.domains[0] else {
        panic!("{:?}", pairs.domains);
    };
    assert!((period / (6.0 * PI) - 1.0).abs() < 0.1, "{period}");
    assert!(
        pairs
            .values
            .lane(0)
            .iter()
            .all(|u| (0.0..period).contains(u))
    );
    // Along the tube u is the same, to what its bend does.
    let u = pairs.values.lane(0);
    for line in u.chunks(30) {
        let away = |it: &f64| ((it - line[15]) / period + 0.5).rem_euclid(1.0) - 0.5;
        assert!(line.iter().all(|it| away(it).abs() < 0.08), "{line:?}");
    }
}

/// A flat ring is unfolded by its plane, and by mean values it goes around; with a small hole it fills a rectangle.
#[test]
fn rings_have_two_loops() {
    let points = places(40, 41, |s, t| [2.0 * s - 1.0, 2.0 * t - 1.0, 0.0]);
    let all = grid(40, 41, false);
    for (hole, is_closed) in [(0.4, true), (0.1, false)] {
        let ring = |[x, y, _]: [f64; 3]| (hole..0.9).contains(&x.hypot(y));
        let (triangles, points) = cut_out(&all, &points, ring);
        let rule = mesh(triangles.clone(), MeshUnfolding::Auto)
            .chosen(&points)
            .unwrap();
        assert_eq!(rule, Scattered::Plane);
        let pairs = mean_values(&triangles, &points);
        assert_eq!(folded(&triangles, &points), None);
        assert_eq!(pairs.domains[0].period().is_some(), is_closed);
    }
}

/// A mesh whose boundary has edges across it keeps all triangles that are not on one of its sides.
#[test]
fn edges_across_are_split() {
    // Two squares that are joined by one edge of a narrow neck.
    let points = places(30, 31, |s, t| [2.0 * s - 1.0, 2.0 * t - 1.0, 0.0]);
    let (triangles, points) = cut_out(&grid(30, 31, false), &points, |[x, y, _]| {
        x.abs() > 0.1 || y.abs() < 0.06
    });
    let folded = folded(&triangles, &points);
    assert!(folded.is_none_or(|it| it.share < 0.01), "{folded:?}");
}

/// Octahedra whose edges are halved again and again, on the unit sphere.
fn ball(halvings: usize) -> (Vec<[u32; 3]>, Points) {
    let mut places: Vec<[f64; 3]> = vec![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let mut triangles: Vec<[u32; 3]> = (0..4)
        .flat_map(|k| [[k, (k + 1) % 4, 4], [(k + 1) % 4, k, 5]])
        .collect();
    for _ in 0..halvings {
        let mut middles = std::collections::HashMap::new();
        let mut parts = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    let sum = [0, 1, 2].map(|k| places[a as usize][k] + places[b as usize][k]);
                    let length = sum.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
                    places.push(sum.map(|x| x / length));
                    places.len() as u32 - 1
                })
            };
            let (m, n, o) = (middle(a, b), middle(b, c), middle(c, a));
            parts.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]);
        }
        triangles = parts;
    }
    let mut points = Points::new(3);
    places.iter().for_each(|place| points.push(place));
    (triangles, points)
}

/// A closed mesh is unrolled by a sphere, with poles at both ends, also if it is a potato.
#[test]
fn closed_meshes_are_spheres() {
    let (triangles, points) = ball(4);
    let lanes = points.lanes().iter().zip([3.0, 3.5, 4.2]);
    let lanes = lanes.map(|(lane, scale)| lane.iter().map(|x| x * scale + 1.0).collect::<Vec<_>>());
    let points = Points::from_lanes(lanes);
    let rule = mesh(triangles, MeshUnfolding::Auto);
    let chosen = rule.chosen(&points).unwrap();
    assert!(matches!(chosen, Scattered::Sphere(_)), "{chosen:?}");
    let pairs = rule.parameters(&points, [false; 2]).unwrap();
    assert_eq!(pairs.domains[1].poles(), [true; 2]);
}

/// Closed meshes that no sphere unfolds, handles and Möbius strips are refused with what they are.
#[test]
fn other_surfaces_are_refused() {
    // A torus.
    let mut triangles = grid(12, 9, true);
    for triangle in &mut triangles {
        *triangle = triangle.map(|index| index / 9 * 8 + index % 9 % 8);
    }
    let torus = |s: f64, t: f64| {
        let out = 5.0 + 2.0 * (TAU * t).cos();
        [
            out * (TAU * s).cos(),
            out * (TAU * s).sin(),
            2.0 * (TAU * t).sin(),
        ]
    };
    let mut points = Points::new(3);
    (0..12).for_each(|i| {
        (0..8).for_each(|j| points.push(&torus(f64::from(i) / 12.0, f64::from(j) / 8.0)))
    });
    let (_, detail) = refused(triangles.clone(), &points);
    assert!(detail.contains("no boundary, and genus 1"), "{detail}");
    triangles.pop();
    let (_, detail) = refused(triangles, &points);
    assert!(
        detail.contains("one boundary loop, and genus 1"),
        "{detail}"
    );
    // A Möbius strip.
    let mut triangles = Vec::new();
    for i in 0..10_u32 {
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i == 9 {
            (1, 0)
        } else {
            (2 * i + 2, 2 * i + 3)
        };
        triangles.extend([[a, b, c], [b, d, c]]);
    }
    let strip = |i: u32| {
        let (angle, half) = (TAU * f64::from(i / 2) / 10.0, PI * f64::from(i / 2) / 10.0);
        let side = f64::from(i % 2) - 0.5;
        let out = 4.0 + side * half.cos();
        [out * angle.cos(), out * angle.sin(), side * half.sin()]
    };
    let mut points = Points::new(3);
    (0..20).for_each(|i| points.push(&strip(i)));
    let (_, detail) = refused(triangles, &points);
    assert!(detail.contains("one side only"), "{detail}");
    // A dumbbell.
    let (triangles, points) = ball(4);
    let narrow = |z: f64| 0.05 + z * z;
    let lanes = [0, 1, 2].map(|axis| {
        let lane = points.lane(axis).iter().zip(points.lane(2));
        let place = |(x, z): (&f64, &f64)| {
            if axis == 2 {
                3.0 * z + 9.0 * x.powi(3)
            } else {
                x * narrow(*z)
            }
        };
        lane.map(place).collect::<Vec<f64>>()
    });
    let bent = lanes[2].iter().map(|z| 0.1 * z * z).collect::<Vec<f64>>();
    let moved: Vec<f64> = lanes[0].iter().zip(&bent).map(|(x, b)| x + b).collect();
    let [_, y, z] = lanes;
    let (_, detail) = refused(triangles, &Points::from_lanes([moved, y, z]));
    assert!(detail.contains("closed (no boundary, genus 0)"), "{detail}");
}

/// Meshes that are not surfaces are refused at the first defect.
#[test]
fn meshes_that_are_no_surface_are_refused() {
    let points = places(4, 4, |s, t| [s, t, s * t]);
    let good = grid(4, 4, false);
    let with = |change: &dyn Fn(&mut Vec<[u32; 3]>)| {
        let mut triangles = good.clone();
        change(&mut triangles);
        refused(triangles, &points)
    };
    let (place, detail) = with(&|it| it[5][1] = 16);
    assert_eq!(place, Place::Triangle(5));
    assert!(
        detail.contains("point 16, and there are 16, from 0 to 15"),
        "{detail}"
    );
    let (place, detail) = with(&|it| it[7][0] = it[7][2]);
    assert_eq!(place, Place::Triangle(7));
    assert!(detail.contains("has a point twice"), "{detail}");
    let (place, detail) = with(&|it| it.truncate(12));
    assert_eq!(place, Place::Point(12));
    assert!(detail.contains("is in no triangle"), "{detail}");
    let (place, detail) = with(&|it| it.push([0, 5, 15]));
    assert_eq!(place, Place::Triangle(18));
    assert!(
        detail.contains("third one on the edge of points"),
        "{detail}"
    );
    let (_, detail) = with(&|it| it.clear());
    assert!(detail.contains("has no triangles"), "{detail}");
    // Two pieces, and two that touch in a point.
    let two = |shift: u32| {
        let mut triangles = grid(2, 3, false);
        triangles.extend(
            grid(2, 3, false)
                .into_iter()
                .map(|it| it.map(|index| index + shift)),
        );
        triangles
    };
    let points = places(4, 3, |s, t| [s, t, s * t]);
    let (_, detail) = refused(two(6), &points);
    assert!(detail.contains("2 pieces of 4, 4 triangles"), "{detail}");
    let bow_tie = vec![
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 4],
        [0, 5, 6],
        [5, 6, 4],
        [0, 4, 1],
        [5, 4, 3],
    ];
    let points = places(7, 1, |s, _| [s.cos(), s.sin(), s]);
    let (place, detail) = refused(bow_tie, &points);
    assert!(matches!(place, Place::Point(_)), "{place:?} {detail}");
    // Two points at one place.
    let mut points = places(4, 4, |s, t| [s, t, s * t]);
    let same: Vec<f64> = points.point(5).collect();
    points.lanes_mut()[0][6] = same[0];
    points.lanes_mut()[1][6] = same[1];
    points.lanes_mut()[2][6] = same[2];
    let error = mesh(good, MeshUnfolding::MeanValue)
        .parameters(&points, [false; 2])
        .unwrap_err();
    assert!(error.to_string().contains("at the same place"), "{error}");
    let flat = Points::from_lanes([vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 1.0]]);
    let (_, detail) = refused(vec![[0, 1, 2]], &flat);
    assert!(detail.contains("points of space"), "{detail}");
}

/// The largest piece is the first one.
#[test]
fn pieces_are_counted() {
    let triangles = [[0, 1, 2], [3, 4, 5], [5, 4, 6], [7, 8, 0]];
    assert_eq!(pieces(&triangles), [1, 0, 0, 2]);
}
