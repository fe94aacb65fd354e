//! A curve or a surface as it is asked for.

use std::sync::Arc;

use schemars::JsonSchema;

use super::method::MethodSpec;
use super::mistakes::{Mistake, Mistakes, OrMistakes, SpecPart};
use super::named::names;
use super::scattered::ScatteredSpec;
use super::stop::StopRules;
use super::weights::{Rational, WeightSpec, check_unused};
use crate::fit::basis::{Polynomial, knots::Knots};
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::ends::Ends;
use crate::fit::invalid::{self as fit, Axis};
use crate::fit::nurbs::Nurbs;
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{Request, Weights};

/// The most coordinates of a point.
pub const MAX_DIMENSION: usize = 3;

/// The degree of a B-spline if nobody says it.
pub const DEFAULT_DEGREE: usize = 3;

/// A kind of basis.
#[derive(Clone, Copy, Debug, Default, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(example = &"bspline")]
#[allow(missing_docs, reason = "schemas repeat what is said of a value")]
pub enum BasisKind {
    #[default]
    Bspline,
    Bernstein,
    SaidBall,
    WangBall,
}

names!(BasisKind, "kind of basis", [
    "bspline" => Bspline,
    "bernstein" => Bernstein,
    "said_ball" => SaidBall,
    "wang_ball" => WangBall,
]);

/// A basis as it is asked for.
#[derive(Clone, Debug, Default)]
pub struct BasisSpec {
    /// Its kind.
    pub kind: BasisKind,
    /// The degree, of B-splines.
    pub degree: Option<usize>,
    /// The knots, of B-splines.
    pub knots: Option<Knots>,
}

impl BasisSpec {
    /// The basis of a direction.
    fn choice(self, axis: Axis) -> OrMistakes<BasisChoice> {
        let kind = match self.kind {
            BasisKind::Bspline => {
                return Ok(BasisChoice::BSpline {
                    degree: self.degree.unwrap_or(DEFAULT_DEGREE),
                    knots: self.knots.unwrap_or(Knots::Usual),
                });
            }
            BasisKind::Bernstein => Polynomial::Bernstein,
            BasisKind::SaidBall => Polynomial::SaidBall,
            BasisKind::WangBall => Polynomial::WangBall,
        };
        let degree = self.degree.map(|_| ("degree", fit::Place::Degree(axis)));
        let knots = self.knots.map(|_| ("knots", fit::Place::Knots(axis)));
        let mut mistakes = Mistakes::default();
        for (field, place) in degree.into_iter().chain(knots) {
            let detail = format!(
                "a {} basis has no {field} to choose: its degree is control points − 1",
                kind.name()
            );
            mistakes.push(Mistake::at(SpecPart::Fit(place), detail));
        }
        mistakes.or(BasisChoice::Polynomial(kind))
    }
}

/// What is asked for in one direction of the parameter domain.
#[derive(Clone, Debug)]
pub struct AxisSpec {
    /// The basis.
    pub basis: OrMistakes<BasisSpec>,
    /// The parameters of the data points.
    pub parameters: Parametrization,
    /// Whether it is periodic.
    pub closed: bool,
    /// How it ends.
    pub ends: OrMistakes<Option<Ends>>,
}

/// A curve or a surface.
#[derive(Clone, Debug)]
pub struct ShapeSpec {
    /// The data points; of a surface row by row, with missing ones anywhere.
    pub points: Points,
    /// Their arrangement: n × 1 of a curve.
    pub grid: Grid,
    /// The indices of missing points.
    pub missing: Vec<usize>,
    /// How the points of a surface get their parameters if they are scattered: n × 1.
    pub scattered: Option<ScatteredSpec>,
    /// The direction of a curve, or u of a surface.
    pub u: AxisSpec,
    /// The direction v of a surface.
    pub v: Option<AxisSpec>,
    /// The weights.
    pub weights: OrMistakes<Option<WeightSpec>>,
}

/// The same with all that is usual where nothing is said.
pub(super) struct CheckedShape {
    points: Points,
    pub(super) grid: Grid,
    missing: Vec<usize>,
    scattered: Option<ScatteredSpec>,
    u: DirectionChoice,
    v: Option<DirectionChoice>,
    weights: Weights,
}

impl ShapeSpec {
    /// What there is of it, also if there are mistakes beside the points.
    pub(super) fn shape(
        self,
        rational: Option<Rational>,
        mistakes: &mut Mistakes,
    ) -> Option<CheckedShape> {
        let weights = self.weights.and_then(|weights| match weights {
            None => check_unused(rational).map(|()| Weights::None.into()),
            Some(weights) => weights.resolve(rational, self.grid),
        });
        let weights = mistakes.keep(weights).unwrap_or(Weights::None.into());
        let mut direction = |spec: AxisSpec, axis, weights| {
            let basis = spec.basis.and_then(|basis| basis.choice(axis));
            let (basis, ends) = (mistakes.keep(basis), mistakes.keep(spec.ends));
            Some(DirectionChoice {
                basis: basis?,
                parameters: spec.parameters,
                closed: spec.closed,
                control_points: None,
                ends: ends?,
                weights,
            })
        };
        let u = direction(self.u, Axis::U, weights.u);
        let v = self.v.map(|v| direction(v, Axis::V, weights.v));
        Some(CheckedShape {
            points: self.points,
            grid: self.grid,
            missing: self.missing,
            scattered: self.scattered,
            u: u?,
            v: match v {
                None => None,
                Some(v) => Some(v?),
            },
            weights: weights.weights,
        })
    }
}

impl CheckedShape {
    /// The problem of fitting it.
    pub(super) fn request(
        self,
        base: Result<&Nurbs, Mistake>,
        method: MethodSpec,
        rules: StopRules,
    ) -> OrMistakes<Request> {
        let scattered = self.scattered.map(|it| it.resolve(&self.points, base));
        Ok(Request {
            points: Arc::new(self.points),
            grid: self.grid,
            missing: self.missing,
            u: self.u,
            v: self.v,
            weights: self.weights,
            method: method.method,
            selected: method.selected,
            start: None,
            start_breaks: None,
            lambda_min: None,
            scattered: scattered.transpose()?,
            tolerance: rules.tolerance,
            max_iterations: rules.max_iterations,
        })
    }
}
