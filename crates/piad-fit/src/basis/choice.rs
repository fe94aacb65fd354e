//! Requested settings of one direction of the parameter domain.
//!
//! A curve has one direction, a surface two, whose bases, parameters and closedness are independent
//! of each other.

use std::sync::Arc;

use super::Polynomial;
use super::end_conditions::MOST_ESTIMATED;
use super::end_conditions::{End, Ends};
use super::knots::Knots;
use crate::data::corners;
use crate::parameters::Parametrization;

/// The requested basis of one direction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum BasisChoice {
    /// Polynomials of degree control points − 1.
    Polynomial(Polynomial),
    /// B-splines.
    BSpline {
        /// The degree p ≥ 1.
        degree: usize,
        /// The rule for the knots.
        knots: Knots,
    },
}

/// The data points with corners, which the curve interpolates.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Corners {
    /// The points with these increasing indices.
    At(Arc<[usize]>),
    /// Points at which the polygon turns by more than this angle in degrees (`data::corners`).
    Found(f64),
}

impl Corners {
    /// Points at which the polygon turns by more than the default 30 degrees.
    pub const USUAL: Self = Self::Found(corners::USUAL_ANGLE);

    /// The indices of the points, if they are known.
    pub fn indices(&self) -> &[usize] {
        match self {
            Self::At(indices) => indices,
            Self::Found(_) => &[],
        }
    }
}

/// The requested settings of one direction of the parameter domain.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionChoice {
    /// The basis.
    pub basis: BasisChoice,
    /// The parameters of the data points.
    pub parameters: Parametrization,
    /// The last point is followed by the first.
    pub closed: bool,
    /// The number of control points of a least-squares fit; otherwise one for each data point.
    pub control_points: Option<usize>,
    /// End conditions, with knots at the data; the default if `None`.
    pub ends: Option<Ends>,
    /// Its corners, or the creases across it, if it may have them.
    pub corners: Option<Corners>,
    /// Fixed weights: one for each control point, end copies included, or one for each data point.
    pub weights: Option<Vec<f64>>,
}

impl BasisChoice {
    /// The number of control points that explicit knots imply.
    pub(crate) fn implied_control_points(&self) -> Option<usize> {
        match self {
            Self::BSpline {
                degree,
                knots: Knots::Explicit(knots),
            } => Some(knots.len().saturating_sub(degree + 1)),
            _ => None,
        }
    }
}

impl DirectionChoice {
    /// An open direction with one control point for each data point, and without weights.
    pub fn new(basis: BasisChoice, parameters: Parametrization) -> Self {
        Self {
            basis,
            parameters,
            closed: false,
            control_points: None,
            ends: None,
            corners: None,
            weights: None,
        }
    }

    /// Returns true if its data determine its knots, with a given number of control points.
    pub(crate) fn is_adaptive(&self) -> bool {
        matches!(
            self.basis,
            BasisChoice::BSpline {
                knots: Knots::Adaptive,
                ..
            }
        )
    }

    /// Fills in the default knots and ends for a control point for each of `count` data points: knots at the data for
    /// odd degrees, whose ends are estimated, and averaged knots for even ones. Closed directions have their knots by
    /// the data.
    pub(crate) fn settle(&mut self, count: usize) {
        let BasisChoice::BSpline { degree, knots } = &mut self.basis else {
            return;
        };
        if self.corners.is_some() {
            return;
        }
        if *knots == Knots::Usual {
            // Averaged knots need more points than the degree.
            let averaged = !self.closed && degree.is_multiple_of(2) && *degree < count;
            *knots = if averaged {
                Knots::Averaged
            } else {
                Knots::Data
            };
        }
        if *knots == Knots::Data && !self.closed && self.ends.is_none() {
            let estimated = *degree <= MOST_ESTIMATED;
            let end = if estimated {
                End::Estimated
            } else {
                End::Repeated
            };
            self.ends = Some(Ends::both(end));
        }
    }

    /// Fills in the default knots of a least-squares fit: open directions spread them.
    pub(crate) fn settle_least_squares(&mut self) {
        self.name_open(Knots::Spread);
    }

    /// Fills in this rule for the knots of an open direction.
    pub(crate) fn name_open(&mut self, rule: Knots) {
        if let BasisChoice::BSpline { knots, .. } = &mut self.basis
            && *knots == Knots::Usual
            && !self.closed
        {
            *knots = rule;
        }
    }

    /// Resets knots and ends that belong to other methods to the default of least squares.
    pub fn unsettle(&mut self) {
        if let BasisChoice::BSpline { knots, .. } = &mut self.basis
            && matches!(knots, Knots::Data | Knots::Averaged)
        {
            *knots = Knots::Usual;
        }
        self.ends = None;
    }

    /// Resets knots that belong to least squares to the default of another method.
    pub fn unsettle_least_squares(&mut self) {
        if let BasisChoice::BSpline { knots, .. } = &mut self.basis
            && matches!(knots, Knots::Spread | Knots::Adaptive)
        {
            *knots = Knots::Usual;
        }
    }

    /// Returns true if eigenvalues of the collocation matrix may nearly coincide, so that its eigenvectors are nearly
    /// parallel and eigenvalues predict single levels badly.
    pub(crate) fn is_clustered(&self) -> bool {
        let BasisChoice::BSpline { degree, knots } = &self.basis else {
            return true;
        };
        let averaged = matches!(knots, Knots::Averaged) || self.closed || self.corners.is_some();
        degree % 2 == 0 && !averaged
    }
}
