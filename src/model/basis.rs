//! Requested bases, knots and parameters.

use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Serialize};

use super::errors::{OrErrors, SpecPart, ValidationError, ValidationErrors};
use super::named::{Named, Rule, names, rules};
use super::schema::{self, schema_of};
use super::serde_helpers::{object, whole};
use piad_fit::basis::{BasisChoice, Knots, MAX_DEGREE, Polynomial};
use piad_fit::invalid::{self as fit, Axis};
use piad_fit::parameters::Parametrization;

/// The default degree of a B-spline.
pub(crate) const DEFAULT_DEGREE: usize = 3;

/// A kind of basis.
#[derive(Clone, Copy, Debug, Default, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(example = &"bspline")]
#[allow(missing_docs, reason = "schemas repeat the documentation of a value")]
pub(crate) enum BasisKind {
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

rules!(
    /// The requested knots of a B-spline.
    KnotsInput(Knots), "rule for knots", [
    "data" => Data,
    "averaged" => Averaged,
    "spread" => Spread,
    "adaptive" => Adaptive,
]);

rules!(
    /// The requested parameters of data points.
    ParametersInput(Parametrization), "rule for parameters", [
    "chord_length" => ChordLength,
    "centripetal" => Centripetal,
    "uniform" => Uniform,
]);

/// The functions that are blended with the control points.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(transform = schema::basis, example = schema::example_basis())]
pub(crate) struct Basis {
    /// The kind of the basis.
    pub kind: BasisKind,
    /// The degree.
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(range(min = 1, max = MAX_DEGREE), extend("default" = DEFAULT_DEGREE))]
    pub degree: Option<usize>,
    /// The knots, where the pieces meet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub knots: Option<KnotsInput>,
}

object!(
    Basis,
    "an object with a kind, or the name of a kind",
    "kind"
);

impl Basis {
    /// A B-spline of this degree.
    pub(crate) fn of_degree(degree: usize) -> Self {
        Self {
            degree: Some(degree),
            ..Self::default()
        }
    }

    /// The same with this degree, if it is a B-spline of which neither the degree nor the knots are given.
    pub(super) fn or_degree(self, degree: usize) -> Self {
        let is_open = self.degree.is_none() && self.knots.is_none();
        match self.kind {
            BasisKind::Bspline if is_open => Self::of_degree(degree),
            _ => self,
        }
    }

    /// The basis of a direction.
    pub(super) fn choice(self, axis: Axis) -> OrErrors<BasisChoice> {
        let kind = match self.kind {
            BasisKind::Bspline => {
                return Ok(BasisChoice::BSpline {
                    degree: self.degree.unwrap_or(DEFAULT_DEGREE),
                    knots: self.knots.map_or(Knots::Usual, |KnotsInput(knots)| knots),
                });
            }
            BasisKind::Bernstein => Polynomial::Bernstein,
            BasisKind::SaidBall => Polynomial::SaidBall,
            BasisKind::WangBall => Polynomial::WangBall,
        };
        let degree = self.degree.map(|_| ("degree", fit::Place::Degree(axis)));
        let knots = self.knots.map(|_| ("knots", fit::Place::Knots(axis)));
        let mut errors = ValidationErrors::default();
        for (field, place) in degree.into_iter().chain(knots) {
            let detail = format!(
                "a {} basis has no {field} to choose: its degree is control points − 1",
                self.kind.name()
            );
            errors.push(ValidationError::at(SpecPart::Fit(place), detail));
        }
        errors.or(BasisChoice::Polynomial(kind))
    }
}

/// A basis in the form of a request.
impl From<&BasisChoice> for Basis {
    fn from(choice: &BasisChoice) -> Self {
        let kind = match choice {
            BasisChoice::BSpline { degree, knots } => {
                return Self {
                    knots: (*knots != Knots::Usual).then(|| KnotsInput(knots.clone())),
                    ..Self::of_degree(*degree)
                };
            }
            BasisChoice::Polynomial(Polynomial::Bernstein) => BasisKind::Bernstein,
            BasisChoice::Polynomial(Polynomial::SaidBall) => BasisKind::SaidBall,
            BasisChoice::Polynomial(Polynomial::WangBall) => BasisKind::WangBall,
        };
        Self {
            kind,
            ..Self::default()
        }
    }
}

schema_of!(
    ParametersInput,
    "ParameterChoice",
    json_schema!({
        "description": "How the data points get their parameters: a rule, or strictly increasing numbers, one for each point; for a closed curve one more, at which it is back at the first.",
        "oneOf": [
            {"type": "string", "enum": <Self as Rule>::names()},
            {"type": "array", "items": {"type": "number"}, "minItems": 2},
        ],
        "default": "chord_length",
        "examples": ["centripetal", [0, 0.2, 0.7, 1]],
    })
);

/// A B-spline of this degree with defaults.
pub(super) enum Degree {}

schema_of!(
    Degree,
    "Degree",
    json_schema!({
        "description": "The degree of a B-spline.",
        "type": "integer",
        "minimum": 1,
        "maximum": MAX_DEGREE,
        "examples": [3],
    })
);

schema_of!(
    KnotsInput,
    "KnotChoice",
    json_schema!({
        "description": "Where the pieces of a B-spline meet: at the parameters of the data, at averages of them, or at the numbers of a clamped knot vector. Open least-squares fits spread them over equal shares of the data's indices, which do not depend on the direction of the data (\"spread\"); of curves they can place them where the data ask for them (\"adaptive\").",
        "oneOf": [
            {"type": "string", "enum": <Self as Rule>::names()},
            {"type": "array", "items": {"type": "number"}, "minItems": 4},
        ],
        "examples": ["data", [0, 0, 0, 0, 1, 1, 1, 1]],
    })
);
