//! Fitted curves and surfaces as files: for CAD systems, viewers, people and spreadsheets.
//!
//! [`write()`] is the only entry. It knows nothing of jobs or of HTTP.
//!
//! - [`format`](mod@format): the formats and their names; [`error`]: why something cannot be written;
//! - [`nurbs`]: the curve or surface as CAD kernels store it, which `step`, `iges` and `obj` write
//!   exactly; `ball`: how polynomials of the Ball bases get there;
//! - `sampling`: points and derivatives of it, for `gltf` and `svg`;
//! - [`csv`]: samples as numbers;
//! - `text`: numbers and names as text.
//!
//! Exact files hold the numbers of the fit to the last bit: reals are written with as many digits
//! (up to 17) as it takes to read them back. What a format cannot say is an error, never a guess:
//! values of a function (one coordinate) have no place in space, and weights must be positive.
//! Points of the plane have z = 0. STEP and IGES need a unit, and say millimetres.

mod ball;
pub mod csv;
pub mod error;
pub mod format;
mod gltf;
mod iges;
pub mod nurbs;
mod obj;
mod sampling;
mod step;
mod svg;
mod text;

use std::sync::Arc;

use jiff::Timestamp;

pub use error::ExportError;
pub use format::{Format, UnknownFormat};
pub use nurbs::Nurbs;

use crate::fit::basis::{Basis, Polynomial};
use crate::fit::direction::Direction;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Problem;

/// The program that writes the files.
const GENERATOR: &str = concat!("piad ", env!("CARGO_PKG_VERSION"));

/// A level of a fit, and what its file should say.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// The problem that was fitted.
    pub problem: &'a Arc<Problem>,
    /// The free control points of the level, in homogeneous coordinates if the fit is.
    pub control_points: &'a Arc<Points>,
    /// The name of the curve or surface; any text.
    pub name: Option<&'a str>,
    /// When it was made, for formats that say so. The same level at the same time is the same file.
    pub created: Timestamp,
    /// The largest distance from the data at each level from 0 on; drawings show how it falls.
    pub errors: &'a [f64],
    /// How many points formats that sample the curve or surface take in each direction, at least
    /// two; otherwise as many as suit it.
    pub samples: Option<Grid>,
}

impl<'a> Fitted<'a> {
    /// A level without a name.
    pub fn new(
        problem: &'a Arc<Problem>,
        control_points: &'a Arc<Points>,
        created: Timestamp,
    ) -> Self {
        Self {
            problem,
            control_points,
            name: None,
            created,
            errors: &[],
            samples: None,
        }
    }

    /// The name, or what it is.
    fn title(&self) -> &'a str {
        let kind = match self.problem.v() {
            None => "curve",
            Some(_) => "surface",
        };
        self.name.filter(|name| !name.is_empty()).unwrap_or(kind)
    }

    /// What was fitted, in a line of ASCII.
    fn description(&self) -> String {
        let problem = self.problem;
        let rational = problem.is_homogeneous() || problem.directions().any(Direction::is_rational);
        let rational = if rational { "rational " } else { "" };
        let u = problem.u();
        let grid = problem.grid();
        match problem.v() {
            None => format!(
                "{rational}{} curve of degree {}, {} data points",
                basis_name(&u.basis),
                u.basis.degree(),
                grid.rows
            ),
            Some(v) => {
                let (first, second) = (basis_name(&u.basis), basis_name(&v.basis));
                let bases = match first == second {
                    true => first.to_owned(),
                    false => format!("{first} x {second}"),
                };
                format!(
                    "{rational}{bases} surface of degree {} x {}, {} x {} data points",
                    u.basis.degree(),
                    v.basis.degree(),
                    grid.rows,
                    grid.columns
                )
            }
        }
    }
}

fn basis_name(basis: &Basis) -> &'static str {
    match basis {
        Basis::BSpline { .. } => "B-spline",
        Basis::Polynomial { kind, .. } => match kind {
            Polynomial::Bernstein => "Bezier",
            Polynomial::SaidBall => "Said-Ball",
            Polynomial::WangBall => "Wang-Ball",
        },
    }
}

/// The highest degree for STEP and IGES: that of OpenCASCADE and of the many systems built on it.
/// They refuse to load a file with a higher one, and some say so only in their log.
pub const MOST_CAD_DEGREE: usize = 25;

/// The file of a level in a format.
pub fn write(format: Format, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    if format == Format::Csv {
        return csv::write(fitted);
    }
    if fitted.problem.dimension() < 2 {
        return Err(ExportError::OneCoordinate { format });
    }
    if matches!(format, Format::Step | Format::Iges) {
        check_degree(format, fitted.problem)?;
    }
    let nurbs = Nurbs::new(fitted.problem, fitted.control_points)?;
    match format {
        Format::Step => Ok(step::write(&nurbs, fitted)),
        Format::Iges => iges::write(&nurbs, fitted),
        Format::Obj => Ok(obj::write(&nurbs, fitted)),
        Format::Gltf => gltf::write(&nurbs, fitted),
        Format::Svg => svg::write(&nurbs, fitted),
        Format::Csv => csv::write(fitted),
    }
}

fn check_degree(format: Format, problem: &Problem) -> Result<(), ExportError> {
    let degrees = problem.directions().map(|it| it.basis.degree());
    match degrees.max() {
        Some(degree) if degree > MOST_CAD_DEGREE => Err(ExportError::Degree {
            format,
            degree,
            most: MOST_CAD_DEGREE,
        }),
        _ => Ok(()),
    }
}
