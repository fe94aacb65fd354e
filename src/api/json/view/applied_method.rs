//! The method of a job as a part of its resource.

use schemars::JsonSchema;
use serde::Serialize;

use crate::job::outline::Outline;
use crate::model::method::counts::{ControlPointCount, ControlPoints, MostControlPoints};
use crate::model::method::{LeastSquaresInput, MethodKind, StartInput, SweepsInput, VariantKind};
use crate::model::per_direction::PerDirection;
use crate::model::serde_helpers::Whole;
use piad_fit::engine::Forecast;
use piad_fit::method::{Adaptive, Convex, Local, Method, Threshold, Weighted};

/// The method of a job, with numbers that were computed for it.
#[derive(Default, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"kind": "weighted", "omega": 1.37, "lambda_min": 0.46}]))]
pub(super) struct AppliedMethod {
    /// The kind.
    #[schemars(with = "MethodKind")]
    kind: &'static str,
    /// Weighted, local and adaptive: the relaxation; null until it is computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    omega: Option<Option<f64>>,
    /// Local: how many control points may move.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "usize")]
    adjusted: Option<usize>,
    /// Local: the lines of points that are swept one after the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "SweepsInput")]
    sweeps: Option<SweepsInput>,
    /// Adaptive: the distance beyond which control points move; left out if each point has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    threshold: Option<f64>,
    /// Convex: the accuracy of the bisection for the longest step that keeps the turns, as a part of the plain step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    step_tolerance: Option<f64>,
    /// Extended: what iteration 0 is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "StartInput")]
    start: Option<StartInput>,
    /// Extended PIA: true if `error.transformed` is reported.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "bool")]
    transformed_error: Option<bool>,
    /// Least squares: the number of control points.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "ControlPoints")]
    control_points: Option<PerDirection<ControlPointCount>>,
    /// Automatic least squares: the most control points.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "MostControlPoints")]
    max_control_points: Option<PerDirection<Whole>>,
    /// Automatic least squares: parameters move to the nearest points of the curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    correct_parameters: Option<bool>,
    /// Least squares: the step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "VariantKind")]
    variant: Option<VariantKind>,
    /// Least squares: the fairness, also if the data have chosen it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    fairness: Option<f64>,
    /// The least eigenvalue of the collocation matrix, where it is known; of local fits of few points
    /// that of their block.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    lambda_min: Option<f64>,
}

impl AppliedMethod {
    /// The method with its settings, and with the numbers that were computed for it.
    pub(super) fn new(outline: &Outline, forecast: Option<Forecast>) -> Self {
        let mut view = Self {
            kind: outline.method.name(),
            lambda_min: forecast.and_then(|it| it.block.or(it.lambda_min)),
            ..Self::default()
        };
        match &outline.method {
            Method::Weighted(Weighted { omega }) => {
                view.omega = Some(forecast.and_then(|it| it.omega).or(*omega));
            }
            Method::Local(Local { omega, sweeps }) => {
                let used = forecast.and_then(|it| it.omega);
                view.omega = Some(used.or(omega.given()));
                view.adjusted = outline.adjusted;
                view.sweeps = sweeps.map(SweepsInput);
            }
            Method::Adaptive(Adaptive { threshold, omega }) => {
                view.threshold = match threshold {
                    Threshold::All(threshold) => Some(*threshold),
                    Threshold::Each(_) => None,
                };
                view.omega = Some(Some(*omega));
            }
            Method::Convex(Convex { step_tolerance }) => {
                view.step_tolerance = Some(*step_tolerance);
            }
            Method::Extended(settings) => {
                view.start = Some(StartInput(settings.start));
                view.transformed_error = settings.transformed_error.then_some(true);
            }
            Method::LeastSquares(settings) => {
                let input = LeastSquaresInput::of(settings, outline.grid, outline.surface);
                view.control_points = input.control_points;
                view.max_control_points = input.max_control_points;
                view.correct_parameters = input.correct_parameters;
                view.variant = input.variant;
                view.fairness = settings.fairness.map(|it| it.value);
            }
            _ => {}
        }
        view
    }
}
