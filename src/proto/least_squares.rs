//! The settings of least squares in messages.

use super::messages::{method as m, method::constraint as c};
use super::values::{MethodTarget, check_count, chosen, count, some, value};
use crate::model::errors::{SpecPart, ValidationError};
use crate::model::method::counts::ControlPointCount;
use crate::model::method::{
    ConstraintInput, EndPointsInput, FairnessInput, LeastSquaresInput, VariantKind,
};
use crate::model::per_direction::PerDirection;
use crate::model::serde_helpers::{AtMost, Whole};
use piad_fit::data::Points;
use piad_fit::invalid::{Axis, Place, Side};
use piad_fit::method::{
    AS_MANY_AS_DATA, At, Constraint, EndPoints, LeastSquares, MOST_CONDITIONS, Variant, Wanted,
};

const VARIANTS: [(VariantKind, m::Variant); 4] = [
    (VariantKind::Cg, m::Variant::Cg),
    (VariantKind::Diagonal, m::Variant::Diagonal),
    (VariantKind::Lspia, m::Variant::Lspia),
    (VariantKind::Direct, m::Variant::Direct),
];

const END_POINTS: [(EndPointsInput, m::EndPoints); 2] = [
    (
        EndPointsInput(EndPoints::Interpolated),
        m::EndPoints::Interpolated,
    ),
    (EndPointsInput(EndPoints::Free), m::EndPoints::Free),
];

const SIDES: [(Side, m::Side); 2] = [(Side::Start, m::Side::Start), (Side::End, m::Side::End)];

const BOUNDARIES: [((Axis, Side), m::Boundary); 4] = [
    ((Axis::U, Side::Start), m::Boundary::UStart),
    ((Axis::U, Side::End), m::Boundary::UEnd),
    ((Axis::V, Side::Start), m::Boundary::VStart),
    ((Axis::V, Side::End), m::Boundary::VEnd),
];

/// The settings of a message. Without a number for v both directions have that for u.
pub(super) fn input(
    settings: m::LeastSquares,
    target: MethodTarget,
) -> Result<LeastSquaresInput, ValidationError> {
    let (u, v) = (settings.control_points_u, settings.control_points_v);
    let wrong = |axis, detail| {
        let place = SpecPart::Fit(Place::ControlPoints(axis));
        Err(ValidationError::at(place, detail))
    };
    if v != 0 && !target.surface {
        return wrong(Axis::U, "a curve has one number of control points");
    }
    if u == 0 && v != 0 {
        return wrong(Axis::V, "without a number for u there is none for v");
    }
    let counts = match (u, v) {
        (0, _) => None,
        (u, 0) => Some(PerDirection::Both(Whole(u as usize))),
        (u, v) => Some(PerDirection::Each {
            u: Whole(u as usize),
            v: Whole(v as usize),
        }),
    };
    let (control_points, max_control_points) = match settings.automatic {
        None => (
            counts.map(|it| it.map(|count| ControlPointCount(Some(count)))),
            None,
        ),
        Some(_) => (Some(PerDirection::Both(ControlPointCount(None))), counts),
    };
    let field = "method.least_squares.data_weights";
    let weights = settings.data_weights;
    check_count(weights.len(), target.most, "weights of data", field)?;
    let order = settings.fairness_order;
    Ok(LeastSquaresInput {
        control_points,
        max_control_points,
        correct_parameters: settings.automatic.map(|it| it.correct_parameters),
        variant: chosen(&VARIANTS, settings.variant, "method.least_squares.variant")?,
        mu: settings.mu,
        end_points: chosen(
            &END_POINTS,
            settings.end_points,
            "method.least_squares.end_points",
        )?,
        data_weights: target.numbers(weights),
        fairness: match settings.fairness_by_data {
            true => Some(FairnessInput(None)),
            false => settings.fairness.map(|value| FairnessInput(Some(value))),
        },
        gap_stiffness: settings.gap_stiffness,
        robust: settings.robust.then_some(true),
        fairness_order: (order != 0).then_some(order as usize),
        constraints: constraints(settings.constraints, target)?,
    })
}

fn constraints(
    messages: Vec<m::Constraint>,
    target: MethodTarget,
) -> Result<Option<AtMost<ConstraintInput, MOST_CONDITIONS>>, ValidationError> {
    let field = "method.least_squares.constraints";
    check_count(messages.len(), MOST_CONDITIONS, "constraints", field)?;
    let one = |(index, message)| {
        let constraint = constraint(message, target.surface, &format!("{field}[{index}]"))?;
        Ok(ConstraintInput::of(
            &constraint,
            target.grid,
            target.surface,
        ))
    };
    let constraints: Result<Vec<_>, ValidationError> =
        messages.into_iter().enumerate().map(one).collect();
    Ok(some(constraints?).map(AtMost))
}

fn constraint(
    message: m::Constraint,
    surface: bool,
    field: &str,
) -> Result<Constraint, ValidationError> {
    let wrong = |detail: &str| ValidationError::at_text(field, detail);
    let at = match message
        .at
        .ok_or_else(|| wrong("it says nowhere where it holds"))?
    {
        c::At::Side(side) => {
            let side = chosen(&SIDES, side, &format!("{field}.side"))?;
            At::Side(side.ok_or_else(|| wrong("its side is not given"))?)
        }
        c::At::Index(index) => At::Index(index as usize),
        c::At::Parameter(t) => At::Parameter(t),
        c::At::Parameters(m::SurfaceParameters { u, v }) => At::Parameters(u, v),
        c::At::Boundary(boundary) => {
            let boundary = chosen(&BOUNDARIES, boundary, &format!("{field}.boundary"))?;
            let (axis, side) = boundary.ok_or_else(|| wrong("its boundary is not given"))?;
            At::Boundary(axis, side)
        }
    };
    let wanted = match message.wanted {
        None if matches!(at, At::Index(_)) => Wanted::DataPoint,
        None => return Err(wrong("it needs a point or a derivative that holds there")),
        Some(c::Wanted::Derivative(derivative)) => {
            let orders = [derivative.order_u, derivative.order_v];
            let [u, v] = orders;
            if u.saturating_add(v) > 2 || (v > 0 && !surface) {
                return Err(wrong(
                    "derivatives have orders up to two in all, of curves in u",
                ));
            }
            Wanted::Derivative {
                orders: orders.map(|order| order as usize),
                vector: derivative.vector.unwrap_or_default().coordinates,
            }
        }
        Some(c::Wanted::Tangent(vector)) => Wanted::Tangent(vector.coordinates),
        Some(c::Wanted::Across(across)) => {
            if across.order > 1 {
                return Err(wrong("across a boundary there is order 0 or 1"));
            }
            Wanted::Across {
                order: across.order as usize,
                control_points: points(&across.control_points).ok_or_else(|| {
                    wrong("its control points have different dimensions, or none")
                })?,
            }
        }
    };
    Ok(Constraint { at, wanted })
}

/// Vectors of the same number of coordinates.
fn points(vectors: &[m::Vector]) -> Option<Points> {
    let dimension = vectors.first()?.coordinates.len();
    if dimension == 0 || vectors.iter().any(|it| it.coordinates.len() != dimension) {
        return None;
    }
    let mut points = Points::new(dimension);
    vectors
        .iter()
        .for_each(|vector| points.push(&vector.coordinates));
    Some(points)
}

/// The settings, without lists.
pub(super) fn message(settings: &LeastSquares, surface: bool) -> m::LeastSquares {
    // Zero means the number of data points.
    let number = |most| {
        if most == AS_MANY_AS_DATA {
            0
        } else {
            count(most)
        }
    };
    m::LeastSquares {
        control_points_u: number(settings.u),
        // A curve has one number of control points, and refuses another one.
        control_points_v: if surface { number(settings.v) } else { 0 },
        automatic: settings.automatic.map(|it| m::Automatic {
            correct_parameters: it.correct_parameters,
        }),
        variant: value(&VARIANTS, Some(settings.variant.into())).into(),
        mu: match settings.variant {
            Variant::Lspia { mu } => mu,
            _ => None,
        },
        end_points: value(&END_POINTS, Some(EndPointsInput(settings.ends))).into(),
        fairness: settings.fairness.map(|fairness| fairness.value),
        fairness_by_data: settings.fairness.is_some_and(|it| it.by_data),
        gap_stiffness: settings.gap_stiffness,
        robust: settings.robust,
        fairness_order: settings
            .fairness
            .map_or(0, |fairness| count(fairness.order)),
        data_weights: Vec::new(),
        constraints: Vec::new(),
    }
}

/// Adds the lists of settings to their message.
pub(super) fn lists(message: &mut m::LeastSquares, settings: &LeastSquares) {
    if let Some(weights) = &settings.data_weights {
        message.data_weights = weights.to_vec();
    }
    message.constraints = settings
        .constraints
        .iter()
        .map(constraint_message)
        .collect();
}

fn constraint_message(constraint: &Constraint) -> m::Constraint {
    let at = match constraint.at {
        At::Side(side) => c::At::Side(value(&SIDES, Some(side)).into()),
        At::Index(index) => c::At::Index(count(index)),
        At::Parameter(t) => c::At::Parameter(t),
        At::Parameters(u, v) => c::At::Parameters(m::SurfaceParameters { u, v }),
        At::Boundary(axis, side) => c::At::Boundary(value(&BOUNDARIES, Some((axis, side))).into()),
    };
    let vector = |coordinates: &[f64]| m::Vector {
        coordinates: coordinates.to_vec(),
    };
    let wanted = match &constraint.wanted {
        Wanted::DataPoint => None,
        Wanted::Derivative {
            orders,
            vector: coordinates,
        } => {
            let [order_u, order_v] = orders.map(count);
            Some(c::Wanted::Derivative(m::Derivative {
                order_u,
                order_v,
                vector: Some(vector(coordinates)),
            }))
        }
        Wanted::Tangent(coordinates) => Some(c::Wanted::Tangent(vector(coordinates))),
        Wanted::Across {
            order,
            control_points,
        } => {
            let points = 0..control_points.len();
            let points = points.map(|k| m::Vector {
                coordinates: control_points.point(k).collect(),
            });
            Some(c::Wanted::Across(m::Across {
                order: count(*order),
                control_points: points.collect(),
            }))
        }
    };
    m::Constraint {
        at: Some(at),
        wanted,
    }
}
