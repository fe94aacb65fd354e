//! The number of control points for a tolerance, and how many with `splprep` of scipy 1.17.1 (the
//! best of ten smoothing factors) and `GeomAPI_PointsToBSpline` of OpenCASCADE 7.9, all of them
//! cubic: `benches/tolerance` compares them through the API.

use super::*;

/// A tolerance, the control points of scipy and OpenCASCADE, and ours.
type Row = (f64, usize, usize, usize);

const PROFILE: [Row; 3] = [(1e-3, 13, 31, 10), (1e-4, 20, 51, 16), (1e-5, 40, 72, 27)];
const LEMNISCATE: [Row; 3] = [(1e-3, 15, 17, 13), (1e-4, 27, 26, 19), (1e-5, 42, 39, 29)];
const ROSE: [Row; 4] = [
    (1e-2, 34, 41, 25),
    (1e-3, 58, 88, 38),
    (1e-4, 92, 135, 61),
    (1e-5, 161, 209, 102),
];
const HELIX: [Row; 4] = [
    (1e-2, 19, 17, 16),
    (1e-3, 38, 25, 25),
    (1e-4, 76, 41, 40),
    (1e-5, 152, 69, 68),
];
const STEP: [Row; 4] = [
    (1e-2, 19, 54, 12),
    (1e-3, 24, 211, 14),
    (1e-4, 29, 337, 19),
    (1e-5, 34, 382, 29),
];

/// The upper side of a symmetric section of the UIUC collection, M1, from the trailing edge on.
const SECTION: [[f64; 2]; 17] = [
    [1.0, 0.002],
    [0.95, 0.0057],
    [0.9, 0.0091],
    [0.8, 0.0154],
    [0.7, 0.0208],
    [0.6, 0.0253],
    [0.5, 0.0285],
    [0.4, 0.0305],
    [0.3, 0.0308],
    [0.2, 0.0288],
    [0.15, 0.0267],
    [0.1, 0.0234],
    [0.075, 0.021],
    [0.05, 0.018],
    [0.025, 0.0136],
    [0.0125, 0.0103],
    [0.0, 0.0],
];

/// No more control points than either, within the tolerance.
fn check(points: &Points, rows: &[Row]) {
    for &(tolerance, scipy, opencascade, ours) in rows {
        let (levels, outcome) = levels(points, chord(points), cubic(tolerance));
        let last = levels.last().unwrap();
        assert_eq!(outcome, Some(Outcome::Converged));
        assert!(last.distances.max <= tolerance);
        let count = last.count();
        assert!(count <= scipy.min(opencascade), "{tolerance:e}: {count}");
        assert!(count <= ours, "{tolerance:e}: {count}");
        valid(points, &levels);
    }
}

#[test]
fn profile_of_a_wing() {
    check(&profile(), &PROFILE);
}

/// Hardly more points than control points.
#[test]
fn few_points_of_a_wing() {
    let mut points = Points::new(2);
    SECTION.iter().for_each(|point| points.push(point));
    let lower = SECTION.iter().rev().skip(1);
    lower.for_each(|[x, y]| points.push(&[*x, -y]));
    check(&points, &[(1e-4, 19, 33, 15)]);
}

#[test]
fn half_a_lemniscate() {
    check(&lemniscate(), &LEMNISCATE);
}

#[test]
fn four_leaves() {
    check(&rose(1501), &ROSE);
}

#[test]
fn three_turns_of_a_helix() {
    check(&helix(), &HELIX);
}

#[test]
fn steep_step() {
    check(&step(), &STEP);
}

/// A quarter fewer than the better of both.
#[test]
fn in_total_a_quarter_fewer() {
    let rows = [&PROFILE[..], &LEMNISCATE, &ROSE, &HELIX, &STEP].concat();
    let better: usize = rows.iter().map(|row| row.1.min(row.2)).sum();
    let ours: usize = rows.iter().map(|row| row.3).sum();
    assert_eq!((better, ours), (756, 563));
    assert!(4 * ours <= 3 * better);
}
