//! Validation of given knots.

use crate::data::monotonic;
use crate::invalid::{Axis, Invalid, Place};
use crate::parameters::LARGEST;

/// Refuses explicit knots that are not the clamped knot vector of a continuous B-spline with
/// `count` control points.
///
/// # Errors
///
/// Names the direction `axis` and the first wrong knot: their number must be count + degree + 1,
/// they must not decrease, the first and the last degree + 1 must be equal, and no other knot may
/// occur more than `degree` times.
pub(crate) fn check(knots: &[f64], degree: usize, count: usize, axis: Axis) -> Result<(), Invalid> {
    let expected = count + degree + 1;
    if knots.len() != expected {
        return Err(Invalid::at(
            Place::Knots(axis),
            format!(
                "{given} knots given; degree {degree} and {count} points (one control point each) need {expected} = points + degree + 1",
                given = knots.len()
            ),
        ));
    }
    check_order(knots, axis)?;
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if !(first < last && first.abs() <= LARGEST && last.abs() <= LARGEST) {
        return Err(Invalid::at(
            Place::Knots(axis),
            "the knots span more than the range of 64-bit numbers, or nothing",
        ));
    }
    check_clamped(knots, degree, axis)?;
    let interior = &knots[degree + 1..count];
    if interior.len() <= degree || monotonic::all_less(interior, &interior[degree..]) {
        return Ok(());
    }
    match interior.windows(degree + 1).position(|w| w[0] == w[degree]) {
        None => Ok(()),
        Some(start) => {
            let index = degree + 1 + start + degree;
            let value = knots[index];
            Err(knot_multiplicity(axis, index, value, degree))
        }
    }
}

/// Refuses knots that decrease or are not finite, and names the first one.
fn check_order(knots: &[f64], axis: Axis) -> Result<(), Invalid> {
    let mut ends = knots.first().into_iter().chain(knots.last());
    if monotonic::never_decreases(knots) && ends.all(|end| end.is_finite()) {
        return Ok(());
    }
    for (index, &value) in knots.iter().enumerate() {
        if !value.is_finite() {
            return Err(Invalid::at(
                Place::Knot(axis, index),
                format!("knot {index} is {value}, which is not a finite number"),
            ));
        }
        if index > 0 && value < knots[index - 1] {
            let previous = knots[index - 1];
            return Err(Invalid::at(
                Place::Knot(axis, index),
                format!(
                    "knot {index} is {value}, less than the one before, {previous}: knots must not decrease"
                ),
            ));
        }
    }
    Ok(())
}

/// Refuses knots whose first and last p + 1 are not equal, or of which more than that are.
fn check_clamped(knots: &[f64], degree: usize, axis: Axis) -> Result<(), Invalid> {
    let needed = degree + 1;
    let count = knots.len() - needed;
    let (low, high) = (knots[0], knots[knots.len() - 1]);
    let loose = |index: usize, end: f64| {
        Invalid::at(
            Place::Knot(axis, index),
            format!(
                "knot {index} is {value}, but the knots must be clamped: the first and the last {needed} equal (the end is {end})",
                value = knots[index]
            ),
        )
    };
    if let Some(index) = (0..needed).find(|&i| knots[i] != low) {
        return Err(loose(index, low));
    }
    if let Some(index) = (count..knots.len()).find(|&i| knots[i] != high) {
        return Err(loose(index, high));
    }
    // One more knot at an end would make the outermost function vanish.
    let repeated = (count > needed && knots[needed] == low)
        .then_some(needed)
        .or((count > needed && knots[count - 1] == high).then_some(count - 1));
    match repeated {
        None => Ok(()),
        Some(index) => Err(knot_multiplicity(axis, index, knots[index], degree)),
    }
}

/// Refuses knots with which the collocation matrix is singular (Schoenberg, Whitney 1953): it is
/// nonsingular exactly if `N_j(t_j) > 0` for every j.
///
/// On a clamped knot vector that means `knots[j] < t_j < knots[j + p + 1]`, where the first and the
/// last parameter may lie on the ends.
///
/// # Errors
///
/// Names the first parameter outside of the support of its B-spline.
pub(crate) fn check_schoenberg_whitney(
    knots: &[f64],
    degree: usize,
    t: &[f64],
    axis: Axis,
) -> Result<(), Invalid> {
    let last = t.len() - 1;
    let support = |index: usize| (knots[index], knots[index + degree + 1]);
    let is_inside = |index: usize| {
        let ((low, high), t) = (support(index), t[index]);
        (t > low || (index == 0 && t == low)) && (t < high || (index == last && t == high))
    };
    let inner = 1..last.max(1);
    let (low, high) = (&knots[inner.clone()], &knots[degree + 2..]);
    let inner = &t[inner];
    let good = monotonic::all_less(low, inner) && monotonic::all_less(inner, high);
    if good && is_inside(0) && is_inside(last) {
        return Ok(());
    }
    match (0..t.len()).find(|&index| !is_inside(index)) {
        None => Ok(()),
        Some(index) => {
            let (low, high) = support(index);
            Err(Invalid::at(
                Place::Knots(axis),
                format!(
                    "Schoenberg–Whitney: parameter {index} is {parameter}, outside the support ({low}, {high}) of B-spline {index}, so that the interpolation problem is singular: move knots {index} or {upper}, or the parameter",
                    upper = index + degree + 1,
                    parameter = t[index]
                ),
            ))
        }
    }
}

/// An explicit knot between the ends occurs more than degree times.
fn knot_multiplicity(axis: Axis, index: usize, value: f64, degree: usize) -> Invalid {
    let detail = format!(
        "knot {index} repeats the value {value} more than degree = {degree} times, which breaks the curve"
    );
    Invalid::at(Place::Knot(axis, index), detail)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind of validation error, with the index of the first knot that causes it.
    #[test]
    fn bad_knots_name_the_index() {
        let check = |knots: &[f64]| check(knots, 2, 5, Axis::U).unwrap_err();
        assert_eq!(check(&[0.0; 7]).place, Place::Knots(Axis::U));
        let cases = [
            ([0.0, 0.0, 0.0, 2.0, 1.0, 3.0, 3.0, 3.0], 4, "decrease"),
            ([0.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.0, 3.0], 2, "clamped"),
            ([0.0, 0.0, 0.0, 1.0, 2.0, 2.5, 3.0, 3.0], 5, "clamped"),
            ([0.0, 0.0, 0.0, 0.0, 2.0, 3.0, 3.0, 3.0], 3, "repeats"),
            ([0.0, 0.0, 0.0, f64::NAN, 2.0, 3.0, 3.0, 3.0], 3, "finite"),
        ];
        for (knots, index, word) in cases {
            let error = check(&knots);
            assert_eq!(error.place, Place::Knot(Axis::U, index));
            assert!(error.to_string().contains(word), "{error}");
        }
    }

    /// A knot of multiplicity p + 1 between the ends would break the curve.
    #[test]
    fn interior_multiplicity_is_limited_by_the_degree() {
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0];
        let error = check(&knots, 2, 6, Axis::U).unwrap_err();
        assert_eq!(error.place, Place::Knot(Axis::U, 5));
        assert!(check(&[0.0, 0.0, 0.0, 1.0, 1.0, 3.0, 3.0, 3.0], 2, 5, Axis::U).is_ok());
    }

    /// The condition at, within and outside of the supports.
    #[test]
    fn schoenberg_whitney_names_the_parameter() {
        let knots = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0];
        let check = |t: &[f64]| check_schoenberg_whitney(&knots, 2, t, Axis::U);
        assert!(check(&[0.0, 0.5, 1.5, 2.5, 3.0]).is_ok());
        assert!(check(&[0.1, 0.5, 1.5, 2.5, 2.9]).is_ok());
        // Four parameters in the first span leave N_3 without one.
        let error = check(&[0.0, 0.2, 0.5, 0.9, 3.0]).unwrap_err();
        assert!(error.to_string().contains("parameter 3"), "{error}");
    }
}
