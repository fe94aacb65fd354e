//! A level of a fit to write, and the metadata of its file.

use std::sync::Arc;

use jiff::Timestamp;

use super::options::Options;
use piad_fit::Level;
use piad_fit::basis::{Basis, Polynomial};
use piad_fit::data::Points;
use piad_fit::engine::{Direction, Problem};

/// The program that writes the files.
pub(super) const GENERATOR: &str = concat!("piad ", env!("CARGO_PKG_VERSION"));

/// A level of a fit, and the metadata of its file.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// The problem that was fitted.
    pub problem: &'a Arc<Problem>,
    /// The free control points of the level, in homogeneous coordinates if the fit is.
    pub control_points: &'a Arc<Points>,
    /// The name of the curve or surface; any text.
    pub name: Option<&'a str>,
    /// The time of creation, for formats that have one. The same level with the same time gives the same
    /// file.
    pub created: Timestamp,
    /// The largest distance from the data at each level from 0 on, for drawings; may be empty.
    pub errors: &'a [f64],
    /// The options of the file.
    pub options: Options,
}

impl<'a> Fitted<'a> {
    /// A level of a fit, created now.
    pub fn of<S>(level: &'a Level<S>) -> Self {
        Self::new(level.problem(), level.control_points(), Timestamp::now())
    }

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
            options: Options::default(),
        }
    }

    /// The name, or `curve` or `surface` without one.
    pub(super) fn title(&self) -> &'a str {
        let kind = match self.problem.v() {
            None => "curve",
            Some(_) => "surface",
        };
        self.name.filter(|name| !name.is_empty()).unwrap_or(kind)
    }

    /// A description of the fit in one line of ASCII.
    pub(super) fn description(&self) -> String {
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
                let data = match problem.is_scattered() {
                    true => format!("{} scattered", grid.rows),
                    false => format!("{} x {}", grid.rows, grid.columns),
                };
                let (first, second) = (basis_name(&u.basis), basis_name(&v.basis));
                let bases = match first == second {
                    true => first.to_owned(),
                    false => format!("{first} x {second}"),
                };
                format!(
                    "{rational}{bases} surface of degree {} x {}, {data} data points",
                    u.basis.degree(),
                    v.basis.degree(),
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
