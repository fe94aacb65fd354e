//! CSV: samples of the curve or surface with their parameters.

use std::ops::Range;
use std::sync::Arc;

use super::error::{ExportError, NetIndex};
use super::fitted::Fitted;
use super::text::Text;
use piad_fit::data::Grid;
use piad_fit::engine::samples::Samples;

/// The number of samples of a curve, and of each direction of a surface, by default.
const CURVE: usize = 200;
const SURFACE: usize = 40;

/// The names of coordinates.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// The number of samples that are evaluated at a time.
const CHUNK: usize = 256;

/// A table that is written in parts: a line with names (`t,x,y` of a curve, `t,x1,x2,…` of one with more than three
/// coordinates, `u,v,x,y,z` of a surface), then one for each sample, at equal steps of the parameters; on surfaces row by row.
#[derive(Debug)]
pub struct Table {
    samples: Samples,
}

impl Table {
    /// The table of a level.
    pub fn new(fitted: &Fitted<'_>) -> Result<Self, ExportError> {
        let grid = fitted.options.samples.unwrap_or(match fitted.problem.v() {
            None => Grid {
                rows: CURVE,
                columns: 1,
            },
            Some(_) => Grid {
                rows: SURFACE,
                columns: SURFACE,
            },
        });
        let setup = Arc::clone(fitted.problem.setup());
        let samples = Samples::new(setup, Arc::clone(fitted.control_points), grid);
        check(&samples)?;
        Ok(Self { samples })
    }

    /// About how many multiplications it takes to evaluate all lines.
    pub fn multiplications(&self) -> usize {
        self.samples.multiplications()
    }

    /// How many lines follow the names.
    pub fn lines(&self) -> usize {
        self.samples.count()
    }

    /// The line with the names.
    pub fn names(&self) -> Vec<u8> {
        let mut text = Text::default();
        text.push(if self.samples.v.is_some() { "u,v" } else { "t" });
        let dimension = self.samples.dimension();
        match COORDINATES.get(..dimension) {
            Some(names) => names
                .iter()
                .for_each(|name| text.put(format_args!(",{name}"))),
            None => (1..=dimension).for_each(|c| text.put(format_args!(",x{c}"))),
        }
        text.push("\n");
        text.into_bytes()
    }

    /// The lines of these samples.
    pub fn part(&self, lines: Range<usize>) -> Vec<u8> {
        let columns = self.samples.columns();
        let mut text = Text::default();
        each(&self.samples, lines, |index, point| {
            text.put(format_args!("{:?}", self.samples.u.at(index / columns)));
            if let Some(v) = self.samples.v {
                text.put(format_args!(",{:?}", v.at(index % columns)));
            }
            for x in point {
                text.put(format_args!(",{x:?}"));
            }
            text.push("\n");
        });
        text.into_bytes()
    }
}

/// The whole table.
pub(super) fn write(fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let table = Table::new(fitted)?;
    let mut file = table.names();
    file.extend(table.part(0..table.lines()));
    Ok(file)
}

fn each(samples: &Samples, range: Range<usize>, mut visit: impl FnMut(usize, &[f64])) {
    let dimension = samples.dimension();
    let mut chunk = vec![0.0; CHUNK * dimension];
    for start in range.clone().step_by(CHUNK) {
        let chunk = &mut chunk[..CHUNK.min(range.end - start) * dimension];
        samples.fill(start, chunk);
        for (k, point) in chunk.chunks_exact(dimension).enumerate() {
            visit(start + k, point);
        }
    }
}

/// Refuses samples that are not finite. They can occur with weights that are not positive, and close to the
/// largest numbers; otherwise samples lie in the convex hull of the control points.
fn check(samples: &Samples) -> Result<(), ExportError> {
    let geometry = samples.geometry();
    let small = |(row, column)| {
        let mut place = geometry.place(row, column);
        place.all(|x: f64| x.abs() < f64::MAX / 4.0)
    };
    if geometry.is_within_hull() && geometry.places().all(small) {
        return Ok(());
    }
    let mut found = None;
    each(samples, 0..samples.count(), |index, point| {
        let coordinate = point.iter().position(|x| !x.is_finite());
        if let Some(coordinate) = coordinate.filter(|_| found.is_none()) {
            found = Some((index, coordinate, point[coordinate]));
        }
    });
    let columns = samples.v.map(|_| samples.columns());
    match found {
        None => Ok(()),
        Some((index, coordinate, value)) => Err(ExportError::NotFinite {
            what: "sample",
            place: NetIndex::new(index, columns),
            coordinate,
            value,
        }),
    }
}
