//! A section as the edges between its points.

use crate::data::vectors::{length, minus};

/// The last point of a curve that comes back is this near to its first one, as a multiple of the largest distance between
/// neighbours and as a part of its length.
const NEIGHBOURS: f64 = 1.5;
const LENGTHS: f64 = 0.2;

/// The edges between points in their order.
#[derive(Clone, Debug)]
pub(super) struct Polyline {
    /// The points; of a closed one the first is there once more.
    places: Vec<[f64; 3]>,
    /// The length up to each of them.
    lengths: Vec<f64>,
    pub(super) is_closed: bool,
}

impl Polyline {
    /// Points in their order; `None` if there are too few or they are all in one place. The last point of a closed one may
    /// be the first again.
    pub(super) fn new(mut places: Vec<[f64; 3]>, is_closed: bool) -> Option<Self> {
        let fewest = if is_closed { 3 } else { 2 };
        if places.len() < fewest {
            return None;
        }
        if is_closed {
            places.push(places[0]);
        }
        let mut lengths = vec![0.0];
        let edges = places
            .windows(2)
            .map(|edge| length(minus(edge[1], edge[0])));
        lengths.extend(edges.scan(0.0, |sum, edge| {
            *sum += edge;
            Some(*sum)
        }));
        let polyline = Self {
            places,
            lengths,
            is_closed,
        };
        (polyline.length() > 0.0).then_some(polyline)
    }

    /// An open one with the edge that closes it.
    pub(super) fn closed(self) -> Self {
        let (first, edge) = (self.places[0], self.gap());
        let length = self.length() + edge;
        let (mut places, mut lengths) = (self.places, self.lengths);
        places.push(first);
        lengths.push(length);
        Self {
            places,
            lengths,
            is_closed: true,
        }
    }

    /// The number of edges.
    pub(super) fn edges(&self) -> usize {
        self.lengths.len() - 1
    }

    pub(super) fn length(&self) -> f64 {
        self.lengths[self.edges()]
    }

    /// The distance of the last point from the first one.
    fn gap(&self) -> f64 {
        length(minus(self.places[self.edges()], self.places[0]))
    }

    /// Returns true if the last point of an open one is near its first one.
    pub(super) fn comes_back(&self) -> bool {
        let gap = self.gap();
        gap <= NEIGHBOURS * self.longest_edge() && gap <= LENGTHS * self.length()
    }

    fn longest_edge(&self) -> f64 {
        let edges = self.lengths.windows(2).map(|ends| ends[1] - ends[0]);
        edges.fold(0.0, f64::max)
    }

    /// The length up to each point that was given, as a part of the whole.
    pub(super) fn parts(&self) -> impl Iterator<Item = f64> {
        let count = self.places.len() - usize::from(self.is_closed);
        let whole = self.length();
        self.lengths[..count].iter().map(move |it| it / whole)
    }

    /// The places after these parts of the length, which increase from 0 to 1.
    pub(super) fn at(&self, parts: impl Iterator<Item = f64>) -> Vec<[f64; 3]> {
        let mut edge = 0;
        let place = |part: f64| {
            let wanted = part * self.length();
            while edge + 2 < self.lengths.len() && self.lengths[edge + 1] < wanted {
                edge += 1;
            }
            let (start, end) = (self.lengths[edge], self.lengths[edge + 1]);
            let t = match end > start {
                true => ((wanted - start) / (end - start)).clamp(0.0, 1.0),
                false => 0.0,
            };
            let (from, to) = (self.places[edge], self.places[edge + 1]);
            [0, 1, 2].map(|axis| from[axis] + t * (to[axis] - from[axis]))
        };
        parts.map(place).collect()
    }
}
