//! CSV: samples of curves and surfaces with their parameters.

mod listed;

use std::ops::Range;
use std::sync::Arc;

use super::document::Document;
use super::error::{ExportError, NetIndex};
use super::fitted::Fitted;
use super::format::Format;
use super::nurbs::{Nurbs, checked};
use super::options::{Options, check_options};
use super::text::{Text, one_line};
use listed::Listed;
pub(super) use listed::{grid, sites};
use piad_fit::engine::samples::Samples;

/// The names of coordinates.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// The number of samples that are evaluated at a time.
const CHUNK: usize = 256;

/// A table that is written in parts: a line with names (`t,x,y` of a curve, `t,x1,x2,…` of one with more than three
/// coordinates, `u,v,x,y,z` of a surface), then one for each sample, at equal steps of the parameters or, if that is chosen, of the length; on surfaces row by row.
#[derive(Debug)]
pub struct Table {
    source: Source,
}

/// The source of the samples of a table.
#[derive(Debug)]
enum Source {
    /// The level of a fit.
    Level(Samples),
    /// A curve or surface by itself.
    Nurbs(Listed),
}

impl Table {
    /// The table of a level.
    ///
    /// # Errors
    ///
    /// If a sample is not finite, or, for samples at equal distances, if [`check_options`] refuses them or a weight is
    /// not positive.
    ///
    /// [`check_options`]: super::check_options
    pub fn new(fitted: &Fitted<'_>) -> Result<Self, ExportError> {
        if fitted.options.is_by_length() {
            check_options(Format::Csv, fitted.problem.v().is_some(), &fitted.options)?;
            let nurbs = checked(fitted.problem, fitted.control_points)?;
            return Self::of_nurbs(&nurbs, &fitted.options);
        }
        let surface = fitted.problem.v().is_some();
        let grid = grid(&fitted.options, surface);
        let setup = Arc::clone(fitted.problem.setup());
        let samples = Samples::new(setup, Arc::clone(fitted.control_points), grid);
        check(&samples)?;
        let source = Source::Level(samples);
        Ok(Self { source })
    }

    fn of_nurbs(nurbs: &Nurbs, options: &Options) -> Result<Self, ExportError> {
        let listed = Listed::new(nurbs, options)?;
        let source = Source::Nurbs(listed);
        Ok(Self { source })
    }

    /// The approximate number of multiplications that it takes to evaluate all lines.
    pub fn multiplications(&self) -> usize {
        match &self.source {
            Source::Level(samples) => samples.multiplications(),
            Source::Nurbs(_) => 0,
        }
    }

    /// The number of lines after the names.
    pub fn lines(&self) -> usize {
        match &self.source {
            Source::Level(samples) => samples.count(),
            Source::Nurbs(listed) => listed.count(),
        }
    }

    /// The line with the names.
    pub fn names(&self) -> Vec<u8> {
        let (surface, dimension) = match &self.source {
            Source::Level(samples) => (samples.v.is_some(), samples.dimension()),
            Source::Nurbs(listed) => (listed.is_surface(), listed.dimension()),
        };
        names(surface, dimension).into_bytes()
    }

    /// The lines of these samples.
    pub fn part(&self, lines: Range<usize>) -> Vec<u8> {
        let mut text = Text::default();
        match &self.source {
            Source::Level(samples) => {
                let columns = samples.columns();
                each(samples, lines, |index, point| {
                    let v = samples.v.map(|v| v.at(index % columns));
                    line(&mut text, samples.u.at(index / columns), v, point);
                });
            }
            Source::Nurbs(listed) => listed.each(lines, |u, v, point| line(&mut text, u, v, point)),
        }
        text.into_bytes()
    }
}

fn names(surface: bool, dimension: usize) -> String {
    let mut names = vec![if surface { "u,v" } else { "t" }.to_owned()];
    match COORDINATES.get(..dimension) {
        Some(few) => names.extend(few.iter().map(|&name| name.to_owned())),
        None => names.extend((1..=dimension).map(|c| format!("x{c}"))),
    }
    names.join(",") + "\n"
}

fn line(text: &mut Text, u: f64, v: Option<f64>, point: &[f64]) {
    text.put(format_args!("{u:?}"));
    for x in v.iter().chain(point) {
        text.put(format_args!(",{x:?}"));
    }
    text.push("\n");
}

/// The whole table of a fit.
pub(super) fn write(fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let table = Table::new(fitted)?;
    let mut file = table.names();
    file.extend(table.part(0..table.lines()));
    Ok(file)
}

/// The tables of several parts under one line of names: blank lines are between them, and their names above them, as
/// comments.
pub(super) fn write_parts(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut file: Vec<u8> = Vec::new();
    let mut columns: Option<Vec<u8>> = None;
    document.try_each(|shape| {
        let table = Table::of_nurbs(shape.nurbs, &document.options)?;
        let names = table.names();
        match &columns {
            None => {
                file.extend(&names);
                columns = Some(names);
            }
            Some(first) if *first == names => file.push(b'\n'),
            Some(first) => return Err(other_columns(&names, first)),
        }
        if document.shapes.len() > 1 {
            file.extend(format!("# {}\n", one_line(shape.title())).into_bytes());
        }
        file.extend(table.part(0..table.lines()));
        Ok(())
    })?;
    Ok(file)
}

fn other_columns(names: &[u8], first: &[u8]) -> ExportError {
    let text = |names: &[u8]| String::from_utf8_lossy(names).trim_end().to_owned();
    ExportError::OtherColumns {
        format: Format::Csv,
        found: text(names),
        expected: text(first),
    }
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
