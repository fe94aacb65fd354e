//! Bases: the functions that are blended with the control points.
//!
//! A curve is `C(t) = Σ_j X_j B_j(t)`. All bases here are normalized, `Σ_j B_j(t) = 1`, and not
//! negative, so that a curve lies in the convex hull of its control points. A basis is totally
//! positive if all minors of its collocation matrices are at least zero; then PIA converges (LBW05,
//! Theorem 2.1).
//!
//! | basis | functions | at one parameter | totally positive |
//! |---|---|---|---|
//! | Bernstein, degree m | m + 1 on [0, 1] | all | yes |
//! | Said–Ball, degree m | m + 1 on [0, 1] | all | yes |
//! | Wang–Ball, degree m | m + 1 on [0, 1] | all | up to degree 3 |
//! | B-spline, degree p | knots − p − 1 | p + 1 | yes |
//!
//! - `bernstein`, `ball` and `bspline`: the bases, one file for each family; `bezier`: Ball bases as Bernstein's;
//! - `knots`: where knots are placed, and `given_knots`: validation of given ones;
//! - `pieces`: curves in pieces that meet at corners;
//! - `choice` and `end_conditions`: requested settings of a direction; `direction`: a basis at the parameters of the
//!   data;
//! - `evaluated`: the functions at parameters; `functional` and `quadrature`: values, derivatives and integrals.

pub(crate) mod ball;
pub(crate) mod bernstein;
pub(crate) mod bezier;
pub(crate) mod bspline;
pub(crate) mod choice;
pub(crate) mod direction;
pub(crate) mod end_conditions;
pub(crate) mod evaluated;
pub(crate) mod functional;
pub(crate) mod given_knots;
pub(crate) mod knots;
pub(crate) mod pieces;
pub(crate) mod quadrature;

use std::borrow::Cow;
use std::sync::Arc;

use super::kind_info::KindInfo;

pub use choice::{BasisChoice, Corners};
pub use end_conditions::{End, Ends};
pub use knots::Knots;

/// All bases, in the order in which they are listed.
#[doc(hidden)]
pub const BASES: [&KindInfo; 4] = [
    &bspline::INFO,
    &bernstein::INFO,
    &ball::SAID_BALL,
    &ball::WANG_BALL,
];

/// The highest degree that is accepted: up to here the evaluation is checked to full accuracy.
pub const MAX_DEGREE: usize = 1000;

/// A normalized basis (its functions sum to one) of one direction.
///
/// ```
/// use piad_fit::basis::{Basis, Polynomial};
///
/// let cubic = Basis::Polynomial { kind: Polynomial::Bernstein, degree: 3 };
/// let mut values = [0.0; 4];
/// assert_eq!(cubic.evaluate(0.5, &mut values), 0);
/// assert_eq!(values, [0.125, 0.375, 0.375, 0.125]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Basis {
    /// Polynomials on [0, 1]: `degree + 1` functions.
    Polynomial {
        /// Which polynomials.
        kind: Polynomial,
        /// The degree m.
        degree: usize,
    },
    /// B-splines: `knots.len() − degree − 1` functions on the interval from knot `degree` to knot
    /// `knots.len() − degree − 1`.
    BSpline {
        /// The degree p ≥ 1.
        degree: usize,
        /// Non-decreasing knots. Open curves: the first and the last p + 1 are equal. Closed ones:
        /// the knots of a period, continued periodically by p on both sides.
        knots: Arc<Vec<f64>>,
    },
}

/// A basis of the polynomials of some degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Polynomial {
    /// Bernstein polynomials: Bézier curves.
    Bernstein,
    /// The Said–Ball basis.
    SaidBall,
    /// The Wang–Ball basis.
    WangBall,
}

impl Polynomial {
    /// Its names and source.
    pub fn info(self) -> &'static KindInfo {
        match self {
            Self::Bernstein => &bernstein::INFO,
            Self::SaidBall => &ball::SAID_BALL,
            Self::WangBall => &ball::WANG_BALL,
        }
    }

    /// The name of the kind of basis.
    pub fn name(self) -> &'static str {
        self.info().name
    }
}

impl Basis {
    /// Its names and source.
    pub fn info(&self) -> &'static KindInfo {
        match self {
            Self::Polynomial { kind, .. } => kind.info(),
            Self::BSpline { .. } => &bspline::INFO,
        }
    }

    /// The name of the kind of basis.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// The polynomial degree.
    pub fn degree(&self) -> usize {
        match self {
            Self::Polynomial { degree, .. } | Self::BSpline { degree, .. } => *degree,
        }
    }

    /// The number of basis functions, one for each control point.
    pub fn functions(&self) -> usize {
        match self {
            Self::Polynomial { degree, .. } => degree + 1,
            Self::BSpline { degree, knots } => knots.len() - degree - 1,
        }
    }

    /// The interval on which the basis is defined, both ends included.
    pub fn domain(&self) -> (f64, f64) {
        match self {
            Self::Polynomial { .. } => (0.0, 1.0),
            Self::BSpline { degree, knots } => (knots[*degree], knots[knots.len() - degree - 1]),
        }
    }

    /// The number of consecutive functions that can differ from zero at one parameter: `degree + 1`.
    pub fn support_width(&self) -> usize {
        self.degree() + 1
    }

    /// The approximate number of multiplications of [`evaluate`](Self::evaluate).
    pub fn multiplications(&self) -> usize {
        let width = self.support_width();
        match self {
            Self::Polynomial { .. } => 2 * width,
            Self::BSpline { .. } => 3 * width * width / 2,
        }
    }

    /// Returns true if only a few functions differ from zero at a parameter.
    pub fn is_local(&self) -> bool {
        matches!(self, Self::BSpline { .. })
    }

    /// Writes the values at `t` of the functions that can differ from zero there into `values`
    /// (`support_width` numbers) and returns the index of the first of them.
    ///
    /// `t` lies in the [domain](Self::domain); at its right end the basis is continuous from the
    /// left. It costs O(p²) for B-splines of degree p, and O(m) for polynomials of degree m.
    pub fn evaluate(&self, t: f64, values: &mut [f64]) -> usize {
        match self {
            Self::Polynomial { kind, degree } => {
                match kind {
                    Polynomial::Bernstein => bernstein::evaluate(*degree, t, values),
                    Polynomial::SaidBall => ball::said_ball(*degree, t, values),
                    Polynomial::WangBall => ball::wang_ball(*degree, t, values),
                }
                0
            }
            Self::BSpline { degree, knots } => {
                let span = bspline::find_span(*degree, knots, t);
                bspline::evaluate(*degree, knots, span, t, values);
                span - degree
            }
        }
    }

    /// The knot vector with which a CAD kernel stores the curve, functions + degree + 1 numbers.
    /// Bernstein polynomials are the B-splines without interior knots; the Ball bases are no
    /// B-splines.
    pub fn knots(&self) -> Option<Cow<'_, [f64]>> {
        match self {
            Self::Polynomial {
                kind: Polynomial::Bernstein,
                degree,
            } => {
                let mut knots = vec![0.0; degree + 1];
                knots.resize(2 * (degree + 1), 1.0);
                Some(knots.into())
            }
            Self::Polynomial { .. } => None,
            Self::BSpline { knots, .. } => Some(Cow::Borrowed(knots)),
        }
    }
}
