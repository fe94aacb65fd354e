//! Distances of a curve from the segments between its data.

use super::line::Place;
use crate::data::points::{Points, normalizing_scale};
use crate::geometry::freedom::{is_surely_shorter, length_of};

/// A gap, and what all places in it have in common.
struct Segment<'a> {
    points: &'a Points,
    gap: usize,
    ends: [usize; 2],
    /// Squares of lengths of any unit stay within the range of numbers.
    unit: f64,
}

/// Raises the distances of gaps to those of the points of `fit` at places in them: from the nearest points of their
/// segments, but for values of functions, which are compared at the same parameters.
pub(super) fn measure(
    points: &Points,
    ends: &[[usize; 2]],
    places: &[Place],
    fit: &Points,
    distances: &mut [f64],
) {
    let mut last: Option<Segment<'_>> = None;
    for (index, place) in places.iter().enumerate() {
        let segment = match last.take() {
            Some(segment) if segment.gap == place.gap => segment,
            _ => Segment::new(points, place.gap, ends[place.gap]),
        };
        let most = &mut distances[place.gap];
        *most = segment.farther(place.part, fit, index, *most);
        last = Some(segment);
    }
}

impl<'a> Segment<'a> {
    fn new(points: &'a Points, gap: usize, ends: [usize; 2]) -> Self {
        let [from, to] = ends;
        let slopes = points.lanes().iter().map(|lane| lane[to] - lane[from]);
        let longest = slopes.fold(0.0, |most: f64, slope| most.max(slope.abs()));
        Self {
            points,
            gap,
            ends,
            unit: normalizing_scale(longest),
        }
    }

    /// The larger one of a distance and that of point `index` of a fit, which is at some part of the gap.
    fn farther(&self, part: f64, fit: &Points, index: usize, most: f64) -> f64 {
        let part = match fit.dimension() {
            1 => part,
            _ => self.nearest(part, fit, index),
        };
        let differences = || {
            let lanes = fit.lanes().iter().zip(self.points.lanes());
            lanes.map(|(fit, data)| fit[index] - self.at(part, data))
        };
        match is_surely_shorter(differences(), most) {
            true => most,
            false => most.max(length_of(differences())),
        }
    }

    fn at(&self, part: f64, data: &[f64]) -> f64 {
        let [from, to] = self.ends;
        (1.0 - part) * data[from] + part * data[to]
    }

    /// The part of the segment that is before its point nearest to that of the fit.
    fn nearest(&self, part: f64, fit: &Points, index: usize) -> f64 {
        let [from, to] = self.ends;
        let (mut square, mut moment) = (0.0, 0.0);
        for (fit, data) in fit.lanes().iter().zip(self.points.lanes()) {
            let difference = (fit[index] - self.at(part, data)) * self.unit;
            let slope = (data[to] - data[from]) * self.unit;
            moment += slope * difference;
            square += slope * slope;
        }
        let step = if square > 0.0 { moment / square } else { 0.0 };
        (part + step).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without shortcuts the same bits: lengths of all units, equal points and functions.
    #[test]
    fn no_distance_is_left_out() {
        let wave = |seed: usize, scale: f64| {
            let value = move |i: usize| scale * ((i * i * 37 + seed) as f64).sin();
            (0..40).map(value).collect::<Vec<f64>>()
        };
        let ends: Vec<[usize; 2]> = (0..39).map(|i| [i, i + 1]).collect();
        let gaps = (0..39).flat_map(|gap| [(gap, 0.25), (gap, 0.5), (gap, 0.75)]);
        let places = gaps.map(|(gap, part)| Place {
            parameter: 0.0,
            gap,
            part,
        });
        let places: Vec<Place> = places.collect();
        for (dimension, scale) in [(1, 1.0), (2, 1.0), (3, 1e-170), (2, 1e-310), (3, 1e170)] {
            let mut lanes: Vec<Vec<f64>> = (0..dimension).map(|c| wave(c, scale)).collect();
            lanes.iter_mut().for_each(|lane| lane[7] = lane[6]);
            let points = Points::from_lanes(lanes);
            let value = |c: usize| move |k: usize| 1.5 * scale * ((k * 11 + c) as f64).cos();
            let lanes = (0..dimension).map(|c| (0..places.len()).map(value(c)).collect::<Vec<_>>());
            let fit = Points::from_lanes(lanes);
            let mut found = vec![0.0; ends.len()];
            measure(&points, &ends, &places, &fit, &mut found);
            let mut expected = vec![0.0_f64; ends.len()];
            for (index, place) in places.iter().enumerate() {
                let segment = Segment::new(&points, place.gap, ends[place.gap]);
                let part = match dimension {
                    1 => place.part,
                    _ => segment.nearest(place.part, &fit, index),
                };
                let lanes = fit.lanes().iter().zip(points.lanes());
                let differences = lanes.map(|(fit, data)| fit[index] - segment.at(part, data));
                let distance = differences.fold(0.0, f64::hypot);
                expected[place.gap] = expected[place.gap].max(distance);
            }
            assert_eq!(found, expected, "{dimension} coordinates of size {scale}");
        }
    }
}
