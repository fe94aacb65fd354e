//! How many control points a tolerance takes, and how many with `splprep` of scipy 1.17.1 (the best
//! of ten smoothing factors) and `GeomAPI_PointsToBSpline` of OpenCASCADE 7.9 (of degree up to 8).

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
    (1e-3, 38, 26, 25),
    (1e-4, 76, 43, 40),
    (1e-5, 152, 73, 68),
];
const STEP: [Row; 4] = [
    (1e-2, 19, 68, 12),
    (1e-3, 24, 253, 14),
    (1e-4, 29, 368, 19),
    (1e-5, 34, 382, 29),
];

/// No more control points than either, within the tolerance.
fn check(points: &Points, rows: &[Row]) {
    for &(tolerance, scipy, opencascade, ours) in rows {
        let (levels, outcome) = levels(points, chord(points), cubic(tolerance));
        let last = levels.last().unwrap();
        assert_eq!(outcome, Some(Outcome::Converged));
        assert!(last.distances.max <= tolerance);
        let count = last.line.control_points();
        assert!(count <= scipy.min(opencascade), "{tolerance:e}: {count}");
        assert!(count <= ours, "{tolerance:e}: {count}");
        valid(points, &levels);
    }
}

#[test]
fn profile_of_a_wing() {
    check(&profile(), &PROFILE);
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
    assert_eq!((better, ours), (763, 563));
    assert!(4 * ours <= 3 * better);
}
