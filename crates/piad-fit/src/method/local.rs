//! Local PIA: only the control points of selected data points move.
//!
//! ```text
//! X⁰ = P,   X ← X + ω S (P − B X),   U = ω S,   S = diag(0 or 1)
//! ```
//!
//! (Lin10, sections 2–5, with ω = 1; section 6 proposes a relaxation, 0 < ω < 2). The difference vectors of the
//! selected points I fall to zero, those of the others J converge to `Δ_J⁰ − B_JI B_II⁻¹ Δ_I⁰` (Lin10, Theorem 2;
//! [`crate::iteration::limit`]). Errors and the stop rule are those of the selected points; the largest difference
//! vector of the others is reported separately. The rate is `max |1 − ω λ|` over the eigenvalues λ of `B_II`: for ω = 1
//! it is `1 − λ_min(B_II)`, where principal blocks of totally positive matrices have larger eigenvalues than the
//! matrix; for one point l it is `|1 − ω B_l(t_l)|`. The best ω for eigenvalues up to one is `2 / (1 + λ_min(B_II))`. A
//! level costs as much as the supports of the selected points.
//!
//! On surfaces the points can also be adjusted row by row (Lin10, Theorem 9), or column by column: a
//! line until it is within the tolerance, then the next one. One pass is not enough, as later lines
//! disturb earlier ones, so that the sweeps are repeated until all lines are.

use super::algorithm::{Algorithm, Scope};
use super::eigenvalues;
use super::equations::Equations;
use super::omega::Omega;
use super::selection::{Choice, Selection, all_points};
use super::update::{State, Update};
use crate::geometry::norms::Norms;
use crate::invalid::{Invalid, Place, Setting};
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::spectrum;
use crate::matrix::tensor::Tensor;
use crate::setup::Setup;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "local",
    title: "Local PIA (LPIA)",
    summary: "Only the control points of selected data points move, and all others stay where they are.",
    source: "Lin10, sections 2–5",
};

/// Up to this number of adjusted points the least eigenvalue of their block is computed, in O(n³).
const BLOCK: usize = 200;

/// Local PIA. The selected points are a part of the request, as there can be many.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Local {
    /// The relaxation. The best one is `2 / (1 + λ_min)` of the block of up to 200 points, and of
    /// the whole matrix for more of them: that is nearer to 2, and as fast as weighted PIA.
    pub omega: Omega,
    /// Surfaces: one line of points after the other, in sweeps until all are within the tolerance.
    pub sweeps: Option<Sweeps>,
}

/// The order of the lines in sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Sweeps {
    /// Row by row.
    Rows,
    /// Column by column.
    Columns,
}

impl Algorithm for Local {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// Sweeps are for surfaces, and indices are those of points, each once.
    fn check(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        self.omega.check()?;
        if self.sweeps.is_some() && !scope.is_surface {
            let setting = Setting::Sweeps;
            return Err(Invalid::at(
                Place::Setting(setting),
                "sweeps are for surfaces; a curve has no rows and no columns",
            ));
        }
        match scope.selected {
            None => Ok(()),
            Some(indices) => check_indices(indices, scope.grid.count()),
        }
    }

    /// Few points have the eigenvalues of their block; for many those of the matrix are bounds.
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        let few = setup.selected().filter(|points| points.len() <= BLOCK);
        let Some(adjusted) = few else {
            return eigenvalues::relaxed(setup, collocation, self.omega);
        };
        let block = spectrum::of_block(collocation, adjusted);
        let least = block.map(|block| block.least);
        let omega = self.omega.of(least);
        Forecast {
            lambda_min: setup.lambda_min(),
            omega: Some(omega),
            rate: block.map(|block| block.rate(omega)),
            block: least,
            ..Forecast::default()
        }
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        let setup = &equations.setup;
        let adjusted = adjusted(setup);
        let Some(sweeps) = self.sweeps else {
            return Box::new(Selection::new(equations, Fixed, adjusted));
        };
        let sweep = LineSweep {
            lines: sweeps.lines(adjusted, setup.grid().columns),
            current: 0,
            norms: all_points(equations),
        };
        Box::new(Selection::new(equations, sweep, Vec::new()))
    }

    /// The selected points: the errors of all others do not count.
    fn adjusted(&self, setup: &Setup) -> Option<Vec<usize>> {
        Some(adjusted(setup))
    }
}

impl Sweeps {
    /// The lines of these points, given in increasing order, of a grid with `columns` columns. The points of each line
    /// increase, too.
    fn lines(self, mut points: Vec<usize>, columns: usize) -> Vec<Vec<usize>> {
        let line = |index: usize| match self {
            Self::Rows => index / columns,
            Self::Columns => index % columns,
        };
        points.sort_by_key(|&index| line(index));
        let lines = points.chunk_by(|a, b| line(*a) == line(*b));
        lines.map(<[usize]>::to_vec).collect()
    }
}

/// The selected points, increasing; all of them if none were selected.
fn adjusted(setup: &Setup) -> Vec<usize> {
    let mut indices = match setup.selected() {
        Some(indices) => indices.to_vec(),
        None => (0..setup.grid().count()).collect(),
    };
    indices.sort_unstable();
    indices
}

/// Refuses indices that are out of range, or given twice; there must be at least one.
fn check_indices(indices: &[usize], count: usize) -> Result<(), Invalid> {
    if indices.is_empty() {
        return Err(Invalid::at(
            Place::Setting(Setting::Indices),
            "indices is empty; expected at least one",
        ));
    }
    let mut seen = vec![false; count];
    for (index, &value) in indices.iter().enumerate() {
        match seen.get_mut(value) {
            None => {
                return Err(Invalid::at(
                    Place::Index(index),
                    format!("index {index} is {value}, but there are {count} points"),
                ));
            }
            Some(true) => {
                return Err(Invalid::at(
                    Place::Index(index),
                    format!("index {index} repeats an earlier one"),
                ));
            }
            Some(seen) => *seen = true,
        }
    }
    Ok(())
}

/// Always the same points.
#[derive(Clone, Debug)]
struct Fixed;

impl Choice for Fixed {
    const VARIES: bool = false;

    fn choose(&mut self, _equations: &Equations, _state: &State, _active: &mut Vec<usize>) {}
}

/// The points of one line, until they are within the tolerance; then those of the next line.
#[derive(Clone, Debug)]
struct LineSweep {
    /// The lines with something to adjust.
    lines: Vec<Vec<usize>>,
    current: usize,
    norms: Norms,
}

impl Choice for LineSweep {
    const VARIES: bool = true;

    fn choose(&mut self, equations: &Equations, state: &State, active: &mut Vec<usize>) {
        let setup = &equations.setup;
        let (data, tolerance) = (setup.data(), setup.tolerance());
        let distance = |index: usize| {
            let mut one = [0.0];
            self.norms.distances(data, &state.residual, index, &mut one);
            one[0]
        };
        let done = |line: &[usize]| line.iter().all(|&index| distance(index) <= tolerance);
        // At most once around: if all are done, the fit has converged.
        for _ in 0..self.lines.len() {
            if !done(&self.lines[self.current]) {
                break;
            }
            self.current = (self.current + 1) % self.lines.len();
        }
        active.clone_from(&self.lines[self.current]);
    }
}
