//! The JSON of bases, knots and parameters.

use std::sync::Arc;

use schemars::{JsonSchema, json_schema};
use serde::Deserialize;

use super::schema;
use crate::api::json::schema::schema_of;
use crate::fit::basis::{MAX_DEGREE, knots::Knots};
use crate::fit::parameters::Parametrization;
use crate::model::either::{RuleOrNumbers, object, whole};
use crate::model::named::{Named, names};
use crate::model::shape::{BasisKind, BasisSpec, DEFAULT_DEGREE};

/// The functions that are blended with the control points.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "Basis", transform = schema::basis, example = schema::example_basis())]
pub(in crate::api) struct BasisRequest {
    /// The kind of the basis.
    pub(in crate::api) kind: BasisKind,
    /// The degree.
    #[serde(default, deserialize_with = "whole")]
    #[schemars(range(min = 1, max = MAX_DEGREE), extend("default" = DEFAULT_DEGREE))]
    pub(in crate::api) degree: Option<usize>,
    /// Where the pieces meet.
    #[schemars(with = "Option<KnotChoice>")]
    pub(in crate::api) knots: Option<RuleOrNumbers<KnotRule>>,
}

/// Where the knots of a B-spline are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum KnotRule {
    Data,
    Averaged,
    Spread,
}

/// How data points get their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::api) enum ParameterRule {
    ChordLength,
    Centripetal,
    Uniform,
}

object!(
    BasisRequest,
    "an object with a kind, or the name of a kind",
    "kind"
);
names!(KnotRule, "rule for knots", [
    "data" => Data,
    "averaged" => Averaged,
    "spread" => Spread,
]);
names!(ParameterRule, "rule for parameters", [
    "chord_length" => ChordLength,
    "centripetal" => Centripetal,
    "uniform" => Uniform,
]);

impl BasisRequest {
    /// A basis of this kind, with its usual degree and knots.
    pub(in crate::api) fn of(kind: BasisKind) -> Self {
        Self {
            kind,
            degree: None,
            knots: None,
        }
    }

    /// A B-spline of this degree.
    pub(super) fn of_degree(degree: usize) -> Self {
        Self {
            degree: Some(degree),
            ..Self::of(BasisKind::Bspline)
        }
    }
}

impl From<BasisRequest> for BasisSpec {
    fn from(request: BasisRequest) -> Self {
        Self {
            kind: request.kind,
            degree: request.degree,
            knots: request.knots.map(|knots| match knots {
                RuleOrNumbers::Numbers(knots) => Knots::Explicit(Arc::new(knots)),
                RuleOrNumbers::Rule(KnotRule::Data) => Knots::Data,
                RuleOrNumbers::Rule(KnotRule::Averaged) => Knots::Averaged,
                RuleOrNumbers::Rule(KnotRule::Spread) => Knots::Spread,
            }),
        }
    }
}

pub(super) fn parametrization(
    request: Option<RuleOrNumbers<ParameterRule>>,
    usual: Parametrization,
) -> Parametrization {
    match request {
        None => usual,
        Some(RuleOrNumbers::Numbers(values)) => Parametrization::Explicit(Arc::new(values)),
        Some(RuleOrNumbers::Rule(rule)) => match rule {
            ParameterRule::ChordLength => Parametrization::ChordLength,
            ParameterRule::Centripetal => Parametrization::Centripetal,
            ParameterRule::Uniform => Parametrization::Uniform,
        },
    }
}

/// How data points get their parameters.
pub(super) enum Parameters {}

schema_of!(
    Parameters,
    "ParameterChoice",
    json_schema!({
        "description": "How the data points get their parameters: a rule, or strictly increasing numbers, one for each point; for a closed curve one more, at which it is back at the first.",
        "oneOf": [
            {"type": "string", "enum": ParameterRule::names()},
            {"type": "array", "items": {"type": "number"}, "minItems": 2},
        ],
        "default": "chord_length",
        "examples": ["centripetal", [0, 0.2, 0.7, 1]],
    })
);

/// The degree of a B-spline that is as usual otherwise.
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

/// Where the pieces of a B-spline meet.
pub(super) enum KnotChoice {}

schema_of!(
    KnotChoice,
    "KnotChoice",
    json_schema!({
        "description": "Where the pieces of a B-spline meet: at the parameters of the data, at averages of them, or at the numbers of a clamped knot vector. Open least-squares fits spread them over equal shares of the data's indices, which do not depend on the direction of the data (\"spread\").",
        "oneOf": [
            {"type": "string", "enum": KnotRule::names()},
            {"type": "array", "items": {"type": "number"}, "minItems": 4},
        ],
        "examples": ["data", [0, 0, 0, 0, 1, 1, 1, 1]],
    })
);
