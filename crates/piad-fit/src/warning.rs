//! Warnings: fits that can be computed but may not be intended.
//!
//! Some warnings follow from the problem alone (degrees that few points do not determine, even degrees with knots at
//! the data). Others follow from the collocation matrix (eigenvalues, trial runs); methods give those,
//! [`Method::warnings`](super::method::Method::warnings).

use super::basis::knots::Knots;
use super::invalid::{Axis, Place};
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::Direction;
use crate::basis::end_conditions::{End, Ends, MOST_ESTIMATED};
use crate::data::corners;
use crate::data::no_data::no_data;
use crate::data::outliers;
use crate::data::point_order::is_unordered;
use crate::data::points::Points;
use crate::geometry::between::Excursion;
use crate::geometry::fold::Fold;
use crate::matrix::forecast::Forecast;

/// A warning about a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Warning {
    /// Knots at the data and repeated ends: the degree is no less than the number of points, so that
    /// most control points are copies of end points.
    FewPoints {
        /// The direction.
        axis: Axis,
        /// The degree of the B-spline.
        degree: usize,
        /// The number of data points in this direction.
        count: usize,
    },
    /// Knots at the data: the degree is even, so that the influence of a point falls slowly along
    /// the curve.
    EvenDegree {
        /// The direction.
        axis: Axis,
        /// The degree of the B-spline.
        degree: usize,
    },
    /// A few points determine the bounding box to which the tolerance is relative.
    Outliers {
        /// The diagonal of the bounding box.
        diagonal: f64,
        /// The diagonal of the box of the inner nine tenths of the points.
        inner: f64,
        /// The tolerance in data units.
        tolerance: f64,
    },
    /// Least squares: a few points of a curve are far from where their neighbours predict them.
    Spikes {
        /// The number of them.
        count: usize,
        /// The first of them.
        index: usize,
    },
    /// A curve that chooses its knots rounds points at which the data turn as corners do.
    RoundedCorners {
        /// The number of corners.
        count: usize,
        /// The first of them.
        index: usize,
    },
    /// The points of a curve have no order along it.
    Unordered,
    /// A value of the points of a grid stands for missing data.
    NoData {
        /// The value.
        value: f64,
        /// The number of points that have it.
        count: usize,
    },
    /// Between neighbouring points the fit deviates by more than their distance.
    Between(Excursion),
    /// Points of a surface with nearly the same parameters are far from each other.
    Folded(Fold),
    /// Extended PIA: the distances between data points are so much larger than the data that rounding leaves more than
    /// the tolerance.
    Rounding {
        /// The approximate remaining error, in data units.
        left: f64,
        /// The number of iterations after which the method makes no more progress.
        iterations: usize,
    },
    /// Chebyshev: with steps for [λ_min, 1] distances would grow too much, so that the steps are for a shorter
    /// interval.
    ShorterInterval {
        /// The least eigenvalue.
        least: f64,
        /// Where the interval begins instead.
        begin: f64,
    },
    /// Chebyshev: all parts of the error shrink at the same, slow rate.
    SlowSteps {
        /// The number of iterations after which a hundredth of the error is left.
        iterations: usize,
    },
    /// The slowest part of the error will have hardly changed after the last iteration, so that the tolerance may be
    /// out of reach.
    IllConditioned {
        /// The least eigenvalue.
        least: f64,
        /// The last level that is computed.
        iterations: usize,
    },
    /// Least squares: control points without data in the support of their basis function stay where
    /// they start.
    WithoutData {
        /// The number of such control points.
        count: usize,
    },
    /// Least squares: the data run against the direction of a tangent, so that the derivative there is zero.
    ReversedTangent {
        /// The constraint.
        index: usize,
    },
}

/// A bounding box is wide if its diagonal is more than this multiple of that of the inner nine tenths.
const WIDE: f64 = 100.0;

/// If at least this part of the slowest part of the error is left, the iterations hardly change it.
const UNCHANGED: f64 = 0.99;

/// Advice about outliers.
const ROBUST: &str = "\"robust\": true leaves such points out";

/// Advice about corners.
const CORNERS: &str = "\"corners\": \"auto\" keeps them sharp";

impl Warning {
    /// Warnings about a requested direction with a control point for each data point.
    pub(super) fn of_direction(
        choice: &DirectionChoice,
        direction: &Direction,
        axis: Axis,
    ) -> Vec<Self> {
        let BasisChoice::BSpline { degree, knots } = &choice.basis else {
            return Vec::new();
        };
        let usual = matches!(knots, Knots::Usual | Knots::Data);
        if !usual || direction.is_closed() || choice.corners.is_some() {
            return Vec::new();
        }
        let (degree, count) = (*degree, direction.parameters.len());
        // Other ends of few points give the polynomial through them.
        let few = degree >= count;
        let repeated = |ends: &Ends| [&ends.start, &ends.end].contains(&&End::Repeated);
        let copies = few && choice.ends.as_ref().is_none_or(repeated);
        let copies = copies.then_some(Self::FewPoints {
            axis,
            degree,
            count,
        });
        let even = (!few && degree % 2 == 0).then_some(Self::EvenDegree { axis, degree });
        copies.into_iter().chain(even).collect()
    }

    /// A warning if a few points determine the bounding box to which the tolerance is relative.
    pub(super) fn of_points(points: &Points, (diagonal, tolerance): (f64, f64)) -> Option<Self> {
        let inner = points.inner_diagonal();
        (inner > 0.0 && diagonal > WIDE * inner).then_some(Self::Outliers {
            diagonal,
            inner,
            tolerance,
        })
    }

    /// A warning if the points of a curve have no order.
    pub(super) fn of_curve(points: &Points) -> Option<Self> {
        is_unordered(points).then_some(Self::Unordered)
    }

    /// A warning about the points of a curve, if they are few, that are far from where their neighbours predict them.
    pub(super) fn of_spikes(points: &Points, closed: bool) -> Option<Self> {
        let spikes = outliers::spikes(points, closed);
        let (count, index) = (spikes.len(), *spikes.first()?);
        Some(Self::Spikes { count, index })
    }

    /// A warning about corners of points of a curve without a setting for them.
    pub(super) fn of_corners(points: &Points, closed: bool) -> Option<Self> {
        let angle = corners::USUAL_ANGLE.to_radians();
        let corners = corners::find(points, closed, angle);
        let (count, index) = (corners.len(), *corners.first()?);
        Some(Self::RoundedCorners { count, index })
    }

    /// A warning if a value of a grid stands for missing data.
    pub(super) fn of_grid(points: &Points, missing: &[usize]) -> Option<Self> {
        no_data(points, missing).map(|(value, count)| Self::NoData { value, count })
    }

    /// A warning if the slowest part of the error will have hardly changed at level `iterations`, the last one, and the
    /// fit does not end before, at level `predicted`.
    pub(super) fn of_rate(
        forecast: &Forecast,
        predicted: Option<usize>,
        iterations: usize,
    ) -> Option<Self> {
        let least = forecast.lambda_min.unwrap_or(0.0);
        let gets_there = predicted.is_some_and(|level| level <= iterations);
        let slow = forecast
            .rate
            .is_some_and(|rate| rate.powf(iterations as f64) > UNCHANGED);
        (slow && !gets_there && iterations > 0)
            .then_some(Self::IllConditioned { least, iterations })
    }

    /// All names on the wire.
    pub const CODES: [&str; 15] = [
        "few_points",
        "even_degree",
        "rounding",
        "shorter_interval",
        "ill_conditioned",
        "without_data",
        "outliers",
        "reversed_tangent",
        "slow_steps",
        "unordered",
        "no_data_value",
        "between_points",
        "folded_parameters",
        "spikes",
        "rounded_corners",
    ];

    /// The name on the wire.
    pub fn code(&self) -> &'static str {
        match self {
            Self::FewPoints { .. } => "few_points",
            Self::EvenDegree { .. } => "even_degree",
            Self::Rounding { .. } => "rounding",
            Self::ShorterInterval { .. } => "shorter_interval",
            Self::IllConditioned { .. } => "ill_conditioned",
            Self::WithoutData { .. } => "without_data",
            Self::Outliers { .. } => "outliers",
            Self::ReversedTangent { .. } => "reversed_tangent",
            Self::SlowSteps { .. } => "slow_steps",
            Self::Unordered => "unordered",
            Self::NoData { .. } => "no_data_value",
            Self::Between(_) => "between_points",
            Self::Folded(_) => "folded_parameters",
            Self::Spikes { .. } => "spikes",
            Self::RoundedCorners { .. } => "rounded_corners",
        }
    }

    /// The part of the problem that the warning is about.
    pub fn place(&self) -> Place {
        match *self {
            Self::FewPoints { axis, .. } | Self::EvenDegree { axis, .. } => Place::Degree(axis),
            Self::Outliers { .. } | Self::Unordered | Self::NoData { .. } => Place::Points,
            Self::Between(excursion) => Place::Point(excursion.index),
            Self::Spikes { index, .. } | Self::RoundedCorners { index, .. } => Place::Point(index),
            Self::Folded(Fold {
                points: [index, _], ..
            }) => Place::Point(index),
            Self::ReversedTangent { index } => Place::Constraint(index),
            _ => Place::Method,
        }
    }

    /// What is doubtful, why, and what to do about it.
    pub fn detail(&self) -> String {
        match *self {
            Self::FewPoints { degree, count, .. } => {
                let most = count - 1;
                let other = match degree <= MOST_ESTIMATED {
                    true => ", or ends that are \"estimated\"",
                    false => "",
                };
                format!(
                    "degree {degree} is more than {count} points determine: most control points are copies of an end \
                     point, near which the curve hardly moves; use at most degree {most}{other}"
                )
            }
            Self::EvenDegree { degree, .. } => format!(
                "degree {degree} is even: with knots at the data one moved point affects the whole \
                 curve; use an odd degree or averaged knots"
            ),
            Self::Rounding { left, iterations } => format!(
                "rounding is expected to leave a distance of about {left:.0e} when the extended method has come to its \
                 end after {iterations} iterations, as distances in between are much larger than the data; use direct"
            ),
            Self::ShorterInterval { least, begin } => format!(
                "the least eigenvalue of the collocation matrix, {least:.2e}, is unreliable for \
                 this matrix: with Chebyshev steps for [{least:.2e}, 1] distances would rise far \
                 above those of the data; the steps are for [{begin:.2e}, 1], which takes more \
                 iterations; direct gives the limit"
            ),
            Self::SlowSteps { iterations } => format!(
                "chebyshev makes all parts of the error shrink at the same rate, here to a \
                 hundredth in {iterations} iterations; global is nearer to the data in the first \
                 ones, and direct gives the limit"
            ),
            Self::IllConditioned { least, iterations } => format!(
                "the least eigenvalue of the collocation matrix is {least:.2e}: the part of the error that belongs to it \
                 hardly changes in {iterations} iterations, and the tolerance may be out of reach; use direct, or \
                 B-splines of a low degree"
            ),
            Self::Outliers {
                diagonal,
                inner,
                tolerance,
            } => format!(
                "a few points determine the bounding box: its diagonal is {diagonal:.3e}, that of the inner 90 % of the \
                 points {inner:.3e}, so that the relative tolerance allows distances of {tolerance:.3e}; give a tolerance \
                 in data units, or leave such points out"
            ),
            Self::ReversedTangent { index } => format!(
                "the data run against the tangent of constraint {index}: the derivative there is zero; reverse the \
                 vector, or leave the constraint out"
            ),
            Self::Unordered => "fewer than a third of the points have one of their two neighbours in the list among their \
                 three nearest points: they seem to have no order along a curve, which goes to and fro between them; put \
                 them in order, as \"order\": \"nearest\" does, or fit a surface to scattered points"
                .to_owned(),
            Self::NoData { value, count } => format!(
                "{count} points have the value {value}, which often stands for missing data, and is fitted like all others; \
                 give null for missing points, which least squares leaves out"
            ),
            Self::Between(excursion) => format!(
                "{excursion}: its errors at the data do not show that; give more points there, use \
                 another parametrization or averaged knots, or least squares with fairness"
            ),
            Self::Folded(Fold {
                points: [first, second],
                distance,
            }) => format!(
                "points {first} and {second} have nearly the same parameters and are {distance:.3e} apart, and so are \
                 others: the parameters fold, and no surface is near both; project to another plane, as with \
                 {{\"project\": \"xy\"}}, take foot points on another surface, or give parameters"
            ),
            Self::Spikes { count: 1, index } => format!(
                "point {index} is far from where its neighbours predict it, and the fit is drawn towards it: {ROBUST}"
            ),
            Self::Spikes { count, index } => format!(
                "{count} points, of which the first is point {index}, are far from where their \
                 neighbours predict them, and the fit is drawn towards them: {ROBUST}"
            ),
            Self::RoundedCorners { count: 1, index } => format!(
                "the points have a corner at point {index}, and the curve rounds it: {CORNERS}"
            ),
            Self::RoundedCorners { count, index } => format!(
                "the points have {count} corners, the first at point {index}, and the curve rounds them: {CORNERS}"
            ),
            Self::WithoutData { count } => format!(
                "{count} control points have no data where their functions differ from zero: they stay where they \
                 start; use fewer control points or other knots"
            ),
        }
    }
}
