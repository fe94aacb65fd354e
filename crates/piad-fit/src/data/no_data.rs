//! Values that mark missing data in files of heights.

use super::points::Points;

/// Values that programs write for missing data, besides -9999 and others of nines: the least integers
/// of 16 and 32 bits.
const LIMITS: [f64; 2] = [-32768.0, -2_147_483_648.0];

/// Programs also write the largest numbers that there are.
const LARGE: f64 = 1e30;

/// Such a value differs from all others by more than this part of their range.
const AWAY: f64 = 0.1;

/// The value of the last coordinate that stands for missing data, and how often it is there: one that programs use for
/// it, more than once, and away from all others. Points with these indices, which increase, are ignored.
pub(crate) fn no_data(points: &Points, missing: &[usize]) -> Option<(f64, usize)> {
    let values = points.lanes().last()?;
    let is_given = |index: usize| missing.binary_search(&index).is_err();
    let given = || {
        let values = values.iter().enumerate();
        values
            .filter(|(index, _)| is_given(*index))
            .map(|(_, it)| *it)
    };
    let low = given().fold(f64::INFINITY, f64::min);
    let high = given().fold(f64::NEG_INFINITY, f64::max);
    [low, high].into_iter().find_map(|value| {
        if !stands_for_nothing(value) {
            return None;
        }
        let others = || given().filter(|it| *it != value);
        let least = others().fold(f64::INFINITY, f64::min);
        let largest = others().fold(f64::NEG_INFINITY, f64::max);
        let gap = (value - least).abs().min((value - largest).abs());
        let count = given().filter(|it| *it == value).count();
        let is_away = gap.is_finite() && gap > AWAY * (largest - least);
        (count > 1 && is_away).then_some((value, count))
    })
}

/// Returns true for values that programs write for missing data.
fn stands_for_nothing(value: f64) -> bool {
    let size = value.abs();
    let nines = [999.0, 9999.0, 99999.0, 999_999.0];
    nines.contains(&size) || LIMITS.contains(&value) || size >= LARGE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_stand_for_nothing_are_found() {
        let heights = |value: f64, every: usize| {
            let height = |i: usize| match i % every {
                0 => value,
                _ => 215.0 + (i as f64).sin(),
            };
            Points::from_lanes([(0..80).map(height).collect::<Vec<_>>()])
        };
        for value in [-9999.0, 9999.0, -32768.0, -3.4028234663852886e38] {
            assert_eq!(no_data(&heights(value, 8), &[]), Some((value, 10)));
        }
        // Other values, one that is there once, and one in the range of the others.
        assert_eq!(no_data(&heights(-1234.0, 8), &[]), None);
        assert_eq!(no_data(&heights(-9999.0, 100), &[]), None);
        let range = Points::from_lanes([(0..4000).map(|i| f64::from(i - 999)).collect::<Vec<_>>()]);
        assert_eq!(no_data(&range, &[]), None);
        let all: Vec<usize> = (0..80).step_by(8).collect();
        assert_eq!(no_data(&heights(-9999.0, 8), &all), None);
        assert_eq!(no_data(&Points::zeros(1, 9), &[]), None);
    }
}
