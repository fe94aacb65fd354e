//! Parts of a mesh that have the same parameters, although no triangle is turned over: a spiral around a cylinder.

use nalgebra::Vector3;

use super::super::pairs::{Domain, Pairs};
use super::super::unfolding::unrolled;

/// The triangles that are examined.
const SAMPLES: usize = 64;

/// True if the middle of some triangle lies in another one by its parameters.
pub(super) fn overlaps(triangles: &[[u32; 3]], pairs: &Pairs) -> bool {
    let step = triangles.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<usize> = (0..triangles.len()).step_by(step).collect();
    let is_ball = matches!(pairs.domains, [Domain::Closed(_), Domain::Between { .. }]);
    let corners = |t: usize| match is_ball {
        true => triangles[t].map(|vertex| Vector3::from(unrolled(pairs, vertex as usize))),
        false => flat(pairs, triangles[t]),
    };
    let middles: Vec<Vector3<f64>> = samples
        .iter()
        .map(|&t| corners(t).iter().sum::<Vector3<f64>>() / 3.0)
        .collect();
    let period = pairs.domains[0].period().filter(|_| !is_ball);
    (0..triangles.len()).any(|t| {
        let corners = corners(t);
        samples.iter().zip(&middles).any(|(&sample, middle)| {
            sample != t
                && match is_ball {
                    true => is_towards(&corners, middle),
                    false => contains(&corners, middle, period),
                }
        })
    })
}

/// The corners of a triangle in the plane of parameters, beside each other also where it goes over the end of a period.
fn flat(pairs: &Pairs, triangle: [u32; 3]) -> [Vector3<f64>; 3] {
    let [us, vs] = [0, 1].map(|axis| pairs.values.lane(axis));
    let first = us[triangle[0] as usize];
    triangle.map(|vertex| {
        let along = us[vertex as usize] - first;
        let along = match pairs.domains[0].period() {
            Some(period) => along - period * (along / period).round(),
            None => along,
        };
        Vector3::new(first + along, vs[vertex as usize], 0.0)
    })
}

fn contains(corners: &[Vector3<f64>; 3], place: &Vector3<f64>, period: Option<f64>) -> bool {
    let mut from = corners.map(|corner| corner - place);
    if let Some(period) = period {
        let turns = (from[0].x / period).round();
        from.iter_mut().for_each(|it| it.x -= period * turns);
    }
    let [a, b, c] = from;
    let sides = [a.cross(&b).z, b.cross(&c).z, c.cross(&a).z];
    sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
}

/// True if the direction of a place goes through a triangle.
fn is_towards([a, b, c]: &[Vector3<f64>; 3], place: &Vector3<f64>) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| place.dot(&a.cross(b)));
    let is_in = sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0);
    is_in && place.dot(&(a + b + c)) > 0.0
}
