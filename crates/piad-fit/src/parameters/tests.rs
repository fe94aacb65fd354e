//! Parameters of curves and surfaces against lengths that are known.

use super::*;

/// The points of a planar curve.
fn curve(values: &[[f64; 2]]) -> (Points, Grid) {
    let mut points = Points::new(2);
    values.iter().for_each(|p| points.push(p));
    let grid = Grid {
        rows: values.len(),
        columns: 1,
    };
    (points, grid)
}

/// All three rules on distances 5, 1 and 9.
#[test]
fn lengths_accumulate() {
    let (points, grid) = curve(&[[0.0, 0.0], [3.0, 4.0], [3.0, 5.0], [12.0, 5.0]]);
    let t = |choice| {
        parameters(choice, &points, grid, None, Axis::U, false)
            .unwrap()
            .values
    };
    assert_eq!(*t(Parametrization::ChordLength), [0.0, 5.0, 6.0, 15.0]);
    let root = 5f64.sqrt();
    assert_eq!(
        *t(Parametrization::Centripetal),
        [0.0, root, root + 1.0, root + 4.0]
    );
    assert_eq!(
        *t(Parametrization::Uniform),
        [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]
    );
}

/// The closing chord belongs to the period, and not to the parameters.
#[test]
fn closed_curves_return_to_the_first_point() {
    let (points, grid) = curve(&[[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]);
    let closed = |choice| parameters(choice, &points, grid, None, Axis::U, true).unwrap();
    let chord = closed(Parametrization::ChordLength);
    assert_eq!(
        (&chord.values[..], chord.period),
        (&[0.0, 3.0, 7.0][..], 12.0)
    );
    let uniform = closed(Parametrization::Uniform);
    assert_eq!(*uniform.values, [0.0, 1.0 / 3.0, 2.0 / 3.0]);
    assert_eq!(uniform.period, 1.0);
}

/// Chord length is undefined between equal points.
#[test]
fn equal_neighbours_are_named() {
    let (points, grid) = curve(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
    let error = parameters(
        Parametrization::ChordLength,
        &points,
        grid,
        None,
        Axis::U,
        false,
    )
    .unwrap_err();
    assert_eq!(error.place, Place::Line(Axis::U, 2));
}

/// LWD04 (12)–(13).
#[test]
fn surface_steps_are_means_over_the_other_direction() {
    // Rows at heights 0 and 1 (first column) or 0 and 3 (second): mean step 2 in u.
    let mut points = Points::new(2);
    for p in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 3.0]] {
        points.push(&p);
    }
    let grid = Grid {
        rows: 2,
        columns: 2,
    };
    let steps = |axis| {
        let choice = Parametrization::ChordLength;
        parameters(choice, &points, grid, None, axis, false)
            .unwrap()
            .values
    };
    let (u, v) = (steps(Axis::U), steps(Axis::V));
    assert_eq!(*u, [0.0, 2.0]);
    assert_eq!(*v, [0.0, (1.0 + 5f64.sqrt()) / 2.0]);
}

/// And parameters that would fall together are refused.
#[test]
fn rescaling_hits_both_ends() {
    let mut t = vec![3.0, 4.0, 7.1];
    rescale(&mut t, 0.0, 1.0, Axis::U).unwrap();
    assert_eq!((t[0], t[2]), (0.0, 1.0));
    let mut close = vec![0.0, 1e-300, 1.0];
    assert!(rescale(&mut close, 5.0, 6.0, Axis::U).is_err());
}
