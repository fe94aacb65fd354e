//! The JSON of a method, and its settings.
//!
//! - `kinds`: the kinds of methods, and names of settings;
//! - `least_squares`: the settings of least squares, with `constraint`;
//! - `written`: methods as they were asked for.

mod constraint;
pub(in crate::api) mod counts;
mod kinds;
mod least_squares;
mod written;

use std::sync::Arc;

use schemars::{JsonSchema, Schema};

use super::schema;
use super::settings::{DataWeights, Index, Matrix, Omega, Thresholds};
use crate::api::json::numbers::WeightList;
use crate::api::json::per_direction::{PerDirection, direction};
use crate::api::json::read::{Read as _, object};
use crate::fit::invalid::{Place as P, Setting};
use crate::fit::method::{
    self as fit, Adaptive, Convex, Custom, Extended, Local, METHODS, MOST_CONDITIONS, Method,
    Start, Sweeps, Weighted,
};
use crate::fit::points::Grid;
use crate::model::method::{MethodSpec, mu_without_lspia, sweeps};
use crate::model::mistakes::{Mistake, Mistakes, OrMistakes, SpecPart};
use constraint::ConstraintRequest;
use counts::{ControlPointCount, ControlPoints, MostControlPoints};
use kinds::{EndPointsRequest, EndingRequest};

pub(in crate::api) use kinds::{
    MethodKind, StartRequest, SweepsRequest, VariantRequest, start_name, sweeps_name, variant_name,
};
pub(in crate::api) use written::written;

/// The settings of the methods that have some.
const SETTINGS: [(&str, &[&str]); 7] = [
    ("weighted", &["omega"]),
    ("local", &["indices", "row_by_row", "sweeps", "omega"]),
    ("adaptive", &["threshold", "omega"]),
    ("convex", &["threshold"]),
    ("extended", &["start", "transformed_error"]),
    (
        "least_squares",
        &[
            "control_points",
            "max_control_points",
            "correct_parameters",
            "variant",
            "mu",
            "ending",
            "ends",
            "data_weights",
            "fairness",
            "fairness_order",
            "constraints",
        ],
    ),
    ("custom", &["transform"]),
];

/// The settings of a method.
pub(in crate::api) fn settings(kind: &str) -> &'static [&'static str] {
    let entry = SETTINGS.iter().find(|(method, _)| *method == kind);
    entry.map_or(&[], |(_, settings)| settings)
}

/// The methods that have a setting.
fn owners(setting: &str) -> Vec<&'static str> {
    let own = SETTINGS.iter().filter(|(_, own)| own.contains(&setting));
    own.map(|(kind, _)| *kind).collect()
}

/// Says in the schema which kinds of methods there are, and to which of them a setting belongs.
fn explain(schema: &mut Schema) {
    schema::explain(schema, &METHODS);
    let mut said = Vec::new();
    for name in SETTINGS.iter().flat_map(|(_, settings)| *settings) {
        if !said.contains(name) {
            schema::belongs(schema, name, &owners(name));
            said.push(*name);
        }
    }
}

/// How the control points move from iteration to iteration.
// Which settings belong to which kind is checked after reading, so that the error can say it.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "Method", transform = explain, example = schema::example_method())]
pub(in crate::api) struct MethodRequest {
    /// The kind of the method.
    pub(in crate::api) kind: MethodKind,
    /// The relaxation. Without one it is `auto` for `weighted`, and 1 for the others.
    pub(in crate::api) omega: Option<Omega>,
    /// The data points whose control points may move.
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub(in crate::api) indices: Option<Vec<Index>>,
    /// Surfaces: one row after the other, in sweeps until all are within the tolerance; short for the
    /// sweeps `rows`.
    pub(in crate::api) row_by_row: Option<bool>,
    /// Surfaces: the lines of points that are adjusted one after the other, until all are within the
    /// tolerance.
    pub(in crate::api) sweeps: Option<SweepsRequest>,
    /// With `adaptive` only control points move whose data point is further away than this, in data
    /// units. With `convex` bisection ends as near as this part of the plain step to the longest one
    /// that keeps the turns: a number below 1, by default 1e-6.
    pub(in crate::api) threshold: Option<Thresholds>,
    /// What iteration 0 is.
    pub(in crate::api) start: Option<StartRequest>,
    /// Whether each iteration tells the largest length of U Δ, too, as `error.transformed`: how far a
    /// control point moves in the next one.
    #[schemars(extend("default" = false))]
    pub(in crate::api) transformed_error: Option<bool>,
    /// The number of control points; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<ControlPoints>")]
    pub(in crate::api) control_points: Option<PerDirection<ControlPointCount>>,
    /// With control_points `auto`: the most control points. Without it as many as data points.
    #[schemars(with = "Option<MostControlPoints>")]
    pub(in crate::api) max_control_points: Option<PerDirection<usize>>,
    /// With control_points `auto`, for curves: whether the parameters of the data move to the points of the curve that are nearest to them, so that errors are distances from the curve. Without it false.
    pub(in crate::api) correct_parameters: Option<bool>,
    /// The step.
    pub(in crate::api) variant: Option<VariantRequest>,
    /// The length of the step; without one 1 / (largest column sum).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) mu: Option<f64>,
    /// Where the fit ends besides its tolerance and its last iteration.
    pub(in crate::api) ending: Option<EndingRequest>,
    /// Whether it passes through its end points at every iteration.
    pub(in crate::api) ends: Option<EndPointsRequest>,
    /// How much each data point counts in the sum of squares: of a curve a list of numbers that are not
    /// negative, of a surface rows of them.
    #[schemars(with = "Option<DataWeights>")]
    pub(in crate::api) data_weights: Option<WeightList>,
    /// How smooth it is to be: a multiple of the integral of the squared derivative is added to the sum
    /// of squares. It is free of units: with n data points whose parameters have the range l, the
    /// multiple is `fairness · l^(2r − 1) / n` on curves and `fairness · (l_u l_v)^(r − 1) / n` on
    /// surfaces.
    #[schemars(extend("minimum" = 0))]
    pub(in crate::api) fairness: Option<f64>,
    /// The order r of that derivative.
    #[schemars(range(min = 2, max = 3), extend("default" = 2))]
    pub(in crate::api) fairness_order: Option<usize>,
    /// What every iteration obeys: points to pass through and derivatives.
    #[schemars(length(min = 1, max = MOST_CONDITIONS))]
    pub(in crate::api) constraints: Option<Vec<ConstraintRequest>>,
    /// The transform U in `X ← X + U (P − B X)`; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<PerDirection<Matrix>>")]
    pub(in crate::api) transform: Option<PerDirection<Matrix>>,
}

object!(
    MethodRequest,
    "an object with a kind, or the name of a kind",
    [
        kind,
        omega,
        indices,
        row_by_row,
        sweeps,
        threshold,
        start,
        transformed_error,
        control_points,
        max_control_points,
        correct_parameters,
        variant,
        mu,
        ending,
        ends,
        data_weights,
        fairness,
        fairness_order,
        constraints,
        transform,
    ],
    of_name: |name, at| MethodKind::reader().text(name, at).map(MethodRequest::of),
    fields_by kind: fields
);

/// The fields of a method of this kind.
fn fields(kind: &MethodKind) -> Vec<&'static str> {
    let settings = settings(kind.name()).iter().copied();
    std::iter::once("kind").chain(settings).collect()
}

impl MethodRequest {
    /// A method without settings.
    pub(in crate::api) fn of(kind: MethodKind) -> Self {
        Self {
            kind,
            omega: None,
            indices: None,
            row_by_row: None,
            sweeps: None,
            threshold: None,
            start: None,
            transformed_error: None,
            control_points: None,
            max_control_points: None,
            correct_parameters: None,
            variant: None,
            mu: None,
            ending: None,
            ends: None,
            data_weights: None,
            fairness: None,
            fairness_order: None,
            constraints: None,
            transform: None,
        }
    }

    /// How it is written.
    pub(super) fn form(&self) -> MethodForm {
        let transform = self.transform.as_ref();
        let most = self.max_control_points;
        MethodForm {
            each: self.control_points.is_some_and(|count| count.is_each())
                || most.is_some_and(|most| most.is_each())
                || transform.is_some_and(PerDirection::is_each),
            limited: most.is_some(),
        }
    }

    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(super) fn spec(self, grid: Grid, surface: bool) -> OrMistakes<MethodSpec> {
        self.check_settings()?;
        let selected = self.selected(grid, surface)?;
        let method = match self.kind {
            MethodKind::Global => Method::Global,
            MethodKind::Weighted => Method::Weighted(Weighted {
                omega: match self.omega {
                    None | Some(Omega::Auto) => None,
                    Some(Omega::Given(omega)) => Some(omega),
                },
            }),
            MethodKind::Local => {
                let settings = Local {
                    omega: match self.omega {
                        None => fit::Omega::default(),
                        Some(Omega::Auto) => fit::Omega::Best,
                        Some(Omega::Given(omega)) => fit::Omega::Given(omega),
                    },
                    sweeps: sweeps(self.sweeps.map(Sweeps::from), self.row_by_row, surface)?,
                };
                return MethodSpec::local(selected, settings);
            }
            MethodKind::Adaptive => Method::Adaptive(self.adaptive(grid, surface)?),
            MethodKind::Extended => Method::Extended(Extended {
                start: match self.start {
                    None | Some(StartRequest::Transformed) => Start::Transformed,
                    Some(StartRequest::Data) => Start::Data,
                },
                transformed_error: self.transformed_error.unwrap_or(false),
            }),
            MethodKind::Transpose => Method::Transpose,
            MethodKind::Convex => Method::Convex(self.convex()?),
            MethodKind::Chebyshev => Method::Chebyshev,
            MethodKind::Direct => Method::Direct,
            MethodKind::LeastSquares => Method::LeastSquares(self.least_squares(grid, surface)?),
            MethodKind::Custom => Method::Custom(match self.transform {
                Some(PerDirection::Both(Matrix(u))) => Custom::new(u, None),
                Some(PerDirection::Each { u, v }) => Custom::new(u.0, Some(v.0)),
                None => {
                    return incomplete(
                        "custom needs a transform: the rows of a matrix, on surfaces also {\"u\": …, \"v\": …}",
                    );
                }
            }),
        };
        Ok(MethodSpec { method, selected })
    }

    /// Refuses settings of other methods.
    pub(super) fn check_settings(&self) -> OrMistakes<()> {
        let given = [
            ("omega", self.omega.is_some()),
            ("indices", self.indices.is_some()),
            ("row_by_row", self.row_by_row.is_some()),
            ("sweeps", self.sweeps.is_some()),
            ("threshold", self.threshold.is_some()),
            ("start", self.start.is_some()),
            ("transformed_error", self.transformed_error.is_some()),
            ("control_points", self.control_points.is_some()),
            ("max_control_points", self.max_control_points.is_some()),
            ("correct_parameters", self.correct_parameters.is_some()),
            ("variant", self.variant.is_some()),
            ("mu", self.mu.is_some()),
            ("ending", self.ending.is_some()),
            ("ends", self.ends.is_some()),
            ("data_weights", self.data_weights.is_some()),
            ("fairness", self.fairness.is_some()),
            ("fairness_order", self.fairness_order.is_some()),
            ("constraints", self.constraints.is_some()),
            ("transform", self.transform.is_some()),
        ];
        let own = settings(self.kind.name());
        let mut mistakes = Mistakes::default();
        for (name, given) in given {
            if given && !own.contains(&name) {
                let detail = format!("{name} is a setting of {}", methods(&owners(name)));
                mistakes.push(Mistake::at_text(format!("/method/{name}"), detail));
            }
        }
        let lspia = self.variant == Some(VariantRequest::Lspia);
        if self.kind == MethodKind::LeastSquares && self.mu.is_some() && !lspia {
            mistakes.push(mu_without_lspia());
        }
        mistakes.or(())
    }

    fn convex(&self) -> OrMistakes<Convex> {
        match self.threshold {
            None => Ok(Convex::default()),
            Some(Thresholds::All(threshold)) => Ok(Convex { threshold }),
            Some(Thresholds::Each(_)) => {
                let place = P::Setting(Setting::Threshold);
                let detail = "convex has one threshold, a part of its step";
                Err(Mistake::at(SpecPart::Fit(place), detail).into())
            }
        }
    }

    fn adaptive(self, grid: Grid, surface: bool) -> OrMistakes<Adaptive> {
        let omega = match self.omega {
            None => 1.0,
            Some(Omega::Given(omega)) => omega,
            Some(Omega::Auto) => {
                let detail = "adaptive needs a number: the best omega is another one for each choice of points";
                let place = P::Setting(Setting::Omega);
                return Err(Mistake::at(SpecPart::Fit(place), detail).into());
            }
        };
        let Some(threshold) = self.threshold else {
            return incomplete("adaptive needs a threshold, in data units");
        };
        let place = P::Setting(Setting::Threshold);
        let wrong = |detail| Mistake::at(SpecPart::Fit(place), detail);
        let threshold = threshold.of_points(grid, surface).map_err(wrong)?;
        Ok(Adaptive { threshold, omega })
    }

    fn selected(&self, grid: Grid, surface: bool) -> OrMistakes<Option<Arc<[usize]>>> {
        let Some(given) = &self.indices else {
            return Ok(None);
        };
        let mut indices = Vec::with_capacity(given.len());
        for (k, index) in given.iter().enumerate() {
            let index = index.of_point(grid, surface);
            let wrong = |detail| Mistake::at(SpecPart::Fit(P::Index(k)), detail);
            indices.push(index.map_err(wrong)?);
        }
        Ok(Some(indices.into()))
    }
}

/// The methods of a setting, as a message names them.
fn methods(names: &[&str]) -> String {
    match names {
        [name] => format!("the method {name:?}"),
        _ => format!("the methods {}", names.join(", ")),
    }
}

/// A setting is missing.
fn incomplete<T>(detail: &str) -> OrMistakes<T> {
    Err(Mistake::at(SpecPart::Fit(P::Method), detail).into())
}

/// How a method is written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MethodForm {
    /// The directions have a setting each.
    each: bool,
    /// The numbers of control points are limits.
    limited: bool,
}

/// The JSON pointer to a setting, or a part of it; everything else is the method.
pub(super) fn pointer(place: P, MethodForm { each, limited }: MethodForm) -> String {
    let setting = match place {
        P::Setting(setting) => setting.name().to_owned(),
        P::Index(index) => format!("indices/{index}"),
        P::Constraint(index) => format!("constraints/{index}"),
        P::ControlPoints(axis) if limited => {
            format!("max_control_points{}", direction(each, axis))
        }
        P::ControlPoints(axis) => format!("control_points{}", direction(each, axis)),
        P::Transform(axis) => format!("transform{}", direction(each, axis)),
        P::TransformRow(axis, row) => format!("transform{}/{row}", direction(each, axis)),
        P::TransformEntry(axis, row, column) => {
            format!("transform{}/{row}/{column}", direction(each, axis))
        }
        _ => return "/method".to_owned(),
    };
    format!("/method/{setting}")
}
