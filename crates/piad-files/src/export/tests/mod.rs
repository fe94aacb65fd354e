//! Files of several parts, each with its own reader.
//!
//! With `PIAD_PARTS_DIR` the files go to that folder, for software of others.

mod assembled;
mod drawn;
mod exact;
mod refused;
mod sampled;
mod trimmed;

use jiff::Timestamp;
use piad_fit::data::Points;

use super::cylinder::{cylinder, line_of};
use super::nurbs::{DirectionData, KnotVector, assemble};
use super::{Format, Header, Nurbs, Options, Part, write_parts};

/// A cubic curve of the plane with an inner knot.
fn wave() -> Nurbs {
    let knots = [0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0];
    of_points(
        line_of(3, &knots),
        &[[0.0, 0.0], [1.0, 2.0], [2.0, -1.5], [3.0, 1.0], [4.0, 0.25]],
    )
}

/// A closed cubic curve, whose knots and control points continue beyond its ends.
fn ring() -> Nurbs {
    let free = [
        [10.0, 0.0],
        [12.0, 1.0],
        [11.0, 3.0],
        [9.0, 3.0],
        [8.0, 1.0],
    ];
    let points: Vec<[f64; 2]> = (0..8).map(|i| free[i % 5]).collect();
    let u = KnotVector {
        degree: 3,
        knots: (-3..=8).map(|i| f64::from(i) / 5.0).collect(),
        closed: true,
    };
    of_points(u, &points)
}

/// A quarter of a circle in space, at height 1.5.
fn arc() -> Nurbs {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Nurbs {
        weights: Some(vec![1.0, half, 1.0]),
        ..of_points(
            line_of(2, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
            &[[5.0, 0.0, 1.5], [5.0, 5.0, 1.5], [0.0, 5.0, 1.5]],
        )
    }
}

fn of_points<const D: usize>(u: KnotVector, places: &[[f64; D]]) -> Nurbs {
    let mut points = Points::new(D);
    places.iter().for_each(|place| points.push(place));
    Nurbs {
        u,
        v: None,
        points,
        weights: None,
    }
}

fn part(name: &str, nurbs: Nurbs) -> Part<'_> {
    Part {
        name: Some(name),
        nurbs,
        outline: None,
    }
}

/// Three curves: two with one name, one without.
fn curves() -> [Part<'static>; 3] {
    [
        part("Höhe 5/7", wave()),
        part("Höhe 5/7", ring()),
        Part {
            name: None,
            nurbs: arc(),
            outline: None,
        },
    ]
}

fn surfaces() -> [Part<'static>; 2] {
    let mut other = cylinder();
    other.points.lanes_mut()[0]
        .iter_mut()
        .for_each(|x| *x += 10.0);
    other.weights = None;
    [part("tube", cylinder()), part("sheet", other)]
}

/// Curves and a surface.
fn mixed() -> Vec<Part<'static>> {
    let [first, ..] = surfaces();
    curves().into_iter().chain([first]).collect()
}

fn header(options: Options) -> Header<'static> {
    Header {
        name: Some("all of it"),
        ..Header::new(Timestamp::from_second(1_800_000_000).unwrap(), options)
    }
}

/// Writes parts; keeps the file under a name if a folder is given.
fn file(name: &str, format: Format, parts: &[Part<'_>], options: Options) -> Vec<u8> {
    let file = write_parts(format, parts, &header(options)).unwrap();
    if let Some(folder) = std::env::var_os("PIAD_PARTS_DIR") {
        let path = std::path::Path::new(&folder).join(format!("{name}.{}", format.extension()));
        std::fs::write(path, &file).unwrap();
    }
    file
}

fn text(name: &str, format: Format, parts: &[Part<'_>], options: Options) -> String {
    String::from_utf8(file(name, format, parts, options)).unwrap()
}

/// A point of a curve.
fn point(nurbs: &Nurbs, t: f64) -> [f64; 3] {
    nurbs.evaluate(&[nurbs.u.site_at(t)], &[])[0].point
}

fn is_near(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() <= tolerance)
}
