//! Parameters of data points: where on the curve each of them lies.

use super::invalid::{Axis, Invalid};
use super::points::{Grid, Points};

/// How the parameters of one direction are chosen.
#[derive(Clone, Debug, PartialEq)]
pub enum Parametrization {
    /// `t_i = i / n`.
    Uniform,
    /// Steps are the distances of successive points, in data units; on surfaces their mean over
    /// all lines of the other direction (LWD04 (12)–(13)).
    ChordLength,
    /// Steps are square roots of the distances (Lee 1989), averaged likewise.
    Centripetal,
    /// Given values, strictly increasing.
    Explicit(Vec<f64>),
}

/// The parameters of the points of `grid` in direction `axis`: finite and strictly increasing.
pub fn parameters(
    choice: Parametrization,
    points: &Points,
    grid: Grid,
    axis: Axis,
) -> Result<Vec<f64>, Invalid> {
    let count = match axis {
        Axis::U => grid.rows,
        Axis::V => grid.columns,
    };
    match choice {
        Parametrization::Uniform => {
            let n = (count - 1) as f64;
            Ok((0..count).map(|i| i as f64 / n).collect())
        }
        Parametrization::ChordLength => by_distance(points, grid, axis, "chord-length", |d| d),
        Parametrization::Centripetal => by_distance(points, grid, axis, "centripetal", f64::sqrt),
        Parametrization::Explicit(values) => explicit(values, count, axis),
    }
}

/// Parameters whose steps are a function of the distances of successive points.
fn by_distance(
    points: &Points,
    grid: Grid,
    axis: Axis,
    rule: &'static str,
    step: impl Fn(f64) -> f64,
) -> Result<Vec<f64>, Invalid> {
    let Grid { rows, columns } = grid;
    // Point (line, k) of the direction, for every line of the other direction.
    let (count, lines, stride, line_stride) = match axis {
        Axis::U => (rows, columns, columns, 1),
        Axis::V => (columns, rows, 1, columns),
    };
    let mut t = Vec::with_capacity(count);
    let mut last = 0.0;
    t.push(last);
    for k in 1..count {
        let total: f64 = (0..lines)
            .map(|line| line * line_stride + k * stride)
            .map(|index| step(points.distance(index - stride, index)))
            .sum();
        let next = last + total / lines as f64;
        if !next.is_finite() {
            return Err(Invalid::TooLarge);
        }
        if next <= last {
            let index = k;
            return Err(if grid.columns == 1 {
                Invalid::EqualPoints { axis, index, rule }
            } else {
                Invalid::EqualLines { axis, index, rule }
            });
        }
        t.push(next);
        last = next;
    }
    Ok(t)
}

fn explicit(values: Vec<f64>, expected: usize, axis: Axis) -> Result<Vec<f64>, Invalid> {
    if values.len() != expected {
        let given = values.len();
        return Err(Invalid::ParameterCount {
            axis,
            given,
            expected,
        });
    }
    for (index, &value) in values.iter().enumerate() {
        if !value.is_finite() {
            return Err(Invalid::ParameterNotFinite { axis, index, value });
        }
        if index > 0 && value <= values[index - 1] {
            let previous = values[index - 1];
            return Err(Invalid::ParameterOrder {
                axis,
                index,
                value,
                previous,
            });
        }
    }
    Ok(values)
}

/// Maps increasing parameters affinely so that they start at `low` and end at `high`, exactly.
pub fn rescale(t: &mut [f64], low: f64, high: f64, axis: Axis) -> Result<(), Invalid> {
    let (Some(&first), Some(&last)) = (t.first(), t.last()) else {
        return Ok(());
    };
    let length = last - first;
    for x in t.iter_mut() {
        *x = low + (high - low) * ((*x - first) / length);
    }
    if let Some(end) = t.last_mut() {
        *end = high;
    }
    // Neighbours may fall together when they differ by less than the rounding of the new range.
    if length.is_finite() && t.windows(2).all(|pair| pair[0] < pair[1]) {
        Ok(())
    } else {
        Err(Invalid::ParameterRange { axis })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(values: &[[f64; 2]]) -> (Points, Grid) {
        let mut points = Points::new(2);
        values.iter().for_each(|p| points.push(p));
        let grid = Grid {
            rows: values.len(),
            columns: 1,
        };
        (points, grid)
    }

    #[test]
    fn lengths_accumulate() {
        let (points, grid) = curve(&[[0.0, 0.0], [3.0, 4.0], [3.0, 5.0], [12.0, 5.0]]);
        let t = |choice| parameters(choice, &points, grid, Axis::U).unwrap();
        assert_eq!(t(Parametrization::ChordLength), [0.0, 5.0, 6.0, 15.0]);
        let root = 5f64.sqrt();
        assert_eq!(
            t(Parametrization::Centripetal),
            [0.0, root, root + 1.0, root + 4.0]
        );
        assert_eq!(
            t(Parametrization::Uniform),
            [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]
        );
    }

    #[test]
    fn equal_neighbours_are_named() {
        let (points, grid) = curve(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        let error = parameters(Parametrization::ChordLength, &points, grid, Axis::U).unwrap_err();
        assert!(matches!(error, Invalid::EqualPoints { index: 2, .. }));
    }

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
        let u = parameters(Parametrization::ChordLength, &points, grid, Axis::U).unwrap();
        let v = parameters(Parametrization::ChordLength, &points, grid, Axis::V).unwrap();
        assert_eq!(u, [0.0, 2.0]);
        assert_eq!(v, [0.0, (1.0 + 5f64.sqrt()) / 2.0]);
    }

    #[test]
    fn rescaling_hits_both_ends() {
        let mut t = vec![3.0, 4.0, 7.1];
        rescale(&mut t, 0.0, 1.0, Axis::U).unwrap();
        assert_eq!((t[0], t[2]), (0.0, 1.0));
        let mut close = vec![0.0, 1e-300, 1.0];
        assert!(rescale(&mut close, 5.0, 6.0, Axis::U).is_err());
    }
}
