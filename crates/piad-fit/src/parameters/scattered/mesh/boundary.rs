//! A loop of the boundary as a closed line in space, with the normals of the mesh beside it.

use nalgebra::Vector3;

use super::sheet::Sheet;

/// The part of a loop over which it and its normals are averaged, on both sides.
const SMOOTH: f64 = 0.04;

/// The most chords with which the length of a side is compared, and the least number of edges of each.
const CHORDS: usize = 32;
const SHORTEST_CHORD: usize = 4;

/// A loop that is longer than its chords by this part moves to and fro.
const RAGGED: f64 = 0.03;

/// A ring around a ragged loop is this part of its length farther out than its farthest vertex.
const MARGIN: f64 = 0.02;

/// The vertices of a loop, with the mesh on the left.
pub(super) struct Boundary {
    pub places: Vec<Vector3<f64>>,
    /// Unit vectors, averaged along the loop.
    pub normals: Vec<Vector3<f64>>,
    /// The length of the loop up to each vertex, and the whole length at the end.
    pub lengths: Vec<f64>,
}

impl Boundary {
    /// That of the vertices of a sheet.
    pub(super) fn new(sheet: &Sheet, line: &[u32]) -> Self {
        let mut normals = vec![Vector3::zeros(); sheet.places.len()];
        for triangle in &sheet.triangles {
            let [a, b, c] = triangle.map(|vertex| sheet.places[vertex as usize]);
            let normal = (b - a).cross(&(c - a));
            for &vertex in triangle {
                normals[vertex as usize] += normal;
            }
        }
        let of_line = |all: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
            line.iter().map(|&vertex| all[vertex as usize]).collect()
        };
        let unit = |normal: Vector3<f64>| normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let normals = averaged(&of_line(&normals)).into_iter().map(unit);
        let places = of_line(&sheet.places);
        let mut sum = 0.0;
        let mut lengths = vec![0.0];
        for (k, place) in places.iter().enumerate() {
            sum += (places[(k + 1) % places.len()] - place).norm();
            lengths.push(sum);
        }
        Self {
            normals: normals.collect(),
            places,
            lengths,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// The length of all of it.
    pub(super) fn whole(&self) -> f64 {
        self.lengths[self.len()]
    }

    /// The length up to a vertex, on from the first one again after the last one.
    pub(super) fn length(&self, k: usize) -> f64 {
        match k.checked_sub(self.len()) {
            Some(k) => self.whole() + self.lengths[k],
            None => self.lengths[k],
        }
    }

    /// The place at a length.
    pub(super) fn at(&self, length: f64) -> Vector3<f64> {
        let count = self.len();
        let wanted = length.rem_euclid(self.whole());
        let after = self.lengths.partition_point(|it| *it <= wanted);
        let after = after.clamp(1, count);
        let (low, high) = (self.lengths[after - 1], self.lengths[after]);
        let part = if high > low {
            (wanted - low) / (high - low)
        } else {
            0.0
        };
        self.places[after - 1].lerp(&self.places[after % count], part)
    }

    /// The shorter length between two vertices.
    pub(super) fn apart(&self, a: usize, b: usize) -> f64 {
        let along = (self.lengths[a] - self.lengths[b]).abs();
        along.min(self.whole() - along)
    }

    /// True if the loop goes to and fro between corners, so that no smooth line is near it: it is longer than its chords by
    /// more than what comes of their number, which is four times as much for chords that are twice as long.
    pub(super) fn is_ragged(&self, corners: &[usize]) -> bool {
        let [short, long] = [1, 2].map(|factor| self.whole() - self.chords(corners, factor));
        (4.0 * short - long) / 3.0 > RAGGED * self.whole()
    }

    /// The length of chords over some vertices each, a factor more than usual.
    fn chords(&self, corners: &[usize], factor: usize) -> f64 {
        let count = self.len();
        let mut sum = 0.0;
        for (k, &start) in corners.iter().enumerate() {
            let end = corners.get(k + 1).map_or(corners[0] + count, |end| *end);
            let step = factor * ((end - start) / CHORDS).max(SHORTEST_CHORD);
            let mut at = start;
            while at < end {
                let next = (at + step).min(end);
                sum += (self.places[next % count] - self.places[at % count]).norm();
                at = next;
            }
        }
        sum
    }

    /// The places of a smooth ring around it, one for each vertex.
    pub(super) fn ring(&self) -> Vec<Vector3<f64>> {
        let count = self.len();
        let smooth = averaged(&self.places);
        let outward = |k: usize| {
            let along = smooth[(k + 1) % count] - smooth[(k + count - 1) % count];
            along
                .cross(&self.normals[k])
                .try_normalize(0.0)
                .unwrap_or_default()
        };
        let outward: Vec<Vector3<f64>> = (0..count).map(outward).collect();
        let away = (0..count).map(|k| (self.places[k] - smooth[k]).dot(&outward[k]));
        let away = away.fold(0.0, f64::max) + MARGIN * self.whole();
        (0..count).map(|k| smooth[k] + outward[k] * away).collect()
    }
}

/// The mean of each vector and those beside it on a loop.
fn averaged(values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let count = values.len();
    let window = ((SMOOTH * count as f64).ceil() as usize).min((count - 1) / 2);
    let width = (2 * window + 1) as f64;
    let mut sum: Vector3<f64> = (0..=2 * window)
        .map(|k| values[(k + count - window) % count])
        .sum();
    let mut means = Vec::with_capacity(count);
    for k in 0..count {
        means.push(sum / width);
        sum += values[(k + window + 1) % count] - values[(k + count - window) % count];
    }
    means
}
