//! The least rectangle around points of a plane.
//!
//! One of its sides lies along an edge of their convex hull (Freeman, Shapira 1975).

/// Edges of a hull that are examined.
const EDGES: usize = 1024;

/// A rectangle along a preferred direction may be larger than the least one by this part of it.
const PREFERRED: f64 = 0.1;

/// The direction of the longer side of the rectangle with the least area around points; `None` of points on a line. Areas
/// that are equal to rounding are one, and then it is the direction nearest to the first axis. Rectangles along preferred
/// directions are taken if they are hardly larger.
pub(super) fn longer_side(points: &[[f64; 2]], preferred: &[[f64; 2]]) -> Option<[f64; 2]> {
    let hull = hull(points);
    let step = hull.len().div_ceil(EDGES).max(1);
    let edges = (0..hull.len()).step_by(step).map(|k| {
        let [from, to] = [hull[k], hull[(k + 1) % hull.len()]];
        [to[0] - from[0], to[1] - from[1]]
    });
    let smallest = least(&hull, edges)?;
    let along = least(&hull, preferred.iter().copied());
    let along = along.filter(|along| along.area <= (1.0 + PREFERRED) * smallest.area);
    Some(along.unwrap_or(smallest).side)
}

/// A rectangle around points.
struct Rectangle {
    area: f64,
    /// The direction of its longer side.
    side: [f64; 2],
}

/// The least rectangle around a hull with a side along one of some vectors.
fn least(hull: &[[f64; 2]], vectors: impl Iterator<Item = [f64; 2]>) -> Option<Rectangle> {
    let mut best: Option<Rectangle> = None;
    for [x, y] in vectors {
        let length = x.hypot(y);
        if length <= 0.0 || !length.is_finite() {
            continue;
        }
        let along = [x / length, y / length];
        let across = [-along[1], along[0]];
        let [width, height] = [along, across].map(|axis| extent(hull, axis));
        let side = if width >= height { along } else { across };
        let side = if side[0] < 0.0 {
            side.map(|x| -x)
        } else {
            side
        };
        let area = width * height;
        let is_better = best.as_ref().is_none_or(|best| {
            area < (1.0 - EQUAL) * best.area
                || area <= (1.0 + EQUAL) * best.area && side[0] > best.side[0]
        });
        if is_better && area > 0.0 {
            best = Some(Rectangle { area, side });
        }
    }
    best
}

/// Areas that differ by this part of them are one.
const EQUAL: f64 = 1e-9;

fn extent(points: &[[f64; 2]], axis: [f64; 2]) -> f64 {
    let along = points.iter().map(|p| p[0] * axis[0] + p[1] * axis[1]);
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    high - low
}

/// The corners of the convex hull, around it (Andrew 1979).
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let turns_left = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut half: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = half[..] {
                if turns_left(a, b, point) {
                    break;
                }
                half.pop();
            }
            half.push(point);
        }
        half.pop();
        half
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turned rectangle full of points has its own sides.
    #[test]
    fn sides_are_those_of_a_turned_rectangle() {
        let (cos, sin) = (0.8, 0.6);
        let points: Vec<[f64; 2]> = (0..400)
            .map(|k| [f64::from(k % 20), 0.7 * f64::from(k / 20)])
            .map(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
            .collect();
        let side = longer_side(&points, &[[1.0, 0.0]]).unwrap();
        assert!((side[0] - cos).abs() < 1e-12 && (side[1] - sin).abs() < 1e-12);
        let line: Vec<[f64; 2]> = (0..5).map(|k| [f64::from(k), f64::from(k)]).collect();
        assert_eq!(longer_side(&line, &[]), None);
    }

    /// All rectangles around a disc are hardly larger than others, and the least one lies anywhere.
    #[test]
    fn discs_have_preferred_sides() {
        let points: Vec<[f64; 2]> = (0..7)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 7.0)
            .map(|angle| [angle.cos(), angle.sin()])
            .collect();
        let preferred = [0.8, 0.6];
        assert_eq!(longer_side(&points, &[preferred]), Some(preferred));
        assert_ne!(longer_side(&points, &[]), Some(preferred));
    }
}
