//! Which given knots are refused.

use super::knots::LARGEST;
use crate::fit::invalid::{Axis, Invalid};
use crate::fit::order;

/// Refuses explicit knots that are not the clamped knot vector of a continuous B-spline with
/// `count` control points.
///
/// # Errors
///
/// Names the direction `axis` and the first wrong knot: their number must be count + degree + 1,
/// they must not decrease, the first and the last degree + 1 must be equal, and no other knot may
/// occur more than `degree` times.
pub(in crate::fit) fn check(
    knots: &[f64],
    degree: usize,
    count: usize,
    axis: Axis,
) -> Result<(), Invalid> {
    let expected = count + degree + 1;
    if knots.len() != expected {
        return Err(Invalid::KnotCount {
            axis,
            given: knots.len(),
            expected,
            degree,
            count,
        });
    }
    check_order(knots, axis)?;
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if !(first < last && first.abs() <= LARGEST && last.abs() <= LARGEST) {
        return Err(Invalid::KnotRange { axis });
    }
    check_clamped(knots, degree, axis)?;
    let interior = &knots[degree + 1..count];
    if interior.len() <= degree || order::all_less(interior, &interior[degree..]) {
        return Ok(());
    }
    match interior.windows(degree + 1).position(|w| w[0] == w[degree]) {
        None => Ok(()),
        Some(start) => {
            let index = degree + 1 + start + degree;
            let value = knots[index];
            Err(Invalid::KnotMultiplicity {
                axis,
                index,
                value,
                degree,
            })
        }
    }
}

/// Refuses knots that decrease or are not finite, and names the first one.
fn check_order(knots: &[f64], axis: Axis) -> Result<(), Invalid> {
    let mut ends = knots.first().into_iter().chain(knots.last());
    if order::never_decreases(knots) && ends.all(|end| end.is_finite()) {
        return Ok(());
    }
    for (index, &value) in knots.iter().enumerate() {
        if !value.is_finite() {
            return Err(Invalid::KnotNotFinite { axis, index, value });
        }
        if index > 0 && value < knots[index - 1] {
            let previous = knots[index - 1];
            return Err(Invalid::KnotOrder {
                axis,
                index,
                value,
                previous,
            });
        }
    }
    Ok(())
}

/// Refuses knots whose first and last p + 1 are not equal, or of which more than that are.
fn check_clamped(knots: &[f64], degree: usize, axis: Axis) -> Result<(), Invalid> {
    let needed = degree + 1;
    let count = knots.len() - needed;
    let (low, high) = (knots[0], knots[knots.len() - 1]);
    let loose = |index: usize, end: f64| Invalid::KnotsNotClamped {
        axis,
        index,
        value: knots[index],
        end,
        needed,
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
        Some(index) => Err(Invalid::KnotMultiplicity {
            axis,
            index,
            value: knots[index],
            degree,
        }),
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
pub(in crate::fit) fn check_schoenberg_whitney(
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
    let good = order::all_less(low, inner) && order::all_less(inner, high);
    if good && is_inside(0) && is_inside(last) {
        return Ok(());
    }
    match (0..t.len()).find(|&index| !is_inside(index)) {
        None => Ok(()),
        Some(index) => {
            let (low, high) = support(index);
            Err(Invalid::SchoenbergWhitney {
                axis,
                index,
                parameter: t[index],
                low,
                high,
                degree,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind of mistake, with the first knot that shows it.
    #[test]
    fn bad_knots_name_the_index() {
        let check = |knots: &[f64]| check(knots, 2, 5, Axis::U).unwrap_err();
        assert!(matches!(
            check(&[0.0; 7]),
            Invalid::KnotCount { expected: 8, .. }
        ));
        assert!(matches!(
            check(&[0.0, 0.0, 0.0, 2.0, 1.0, 3.0, 3.0, 3.0]),
            Invalid::KnotOrder { index: 4, .. }
        ));
        assert!(matches!(
            check(&[0.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.0, 3.0]),
            Invalid::KnotsNotClamped { index: 2, .. }
        ));
        assert!(matches!(
            check(&[0.0, 0.0, 0.0, 1.0, 2.0, 2.5, 3.0, 3.0]),
            Invalid::KnotsNotClamped { index: 5, .. }
        ));
        assert!(matches!(
            check(&[0.0, 0.0, 0.0, 0.0, 2.0, 3.0, 3.0, 3.0]),
            Invalid::KnotMultiplicity { index: 3, .. }
        ));
        assert!(matches!(
            check(&[0.0, 0.0, 0.0, f64::NAN, 2.0, 3.0, 3.0, 3.0]),
            Invalid::KnotNotFinite { index: 3, .. }
        ));
    }

    /// A knot of multiplicity p + 1 between the ends would break the curve.
    #[test]
    fn interior_multiplicity_is_limited_by_the_degree() {
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0];
        assert!(matches!(
            check(&knots, 2, 6, Axis::U),
            Err(Invalid::KnotMultiplicity { index: 5, .. })
        ));
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
        assert!(matches!(error, Invalid::SchoenbergWhitney { index: 3, .. }));
    }
}
