//! Least squares: fewer control points than data points.
//!
//! ```text
//! X ← X + D Aᵀ (P − A X),   A[i][j] = B_j(t_i)
//! ```
//!
//! Data points can have weights, the curve can be fair, and every level can satisfy conditions; by
//! default it passes through its first and its last data point, and a surface through its corners.
//!
//! A is the rectangular collocation matrix, m + 1 data points × n + 1 control points. Level 0 are
//! the first data point, the last, and between them data point `⌊(m+1) i / n⌋` (Deng, Lin 2014); on
//! closed curves `⌊(m+1) i / (n+1)⌋`. Three choices of D:
//!
//! - [`Variant::Diagonal`]: D = diag(1 / column sums of A) (Lin, Cao, Zhang 2018);
//! - [`Variant::Lspia`]: D = μ I with 0 < μ < 2/λ_max(AᵀA) (Deng, Lin 2014), by default 1 over the
//!   largest column sum, as their 2 is on the edge of stability;
//! - [`Variant::ConjugateGradients`]: CGLS for each coordinate, preconditioned with the diagonal D;
//! - [`Variant::Direct`]: `D = (AᵀA)⁻¹`, so that level 1 is the minimum.
//!
//! Control points without data (a zero column of A) stay where they are. The fit ends at its
//! minimum, which is hardly ever within the tolerance: [`end`] says when it is there. A level costs
//! one application of A and one of Aᵀ.
//!
//! - [`start`]: level 0; [`steps`]: steps along the gradient, and what all variants share;
//! - [`conjugate`]: conjugate gradients; [`solver`]: the normal equations, solved;
//! - [`objective`]: the objective, with [`fairness`], which the data may choose ([`cross_validation`]), and the
//!   stiffness of [`gaps`]; [`end`]: its distance from the minimum;
//! - [`constraints`]: the conditions of every level.

mod conjugate;
pub(crate) mod constrained;
pub(crate) mod constrained_surface;
pub(crate) mod constraints;
pub(crate) mod cross_validation;
mod end;
pub(crate) mod fair_surface;
mod fairness;
mod gaps;
mod objective;
mod settings;
mod solver;
mod start;
mod steps;

use std::sync::Arc;

use super::algorithm::{Algorithm, Demand, Scope};
use super::equations::Equations;
use super::update::Update;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place, Setting};
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::setup::Setup;
use crate::warning::Warning;
use constraints::independent;
use fairness::Energy;
use steps::Steps;

pub use constraints::MOST_CONDITIONS;
pub use constraints::{At, Constraint, Wanted};
pub use settings::{
    AS_MANY_AS_DATA, BY_KNOTS, EndPoints, Fairness, KnotSelection, LeastSquares, Variant,
};

/// The most control points for each data point of a direction of a fair fit.
const FAIR: usize = 2;

/// Square matrices of conditions that are there at the same time: of each metric `C M Cᵀ` and its
/// factor.
const MATRICES: usize = 4;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "least_squares",
    title: "Least-squares PIA (LSPIA)",
    summary: "Fewer control points than data points approach the least-squares approximation.",
    source: "Deng, Lin, CAD 47 (2014); Lin, Cao, Zhang, CAGD 64 (2018)",
};

impl LeastSquares {
    /// There are no more control points than data points of a direction, unless fairness determines
    /// the others.
    fn check_count(&self, axis: Axis, free: usize, count: usize) -> Result<(), Invalid> {
        let most = count * if self.fairness().is_some() { FAIR } else { 1 };
        if (2..=most).contains(&free) {
            Ok(())
        } else {
            Err(Invalid::at(
                Place::ControlPoints(axis),
                format!(
                    "{free} control points for {count} data points: give at least 2 and at most {count}, or up to {twice} together with \"fairness\"",
                    twice = 2 * count
                ),
            ))
        }
    }

    /// There are no more control points than scattered points, unless fairness determines the others.
    fn check_scattered(&self, count: usize) -> Result<(), Invalid> {
        let most = count * if self.fairness().is_some() { FAIR } else { 1 };
        let (rows, columns) = (self.u, self.v);
        match rows.saturating_mul(columns) <= most {
            true => Ok(()),
            false => Err(Invalid::at(
                Place::Points,
                format!(
                    "{rows} × {columns} control points need at least as many points, {count} given"
                ),
            )),
        }
    }

    /// What the choice of fairness by the data cannot be combined with.
    fn check_chosen(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        let found = match scope {
            _ if scope.is_surface && self.ends == EndPoints::Interpolated => {
                "a surface whose data choose it does not pass through corners: leave end_points out, or give a number"
            }
            _ if scope.is_surface && self.automatic.is_some() => {
                "control_points \"auto\" do not smooth a surface: give their numbers"
            }
            _ if !self.constraints.is_empty() => {
                "with constraints or corners it is not chosen by the data: give a number"
            }
            _ if self.automatic.is_some() => {
                "control_points \"auto\" with a tolerance do not smooth: give their number, or leave the tolerance out"
            }
            _ => return Ok(()),
        };
        Err(Invalid::at(
            Place::Setting(Setting::Fairness),
            format!("fairness is \"auto\": {found}"),
        ))
    }

    /// Gaps are those of surfaces.
    fn check_gaps(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        let wrong =
            |detail: String| Err(Invalid::at(Place::Setting(Setting::GapStiffness), detail));
        match self.gap_stiffness {
            Some(value) if !(value.is_finite() && value >= 0.0) => wrong(format!(
                "gap_stiffness is {value}; it is a finite number, zero or greater"
            )),
            Some(_) if !scope.is_surface => {
                wrong("gap_stiffness is that of surfaces, and this is a curve".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Room for the matrix of conditions and its factors, with both metrics.
    fn bytes(&self) -> usize {
        let along = |constraint: &Constraint| match &constraint.wanted {
            Wanted::Across { control_points, .. } => control_points.len(),
            _ => 1,
        };
        let conditions = 4 + self.constraints.iter().map(along).sum::<usize>();
        let numbers = conditions.saturating_mul(conditions);
        numbers.saturating_mul(MATRICES * size_of::<f64>())
    }
}

impl Algorithm for LeastSquares {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// A given μ must be positive; one that is too large makes the residual grow.
    fn check(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        let lines = [(Axis::U, self.u), (Axis::V, self.v)];
        let fixed = self.automatic.is_none();
        let lines = lines.into_iter().filter(|_| fixed);
        for (axis, free) in lines.take(1 + usize::from(scope.is_surface)) {
            let count = match scope.is_scattered {
                true => scope.grid.count(),
                false => scope.grid.along(axis),
            };
            self.check_count(axis, free, count)?;
        }
        if scope.is_scattered && fixed {
            self.check_scattered(scope.grid.count())?;
        }
        if let Variant::Lspia { mu: Some(mu) } = self.variant {
            Invalid::unless_positive(Setting::Mu, mu)?;
        }
        if let Some(fairness) = self.fairness {
            fairness.check()?;
            if fairness.by_data {
                self.check_chosen(scope)?;
            }
        }
        self.check_gaps(scope)?;
        self.check_weights(scope.grid.count())
    }

    /// Conditions can be obeyed, and the normal equations solved if they have to be: those of a surface
    /// with holes, weights or fairness are those of the whole grid.
    fn check_convergence(&self, setup: &Setup) -> Result<(), Invalid> {
        independent(setup, self)?;
        let weighted = setup.is_homogeneous() || setup.directions().any(Direction::is_rational);
        if self.has_energy() {
            if weighted {
                return Err(Invalid::at(
                    Place::Setting(Setting::Fairness),
                    "fairness is that of polynomial curves and surfaces: this one has weights",
                ));
            }
            // Derivatives are those of B-splines.
            if setup.directions().any(|it| it.basis.knots().is_none()) {
                return Err(Invalid::at(
                    Place::Setting(Setting::Fairness),
                    "fairness needs derivatives, which B-splines and Bernstein polynomials have here",
                ));
            }
        }
        let direct = self.variant == Variant::Direct;
        let whole = solver::is_whole(setup, self.is_separable());
        if direct && whole && solver::cost(setup, self) > solver::MAX_SURFACE_MULTIPLICATIONS {
            return Err(Invalid::at(
                Place::Method,
                "direct has to factorize the normal equations of the whole surface here, and there are too many control points for that: use cg",
            ));
        }
        Ok(())
    }

    /// The factorization of the normal equations, also for the lengths of tangents, and the matrix of fairness.
    fn start_cost(&self, setup: &Setup) -> usize {
        let fairness = self.fairness();
        let fairness = fairness.map_or(0, |it| Energy::cost(setup, it.order));
        match self.variant == Variant::Direct || self.has_tangents() {
            true => fairness.saturating_add(solver::cost(setup, self)),
            false => fairness,
        }
    }

    /// The requested numbers of control points.
    fn control_points(&self) -> Option<(usize, usize)> {
        Some((self.u, self.v))
    }

    /// Points without data have no residual, and no effect.
    fn fits_holes(&self) -> bool {
        true
    }

    /// Each point has a row of the matrix of its own.
    fn fits_scattered(&self) -> bool {
        true
    }

    /// The gradient, for conjugate gradients the direction and its image, and the factorization that measures the
    /// distance to the minimum.
    fn demand(&self) -> Demand {
        Demand {
            vectors: if self.fairness().is_some() {
                3 * FAIR
            } else {
                3
            },
            matrices: 8,
            bytes: self.bytes(),
        }
    }

    /// Control points with a zero column of A, and a tangent that the data run against.
    fn complete(&self, equations: &mut Equations) {
        if self.automatic.is_some() {
            return;
        }
        equations.forecast.without_data = Steps::without_data(equations, self);
        if self.has_tangents() {
            equations.forecast.reversed = Steps::new(equations, self).reversed();
        }
    }

    /// Samples of the data, or means of scattered points.
    fn start(&self, equations: &Equations) -> Arc<Points> {
        Arc::new(match equations.setup.is_scattered() {
            true => start::means(equations),
            false => start::start(&equations.setup),
        })
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        Box::new(Steps::new(equations, self))
    }

    /// They end at the minimum, wherever that is, and nothing falls to zero.
    fn decays(&self) -> bool {
        false
    }

    /// At the minimum.
    fn ends_by_itself(&self) -> bool {
        true
    }

    /// Control points without data, and tangents that the data run against.
    fn warnings(
        &self,
        forecast: &Forecast,
        _predicted: Option<usize>,
        _iterations: usize,
    ) -> Vec<Warning> {
        let count = forecast.without_data;
        let lost = (count > 0).then_some(Warning::WithoutData { count });
        let reversed = forecast.reversed;
        let reversed = reversed.map(|index| Warning::ReversedTangent { index });
        lost.into_iter().chain(reversed).collect()
    }
}
