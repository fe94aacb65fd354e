//! A requested curve, and what curves and surfaces have in common.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::basis::{Basis, ParametersInput};
use super::corners::CornersInput;
use super::ends::{CurveEnds, EndsInput};
use super::errors::{ValidationError, ValidationErrors};
use super::lists::PointNumbers;
use super::named::names;
use super::numbers::CurveWeights;
use super::per_direction::PerDirection;
use super::points::PointList;
use super::schema;
use super::serde_helpers::{object, whole};
use super::weights::{self, Rational, Resolved, check_unused};
use piad_fit::basis::MAX_DEGREE;
use piad_fit::data::{Grid, Points};
use piad_fit::engine::{DirectionChoice, Request, Weights};
use piad_fit::invalid::Axis;
use piad_fit::parameters::Parametrization;

/// A curve through data points.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_curve())]
pub(crate) struct CurveInput {
    /// The data points, in their order.
    pub points: PointList,
    /// The basis; without one a cubic B-spline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub basis: Option<Basis>,
    /// Short for a B-spline of this degree, instead of `basis`.
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(range(min = 1, max = MAX_DEGREE))]
    pub degree: Option<usize>,
    /// The parameters of the data points; without them `chord_length`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<ParametersInput>,
    /// Weights of the data points, for a rational curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<CurveWeights>")]
    pub weights: Option<PointNumbers>,
    /// True if the curve returns to its first point: a periodic B-spline, or with corners one that is clamped at the
    /// first of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub closed: Option<bool>,
    /// Its ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<CurveEnds>")]
    pub ends: Option<EndsInput>,
    /// The corners; default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corners: Option<CornersInput>,
    /// True if the edges between the points are data, too. Such a curve is fitted with `control_points` `"auto"`, and
    /// turns at all points at which the edges do by more than 30 degrees, unless `corners` are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub polyline: Option<bool>,
    /// The order of the points: that in which they are given, or the nearest one where they have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<PointOrder>,
    /// The treatment of points that equal the one before them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeated_points: Option<RepeatedPoints>,
}

/// The order of the points of a curve: `given`, or `nearest`, in which they are put before they are fitted: along the
/// shortest tree that connects them. Points that branch are refused.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case", extend("default" = "given"), example = &"nearest")]
pub(crate) enum PointOrder {
    Given,
    Nearest,
}

names!(PointOrder, "order of points", [
    "given" => Given,
    "nearest" => Nearest,
]);

/// The treatment of points of a curve that equal the one before them: `refuse`, where their parameters do not increase,
/// or `merge`, which keeps each once, and of a closed curve the first point alone where the last one equals it.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case", extend("default" = "refuse"), example = &"merge")]
pub(crate) enum RepeatedPoints {
    Refuse,
    Merge,
}

names!(RepeatedPoints, "treatment of repeated points", [
    "refuse" => Refuse,
    "merge" => Merge,
]);

object!(CurveInput, "an object with points");

/// The settings of a direction.
pub(super) struct DirectionInput {
    pub(super) basis: Option<Basis>,
    pub(super) parameters: Option<ParametersInput>,
    pub(super) closed: Option<bool>,
    pub(super) ends: Option<EndsInput>,
}

impl DirectionInput {
    /// The direction with defaults filled in, but for weights.
    pub(super) fn choice(
        self,
        axis: Axis,
        usual: Parametrization,
        is_surface: bool,
        errors: &mut ValidationErrors,
    ) -> Option<DirectionChoice> {
        let basis = errors.keep(self.basis.unwrap_or_default().choice(axis));
        let ends = self.ends.map(|ends| ends.ends(axis, is_surface));
        let ends = errors.keep(ends.transpose());
        Some(DirectionChoice {
            closed: self.closed.unwrap_or(false),
            ends: ends?,
            ..DirectionChoice::new(
                basis?,
                self.parameters.map_or(usual, |ParametersInput(rule)| rule),
            )
        })
    }
}

/// The weights of points as a fit uses them, or none where they are invalid.
pub(super) fn resolved(
    weights: Option<PerDirection<PointNumbers>>,
    rational: Option<Rational>,
    (grid, is_surface): (Grid, bool),
    errors: &mut ValidationErrors,
) -> Resolved {
    let weights = match weights {
        None => check_unused(rational).map(|()| Weights::None.into()),
        Some(weights) => Resolved::new(weights, rational, grid, is_surface),
    };
    errors.keep(weights).unwrap_or(Weights::None.into())
}

/// Refuses a degree beside a basis.
pub(super) fn check_degree(is_doubled: bool, root: &str, errors: &mut ValidationErrors) {
    if is_doubled {
        let detail = "a basis is given, which has its degree itself";
        errors.push(ValidationError::at_text(format!("{root}/degree"), detail));
    }
}

/// A problem with these points and directions, without a method and without an end.
pub(super) fn problem(
    points: Arc<Points>,
    grid: Grid,
    (mut u, mut v): (DirectionChoice, Option<DirectionChoice>),
    weights: Resolved,
) -> Request {
    u.weights = weights.u;
    if let Some(v) = &mut v {
        v.weights = weights.v;
    }
    Request {
        weights: weights.weights,
        max_iterations: 0,
        ..Request::new(points, grid, u, v)
    }
}

impl CurveInput {
    /// The problem of fitting it, also if there are errors outside the points.
    pub(super) fn request(
        self,
        rational: Option<Rational>,
        errors: &mut ValidationErrors,
    ) -> Option<Request> {
        let grid = self.points.grid();
        let weights = self.weights.map(PerDirection::Both);
        let weights = resolved(weights, rational, (grid, false), errors);
        check_degree(
            self.degree.is_some() && self.basis.is_some(),
            "/curve",
            errors,
        );
        let u = DirectionInput {
            basis: self.basis.or(self.degree.map(Basis::of_degree)),
            parameters: self.parameters,
            closed: self.closed,
            ends: self.ends,
        };
        let u = u.choice(Axis::U, Parametrization::ChordLength, false, errors)?;
        let u = DirectionChoice {
            corners: self.corners.map(|CornersInput(corners)| corners),
            ..u
        };
        Some(Request {
            polyline: self.polyline.unwrap_or(false),
            unordered: self.order == Some(PointOrder::Nearest),
            merge_repeated: self.repeated_points == Some(RepeatedPoints::Merge),
            ..problem(self.points.0, grid, (u, None), weights)
        })
    }

    /// The curve of a problem in the form of a request.
    pub(super) fn of(request: &Request) -> Self {
        let weights = match weights::requested(request) {
            Some(PerDirection::Both(weights)) => Some(weights),
            // Only a surface has a list for each direction.
            Some(PerDirection::Each { .. }) | None => None,
        };
        Self {
            points: PointList(Arc::clone(&request.points)),
            basis: Some(Basis::from(&request.u.basis)),
            degree: None,
            parameters: Some(ParametersInput(request.u.parameters.clone())),
            weights,
            closed: Some(request.u.closed),
            ends: request.u.ends.as_ref().map(|it| EndsInput::of(it, false)),
            corners: request.u.corners.clone().map(CornersInput),
            polyline: request.polyline.then_some(true),
            order: request.unordered.then_some(PointOrder::Nearest),
            repeated_points: request.merge_repeated.then_some(RepeatedPoints::Merge),
        }
    }
}
