//! How a curve with knots at the data ends.
//!
//! With knots at the data a B-spline of degree p has p − 1 control points more than there are data
//! points ([`crate::fit::direction`]). All control points are `c = E x + g` with the free ones x,
//! one for each data point, so that the residual is
//!
//! ```text
//! Δ = P − N c = (P − N g) − (N E) x
//! ```
//!
//! and the loop runs with `B = N E` and the data `P − N g`. Where E repeats the first and the last
//! free control point, B and all rates are those of the papers, whatever g is:
//!
//! | end | E | g | the curve at its end |
//! |---|---|---|---|
//! | repeated (LBW05 (3.2)) | copies | 0 | stands still: CAD kernels have no tangent there |
//! | derivatives, given or estimated | copies | constant | has these derivatives at every level |
//! | natural (cubic) | `c_1 = (1 − β) c_0 + β c_2` | 0 | has no second derivative |
//!
//! Estimated derivatives are those of the polynomial through the first points: as many as it takes
//! for one degree more than derivatives are needed, three points for cubics (Bessel).
//!
//! - `estimate`: derivatives from points; `copies`: control points from derivatives;
//! - `offsets`: g of a curve and of a surface.

mod copies;
mod estimate;
mod offsets;

use std::sync::Arc;

use super::basis::knots::Knots;
use super::choice::{BasisChoice, DirectionChoice};
use super::direction::{CopyRule, Direction};
use super::invalid::{Axis, Invalid, Side};
use super::points::Points;
use copies::Copies;

pub(super) use offsets::{Fitted, Offsets};

/// The highest degree whose ends are estimated: polynomials through more points lose all digits.
pub const MOST_ESTIMATED: usize = 31;

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

/// The ends that were chosen of a direction, if they can be: those of an open B-spline with knots at
/// the data and a control point for each data point.
///
/// # Errors
///
/// Why this direction has no ends to choose.
pub(super) fn are_chosen(choice: &DirectionChoice, axis: Axis) -> Result<Option<Ends>, Invalid> {
    let Some(ends) = &choice.ends else {
        return Ok(None);
    };
    let found = match &choice.basis {
        _ if choice.closed => "this direction is closed",
        _ if choice.control_points.is_some() => "least squares has ends of its own",
        BasisChoice::Polynomial(_) => "polynomial bases have none",
        BasisChoice::BSpline { knots, .. } => match knots {
            Knots::Usual | Knots::Data => return Ok(Some(ends.clone())),
            Knots::Averaged => "with averaged knots each control point belongs to a data point",
            Knots::Explicit(_) => "with explicit knots each control point belongs to a data point",
        },
    };
    Err(Invalid::NoEnds { axis, found })
}

impl Ends {
    /// The direction with these ends; `boundary` is the number of data points on the boundary and
    /// that of their coordinates.
    pub(super) fn apply(
        &self,
        direction: Direction,
        axis: Axis,
        boundary: (usize, usize),
    ) -> Result<Direction, Invalid> {
        let degree = direction.basis.degree();
        for side in [Side::Start, Side::End] {
            let copies = direction.copies(side);
            self.at(side)
                .check((axis, side), degree, copies, boundary)?;
        }
        let rule = |side| match self.at(side) {
            End::Repeated => Ok(CopyRule::Equal),
            End::Natural => natural(&direction, axis, side).map(CopyRule::Natural),
            _ => Ok(CopyRule::Constant),
        };
        let mut rules = [rule(Side::Start)?, rule(Side::End)?];
        // Of two points both copies lie between the same two control points, and follow each other.
        if let ([CopyRule::Natural(a), CopyRule::Natural(b)], 2) =
            (&mut rules, direction.parameters.len())
        {
            let all = 1.0 - *a * *b;
            (*a, *b) = (*a * (1.0 - *b) / all, *b * (1.0 - *a) / all);
        }
        Ok(direction.with_copies(rules))
    }

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
    ) -> Result<(), Invalid> {
        match self {
            Self::Repeated => Ok(()),
            Self::Estimated if degree > MOST_ESTIMATED => {
                Err(Invalid::EstimatedDegree { axis, side, degree })
            }
            Self::Natural if degree != 3 => Err(Invalid::NaturalDegree { axis, side, degree }),
            Self::Estimated | Self::Natural => Ok(()),
            Self::Derivatives(orders) if orders.len() > copies => Err(Invalid::EndOrders {
                axis,
                side,
                given: orders.len(),
                most: copies,
                degree,
            }),
            Self::Derivatives(_) if degree > MOST_ESTIMATED => {
                Err(Invalid::EstimatedDegree { axis, side, degree })
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
            Self::Tangent(_) if copies == 0 => Err(Invalid::EndOrders {
                axis,
                side,
                given: 1,
                most: 0,
                degree,
            }),
            Self::Tangent(_) if degree > MOST_ESTIMATED => {
                Err(Invalid::EstimatedDegree { axis, side, degree })
            }
            Self::Tangent(vectors) => {
                check_vectors(vectors, (axis, side, 0), boundary, dimension)?;
                let is_zero = |index: &usize| vectors.point(*index).all(|x| x == 0.0);
                match (0..vectors.len()).find(is_zero) {
                    None => Ok(()),
                    Some(index) => Err(Invalid::ZeroTangent { axis, side, index }),
                }
            }
        }
    }
}

/// The part of the next control point in a natural end, which lies between 0 and 1, so that the
/// collocation matrix stays totally positive.
fn natural(direction: &Direction, axis: Axis, side: Side) -> Result<f64, Invalid> {
    let beta = Copies::natural(direction, side);
    if (0.0..=1.0).contains(&beta) {
        Ok(beta)
    } else {
        Err(Invalid::NaturalWeights { axis, side })
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
    if vectors.len() != boundary {
        return Err(Invalid::EndVectorCount {
            axis,
            side,
            order,
            given: vectors.len(),
            expected: boundary,
        });
    }
    if vectors.dimension() != dimension {
        return Err(Invalid::EndVectorDimension {
            axis,
            side,
            order,
            given: vectors.dimension(),
            expected: dimension,
        });
    }
    for (coordinate, lane) in vectors.lanes().iter().enumerate() {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::EndVectorNotFinite {
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
