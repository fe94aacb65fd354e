//! Samples of curves and surfaces without a fit, in any number of coordinates.

use std::ops::Range;

use crate::export::error::{ExportError, NetIndex};
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::options::Options;
use crate::export::sampling::by_length;
use piad_fit::data::Grid;
use piad_fit::engine::nurbs::{SpanParameter, steps_between};

/// The number of samples of a curve, and of each direction of a surface, by default.
const CURVE: usize = 200;
const SURFACE: usize = 40;

/// The coordinates that are evaluated at a time.
const TOGETHER: usize = 3;

/// Samples with their parameters.
#[derive(Debug)]
pub(super) struct Listed {
    u: Vec<f64>,
    /// Empty for curves.
    v: Vec<f64>,
    dimension: usize,
    /// The samples, row by row, point by point.
    coordinates: Vec<f64>,
}

impl Listed {
    /// Samples at equal steps of the parameters, or of the length.
    pub(super) fn new(nurbs: &Nurbs, options: &Options) -> Result<Self, ExportError> {
        let (u, v) = sites(nurbs, options)?;
        Self::at(nurbs, &u, &v)
    }

    /// Samples at these sites.
    fn at(nurbs: &Nurbs, u: &[SpanParameter], v: &[SpanParameter]) -> Result<Self, ExportError> {
        let dimension = nurbs.points.dimension();
        let count = u.len() * v.len().max(1);
        let mut coordinates = vec![0.0; count * dimension];
        for first in (0..dimension).step_by(TOGETHER) {
            let jets = nurbs.evaluate_from(first, u, v);
            for (point, jet) in coordinates.chunks_exact_mut(dimension).zip(&jets) {
                let some = point.iter_mut().skip(first).zip(jet.point);
                some.for_each(|(to, x)| *to = x);
            }
        }
        let parameters = |sites: &[SpanParameter]| sites.iter().map(|site| site.t).collect();
        let listed = Self {
            u: parameters(u),
            v: parameters(v),
            dimension,
            coordinates,
        };
        listed.check()?;
        Ok(listed)
    }

    /// Refuses samples that are not finite.
    fn check(&self) -> Result<(), ExportError> {
        let found = self.coordinates.iter().position(|x| !x.is_finite());
        let columns = self.is_surface().then_some(self.v.len());
        match found {
            None => Ok(()),
            Some(index) => Err(ExportError::NotFinite {
                what: "sample",
                place: NetIndex::new(index / self.dimension, columns),
                coordinate: index % self.dimension,
                value: self.coordinates[index],
            }),
        }
    }

    pub(super) fn is_surface(&self) -> bool {
        !self.v.is_empty()
    }

    pub(super) fn dimension(&self) -> usize {
        self.dimension
    }

    pub(super) fn count(&self) -> usize {
        self.u.len() * self.v.len().max(1)
    }

    /// Visits samples with their parameters.
    pub(super) fn each(
        &self,
        range: Range<usize>,
        mut visit: impl FnMut(f64, Option<f64>, &[f64]),
    ) {
        let columns = self.v.len().max(1);
        for index in range {
            let point = &self.coordinates[index * self.dimension..][..self.dimension];
            let v = self.v.get(index % columns).copied();
            visit(self.u[index / columns], v, point);
        }
    }
}

/// The parameters of samples in both directions, of a curve in one: at equal steps of the parameters, or of the length.
pub(in crate::export) fn sites(
    nurbs: &Nurbs,
    options: &Options,
) -> Result<(Vec<SpanParameter>, Vec<SpanParameter>), ExportError> {
    let counts = grid(options, nurbs.v.is_some());
    if options.is_by_length() {
        let u = by_length(nurbs, options, steps_between(counts.rows))?;
        return Ok((u, Vec::new()));
    }
    let u = equal_steps(&nurbs.u, counts.rows);
    let v = nurbs.v.as_ref().map(|v| equal_steps(v, counts.columns));
    Ok((u, v.unwrap_or_default()))
}

/// Parameters at equal distances over the domain, both ends included.
fn equal_steps(knots: &KnotVector, count: usize) -> Vec<SpanParameter> {
    let (low, high) = knots.domain();
    let steps = steps_between(count);
    let at = |i: usize| {
        let part = i as f64 / steps as f64;
        knots.site_at((1.0 - part) * low + part * high)
    };
    (0..=steps).map(at).collect()
}

/// The number of samples.
pub(in crate::export) fn grid(options: &Options, surface: bool) -> Grid {
    options.samples.unwrap_or(match surface {
        false => Grid {
            rows: CURVE,
            columns: 1,
        },
        true => Grid {
            rows: SURFACE,
            columns: SURFACE,
        },
    })
}
