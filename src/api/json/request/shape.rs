//! The JSON of a curve or a surface.

use schemars::JsonSchema;

use super::basis::{BasisRequest, Degree, ParameterRule, Parameters, basis, parametrization};
use super::invalid::invalid;
use super::mistakes::Mistakes;
use super::places::Places;
use super::schema;
use super::weights::{RationalRequest, curve_weights, surface_weights};
use crate::api::json::numbers::{PointGrid, PointList, RuleOrNumbers, WeightList};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::object;
use crate::api::json::read::values::Count;
use crate::api::json::schema::numbers::{SurfaceWeights, Weights as CurveWeights};
use crate::api::problem::Problem;
use crate::fit::basis::MAX_DEGREE;
use crate::fit::direction::DirectionChoice;
use crate::fit::invalid::Axis;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Weights;

/// A curve through data points.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "CurveInput", example = schema::example_curve())]
pub(in crate::api) struct CurveRequest {
    /// The data points, in their order.
    pub(in crate::api) points: PointList,
    /// The basis; without one a cubic B-spline.
    pub(in crate::api) basis: Option<BasisRequest>,
    /// Short for a B-spline of this degree, instead of `basis`.
    #[schemars(range(min = 1, max = MAX_DEGREE))]
    pub(in crate::api) degree: Option<Count>,
    /// The parameters of the data points; without them `chord_length`.
    #[schemars(with = "Option<Parameters>")]
    pub(in crate::api) parameters: Option<RuleOrNumbers<ParameterRule>>,
    /// Weights of the data points, for a rational curve.
    #[schemars(with = "Option<CurveWeights>")]
    pub(in crate::api) weights: Option<WeightList>,
    /// Whether the curve is a periodic B-spline, which returns to its first point.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<bool>,
}

/// A surface through a grid of data points. `basis`, `parameters` and `closed` are one value for
/// both directions, or one for each.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "SurfaceInput", example = schema::example_surface())]
pub(in crate::api) struct SurfaceRequest {
    /// Rows (u) of columns (v) of data points.
    pub(in crate::api) points: PointGrid,
    /// The bases; without them cubic B-splines.
    pub(in crate::api) basis: Option<PerDirection<BasisRequest>>,
    /// Short for B-splines of this degree, instead of `basis`.
    #[schemars(with = "Option<PerDirection<Degree>>")]
    pub(in crate::api) degree: Option<PerDirection<Count>>,
    /// The parameters of the data points; without them `chord_length`.
    #[schemars(with = "Option<PerDirection<Parameters>>")]
    pub(in crate::api) parameters: Option<PerDirection<RuleOrNumbers<ParameterRule>>>,
    /// Weights of the data points, for a rational surface.
    #[schemars(with = "Option<SurfaceWeights>")]
    pub(in crate::api) weights: Option<PerDirection<WeightList>>,
    /// Whether the directions are periodic.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<PerDirection<bool>>,
}

object!(
    CurveRequest,
    "an object with points",
    [points, basis, degree, parameters, weights, closed]
);
object!(
    SurfaceRequest,
    "an object with points",
    [points, basis, degree, parameters, weights, closed]
);
/// What curves and surfaces have in common.
pub(super) struct Shape {
    pub(super) points: Points,
    pub(super) grid: Grid,
    pub(super) u: DirectionChoice,
    pub(super) v: Option<DirectionChoice>,
    pub(super) missing: Vec<usize>,
    pub(super) weights: Weights,
    pub(super) places: Places,
}

impl CurveRequest {
    /// What there is of it, also if there are mistakes beside the points.
    pub(super) fn shape(
        self,
        rational: Option<RationalRequest>,
        mistakes: &mut Mistakes,
    ) -> Option<Shape> {
        let degree = check_degree(self.degree.is_some(), self.basis.is_some(), "/curve");
        mistakes.keep(degree);
        let short = self.degree.is_some();
        let of_degree = self.degree.map(BasisRequest::of_degree);
        let PointList(points) = self.points;
        let grid = Grid {
            rows: points.len(),
            columns: 1,
        };
        let weights = mistakes.keep(curve_weights(self.weights, rational));
        let (weights, fixed) = weights.unwrap_or((Weights::None, None));
        let basis = mistakes.keep(basis(self.basis.or(of_degree), "/curve/basis"));
        Some(Shape {
            points,
            grid,
            u: DirectionChoice {
                basis: basis?,
                parameters: parametrization(self.parameters),
                closed: self.closed.unwrap_or(false),
                control_points: None,
                weights: fixed,
            },
            v: None,
            missing: Vec::new(),
            weights,
            places: Places {
                degree_alone: short,
                ..Places::default()
            },
        })
    }
}

impl SurfaceRequest {
    /// What there is of it, also if there are mistakes beside the points.
    pub(super) fn shape(
        self,
        rational: Option<RationalRequest>,
        mistakes: &mut Mistakes,
    ) -> Option<Shape> {
        let degree = check_degree(self.degree.is_some(), self.basis.is_some(), "/surface");
        mistakes.keep(degree);
        let degree_alone = self.degree.is_some();
        let of_degree = self
            .degree
            .map(|degree| degree.map(BasisRequest::of_degree));
        let bases = self.basis.or(of_degree);
        let PointGrid {
            points,
            missing,
            rows,
            columns,
        } = self.points;
        let grid = Grid { rows, columns };
        let places = Places {
            surface_columns: Some(columns),
            degree_alone,
            basis_each: bases.as_ref().is_some_and(PerDirection::is_each),
            parameters_each: self.parameters.as_ref().is_some_and(PerDirection::is_each),
            closed_each: self.closed.is_some_and(|closed| closed.is_each()),
            weights_each: self.weights.as_ref().is_some_and(PerDirection::is_each),
            control_points_each: false,
            transform_each: false,
        };
        let weights = surface_weights(self.weights, rational, grid, "/surface/weights");
        let weights = mistakes.keep(weights);
        let (weights, fixed) = weights.unwrap_or((Weights::None, None));
        let (basis_u, basis_v) = bases.map(PerDirection::split).unzip();
        let (parameters_u, parameters_v) = self.parameters.map(PerDirection::split).unzip();
        let (closed_u, closed_v) = self.closed.map(PerDirection::split).unzip();
        let (fixed_u, fixed_v) = fixed.unzip();
        let mut direction = |axis, request, parameters, closed: Option<bool>, weights| {
            let basis = mistakes.keep(basis(request, &places.basis(axis)));
            Some(DirectionChoice {
                basis: basis?,
                parameters: parametrization(parameters),
                closed: closed.unwrap_or(false),
                control_points: None,
                weights,
            })
        };
        let u = direction(Axis::U, basis_u, parameters_u, closed_u, fixed_u);
        let v = direction(Axis::V, basis_v, parameters_v, closed_v, fixed_v);
        Some(Shape {
            points,
            grid,
            u: u?,
            v: Some(v?),
            missing,
            weights,
            places,
        })
    }
}

/// A degree that stands instead of a basis does not stand beside one.
fn check_degree(degree: bool, basis: bool, root: &str) -> Result<(), Problem> {
    if degree && basis {
        let detail = "a basis is given, which has its degree itself";
        return Err(invalid(&format!("{root}/degree"), detail));
    }
    Ok(())
}

pub(super) fn check_count(shape: &Shape, limit: usize) -> Result<(), Problem> {
    let count = shape.grid.count();
    if count > limit {
        let detail = format!("{count} points are more than {limit}, the limit of this server");
        return Err(invalid(&format!("{}/points", shape.places.root()), detail));
    }
    Ok(())
}
