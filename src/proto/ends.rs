//! How directions end, in messages.

use std::sync::Arc;

use super::messages as pb;
use super::values::known;
use crate::model::ends::check_orders;
use crate::model::errors::ValidationError;
use piad_fit::basis::{End, Ends};
use piad_fit::data::Points;
use piad_fit::invalid::Side;

/// The ends of a message; `boundary` is the number of data points on a boundary and that of their coordinates.
pub(super) fn read(
    ends: Option<pb::Ends>,
    boundary: (usize, usize),
    field: &str,
) -> Result<Option<Ends>, ValidationError> {
    let Some(pb::Ends { start, end }) = ends else {
        return Ok(None);
    };
    let side = |end: Option<pb::End>, side: Side| {
        let field = format!("{field}.{}", side.name());
        end.map_or(Ok(End::Estimated), |end| one(&end, boundary, &field))
    };
    Ok(Some(Ends {
        start: side(start, Side::Start)?,
        end: side(end, Side::End)?,
    }))
}

/// An end.
fn one(end: &pb::End, boundary: (usize, usize), field: &str) -> Result<End, ValidationError> {
    use pb::EndRule as R;
    let rule = known(end.rule, &format!("{field}.rule"))?;
    let (derivatives, tangents) = (&end.derivatives, &end.tangents);
    let rule = match (rule, derivatives.is_empty(), tangents.is_empty()) {
        (R::Unspecified, true, true) => R::Estimated,
        (R::Unspecified | R::Derivatives, false, true) => R::Derivatives,
        (R::Unspecified | R::Tangent, true, false) => R::Tangent,
        (rule, true, true) => rule,
        (..) => {
            let detail = "vectors are given that its rule has no use for";
            return Err(ValidationError::at_text(field, detail));
        }
    };
    Ok(match rule {
        R::Unspecified | R::Estimated => End::Estimated,
        R::Repeated => End::Repeated,
        R::Natural => End::Natural,
        R::Derivatives => {
            let field = format!("{field}.derivatives");
            let vectors = vectors(derivatives, boundary, &field)?;
            End::Derivatives(vectors)
        }
        R::Tangent => {
            let field = format!("{field}.tangents");
            let mut vectors = vectors(tangents, boundary, &field)?;
            match (vectors.pop(), vectors.is_empty()) {
                (Some(vectors), true) => End::Tangent(vectors),
                _ => {
                    let detail = "one vector is needed for each data point of this boundary";
                    return Err(ValidationError::at_text(field, detail));
                }
            }
        }
    })
}

/// Flat vectors, one list of them for each order.
fn vectors(
    flat: &[f64],
    (boundary, dimension): (usize, usize),
    field: &str,
) -> Result<Vec<Arc<Points>>, ValidationError> {
    let numbers = boundary * dimension;
    if numbers == 0 || flat.is_empty() || !flat.len().is_multiple_of(numbers) {
        let detail = format!(
            "{} numbers are not one vector of {dimension} coordinates for each of {boundary} data points of this boundary",
            flat.len()
        );
        return Err(ValidationError::at_text(field, detail));
    }
    let orders = flat.len() / numbers;
    check_orders(orders).map_err(|detail| ValidationError::at_text(field, detail))?;
    let order = |flat| Arc::new(Points::from_flat(dimension, flat));
    Ok(flat.chunks_exact(numbers).map(order).collect())
}

/// The message of these ends.
pub(super) fn message(ends: &Ends) -> pb::Ends {
    let side = |end: &End| {
        let mut message = pb::End {
            rule: rule(end).into(),
            ..pb::End::default()
        };
        match end {
            End::Derivatives(orders) => {
                message.derivatives = orders.iter().flat_map(|it| it.to_flat()).collect();
            }
            End::Tangent(vectors) => message.tangents = vectors.to_flat(),
            End::Estimated | End::Repeated | End::Natural => {}
        }
        Some(message)
    };
    pb::Ends {
        start: side(&ends.start),
        end: side(&ends.end),
    }
}

/// The rule of an end.
pub(crate) fn rule(end: &End) -> pb::EndRule {
    match end {
        End::Estimated => pb::EndRule::Estimated,
        End::Repeated => pb::EndRule::Repeated,
        End::Natural => pb::EndRule::Natural,
        End::Derivatives(_) => pb::EndRule::Derivatives,
        End::Tangent(_) => pb::EndRule::Tangent,
    }
}

/// The locations of the vectors of ends in a message.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EndsLayout {
    /// True if the ends of u and v have tangents, at the start and at the end.
    tangents: [[bool; 2]; 2],
    /// The numbers of data points on the boundaries of u and v.
    boundaries: [usize; 2],
    /// The number of coordinates.
    dimension: usize,
}

impl EndsLayout {
    /// The layout of a job.
    pub(crate) fn of(input: &pb::JobInput) -> Self {
        use pb::job_input::Geometry as G;
        let sides = |ends: Option<&pb::Ends>| {
            let tangents = |end: Option<&pb::End>| end.is_some_and(|it| !it.tangents.is_empty());
            let sides = |it: &pb::Ends| [tangents(it.start.as_ref()), tangents(it.end.as_ref())];
            ends.map_or([false; 2], sides)
        };
        match &input.geometry {
            None => Self::default(),
            Some(G::Curve(curve)) => Self {
                tangents: [sides(curve.ends.as_ref()), [false; 2]],
                boundaries: [1, 1],
                dimension: curve.dimension as usize,
            },
            Some(G::Surface(surface)) => {
                let of = |axis: Option<&pb::SurfaceDirection>| {
                    sides(axis.and_then(|axis| axis.ends.as_ref()))
                };
                Self {
                    tangents: [of(surface.u.as_ref()), of(surface.v.as_ref())],
                    boundaries: [surface.columns as usize, surface.rows as usize],
                    dimension: surface.dimension as usize,
                }
            }
        }
    }

    /// The field, below that of an end, of the vectors of an order, or of one of them.
    pub(crate) fn field(
        &self,
        axis: usize,
        side: Side,
        order: usize,
        index: Option<usize>,
    ) -> String {
        let tangents = self.tangents[axis][usize::from(side == Side::End)];
        let name = if tangents { "tangents" } else { "derivatives" };
        match index {
            None if order == 0 => name.to_owned(),
            index => {
                let place = order * self.boundaries[axis] + index.unwrap_or(0);
                format!("{name}[{}]", place * self.dimension)
            }
        }
    }
}
