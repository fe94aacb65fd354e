//! Points of a curve or surface at equal steps of its parameters, evaluated on demand.
//!
//! Clients ask for a polyline or a mesh of every level. Samples are evaluated when they are
//! written, a few hundred at a time, and none is kept: their number is limited by what the client
//! wants to read, not by memory.

use std::sync::Arc;

use super::evaluation::Geometry;
use crate::basis::Basis;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::setup::Setup;

/// The number of samples evaluated at a time: the values of all basis functions at their parameters, of which there can
/// be thousands each, are held for that long.
const AT_ONCE: usize = 256;

/// Parameters at equal distances over the domain of a direction, both ends included.
#[derive(Clone, Copy, Debug)]
pub struct Uniform {
    domain: (f64, f64),
    count: usize,
}

impl Uniform {
    /// `count` parameters over the domain of a basis.
    pub fn new(basis: &Basis, count: usize) -> Self {
        Self {
            domain: basis.domain(),
            count,
        }
    }

    /// Their number.
    pub fn count(self) -> usize {
        self.count
    }

    /// Parameter `i`.
    pub fn at(self, i: usize) -> f64 {
        let (low, high) = self.domain;
        let s = i as f64 / self.count.saturating_sub(1).max(1) as f64;
        (1.0 - s) * low + s * high
    }
}

/// A grid of samples of one level, which are evaluated on demand and not kept.
#[derive(Clone, Debug)]
pub struct Samples {
    setup: Arc<Setup>,
    control_points: Arc<Points>,
    /// The parameters of a curve, or in the u direction.
    pub u: Uniform,
    /// Those in the v direction of a surface.
    pub v: Option<Uniform>,
}

/// The approximate number of multiplications that it takes to evaluate a grid of samples.
pub fn multiplications(setup: &Setup, grid: Grid) -> usize {
    let Grid { rows, columns } = grid;
    let (count, u) = (grid.count(), &setup.u().basis);
    let along = rows.saturating_mul(u.multiplications());
    let (lines, across) = match setup.v() {
        None => (count * u.support_width(), 0),
        Some(v) => {
            let v = &v.basis;
            let blocks = count.div_ceil(AT_ONCE) * columns.min(AT_ONCE);
            // The order of summation with the fewest multiplications, as [`Geometry::evaluate`] chooses it.
            let at_once = count.saturating_mul(u.support_width() * v.support_width());
            let by_rows = rows * u.support_width() * v.functions() + count * v.support_width();
            (
                at_once.min(by_rows),
                blocks.saturating_mul(v.multiplications()),
            )
        }
    };
    along + across + lines.saturating_mul(setup.dimension())
}

impl Samples {
    /// Samples of a level of `setup`, on a grid of rows × columns parameters. A curve has `rows` samples in one column.
    pub fn new(setup: Arc<Setup>, control_points: Arc<Points>, grid: Grid) -> Self {
        let v = setup.v();
        Self {
            u: Uniform::new(&setup.u().basis, grid.rows),
            v: v.map(|v| Uniform::new(&v.basis, grid.columns)),
            setup,
            control_points,
        }
    }

    /// Their number in a row.
    pub fn columns(&self) -> usize {
        self.v.map_or(1, Uniform::count)
    }

    /// Their number.
    pub fn count(&self) -> usize {
        self.u.count() * self.columns()
    }

    /// The approximate number of multiplications that it takes to evaluate all of them.
    pub fn multiplications(&self) -> usize {
        let (rows, columns) = (self.u.count(), self.columns());
        multiplications(&self.setup, Grid { rows, columns })
    }

    /// The number of coordinates of each.
    pub fn dimension(&self) -> usize {
        self.setup.dimension()
    }

    /// The curve or surface itself.
    pub fn geometry(&self) -> Geometry<'_> {
        Geometry::new(&self.setup, &self.control_points)
    }

    /// Writes the coordinates of the samples from number `start` on, row by row and point by point, until `coordinates`
    /// is full.
    pub fn fill(&self, start: usize, coordinates: &mut [f64]) {
        let columns = self.columns();
        let dimension = self.dimension();
        let end = start + coordinates.len() / dimension;
        let mut at = start;
        let mut rest = coordinates;
        while at < end {
            // A part of a row, or as many whole rows as are evaluated at a time.
            let (row, column) = (at / columns, at % columns);
            let left = (end - at).min(AT_ONCE);
            let (rows, width) = match column {
                0 if left >= columns => (left / columns, columns),
                _ => (1, left.min(columns - column)),
            };
            let u: Vec<f64> = (row..row + rows).map(|i| self.u.at(i)).collect();
            let v = self
                .v
                .map(|v| (column..column + width).map(move |j| v.at(j)));
            let v: Vec<f64> = v.into_iter().flatten().collect();
            let points = self.geometry().evaluate(&u, &v);
            let part;
            (part, rest) = rest.split_at_mut(rows * width * dimension);
            for (k, place) in part.chunks_exact_mut(dimension).enumerate() {
                place
                    .iter_mut()
                    .zip(points.point(k))
                    .for_each(|(to, x)| *to = x);
            }
            at += rows * width;
        }
    }
}
