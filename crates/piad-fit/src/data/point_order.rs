//! Detects whether points have an order along a curve.
//!
//! Along a curve that is sampled well enough to be fitted, the neighbours of a point in the list are among
//! the points nearest to it. In points without an order hardly any are.

use super::points::Points;

/// The most points that are examined, at equal distances in the list.
const MOST_SAMPLES: usize = 96;

/// In long lists fewer points are examined, for about this many distances in all, but at least [`LEAST_SAMPLES`].
const MOST_DISTANCES: usize = 1 << 22;
const LEAST_SAMPLES: usize = 12;

/// The number of nearest points that count.
const NEAREST: usize = 3;

/// Points have an order if one in this many has a neighbour of the list among its nearest points.
const ONE_IN: usize = 3;

/// Returns true if fewer than a third of the points have one of their two neighbours in the list among their three
/// nearest points. Points of the plane whose x or y increases or decreases throughout are the graph of a function,
/// however noisy, and plain values have no distances.
pub fn is_unordered(points: &Points) -> bool {
    let count = points.len();
    let is_graph = points.dimension() == 2 && points.lanes().iter().any(|lane| is_monotone(lane));
    if points.dimension() < 2 || is_graph {
        return false;
    }
    let affordable = MOST_DISTANCES / count.max(1);
    let samples = count.min(affordable.clamp(LEAST_SAMPLES, MOST_SAMPLES));
    let needed = samples.div_ceil(ONE_IN);
    let mut ordered = 0;
    for k in 0..samples {
        ordered += usize::from(has_neighbour_near(points, k * count / samples));
        if ordered == needed {
            return false;
        }
        // Not even if all others had one.
        if ordered + samples - (k + 1) < needed {
            return true;
        }
    }
    samples > 0
}

/// Returns true if a neighbour of a point in the list is among its nearest points.
fn has_neighbour_near(points: &Points, index: usize) -> bool {
    let square = |j: usize| -> f64 {
        let lanes = points.lanes().iter();
        lanes.map(|lane| (lane[j] - lane[index]).powi(2)).sum()
    };
    let before = index.checked_sub(1).map(square);
    let after = (index + 1 < points.len()).then(|| square(index + 1));
    let near = before
        .into_iter()
        .chain(after)
        .fold(f64::INFINITY, f64::min);
    let nearer = (0..points.len()).filter(|j| *j != index && square(*j) < near);
    nearer.take(NEAREST).count() < NEAREST
}

fn is_monotone(values: &[f64]) -> bool {
    let pairs = || values.windows(2);
    pairs().all(|pair| pair[0] < pair[1]) || pairs().all(|pair| pair[0] > pair[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a spiral in an order that is mixed by steps of `step`.
    fn spiral(count: usize, step: usize) -> Points {
        let mut points = Points::new(2);
        for i in 0..count {
            let t = 1.0 + (i * step % count) as f64 / count as f64 * 5.0;
            points.push(&[t * t.cos(), t * t.sin()]);
        }
        points
    }

    #[test]
    fn mixed_points_have_no_order() {
        for count in [50, 200, 3001, 300_007] {
            assert!(!is_unordered(&spiral(count, 1)), "{count}");
            assert!(is_unordered(&spiral(count, 7 * count / 20 + 1)), "{count}");
        }
    }

    #[test]
    fn graphs_and_few_points_have_one() {
        let noise = |i: usize| ((i * 7919) % 101) as f64;
        let graph = Points::from_lanes([
            (0..500).map(|i| i as f64 * 1e-3).collect::<Vec<_>>(),
            (0..500).map(noise).collect(),
        ]);
        assert!(!is_unordered(&graph));
        let values = Points::from_lanes([(0..500).map(noise).collect::<Vec<_>>()]);
        assert!(!is_unordered(&values));
        for count in 0..5 {
            assert!(!is_unordered(&spiral(count, 3)), "{count}");
        }
        // Distances whose squares are beyond the range of numbers are ignored.
        let mut far = Points::new(3);
        (0..50).for_each(|i| far.push(&[1e300 * noise(i), -1e300 * noise(2 * i), 0.0]));
        assert!(!is_unordered(&far));
    }
}
