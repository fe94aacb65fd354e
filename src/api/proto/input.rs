//! A job as it was asked for, as a message.

use bytes::Bytes;
use prost::Message;

use super::messages::{self as pb, job_input::Geometry, stop_rules::Rule};
use super::method;
use super::names;
use super::names::count;
use super::view::stream_options;
use crate::fit::basis::knots::Knots;
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::parameters::Parametrization;
use crate::fit::points::Points;
use crate::fit::problem::{Problem, Request, Tolerance, Weights};
use crate::job::outline::Outline;

/// The bytes of the `JobInput` that would ask for the same problem again. The start of an edit is not a
/// part of it: that is its iteration 0.
pub fn input(outline: &Outline, problem: &Problem) -> Bytes {
    let request = problem.request();
    let selected = request.selected.as_deref().unwrap_or_default();
    let indices = selected.iter().map(|&index| count(index)).collect();
    let message = pb::JobInput {
        name: outline.label.name.clone(),
        geometry: Some(match &request.v {
            None => Geometry::Curve(curve(request)),
            Some(v) => Geometry::Surface(surface(request, v)),
        }),
        rational: rational(request).into(),
        method: Some(method::asked(&request.method, indices)),
        stop: Some(pb::StopRules {
            rule: Some(match request.tolerance {
                Tolerance::Absolute(value) => Rule::Tolerance(value),
                Tolerance::Relative(value) => Rule::RelativeTolerance(value),
            }),
            max_iterations: Some(request.max_iterations as u64),
        }),
        stream: stream_options(outline),
    };
    message.encode_to_vec().into()
}

fn curve(request: &Request) -> pb::Curve {
    let fixed = request.u.weights.clone();
    pb::Curve {
        dimension: count(request.points.dimension()),
        points: flat(&request.points),
        basis: Some(basis(&request.u.basis)),
        parameters: Some(parameters(&request.u.parameters)),
        weights: grid_weights(&request.weights).or(fixed).unwrap_or_default(),
        closed: request.u.closed,
    }
}

fn surface(request: &Request, v: &DirectionChoice) -> pb::Surface {
    pb::Surface {
        dimension: count(request.points.dimension()),
        rows: count(request.grid.rows),
        columns: count(request.grid.columns),
        points: flat(&request.points),
        missing: request.missing.iter().map(|&index| count(index)).collect(),
        u: Some(direction(&request.u)),
        v: Some(direction(v)),
        weights: grid_weights(&request.weights).unwrap_or_default(),
    }
}

fn direction(choice: &DirectionChoice) -> pb::SurfaceDirection {
    pb::SurfaceDirection {
        basis: Some(basis(&choice.basis)),
        parameters: Some(parameters(&choice.parameters)),
        closed: choice.closed,
        weights: choice.weights.clone().unwrap_or_default(),
    }
}

fn flat(points: &Points) -> Vec<f64> {
    let mut flat = Vec::with_capacity(points.len() * points.dimension());
    flat.extend((0..points.len()).flat_map(|index| points.point(index)));
    flat
}

fn basis(choice: &BasisChoice) -> pb::Basis {
    let kind = names::basis_choice(choice).into();
    let BasisChoice::BSpline { degree, knots } = choice else {
        return pb::Basis {
            kind,
            ..pb::Basis::default()
        };
    };
    let (rule, knots) = match knots {
        Knots::Usual => (pb::KnotRule::Unspecified, Vec::new()),
        Knots::Data => (pb::KnotRule::Data, Vec::new()),
        Knots::Averaged => (pb::KnotRule::Averaged, Vec::new()),
        Knots::Explicit(knots) => (pb::KnotRule::Explicit, knots.to_vec()),
    };
    pb::Basis {
        kind,
        degree: Some(count(*degree)),
        knot_rule: rule.into(),
        knots,
    }
}

fn parameters(choice: &Parametrization) -> pb::Parameters {
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

fn rational(request: &Request) -> pb::Rational {
    match (&request.weights, &request.u.weights) {
        (Weights::Homogeneous(_), _) => pb::Rational::Homogeneous,
        (Weights::FixedGrid(_), _) | (Weights::None, Some(_)) => pb::Rational::Fixed,
        (Weights::None, None) => pb::Rational::Unspecified,
    }
}

fn grid_weights(weights: &Weights) -> Option<Vec<f64>> {
    match weights {
        Weights::None => None,
        Weights::Homogeneous(weights) | Weights::FixedGrid(weights) => Some(weights.clone()),
    }
}
