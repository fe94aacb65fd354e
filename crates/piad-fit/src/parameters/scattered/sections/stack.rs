//! Closed curves that lie one behind the other, as sections of a tube do.

use super::polyline::Polyline;
use crate::data::points::Points;
use crate::data::vectors::{cross, dot, in_space, length, minus, unit};

/// The least step from one section to the next across their plane, as a part of the length around them.
const STEP: f64 = 1e-3;

/// The most that the next section may be beside the one before, as a part of the length around that: half of it is more
/// than the radius of a circle.
const BESIDE: f64 = 0.5;

/// The least cosine of the angle between the planes of a section and the next one.
const COSINE: f64 = 0.5;

/// Returns true if these are two closed curves or more, each of which lies behind the one before it, on one side of them.
pub fn is_stack(curves: &[&Points]) -> bool {
    let rings: Option<Vec<Ring>> = curves.iter().map(|curve| Ring::of(curve)).collect();
    rings.is_some_and(|rings| rings.len() > 1 && follow_each_other(&rings))
}

/// Returns true if each is behind the one before, all on the same side: normals that go around the other way are turned.
fn follow_each_other(rings: &[Ring]) -> bool {
    let mut sense = 1.0;
    let mut pairs = rings.windows(2).map(|pair| {
        let step = pair[0].step(&pair[1]).map(|step| step * sense);
        sense *= dot(pair[0].normal, pair[1].normal).signum();
        step
    });
    let Some(Some(first)) = pairs.next() else {
        return false;
    };
    pairs.all(|step| step.is_some_and(|step| step.signum() == first.signum()))
}

/// A closed curve.
struct Ring {
    center: [f64; 3],
    normal: [f64; 3],
    length: f64,
}

impl Ring {
    fn of(points: &Points) -> Option<Self> {
        let places = (0..points.len()).map(|index| in_space(points.point(index)));
        let places: Vec<[f64; 3]> = places.collect();
        let sum = places
            .iter()
            .fold([0.0; 3], |sum, place| [0, 1, 2].map(|k| sum[k] + place[k]));
        let center = sum.map(|x| x / places.len() as f64);
        let next = places.iter().cycle().skip(1);
        let areas = places
            .iter()
            .zip(next)
            .map(|(a, b)| cross(minus(*a, center), minus(*b, center)));
        let area = areas.fold([0.0; 3], |sum, it| [0, 1, 2].map(|k| sum[k] + it[k]));
        let polyline = Polyline::new(places, false)
            .filter(Polyline::comes_back)?
            .closed();
        Some(Self {
            center,
            normal: unit(area)?,
            length: polyline.length(),
        })
    }

    /// How far another one is behind this one, along its normal; `None` if it is beside it, or turned too far.
    fn step(&self, next: &Self) -> Option<f64> {
        let between = minus(next.center, self.center);
        let along = dot(between, self.normal);
        let beside = minus(between, self.normal.map(|x| x * along));
        let is_behind = along.abs() >= STEP * self.length
            && length(beside) <= BESIDE * self.length
            && dot(self.normal, next.normal).abs() >= COSINE;
        is_behind.then_some(along)
    }
}
