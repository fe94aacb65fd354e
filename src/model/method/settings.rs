//! Requested settings of methods, and their form for a fit.

use std::sync::Arc;

use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Serialize};

use super::choice::MethodChoice;
use crate::model::errors::{OrErrors, SpecPart, ValidationError};
use crate::model::list_limits::for_points;
use crate::model::named::{Named, setting};
use crate::model::per_direction::PerDirection;
use crate::model::schema::{names as schema_of_names, schema_of};
use crate::model::serde_helpers::AtMost;
use crate::model::settings::{Index, Matrix, Omega, Thresholds};
use piad_fit::data::Grid;
use piad_fit::engine::Request;
use piad_fit::invalid::{Place as P, Setting};
use piad_fit::method::{
    self as fit, Adaptive, Convex, Custom, Extended, Local, Method, Start, Sweeps, Weighted,
};

/// Settings of weighted PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WeightedInput {
    /// The relaxation. Without one it is `auto` for `weighted`, and 1 for the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of local PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LocalInput {
    /// The data points whose control points may move.
    #[serde(
        default,
        deserialize_with = "for_points",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub indices: Option<Vec<Index>>,
    /// Surfaces: the lines of points that are adjusted one after the other, until all are within the
    /// tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweeps: Option<SweepsInput>,
    /// The relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of adaptive PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AdaptiveInput {
    /// Only control points move whose data point is further away than this, in data units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<Thresholds>,
    /// The relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Omega>,
}

/// Settings of extended PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExtendedInput {
    /// The start of the iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartInput>,
    /// True if each iteration also reports the largest length of U Δ, as `error.transformed`: how far a control point
    /// moves in the next one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub transformed_error: Option<bool>,
}

/// Settings of convexity-preserving PIA.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConvexInput {
    /// How near bisection comes to the longest step that keeps the turns, as a part of the plain step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "default" = 1e-6))]
    pub step_tolerance: Option<f64>,
}

/// Settings of PIA with a given transform.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CustomInput {
    /// The transform U in `X ← X + U (P − B X)`; on surfaces of both directions, or one for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<PerDirection<Matrix>>,
}

setting!(
    /// A requested start.
    StartInput(Start), "start of the method extended", [
    "transformed" => Transformed,
    "data" => Data,
]);
setting!(
    /// Requested sweeps.
    SweepsInput(Sweeps), "kind of sweeps", [
    "rows" => Rows,
    "columns" => Columns,
]);

schema_of!(
    StartInput,
    "ExtendedStart",
    schema_of_names::<Self>(
        "What iteration 0 of the extended method is: the transformed data, or the data themselves."
    )
);
schema_of!(
    SweepsInput,
    "Sweeps",
    json_schema!({
        "description": "The lines of points of a surface that sweeps go by.",
        "type": "string",
        "enum": SweepsInput::names(),
        "examples": ["columns"],
    })
);

impl WeightedInput {
    pub(super) fn settings(self) -> Weighted {
        let omega = self.omega.and_then(|Omega(omega)| omega);
        Weighted { omega }
    }

    pub(super) fn of(weighted: Weighted) -> Self {
        let omega = Some(Omega(weighted.omega));
        Self { omega }
    }
}

impl ExtendedInput {
    pub(super) fn settings(self) -> Extended {
        Extended {
            start: self
                .start
                .map_or(Start::default(), |StartInput(start)| start),
            transformed_error: self.transformed_error.unwrap_or(false),
        }
    }

    pub(super) fn of(extended: Extended) -> Self {
        Self {
            start: Some(StartInput(extended.start)),
            transformed_error: extended.transformed_error.then_some(true),
        }
    }
}

impl ConvexInput {
    pub(super) fn settings(self) -> Convex {
        let convex = self
            .step_tolerance
            .map(|step_tolerance| Convex { step_tolerance });
        convex.unwrap_or_default()
    }

    pub(super) fn of(convex: Convex) -> Self {
        let is_other = convex != Convex::default();
        Self {
            step_tolerance: is_other.then_some(convex.step_tolerance),
        }
    }
}

impl LocalInput {
    pub(super) fn choice(self, grid: Grid, surface: bool) -> OrErrors<MethodChoice> {
        let selected = self.indices.map(|mut given| {
            // If there are more indices than points, one is invalid, or given twice.
            given.truncate(grid.count().saturating_add(1));
            let of_point = |(k, index): (usize, Index)| {
                let wrong = |detail| ValidationError::at(SpecPart::Fit(P::Index(k)), detail);
                index.of_point(grid, surface).map_err(wrong)
            };
            given.into_iter().enumerate().map(of_point).collect()
        });
        let selected: Option<Arc<[usize]>> = selected.transpose()?;
        if self.sweeps.is_some() && !surface {
            let place = P::Setting(Setting::Sweeps);
            let detail = "sweeps are for surfaces; a curve has no rows and no columns";
            return Err(ValidationError::at(SpecPart::Fit(place), detail).into());
        }
        if selected.is_none() && self.sweeps.is_none() {
            return incomplete("local needs the indices of the points to adjust, or sweeps");
        }
        let method = Method::Local(Local {
            omega: match self.omega {
                None => fit::Omega::default(),
                Some(Omega(None)) => fit::Omega::Best,
                Some(Omega(Some(omega))) => fit::Omega::Given(omega),
            },
            sweeps: self.sweeps.map(|SweepsInput(sweeps)| sweeps),
        });
        Ok(MethodChoice { method, selected })
    }

    pub(super) fn of(local: &Local, request: &Request) -> Self {
        let is_grid = request.v.is_some() && request.grid.is_rows();
        let columns = is_grid.then_some(request.grid.columns);
        let index = |&index: &usize| Index::new(index, columns);
        let selected = request.selected.as_deref();
        Self {
            indices: selected.map(|it| it.iter().map(index).collect()),
            sweeps: local.sweeps.map(SweepsInput),
            omega: local.omega.other_than_one().map(Omega::from),
        }
    }
}

impl AdaptiveInput {
    pub(super) fn settings(self, grid: Grid, surface: bool) -> OrErrors<Adaptive> {
        let wrong =
            |setting, detail: &str| ValidationError::at(SpecPart::Fit(P::Setting(setting)), detail);
        let omega = match self.omega {
            None => 1.0,
            Some(Omega(Some(omega))) => omega,
            Some(Omega(None)) => {
                let detail = "adaptive needs a number: the best omega is another one for each choice of points";
                return Err(wrong(Setting::Omega, detail).into());
            }
        };
        let Some(threshold) = self.threshold else {
            return incomplete("adaptive needs a threshold, in data units");
        };
        let threshold = threshold.of_points(grid, surface);
        let threshold = threshold.map_err(|detail| wrong(Setting::Threshold, &detail))?;
        Ok(Adaptive { threshold, omega })
    }

    pub(super) fn of(adaptive: &Adaptive, grid: Grid, surface: bool) -> Self {
        let Adaptive { threshold, omega } = adaptive;
        Self {
            threshold: Some(Thresholds::of(threshold, grid, surface)),
            omega: (*omega != 1.0).then_some(Omega(Some(*omega))),
        }
    }
}

impl CustomInput {
    pub(super) fn settings(self) -> OrErrors<Custom> {
        match self.transform {
            Some(PerDirection::Both(u)) => Ok(Custom::new(rows(u), None)),
            Some(PerDirection::Each { u, v }) => Ok(Custom::new(rows(u), Some(rows(v)))),
            None => incomplete(
                "custom needs a transform: the rows of a matrix, on surfaces also {\"u\": …, \"v\": …}",
            ),
        }
    }

    pub(super) fn of(custom: &Custom) -> Self {
        let transform = match custom.v() {
            None => PerDirection::Both(matrix(custom.u())),
            Some(v) => PerDirection::Each {
                u: matrix(custom.u()),
                v: matrix(v),
            },
        };
        Self {
            transform: Some(transform),
        }
    }
}

/// The rows of a matrix.
fn rows(AtMost(rows): Matrix) -> Vec<Vec<f64>> {
    rows.into_iter().map(|AtMost(row)| row).collect()
}

/// The matrix that has these rows.
fn matrix(rows: &[Vec<f64>]) -> Matrix {
    AtMost(rows.iter().cloned().map(AtMost).collect())
}

/// The error for a missing setting.
fn incomplete<T>(detail: &str) -> OrErrors<T> {
    Err(ValidationError::at(SpecPart::Fit(P::Method), detail).into())
}
