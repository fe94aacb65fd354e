//! What can be asked for at the ends of a direction, and which of it a B-spline cannot have.

use std::sync::Arc;

use super::mistake::{EndsMistake, MOST_ESTIMATED};
use crate::fit::place::{Axis, Side};
use crate::fit::points::Points;

/// How a direction ends on both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Ends {
    /// At its first parameter.
    pub start: End,
    /// At its last parameter.
    pub end: End,
}

/// How a direction ends on one side. Vectors are derivatives with respect to the parameter: one of
/// a curve, of a surface one for each data point of that boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// With the derivatives of the polynomial through the points there.
    Estimated,
    /// With copies of its last control point, where it stands still (LBW05 (3.2)).
    Repeated,
    /// Without second derivative; cubic B-splines.
    Natural,
    /// With given derivatives, of the first order and further ones; those that are missing are
    /// estimated.
    Derivatives(Vec<Arc<Points>>),
    /// With first derivatives of given directions, whose length is that of the line of points over
    /// the range of its parameters.
    Tangent(Arc<Points>),
}

impl Ends {
    /// The same on both sides.
    pub fn both(end: End) -> Self {
        Self {
            start: end.clone(),
            end,
        }
    }

    /// The end on one side.
    pub fn at(&self, side: Side) -> &End {
        match side {
            Side::Start => &self.start,
            Side::End => &self.end,
        }
    }
}

impl End {
    /// All names on the wire.
    pub const NAMES: [&str; 5] = ["estimated", "repeated", "natural", "derivatives", "tangent"];

    /// The name on the wire.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Estimated => "estimated",
            Self::Repeated => "repeated",
            Self::Natural => "natural",
            Self::Derivatives(_) => "derivatives",
            Self::Tangent(_) => "tangent",
        }
    }

    /// Refuses an end that a B-spline of this degree, with `copies` control points to choose on that
    /// side, cannot have: `boundary` is the number of data points on the boundary, and `dimension`
    /// that of their coordinates.
    pub(super) fn check(
        &self,
        (axis, side): (Axis, Side),
        degree: usize,
        copies: usize,
        (boundary, dimension): (usize, usize),
    ) -> Result<(), EndsMistake> {
        match self {
            Self::Repeated => Ok(()),
            Self::Natural if degree != 3 => Err(EndsMistake::NaturalDegree { axis, side, degree }),
            Self::Natural => Ok(()),
            // Whatever is not given is estimated.
            _ if degree > MOST_ESTIMATED => {
                Err(EndsMistake::EstimatedDegree { axis, side, degree })
            }
            Self::Estimated => Ok(()),
            Self::Derivatives(orders) if orders.len() > copies => Err(EndsMistake::EndOrders {
                axis,
                side,
                given: orders.len(),
                most: copies,
                degree,
            }),
            Self::Derivatives(orders) => {
                let check = |(order, vectors)| {
                    check_vectors(vectors, (axis, side, order), boundary, dimension)
                };
                orders
                    .iter()
                    .map(|it| &**it)
                    .enumerate()
                    .try_for_each(check)
            }
            Self::Tangent(_) if copies == 0 => Err(EndsMistake::EndOrders {
                axis,
                side,
                given: 1,
                most: 0,
                degree,
            }),
            Self::Tangent(vectors) => {
                check_vectors(vectors, (axis, side, 0), boundary, dimension)?;
                let is_zero = |index: &usize| vectors.point(*index).all(|x| x == 0.0);
                match (0..vectors.len()).find(is_zero) {
                    None => Ok(()),
                    Some(index) => Err(EndsMistake::ZeroTangent { axis, side, index }),
                }
            }
        }
    }
}

/// Refuses vectors that are not one for each data point of the boundary, have other coordinates than
/// the points, or coordinates that are infinite or NaN.
fn check_vectors(
    vectors: &Points,
    (axis, side, order): (Axis, Side, usize),
    boundary: usize,
    dimension: usize,
) -> Result<(), EndsMistake> {
    if vectors.len() != boundary {
        return Err(EndsMistake::EndVectorCount {
            axis,
            side,
            order,
            given: vectors.len(),
            expected: boundary,
        });
    }
    if vectors.dimension() != dimension {
        return Err(EndsMistake::EndVectorDimension {
            axis,
            side,
            order,
            given: vectors.dimension(),
            expected: dimension,
        });
    }
    for (coordinate, lane) in vectors.lanes().iter().enumerate() {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(EndsMistake::EndVectorNotFinite {
                axis,
                side,
                order,
                index,
                coordinate,
                value: lane[index],
            });
        }
    }
    Ok(())
}
