//! The end conditions of a direction, and which of them a B-spline cannot have.

use std::sync::Arc;

use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place, Side};

/// The highest degree with estimated ends: polynomials through more points lose all digits.
pub(crate) const MOST_ESTIMATED: usize = 31;

/// The end conditions of a direction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ends {
    /// At its first parameter.
    pub start: End,
    /// At its last parameter.
    pub end: End,
}

/// An end condition. Vectors are derivatives with respect to the parameter: one of a curve, of a
/// surface one for each data point of that boundary.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum End {
    /// With the derivatives of the polynomial through the points there.
    Estimated,
    /// With copies of its last control point, where its derivative is zero (LBW05 (3.2)).
    Repeated,
    /// Without second derivative; cubic B-splines.
    Natural,
    /// With given derivatives, of the first order and further ones; those that are missing are
    /// estimated.
    Derivatives(Vec<Arc<Points>>),
    /// With first derivatives in given directions, whose length is that of the line of points
    /// divided by the range of its parameters.
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

    /// Refuses an end that a B-spline of this degree, with `copies` free choices of control points
    /// on that side, cannot have: `boundary` is the number of data points on the boundary, and
    /// `dimension` that of their coordinates.
    pub(crate) fn check(
        &self,
        (axis, side): (Axis, Side),
        degree: usize,
        copies: usize,
        (boundary, dimension): (usize, usize),
    ) -> Result<(), Invalid> {
        match self {
            Self::Repeated => Ok(()),
            Self::Natural if degree != 3 => Err(natural_degree(axis, side, degree)),
            Self::Natural => Ok(()),
            // Vectors that are not given are estimated.
            _ if degree > MOST_ESTIMATED => Err(Invalid::at(
                Place::End(axis, side),
                format!(
                    "derivatives are estimated up to degree {MOST_ESTIMATED}, and this B-spline has degree {degree}: use repeated ends"
                ),
            )),
            Self::Estimated => Ok(()),
            Self::Derivatives(orders) if orders.len() > copies => {
                Err(too_many_orders((axis, side), orders.len(), copies, degree))
            }
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
            Self::Tangent(_) if copies == 0 => Err(too_many_orders((axis, side), 1, 0, degree)),
            Self::Tangent(vectors) => {
                check_vectors(vectors, (axis, side, 0), boundary, dimension)?;
                let is_zero = |index: &usize| vectors.point(*index).all(|x| x == 0.0);
                match (0..vectors.len()).find(is_zero) {
                    None => Ok(()),
                    Some(index) => Err(Invalid::at(
                        Place::EndVector(axis, side, 0, index),
                        "the zero vector has no direction, so that it is no tangent",
                    )),
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
) -> Result<(), Invalid> {
    let wrong = |detail: String| Err(Invalid::at(Place::EndOrder(axis, side, order), detail));
    let given = vectors.len();
    if given != boundary {
        return wrong(format!(
            "{given} vectors given; {boundary} are needed, one for each data point of this boundary"
        ));
    }
    let given = vectors.dimension();
    if given != dimension {
        return wrong(format!(
            "this vector has {given} coordinates; the points have {dimension}"
        ));
    }
    for (coordinate, lane) in vectors.lanes().iter().enumerate() {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::at(
                Place::EndVector(axis, side, order, index),
                format!(
                    "coordinate {coordinate} is {value}, which is not a finite number",
                    value = lane[index]
                ),
            ));
        }
    }
    Ok(())
}

/// Natural ends of another degree than 3.
pub(crate) fn natural_degree(axis: Axis, side: Side, degree: usize) -> Invalid {
    let detail = format!("natural ends are those of cubic B-splines; this one has degree {degree}");
    Invalid::at(Place::End(axis, side), detail)
}

/// More derivatives are given at an end than there are control points to choose.
fn too_many_orders(
    (axis, side): (Axis, Side),
    given: usize,
    most: usize,
    degree: usize,
) -> Invalid {
    let name = side.name();
    let detail =
        format!("{given} derivatives given; degree {degree} has room for {most} at the {name}");
    Invalid::at(Place::EndOrder(axis, side, most), detail)
}
