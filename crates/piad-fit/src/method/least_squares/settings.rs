//! Settings of a least-squares fit.

use std::sync::Arc;

use super::constraints::{Constraint, Wanted};
use crate::basis::choice::BasisChoice;
use crate::invalid::{Invalid, Place, Setting, one_for_each};

/// The number of control points where only the data limit it.
pub const AS_MANY_AS_DATA: usize = usize::MAX;

/// The number of control points of a direction that its explicit knots imply.
pub const BY_KNOTS: usize = usize::MAX - 1;

/// The stiffness of gaps of fits with fairness, where none is given.
const GAP_STIFFNESS: f64 = 1e-6;

/// A least-squares fit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LeastSquares {
    /// The number of control points of a curve, or in the u direction; the most of an automatic fit.
    pub u: usize,
    /// The number of control points in the v direction of a surface.
    pub v: usize,
    /// Settings of a fit that chooses the number of control points, and the knots, itself.
    pub automatic: Option<KnotSelection>,
    /// How the control points move.
    pub variant: Variant,
    /// The choice to interpolate the end points.
    pub ends: EndPoints,
    /// Constraints of every level, besides the end points.
    pub constraints: Arc<[Constraint]>,
    /// The fairness, at the cost of distances.
    pub fairness: Option<Fairness>,
    /// The multiple g of the membrane energy over the spans of a surface that have no data, free of units like that of
    /// fairness: see `super::gaps`. Without it there is some with fairness.
    pub gap_stiffness: Option<f64>,
    /// The weight of each data point; `None` means 1.
    pub data_weights: Option<Arc<[f64]>>,
    /// True if outliers are left out.
    #[cfg_attr(feature = "serde", serde(default))]
    pub robust: bool,
}

/// Settings of a fit that chooses the number of its control points and its knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KnotSelection {
    /// True if parameters move to the foot points of their data.
    pub correct_parameters: bool,
}

impl LeastSquares {
    /// With at most u × v control points, and as few of them as the tolerance needs.
    pub fn automatic(u: usize, v: usize) -> Self {
        Self {
            automatic: Some(KnotSelection::default()),
            ..Self::new(u, v)
        }
    }

    /// Returns true if the schedule of knots can take steps of plain least squares: there are no constraints but
    /// the end points, and no fairness.
    pub(crate) fn is_plain(&self) -> bool {
        self.constraints.is_empty() && !self.has_energy() && self.ends != EndPoints::Free
    }

    /// The same of a surface, whose data all count alike.
    pub(crate) fn is_plain_surface(&self) -> bool {
        self.is_plain() && self.data_weights.is_none()
    }

    /// Returns true if nothing but distances and an energy of equally weighted points matters, so that all control points
    /// of a pole of a surface can be one.
    pub(crate) fn allows_poles(&self) -> bool {
        self.constraints.is_empty()
            && self.data_weights.is_none()
            && self.ends != EndPoints::Interpolated
    }

    /// This number of control points in each direction, and defaults for the rest.
    pub fn new(u: usize, v: usize) -> Self {
        Self {
            u,
            v,
            automatic: None,
            variant: Variant::ConjugateGradients,
            ends: EndPoints::Usual,
            constraints: Arc::new([]),
            fairness: None,
            gap_stiffness: None,
            data_weights: None,
            robust: false,
        }
    }

    /// The same with the numbers of control points that the bases of both directions imply.
    pub(crate) fn with_counts<'a>(
        &self,
        bases: impl IntoIterator<Item = &'a BasisChoice>,
    ) -> Result<Self, Invalid> {
        let mut settings = self.clone();
        let counts = [&mut settings.u, &mut settings.v];
        for (count, basis) in counts.into_iter().zip(bases) {
            if *count == BY_KNOTS {
                *count = basis.implied_control_points().ok_or_else(|| Invalid::at(
                    Place::Method,
                    "least_squares needs control_points: their number, on surfaces also {\"u\": …, \"v\": …}, or \"auto\"; only explicit knots imply it",
                ))?;
            }
        }
        if settings.v == BY_KNOTS {
            settings.v = settings.u;
        }
        Ok(settings)
    }

    /// The same without weights of data and constraints.
    pub(crate) fn outline(&self) -> Self {
        Self {
            constraints: Arc::new([]),
            data_weights: None,
            ..self.clone()
        }
    }

    /// Weights of data are finite and not negative, one for each point, and some of them are greater than zero.
    pub(crate) fn check_weights(&self, expected: usize) -> Result<(), Invalid> {
        let Some(weights) = self.data_weights.as_deref() else {
            return Ok(());
        };
        let given = weights.len();
        if given != expected {
            return Err(Invalid::at(
                Place::Setting(Setting::DataWeights),
                one_for_each(given, "weights of data", expected),
            ));
        }
        let wrong = |weight: &f64| !(weight.is_finite() && *weight >= 0.0);
        if let Some(index) = weights.iter().position(wrong) {
            let value = weights[index];
            return Err(Invalid::at(
                Place::DataWeight(index),
                format!(
                    "data weight {index} is {value}; weights of data are finite and not negative"
                ),
            ));
        }
        match weights.iter().any(|weight| *weight > 0.0) {
            true => Ok(()),
            false => Err(Invalid::at(
                Place::Setting(Setting::DataWeights),
                "all weights of data are zero, so that no data point counts",
            )),
        }
    }

    /// Advice on how to bring a minimum nearer to the data.
    pub(crate) fn advice_at_minimum(&self) -> String {
        let mut advice = match self.automatic {
            Some(_) => vec![
                "those with more control points that were tried are no nearer: use a larger tolerance",
            ],
            None => vec!["use more control points, or \"auto\" for as many as the tolerance needs"],
        };
        if self.fairness().is_some() {
            advice.push("less fairness");
        }
        if !self.constraints.is_empty() {
            advice.push("fewer constraints");
        }
        if self.automatic.is_some() && self.fairness().is_none() {
            advice.push("a number of control points");
        }
        advice.join(", or ")
    }

    /// Returns true if all data points count alike, and nothing but their distances does.
    pub(super) fn is_separable(&self) -> bool {
        self.data_weights.is_none() && !self.has_energy()
    }

    /// Returns true if a constraint gives the direction of a derivative.
    pub(super) fn has_tangents(&self) -> bool {
        let is_tangent = |constraint: &Constraint| matches!(constraint.wanted, Wanted::Tangent(_));
        self.constraints.iter().any(is_tangent)
    }

    /// Returns true if the fit minimizes more than distances.
    pub(super) fn has_energy(&self) -> bool {
        self.fairness().is_some() || self.gap_stiffness().is_some()
    }

    /// The stiffness of gaps, if it matters.
    pub(super) fn gap_stiffness(&self) -> Option<f64> {
        let usual = self.fairness().map(|_| GAP_STIFFNESS);
        self.gap_stiffness
            .or(usual)
            .filter(|stiffness| *stiffness > 0.0)
    }

    /// Fairness, if it matters.
    pub(super) fn fairness(&self) -> Option<Fairness> {
        self.fairness
            .filter(|fairness| fairness.value > 0.0 || fairness.by_data)
    }
}

/// The choice of a curve to pass through its first and last data point, and of a surface to pass through its four
/// corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum EndPoints {
    /// They are interpolated where there are ends.
    Usual,
    /// They are interpolated; a closed direction has none.
    Interpolated,
    /// They are data points like others.
    Free,
}

/// A multiple of the integral of a squared derivative is added to the sum of squares.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fairness {
    /// The multiple f, free of units, of the integral over parameters scaled to [0, 1], beside the mean of the squared
    /// distances: see `super::fairness`.
    pub value: f64,
    /// The order r of the derivative, 2 or 3.
    pub order: usize,
    /// True if the data choose the value, and replace the one that is given: see `super::cross_validation`.
    #[cfg_attr(feature = "serde", serde(default))]
    pub by_data: bool,
}

/// The variants of the least-squares update.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Variant {
    /// `X ← X + D Aᵀ Δ` with D = diag(1 / column sums of A).
    Diagonal,
    /// `X ← X + μ Aᵀ Δ`; without μ it is 1 / (largest column sum of A).
    Lspia {
        /// The given μ > 0.
        mu: Option<f64>,
    },
    /// Conjugate gradients (CGLS), preconditioned with the same D.
    #[cfg_attr(feature = "serde", serde(rename = "cg"))]
    ConjugateGradients,
    /// The normal equations are solved.
    Direct,
}

impl Fairness {
    /// By the second derivative, with a weight that the data determine.
    pub const BY_DATA: Self = Self {
        value: 0.0,
        order: 2,
        by_data: true,
    };

    /// Refuses values and orders out of their range.
    pub(super) fn check(self) -> Result<(), Invalid> {
        let Self { value, order, .. } = self;
        if !(value.is_finite() && value >= 0.0) {
            return Err(Invalid::at(
                Place::Setting(Setting::Fairness),
                format!("fairness is {value}; it is a finite number, zero or greater"),
            ));
        }
        match order {
            2 | 3 => Ok(()),
            _ => Err(Invalid::at(
                Place::Setting(Setting::FairnessOrder),
                format!("fairness_order is {order}; expected 2 or 3"),
            )),
        }
    }
}
