//! Writes fitted curves and surfaces to files: for CAD systems, viewers, people and spreadsheets.
//!
//! [`write()`] writes a level of a fit, [`write_parts`] several curves and surfaces, through the same writers. They do
//! not depend on jobs or HTTP.
//!
//! - `fitted` and `part`: the contents of a file; `options`: its options; `document`: the input of writers;
//! - `format`: the formats and their names; `error`: errors of writing;
//! - [`nurbs`]: the curve or surface as CAD kernels store it, which `step`, `iges` and `obj` write
//!   exactly; `assemble`: that of plain data;
//! - `mesh`: its triangles, for `gltf`, `stl` and `ply`;
//! - `sampling`: samples along curves; `map`: those in degrees, for `geojson` and `gpx`;
//! - `deviation`: its distance from each data point, for `svg`;
//! - `csv`: samples as numbers; [`shape`]: with curvatures, which is not a file;
//! - `trim`: edges and triangles of trimmed surfaces;
//! - `text`: numbers and names as text.
//!
//! Exact files hold the numbers of the fit to the last bit: reals are written with as many digits (up to 17) as are
//! needed to read them back. A format that cannot represent the geometry gives an error, never an approximation. Values
//! of a function (one coordinate) and points of more than three coordinates cannot be placed in space, and weights must
//! be positive. Points of the plane have z = 0. STEP and IGES need a unit, by default millimetres.

mod assemble;
pub mod csv;
#[cfg(test)]
mod cylinder;
mod deviation;
mod document;
mod dxf;
mod error;
mod fitted;
mod format;
mod geojson;
mod gltf;
mod gpx;
mod iges;
mod map;
mod mesh;
pub mod nurbs;
mod obj;
mod options;
mod part;
mod ply;
mod sampling;
pub mod shape;
mod step;
mod stl;
mod svg;
#[cfg(test)]
mod tests;
mod text;
mod trim;

/// The most coordinates of points in files of curves and surfaces.
const SPACE: usize = 3;

pub use crate::wgs84::Origin;
pub use deviation::MOST_MEASURED;
pub use error::ExportError;
pub use fitted::Fitted;
pub use format::{Format, UnknownFormat};
pub use nurbs::Nurbs;
pub use options::{Dots, Options, Style, Unit, Version, check_options};
pub use part::{Header, Part};

use document::Document;
use mesh::MOST_ALONG_SURFACE;

use piad_fit::data::Grid;
use piad_fit::engine::{Problem, samples};

/// The highest degree for STEP and IGES: that of OpenCASCADE and of the many systems built on it. They refuse to load a
/// file with a higher one, and some report this only in their log.
pub const MOST_CAD_DEGREE: usize = 25;

/// Writes a level of a fit to a file of a format.
pub fn write(format: Format, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let surface = fitted.problem.v().is_some();
    check_options(format, surface, &fitted.options)?;
    if format == Format::Csv {
        return csv::write(fitted);
    }
    check(format, fitted.problem)?;
    let nurbs = nurbs::checked(fitted.problem, fitted.control_points)?;
    check_spline_degree(format, &nurbs, &fitted.options)?;
    if format == Format::Svg && fitted.options.style == Style::Drawing {
        return svg::write(&nurbs, fitted);
    }
    write_document(format, &Document::of_fit(fitted, &nurbs))
}

/// The file of several curves and surfaces in a format.
///
/// All formats can hold several: STEP in one product, IGES, OBJ, glTF, DXF, GeoJSON and GPX as entities with the names
/// of the parts, SVG as paths ([`Style::Path`], whatever the options, as there are no data to draw), STL and PLY as one
/// mesh, CSV with blank lines between parts.
///
/// # Errors
///
/// If there is no part, or the first part that the format cannot hold, with its number and name.
///
/// ```
/// use jiff::Timestamp;
/// use piad_files::export::nurbs::{DirectionData, assemble};
/// use piad_files::export::{Format, Header, Options, Part, write_parts};
/// use piad_fit::data::Points;
///
/// // The numbers of a result in JSON: a Bézier curve of degree 2 has no knots.
/// let u = DirectionData { degree: 2, knots: None, closed: false };
/// let points = Points::from_flat(2, &[0.0, 0.0, 1.0, 2.0, 2.0, 0.0]);
/// let parts = [Part { name: Some("arch"), nurbs: assemble(u, None, points, None)?, outline: None }];
/// let header = Header::new(Timestamp::now(), Options::default());
/// assert!(write_parts(Format::Dxf, &parts, &header)?.ends_with(b"EOF\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_parts(
    format: Format,
    parts: &[Part<'_>],
    header: &Header<'_>,
) -> Result<Vec<u8>, ExportError> {
    if parts.is_empty() {
        return Err(ExportError::NoParts { format });
    }
    let mut document = Document::of_parts(parts, header);
    if format == Format::Svg {
        document.options.style = Style::Path;
    }
    document.try_each(|shape| check_shape_of(format, shape.nurbs, &document.options))?;
    write_document(format, &document)
}

/// Checks one curve or surface that is not a level of a fit.
fn check_shape_of(format: Format, nurbs: &Nurbs, options: &Options) -> Result<(), ExportError> {
    let surface = nurbs.v.is_some();
    check_options(format, surface, options)?;
    check_shape(format, surface, nurbs.points.dimension())?;
    let across = nurbs.v.as_ref().map_or(0, |v| v.degree);
    check_degree(format, nurbs.u.degree.max(across))?;
    check_spline_degree(format, nurbs, options)?;
    nurbs::check(nurbs)
}

fn write_document(format: Format, document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    if format == Format::Dxf {
        document.try_each(|shape| match shape.outline {
            None => Ok(()),
            Some(_) => Err(ExportError::Trimmed { format }),
        })?;
    }
    match format {
        Format::Step => Ok(step::write(document)),
        Format::Iges => iges::write(document),
        Format::Obj => Ok(obj::write(document)),
        Format::Gltf => gltf::write(document),
        Format::Stl => stl::write(document),
        Format::Ply => ply::write(document),
        Format::Dxf => dxf::write(document),
        Format::Svg => svg::path::write(document),
        Format::GeoJson => geojson::write(document),
        Format::Gpx => gpx::write(document),
        Format::Csv => csv::write_parts(document),
    }
}

/// The cost of samples at equal distances, as a multiple of samples at equal steps: the quadrature has five nodes, and
/// finding a parameter takes about three steps.
const LENGTH_COST: usize = 20;

/// The approximate number of samples for a spacing; the exact number is unknown before the length of the curve.
const SPACED: usize = 1 << 14;

/// The approximate number of multiplications that it takes to sample a level for a format; 0 for those that are exact,
/// and for tables at equal steps, which are sampled while they are sent.
pub fn sampling_cost(format: Format, problem: &Problem, options: &Options) -> usize {
    let by_length = options.is_by_length();
    let suitable = || match problem.v() {
        None => Grid {
            rows: (4 * problem.u().basis.functions()).max(MOST_ALONG_SURFACE),
            columns: 1,
        },
        Some(_) => Grid {
            rows: MOST_ALONG_SURFACE,
            columns: MOST_ALONG_SURFACE,
        },
    };
    match format {
        Format::Step | Format::Iges => 0,
        Format::Csv if !by_length => 0,
        Format::Csv
        | Format::Obj
        | Format::Gltf
        | Format::Stl
        | Format::Ply
        | Format::Dxf
        | Format::Svg
        | Format::GeoJson
        | Format::Gpx => {
            let mut grid = options.samples.unwrap_or_else(suitable);
            if options.spacing.is_some() {
                grid.rows = grid.rows.max(SPACED);
            }
            // Points and their derivatives.
            let times = if by_length { 3 * LENGTH_COST } else { 3 };
            samples::multiplications(problem, grid).saturating_mul(times)
        }
    }
}

/// Checks before the fit whether the results of a problem can be written in a format.
pub fn check(format: Format, problem: &Problem) -> Result<(), ExportError> {
    check_shape(format, problem.v().is_some(), problem.dimension())?;
    let degrees = problem.directions().map(|it| it.basis.degree());
    check_degree(format, degrees.max().unwrap_or(0))
}

fn check_degree(format: Format, degree: usize) -> Result<(), ExportError> {
    match format {
        Format::Step | Format::Iges if degree > MOST_CAD_DEGREE => Err(ExportError::Degree {
            format,
            degree,
            most: MOST_CAD_DEGREE,
        }),
        _ => Ok(()),
    }
}

/// DXF files have only splines of the degrees that CAD systems support.
fn check_spline_degree(
    format: Format,
    nurbs: &Nurbs,
    options: &Options,
) -> Result<(), ExportError> {
    let is_spline = format == Format::Dxf && options.version == Version::R2000;
    match nurbs.u.degree {
        degree if is_spline && nurbs.v.is_none() && degree > MOST_CAD_DEGREE => {
            Err(ExportError::Degree {
                format,
                degree,
                most: MOST_CAD_DEGREE,
            })
        }
        _ => Ok(()),
    }
}

/// Checks that a format can hold curves, or surfaces, through points with this number of coordinates.
pub fn check_shape(format: Format, surface: bool, dimension: usize) -> Result<(), ExportError> {
    match format {
        Format::Csv => Ok(()),
        _ if dimension < 2 => Err(ExportError::OneCoordinate { format }),
        _ if dimension > SPACE => Err(ExportError::ManyCoordinates { format, dimension }),
        Format::Stl | Format::Ply if !surface => Err(ExportError::NoTriangles { format }),
        Format::GeoJson | Format::Gpx if surface => Err(ExportError::NoLine {
            format,
            what: "files hold curves as lines of a map",
            instead: "step, gltf or ply",
        }),
        _ => Ok(()),
    }
}
