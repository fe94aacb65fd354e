//! Bases, knots and parameters as they were asked for, as protobuf messages.

use std::sync::Arc;

use prost::{Enumeration, Message};

use super::super::StoreError;
use super::fields::number;
use crate::fit::basis::{Polynomial, knots::Knots};
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::parameters::Parametrization;

/// A direction as it was asked for.
#[derive(Clone, PartialEq, Message)]
pub(super) struct DirectionMessage {
    #[prost(enumeration = "BasisCode", tag = "1")]
    basis: i32,
    #[prost(uint64, tag = "2")]
    degree: u64,
    #[prost(enumeration = "KnotsCode", tag = "3")]
    knots: i32,
    #[prost(double, repeated, tag = "4")]
    knot_values: Vec<f64>,
    #[prost(enumeration = "ParametersCode", tag = "5")]
    parameters: i32,
    #[prost(double, repeated, tag = "6")]
    parameter_values: Vec<f64>,
    #[prost(bool, tag = "7")]
    closed: bool,
    #[prost(bool, tag = "8")]
    weighted: bool,
    #[prost(double, repeated, tag = "9")]
    weights: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum BasisCode {
    BSpline = 0,
    Bernstein = 1,
    SaidBall = 2,
    WangBall = 3,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum KnotsCode {
    Usual = 0,
    Data = 1,
    Averaged = 2,
    Explicit = 3,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum ParametersCode {
    ChordLength = 0,
    Centripetal = 1,
    Uniform = 2,
    Explicit = 3,
}

impl From<&DirectionChoice> for DirectionMessage {
    fn from(choice: &DirectionChoice) -> Self {
        let (basis, degree, knots, knot_values) = match &choice.basis {
            BasisChoice::Polynomial(kind) => {
                let basis = match kind {
                    Polynomial::Bernstein => BasisCode::Bernstein,
                    Polynomial::SaidBall => BasisCode::SaidBall,
                    Polynomial::WangBall => BasisCode::WangBall,
                };
                (basis, 0, KnotsCode::Usual, Vec::new())
            }
            BasisChoice::BSpline { degree, knots } => {
                let (code, values) = match knots {
                    Knots::Usual => (KnotsCode::Usual, Vec::new()),
                    Knots::Data => (KnotsCode::Data, Vec::new()),
                    Knots::Averaged => (KnotsCode::Averaged, Vec::new()),
                    Knots::Explicit(values) => (KnotsCode::Explicit, values.to_vec()),
                };
                (BasisCode::BSpline, *degree, code, values)
            }
        };
        let (parameters, parameter_values) = match &choice.parameters {
            Parametrization::ChordLength => (ParametersCode::ChordLength, Vec::new()),
            Parametrization::Centripetal => (ParametersCode::Centripetal, Vec::new()),
            Parametrization::Uniform => (ParametersCode::Uniform, Vec::new()),
            Parametrization::Explicit(values) => (ParametersCode::Explicit, values.to_vec()),
        };
        Self {
            basis: basis as i32,
            degree: degree as u64,
            knots: knots as i32,
            knot_values,
            parameters: parameters as i32,
            parameter_values,
            closed: choice.closed,
            weighted: choice.weights.is_some(),
            weights: choice.weights.clone().unwrap_or_default(),
        }
    }
}

impl TryFrom<DirectionMessage> for DirectionChoice {
    type Error = StoreError;

    fn try_from(message: DirectionMessage) -> Result<Self, StoreError> {
        let parameters = match message.parameters() {
            ParametersCode::ChordLength => Parametrization::ChordLength,
            ParametersCode::Centripetal => Parametrization::Centripetal,
            ParametersCode::Uniform => Parametrization::Uniform,
            ParametersCode::Explicit => {
                Parametrization::Explicit(Arc::new(message.parameter_values.clone()))
            }
        };
        let basis = match message.basis() {
            BasisCode::Bernstein => BasisChoice::Polynomial(Polynomial::Bernstein),
            BasisCode::SaidBall => BasisChoice::Polynomial(Polynomial::SaidBall),
            BasisCode::WangBall => BasisChoice::Polynomial(Polynomial::WangBall),
            BasisCode::BSpline => BasisChoice::BSpline {
                degree: number(message.degree)?,
                knots: match message.knots() {
                    KnotsCode::Usual => Knots::Usual,
                    KnotsCode::Data => Knots::Data,
                    KnotsCode::Averaged => Knots::Averaged,
                    KnotsCode::Explicit => Knots::Explicit(Arc::new(message.knot_values)),
                },
            },
        };
        Ok(Self {
            basis,
            parameters,
            closed: message.closed,
            control_points: None,
            weights: message.weighted.then_some(message.weights),
        })
    }
}
