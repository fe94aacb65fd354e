//! Fitted curves and surfaces as files: for CAD systems, viewers, people and spreadsheets.
//!
//! [`write()`] is the only entry. It knows nothing of jobs or of HTTP.
//!
//! - `fitted`: what is written; `options`: what can be chosen about it;
//! - `format`: the formats and their names; `error`: why something cannot be written;
//! - [`nurbs`]: the curve or surface as CAD kernels store it, which `step`, `iges` and `obj` write
//!   exactly;
//! - `mesh`: its triangles, for `gltf` and `stl`;
//! - `deviation`: how far it is from each data point, for `svg`;
//! - `csv`: samples as numbers;
//! - `text`: numbers and names as text.
//!
//! Exact files hold the numbers of the fit to the last bit: reals are written with as many digits
//! (up to 17) as it takes to read them back. What a format cannot represent is an error, never a guess:
//! values of a function (one coordinate) and points of more than three coordinates have no place in space, and weights must be positive.
//! Points of the plane have z = 0. STEP and IGES need a unit, and say millimetres if none is chosen.

pub mod csv;
#[cfg(test)]
mod cylinder;
mod deviation;
mod dxf;
mod error;
mod fitted;
mod format;
mod gltf;
mod iges;
mod mesh;
pub mod nurbs;
mod obj;
mod options;
mod step;
mod stl;
mod svg;
mod text;
mod vectors;

/// The most coordinates of points in files of curves and surfaces.
const SPACE: usize = 3;

pub use deviation::MOST_MEASURED;
pub use error::ExportError;
pub use fitted::Fitted;
pub use format::{Format, UnknownFormat};
pub use nurbs::Nurbs;
pub use options::{Dots, Options, Unit};

use mesh::MOST_ALONG_SURFACE;

use piad_fit::data::Grid;
use piad_fit::engine::{Problem, samples};

/// The highest degree for STEP and IGES: that of OpenCASCADE and of the many systems built on it.
/// They refuse to load a file with a higher one, and some say so only in their log.
pub const MOST_CAD_DEGREE: usize = 25;

/// The file of a level in a format.
pub fn write(format: Format, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    if fitted.options.unit.is_some() && !format.has_unit() {
        return Err(ExportError::NoUnit { format });
    }
    if format == Format::Csv {
        return csv::write(fitted);
    }
    check(format, fitted.problem)?;
    let nurbs = nurbs::checked(fitted.problem, fitted.control_points)?;
    match format {
        Format::Step => Ok(step::write(&nurbs, fitted)),
        Format::Iges => iges::write(&nurbs, fitted),
        Format::Obj => Ok(obj::write(&nurbs, fitted)),
        Format::Gltf => gltf::write(&nurbs, fitted),
        Format::Stl => stl::write(&nurbs, fitted),
        Format::Dxf => dxf::write(&nurbs, fitted),
        Format::Svg => svg::write(&nurbs, fitted),
        Format::Csv => csv::write(fitted),
    }
}

/// About how many multiplications it takes to sample a level for a format; 0 for those that are exact, and for tables,
/// which are sampled while they are sent.
pub fn sampling_cost(format: Format, problem: &Problem, options: &Options) -> usize {
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
        Format::Step | Format::Iges | Format::Csv => 0,
        Format::Obj | Format::Gltf | Format::Stl | Format::Dxf | Format::Svg => {
            let grid = options.samples.unwrap_or_else(suitable);
            // Points and their derivatives.
            samples::multiplications(problem, grid).saturating_mul(3)
        }
    }
}

/// Checks what is known of a problem before it is fitted: whether its results can be written in a format.
pub fn check(format: Format, problem: &Problem) -> Result<(), ExportError> {
    check_shape(format, problem.v().is_some(), problem.dimension())?;
    let degrees = problem.directions().map(|it| it.basis.degree());
    match degrees.max() {
        Some(degree)
            if degree > MOST_CAD_DEGREE && matches!(format, Format::Step | Format::Iges) =>
        {
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
        Format::Stl if !surface => Err(ExportError::NoTriangles { format }),
        _ => Ok(()),
    }
}
