//! The JSON of a curve or a surface.

use schemars::JsonSchema;
use serde::Deserialize;

use super::basis::{BasisRequest, Degree, ParameterRule, Parameters, parametrization};
use super::ends::{CurveEnds, DirectionEnds, EndsForm, EndsRequest, SurfaceEnds};
use super::places::Places;
use super::scattered::{SurfaceParameterChoice, SurfaceParameters};
use super::schema;
use crate::api::json::lists::WeightList;
use crate::api::json::points::{PointGrid, PointList, ScatteredPoints};
use crate::api::json::schema::numbers::{CurveWeights, SurfaceWeights};
use crate::fit::basis::MAX_DEGREE;
use crate::fit::ends::Ends;
use crate::fit::invalid::{self as fit, Axis};
use crate::fit::parameters::Parametrization;
use crate::fit::points::{Grid, Points};
use crate::model::either::{PerDirection, RuleOrNumbers, Whole, object, whole};
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::scattered::ScatteredSpec;
use crate::model::shape::{AxisSpec, BasisSpec, ShapeSpec};
use crate::model::weights::WeightSpec;

/// A curve through data points.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "CurveInput", example = schema::example_curve())]
pub(in crate::api) struct CurveRequest {
    /// The data points, in their order.
    pub(in crate::api) points: PointList,
    /// The basis; without one a cubic B-spline.
    pub(in crate::api) basis: Option<BasisRequest>,
    /// Short for a B-spline of this degree, instead of `basis`.
    #[serde(default, deserialize_with = "whole")]
    #[schemars(range(min = 1, max = MAX_DEGREE))]
    pub(in crate::api) degree: Option<usize>,
    /// The parameters of the data points; without them `chord_length`.
    #[schemars(with = "Option<Parameters>")]
    pub(in crate::api) parameters: Option<RuleOrNumbers<ParameterRule>>,
    /// Weights of the data points, for a rational curve.
    #[schemars(with = "Option<CurveWeights>")]
    pub(in crate::api) weights: Option<WeightList>,
    /// Whether the curve is a periodic B-spline, which returns to its first point.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<bool>,
    /// How it ends.
    #[schemars(with = "Option<CurveEnds>")]
    pub(in crate::api) ends: Option<EndsRequest>,
}

/// A surface through a grid of data points, or near scattered ones, which only least squares fits: one
/// of `points` and `scattered` is given. `basis`, `parameters` and `closed` are one value for both
/// directions, or one for each.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "SurfaceInput", example = schema::example_surface())]
pub(in crate::api) struct SurfaceRequest {
    /// Rows (u) of columns (v) of data points, or of heights.
    pub(in crate::api) points: Option<PointGrid>,
    /// Points without rows and columns, for least-squares fits; `parameters` says where each of them is.
    pub(in crate::api) scattered: Option<ScatteredPoints>,
    /// The bases; without them cubic B-splines.
    pub(in crate::api) basis: Option<PerDirection<BasisRequest>>,
    /// Short for B-splines of this degree, instead of `basis`.
    #[schemars(with = "Option<PerDirection<Degree>>")]
    pub(in crate::api) degree: Option<PerDirection<Whole>>,
    /// The parameters of the data points; of a grid without them `chord_length`, of heights `uniform`.
    /// Scattered points need them.
    #[schemars(with = "Option<SurfaceParameterChoice>")]
    pub(in crate::api) parameters: Option<SurfaceParameters>,
    /// Weights of the data points, for a rational surface.
    #[schemars(with = "Option<SurfaceWeights>")]
    pub(in crate::api) weights: Option<PerDirection<WeightList>>,
    /// Whether the directions are periodic.
    #[schemars(extend("default" = false))]
    pub(in crate::api) closed: Option<PerDirection<bool>>,
    /// How it ends; one value for both directions, or one for each that is not closed.
    #[schemars(with = "Option<SurfaceEnds>")]
    pub(in crate::api) ends: Option<PerDirection<DirectionEnds>>,
}

object!(CurveRequest, "an object with points");
object!(SurfaceRequest, "an object with points");

/// The data points of a surface as they are asked for.
struct SurfaceData {
    points: Points,
    grid: Grid,
    missing: Vec<usize>,
    /// How scattered points get their parameters.
    scattered: Option<ScatteredSpec>,
    /// How those of a grid do.
    parameters: Option<PerDirection<RuleOrNumbers<ParameterRule>>>,
}

/// The data points of a surface with their parameters: in a grid, or scattered.
fn surface_data(
    points: Option<PointGrid>,
    scattered: Option<ScatteredPoints>,
    parameters: Option<SurfaceParameters>,
) -> Result<SurfaceData, Mistake> {
    match (points, scattered, parameters) {
        (Some(_), Some(_), _) => Err(Mistake::at_text(
            "/surface/scattered",
            "the surface has points in a grid, so it cannot have scattered ones as well",
        )),
        (None, None, _) => Err(Mistake::at_text(
            "/surface",
            "the field \"points\" is missing, or \"scattered\" ones",
        )),
        (Some(_), None, Some(SurfaceParameters::Scattered(_))) => Err(Mistake::at_text(
            "/surface/parameters",
            "pairs, projections and foot points are parameters of scattered points; rows and columns have rules or lists of numbers",
        )),
        (Some(it), None, parameters) => Ok(SurfaceData {
            grid: Grid {
                rows: it.rows,
                columns: it.columns,
            },
            points: it.points,
            missing: it.missing,
            scattered: None,
            parameters: match parameters {
                Some(SurfaceParameters::Grid(parameters)) => Some(parameters),
                _ => None,
            },
        }),
        (None, Some(ScatteredPoints(points)), Some(SurfaceParameters::Scattered(scattered))) => {
            Ok(SurfaceData {
                grid: Grid {
                    rows: points.len(),
                    columns: 1,
                },
                points,
                missing: Vec::new(),
                scattered: Some(scattered),
                parameters: None,
            })
        }
        (None, Some(_), None) => Err(Mistake::at_text(
            "/surface",
            "scattered points need parameters: [[u, v], …], \"project\", {\"project\": \"xy\"} or {\"foot_points\": {\"job\": …}}",
        )),
        (None, Some(_), Some(SurfaceParameters::Grid(_))) => Err(Mistake::at_text(
            "/surface/parameters",
            "scattered points have no rows and columns: their parameters are [[u, v], …], \"project\", {\"project\": \"xy\"} or {\"foot_points\": {\"job\": …}}",
        )),
    }
}

impl CurveRequest {
    /// What it asks for, and where its parts stand.
    pub(super) fn spec(self) -> (ShapeSpec, Places) {
        let places = Places {
            degree_alone: self.degree.is_some(),
            ends: [form(self.ends.as_ref(), false), EndsForm::default()],
            ..Places::of_curve()
        };
        let PointList(points) = self.points;
        let of_degree = self.degree.map(BasisRequest::of_degree);
        let doubled = self.degree.is_some() && self.basis.is_some();
        let spec = ShapeSpec {
            grid: Grid {
                rows: points.len(),
                columns: 1,
            },
            points,
            missing: Vec::new(),
            scattered: None,
            u: AxisSpec {
                basis: basis(self.basis.or(of_degree), doubled, &places),
                parameters: parametrization(self.parameters, Parametrization::ChordLength),
                closed: self.closed.unwrap_or(false),
                ends: ends(self.ends, Axis::U, false),
            },
            v: None,
            weights: weights(self.weights.map(PerDirection::Both), false),
        };
        (spec, places)
    }
}

impl SurfaceRequest {
    /// What it asks for, and where its parts stand.
    pub(super) fn spec(self) -> (OrMistakes<ShapeSpec>, Places) {
        let data = match surface_data(self.points, self.scattered, self.parameters) {
            Ok(data) => data,
            Err(mistake) => return (Err(mistake.into()), Places::default()),
        };
        let doubled = self.degree.is_some() && self.basis.is_some();
        let of_degree = self
            .degree
            .map(|degree| degree.map(|Whole(degree)| BasisRequest::of_degree(degree)));
        let bases = self.basis.or(of_degree);
        let of_each = self.ends.clone().map(|ends| ends.map(|ends| ends.0));
        let (ends_u, ends_v) = of_each.map(PerDirection::split).unzip();
        let (ends_u, ends_v) = (ends_u.flatten(), ends_v.flatten());
        let places = Places {
            degree_alone: self.degree.is_some(),
            basis_each: bases.as_ref().is_some_and(PerDirection::is_each),
            parameters_each: data.parameters.as_ref().is_some_and(PerDirection::is_each),
            scattered: data.scattered.is_some(),
            closed_each: self.closed.is_some_and(|closed| closed.is_each()),
            weights_each: self.weights.as_ref().is_some_and(PerDirection::is_each),
            ends_each: self.ends.as_ref().is_some_and(PerDirection::is_each),
            ends: [&ends_u, &ends_v].map(|it| form(it.as_ref(), true)),
            ..Places::of_surface(data.grid)
        };
        let (basis_u, basis_v) = bases.map(PerDirection::split).unzip();
        let (parameters_u, parameters_v) = data.parameters.map(PerDirection::split).unzip();
        let (closed_u, closed_v) = self.closed.map(PerDirection::split).unzip();
        let usual = Parametrization::usual_of_surface(&data.points);
        let axis = |request, doubled, parameters, closed: Option<bool>, ends| AxisSpec {
            basis: basis(request, doubled, &places),
            parameters: parametrization(parameters, usual.clone()),
            closed: closed.unwrap_or(false),
            ends,
        };
        let (ends_u, ends_v) = (ends(ends_u, Axis::U, true), ends(ends_v, Axis::V, true));
        let spec = ShapeSpec {
            points: data.points,
            grid: data.grid,
            missing: data.missing,
            scattered: data.scattered,
            u: axis(basis_u, doubled, parameters_u, closed_u, ends_u),
            v: Some(axis(basis_v, false, parameters_v, closed_v, ends_v)),
            weights: weights(self.weights, true),
        };
        (Ok(spec), places)
    }
}

/// How the ends of a direction are written.
fn form(request: Option<&EndsRequest>, surface: bool) -> EndsForm {
    request.map(|it| it.form(surface)).unwrap_or_default()
}

/// The ends of a direction.
fn ends(request: Option<EndsRequest>, axis: Axis, surface: bool) -> OrMistakes<Option<Ends>> {
    request.map(|ends| ends.spec(axis, surface)).transpose()
}

/// The basis of a direction. A degree that stands instead of a basis does not stand beside one.
fn basis(request: Option<BasisRequest>, doubled: bool, places: &Places) -> OrMistakes<BasisSpec> {
    if doubled {
        let detail = "a basis is given, which has its degree itself";
        return Err(Mistake::at_text(format!("{}/degree", places.root), detail).into());
    }
    Ok(request.map(BasisSpec::from).unwrap_or_default())
}

/// Weights of a curve, a list, or of a surface, rows or a list for each direction.
pub(super) fn weights(
    weights: Option<PerDirection<WeightList>>,
    surface: bool,
) -> OrMistakes<Option<WeightSpec>> {
    let Some(weights) = weights else {
        return Ok(None);
    };
    let detail = match (weights, surface) {
        (PerDirection::Both(WeightList::Line(weights)), false) => {
            return Ok(Some(WeightSpec::List(weights)));
        }
        (PerDirection::Both(WeightList::Grid { values, columns }), true) => {
            return Ok(Some(WeightSpec::Grid { values, columns }));
        }
        (
            PerDirection::Each {
                u: WeightList::Line(u),
                v: WeightList::Line(v),
            },
            true,
        ) => return Ok(Some(WeightSpec::Axes { u, v })),
        (_, false) => "the weights of a curve are a list of numbers",
        (_, true) => "the weights of a surface are rows of numbers, or {\"u\": […], \"v\": […]}",
    };
    Err(Mistake::at(SpecPart::Fit(fit::Place::Weights), detail).into())
}
