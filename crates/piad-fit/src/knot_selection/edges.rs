//! Points along the edges of a polyline, to which the fit must be near.

use std::sync::Arc;

use super::levels::Level;
use crate::data::points::Points;

/// The fewest parts of an edge.
const PARTS: usize = 8;

/// The approximate number of further parts in all, longer edges having more of them.
const SHARED: usize = 2000;

/// The most points of each edge, if there are few edges.
const SHARED_BY_EDGE: usize = 200;

/// The points along the edges of a polyline.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    /// The vertices and the points between them, in order.
    pub(crate) points: Arc<Points>,
    /// Their parameters.
    pub(crate) parameters: Arc<Vec<f64>>,
    /// The vertices among the points.
    vertices: Vec<usize>,
    /// The parameters of the vertices.
    of_vertices: Arc<Vec<f64>>,
}

impl Edges {
    /// The largest number of points along the edges of a polyline with this number of vertices.
    pub(crate) fn most(vertices: usize) -> usize {
        vertices.saturating_mul(PARTS + 1).saturating_add(SHARED) + 1
    }

    /// Along the edges between vertices at increasing parameters, of a closed polyline also from the last to the first.
    pub(crate) fn new(polyline: &Points, parameters: &Arc<Vec<f64>>, period: Option<f64>) -> Self {
        let count = polyline.len();
        let edges = count - usize::from(period.is_none());
        let end = |i: usize| (i + 1) % count;
        let lengths: Vec<f64> = (0..edges).map(|i| polyline.distance(i, end(i))).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        // Lengths in any unit have a sum.
        let total: f64 = lengths.iter().map(|length| length / longest).sum();
        let shared = SHARED.min(SHARED_BY_EDGE * edges) as f64;
        let mut points = Points::new(polyline.dimension());
        let (mut t, mut vertices) = (Vec::new(), Vec::with_capacity(count));
        for (i, length) in lengths.iter().enumerate() {
            let parts = PARTS + (shared * (length / longest) / total) as usize;
            vertices.push(points.len());
            let next = match i + 1 == count {
                true => parameters[0] + period.unwrap_or(0.0),
                false => parameters[i + 1],
            };
            for k in 0..parts {
                let part = k as f64 / parts as f64;
                let between = |from: f64, to: f64| (1.0 - part) * from + part * to;
                let pairs = polyline.point(i).zip(polyline.point(end(i)));
                points.push(&pairs.map(|(a, b)| between(a, b)).collect::<Vec<_>>());
                t.push(between(parameters[i], next));
            }
        }
        if period.is_none() {
            vertices.push(points.len());
            points.push(&polyline.point(count - 1).collect::<Vec<_>>());
            t.push(parameters[count - 1]);
        }
        Self {
            points: Arc::new(points),
            parameters: Arc::new(t),
            vertices,
            of_vertices: Arc::clone(parameters),
        }
    }

    /// A level with the parameters of the vertices, and the distances of all points, of which the largest is at the vertex
    /// before it.
    pub(crate) fn of_vertices(&self, level: &Level<1>) -> Level<1> {
        let mut level = level.clone();
        level.parameters = [Arc::clone(&self.of_vertices)];
        let after = self
            .vertices
            .partition_point(|&it| it <= level.distances.at);
        level.distances.at = after.saturating_sub(1);
        level
    }
}
