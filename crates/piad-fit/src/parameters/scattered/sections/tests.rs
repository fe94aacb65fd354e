use std::f64::consts::TAU;

use super::Sections;
use crate::data::points::Points;
use crate::invalid::Place;
use crate::parameters::{Domain, Scattered};

/// Points around ellipses at some heights; each section starts at its angle and goes one way or the other.
fn ellipses(sections: &[(usize, f64, bool)]) -> (Points, Sections) {
    let mut numbers = Vec::new();
    for (k, &(count, start, is_reversed)) in sections.iter().enumerate() {
        let sense = if is_reversed { -1.0 } else { 1.0 };
        for i in 0..count {
            let angle = start + sense * TAU * i as f64 / count as f64;
            numbers.extend([3.0 * angle.cos(), 2.0 * angle.sin(), 4.0 * k as f64]);
        }
    }
    let counts: Vec<usize> = sections.iter().map(|section| section.0).collect();
    (Points::from_flat(3, &numbers), Sections::new(counts))
}

/// The distance of places on a line that comes back to its start.
fn around(a: f64, b: f64, period: f64) -> f64 {
    let apart = (a - b).rem_euclid(period);
    apart.min(period - apart)
}

#[test]
fn closed_sections_start_where_the_one_before_does() {
    let straight = [(40, 0.0, false); 3];
    let turned = [(40, 0.0, false), (40, 2.0, true), (40, 5.1, false)];
    let (points, sections) = ellipses(&straight);
    let pairs = sections.parameters(&points, [false; 2]).unwrap();
    let [u, v] = [0, 1].map(|axis| pairs.values.lane(axis).to_vec());
    let Domain::Closed(period) = pairs.domains[1] else {
        panic!("{:?}", pairs.domains)
    };
    assert_eq!(pairs.domains[0], Domain::Data);
    assert_eq!((u[0], u[40], u[80]), (0.0, 4.0, 8.0));
    assert!((period - 15.86).abs() < 0.02, "{period}");
    assert!(v.iter().all(|v| (0.0..period).contains(v)));

    let (points, sections) = ellipses(&turned);
    let pairs = sections.parameters(&points, [false; 2]).unwrap();
    let v_turned = pairs.values.lane(1);
    // A point of a turned section has the parameter of the point of the same angle. They start at places that are known
    // to about a hundredth of the distance of the places at which they are compared.
    for k in 0..40 {
        let angle = TAU * k as f64 / 40.0;
        let place = ((2.0 - angle).rem_euclid(TAU) / TAU) * 40.0;
        let (low, part) = (place.floor() as usize % 40, place.fract());
        let expected = v[low] + part * around(v[(low + 1) % 40], v[low], period);
        let apart = around(v_turned[40 + k], expected, period);
        assert!(apart < 0.01 * period, "{k}: {apart}");
    }
}

#[test]
fn open_sections_go_one_way() {
    let row = |y: f64, xs: [f64; 4]| xs.map(|x| [x, y, 0.1 * x * x]);
    let points: Vec<[f64; 3]> = [
        row(0.0, [0.0, 1.0, 2.0, 3.0]),
        row(1.0, [3.0, 2.0, 1.0, 0.0]),
    ]
    .concat();
    let points = Points::from_flat(3, &points.concat());
    let sections = Sections::new([4, 4]);
    let pairs = sections.parameters(&points, [false; 2]).unwrap();
    assert_eq!(pairs.domains, [Domain::Data; 2]);
    let v = pairs.values.lane(1);
    assert!((0..4).all(|k| (v[k] - v[7 - k]).abs() < 1e-12), "{v:?}");
    // Sections that do not return to their start are closed if requested.
    let pairs = sections.parameters(&points, [false, true]).unwrap();
    assert!(pairs.domains[1].period().is_some());
}

#[test]
fn errors_are_named() {
    let (points, sections) = ellipses(&[(12, 0.0, false), (9, 0.0, false)]);
    let refused = |counts: &[usize], points: &Points| {
        let sections = Scattered::Sections(Sections::new(counts));
        let refused = sections.parameters(points, [false; 2]).unwrap_err();
        (refused.place, refused.to_string())
    };
    assert!(sections.parameters(&points, [false; 2]).is_ok());
    let (_, detail) = refused(&[21], &points);
    assert!(detail.contains("two of them or more, not 1"), "{detail}");
    let (_, detail) = refused(&[12, 8], &points);
    assert!(detail.contains("have 20 points, and 21"), "{detail}");
    let (place, detail) = refused(&[12, 8, 1], &points);
    assert_eq!(place, Place::Section(2));
    assert!(detail.contains("section 2 has 1 points"), "{detail}");
    let (twice, _) = ellipses(&[(12, 0.0, false)]);
    let twice = [0, 1, 2].map(|axis| twice.lane(axis).repeat(2));
    let (place, detail) = refused(&[12, 12], &Points::from_lanes(twice));
    assert_eq!(place, Place::Section(1));
    assert!(detail.contains("the same as section 0"), "{detail}");
}

/// Two straight sections that form a cross, and two rings of a chain.
#[test]
fn sections_that_cross_are_refused() {
    let cross: Vec<[f64; 3]> = (0..6)
        .map(|k| [f64::from(k) - 2.5, 0.0, 0.0])
        .chain((0..6).map(|k| [0.0, f64::from(k) - 2.5, 0.0]))
        .collect();
    let ring = |k: u32| {
        let angle = TAU * f64::from(k) / 20.0;
        [angle.cos(), angle.sin()]
    };
    let chain: Vec<[f64; 3]> = (0..20)
        .map(ring)
        .map(|[x, y]| [x, y, 0.0])
        .chain((0..20).map(ring).map(|[x, y]| [x + 1.0, 0.0, y]))
        .collect();
    for (points, count) in [(cross, 6), (chain, 20)] {
        let points = Points::from_flat(3, &points.concat());
        let refused = Sections::new([count, count]).parameters(&points, [false; 2]);
        let refused = refused.unwrap_err();
        assert_eq!(refused.place, Place::Section(1));
        let detail = refused.to_string();
        assert!(detail.contains("section 1 crosses section 0"), "{detail}");
    }
}
