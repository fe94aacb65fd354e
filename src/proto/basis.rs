//! The basis and the parameters of a direction, and their messages, both ways.

use std::sync::Arc;

use super::messages as pb;
use super::values::{chosen, count, known, value};
use crate::model::basis::{Basis, BasisKind, KnotsInput, ParametersInput};
use crate::model::errors::ValidationError;
use crate::model::named::{Named, Rule};
use piad_fit::basis::{BasisChoice, Knots};
use piad_fit::parameters::Parametrization;

const KINDS: [(BasisKind, pb::BasisKind); 4] = [
    (BasisKind::Bspline, pb::BasisKind::Bspline),
    (BasisKind::Bernstein, pb::BasisKind::Bernstein),
    (BasisKind::SaidBall, pb::BasisKind::SaidBall),
    (BasisKind::WangBall, pb::BasisKind::WangBall),
];

/// The basis of a direction, which is this field.
pub(crate) fn read(basis: Option<pb::Basis>, field: &str) -> Result<Basis, ValidationError> {
    let basis = basis.unwrap_or_default();
    let rule = match known(basis.knot_rule, &format!("{field}.knot_rule"))? {
        pb::KnotRule::Unspecified => Chosen::Any,
        pb::KnotRule::Explicit => Chosen::Explicit,
        pb::KnotRule::Data => Chosen::Rule(KnotsInput(Knots::Data)),
        pb::KnotRule::Averaged => Chosen::Rule(KnotsInput(Knots::Averaged)),
        pb::KnotRule::Spread => Chosen::Rule(KnotsInput(Knots::Spread)),
        pb::KnotRule::Adaptive => Chosen::Rule(KnotsInput(Knots::Adaptive)),
    };
    Ok(Basis {
        kind: chosen(&KINDS, basis.kind, &format!("{field}.kind"))?.unwrap_or_default(),
        degree: basis.degree.map(|degree| degree as usize),
        knots: rule.of(basis.knots, &format!("{field}.knots"))?,
    })
}

/// The parameters of a direction, which are this field.
pub(crate) fn read_parameters(
    parameters: Option<pb::Parameters>,
    field: &str,
) -> Result<Option<ParametersInput>, ValidationError> {
    let parameters = parameters.unwrap_or_default();
    let rule = match known(parameters.rule, &format!("{field}.rule"))? {
        pb::ParameterRule::Unspecified => Chosen::Any,
        pb::ParameterRule::Explicit => Chosen::Explicit,
        pb::ParameterRule::ChordLength => {
            Chosen::Rule(ParametersInput(Parametrization::ChordLength))
        }
        pb::ParameterRule::Centripetal => {
            Chosen::Rule(ParametersInput(Parametrization::Centripetal))
        }
        pb::ParameterRule::Uniform => Chosen::Rule(ParametersInput(Parametrization::Uniform)),
    };
    rule.of(parameters.values, &format!("{field}.values"))
}

/// The rule by which numbers are chosen.
enum Chosen<R> {
    /// Explicit numbers, if there are any.
    Any,
    Explicit,
    Rule(R),
}

impl<R: Rule> Chosen<R> {
    fn of(self, numbers: Vec<f64>, field: &str) -> Result<Option<R>, ValidationError> {
        match (self, numbers.is_empty()) {
            (Self::Any, true) => Ok(None),
            (Self::Any, false) | (Self::Explicit, _) => Ok(Some(R::explicit(Arc::new(numbers)))),
            (Self::Rule(rule), true) => Ok(Some(rule)),
            (Self::Rule(rule), false) => {
                let name = rule.name().unwrap_or_default();
                let detail = format!("numbers are given, but the rule is {name:?}");
                Err(ValidationError::at_text(field, detail))
            }
        }
    }
}

/// The message of a basis.
pub(crate) fn message(choice: &BasisChoice) -> pb::Basis {
    let Basis {
        kind,
        degree,
        knots,
    } = Basis::from(choice);
    let (rule, knots) = match knots.map(|KnotsInput(knots)| knots) {
        None | Some(Knots::Usual) => (pb::KnotRule::Unspecified, Vec::new()),
        Some(Knots::Data) => (pb::KnotRule::Data, Vec::new()),
        Some(Knots::Averaged) => (pb::KnotRule::Averaged, Vec::new()),
        Some(Knots::Spread) => (pb::KnotRule::Spread, Vec::new()),
        Some(Knots::Adaptive) => (pb::KnotRule::Adaptive, Vec::new()),
        Some(Knots::Explicit(knots)) => (pb::KnotRule::Explicit, knots.to_vec()),
    };
    pb::Basis {
        kind: value(&KINDS, Some(kind)).into(),
        degree: degree.map(count),
        knot_rule: rule.into(),
        knots,
    }
}

/// The kind of a basis with this name.
pub(crate) fn kind(name: &str) -> pb::BasisKind {
    value(&KINDS, BasisKind::of_name(name))
}

/// The message of parameters.
pub(crate) fn parameters_message(choice: &Parametrization) -> pb::Parameters {
    let (rule, values) = match choice {
        Parametrization::ChordLength => (pb::ParameterRule::ChordLength, Vec::new()),
        Parametrization::Centripetal => (pb::ParameterRule::Centripetal, Vec::new()),
        Parametrization::Uniform => (pb::ParameterRule::Uniform, Vec::new()),
        Parametrization::Explicit(values) => (pb::ParameterRule::Explicit, values.to_vec()),
    };
    pb::Parameters {
        rule: rule.into(),
        values,
    }
}
