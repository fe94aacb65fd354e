//! Distances from the data, and the indices of data points.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;

use super::examples;
use crate::api::json::plain::never_null;
use crate::job::outline::Outline;
use crate::model::settings::Index;
use piad_fit::engine::{Level, Problem};
use piad_fit::geometry::FitError;
use piad_fit::method::Method;

/// The numbering of the data points of a job, and whether the fit is local.
#[derive(Clone, Copy)]
pub(crate) struct Arrangement {
    /// The number of columns of points in rows.
    columns: Option<usize>,
    local: bool,
}

impl From<&Problem> for Arrangement {
    fn from(problem: &Problem) -> Self {
        Self {
            columns: problem
                .v()
                .filter(|_| !problem.is_scattered())
                .map(|_| problem.grid().columns),
            local: matches!(problem.method(), Method::Local(_)),
        }
    }
}

impl From<&Outline> for Arrangement {
    fn from(outline: &Outline) -> Self {
        Self {
            columns: (outline.surface && outline.grid.is_rows()).then_some(outline.grid.columns),
            local: matches!(outline.method, Method::Local(_)),
        }
    }
}

/// Distances from the data points; of local fits from the adjusted ones. Null where a distance is infinite.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "FitError", example = examples::error())]
pub(crate) struct ErrorView {
    /// The largest distance.
    max: Distance,
    /// The root mean square of the distances.
    rms: Distance,
    /// The sum of the distances.
    sum: Distance,
    /// The data point with the largest distance.
    at: Index,
    /// Local fits: the largest distance of the points that are not adjusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed_max: Option<f64>,
    /// Homogeneous fits: the largest distance in homogeneous coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    homogeneous: Option<f64>,
    /// Least squares: the gradient, which is zero at the minimum.
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient: Option<f64>,
    /// Extended fits with `transformed_error`: the largest length of U Δ, which is how far a control point
    /// moves in the next iteration; of homogeneous fits in homogeneous coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    transformed: Option<f64>,
    /// At the end of fits of curves and grids: by how much the fit leaves its data between neighbours, beyond the freedom
    /// that these leave; 0 if it does so nowhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    between: Option<f64>,
}

/// The index of a data point of a problem.
pub(super) fn index(index: usize, problem: &Problem) -> Index {
    Index::new(index, Arrangement::from(problem).columns)
}

impl ErrorView {
    /// The distances of a level from the data.
    pub(crate) fn new(error: &FitError, of: impl Into<Arrangement>) -> Self {
        let of = of.into();
        Self {
            max: Distance(error.max),
            rms: Distance(error.rms),
            sum: Distance(error.sum),
            at: Index::new(error.at, of.columns),
            fixed_max: error.fixed_max.filter(|_| of.local),
            homogeneous: error.homogeneous,
            gradient: error.gradient,
            transformed: error.transformed,
            between: None,
        }
    }

    /// The distances of the last level of a job so far, with its deviation between data.
    pub(super) fn of_last(level: &Level, of: impl Into<Arrangement>) -> Self {
        Self {
            between: level.between,
            ..Self::new(&level.error, of)
        }
    }
}

/// A distance. It is infinite at a point whose weight is not positive, and null in JSON then.
#[derive(Clone, Copy, Serialize)]
struct Distance(f64);

impl JsonSchema for Distance {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Distance".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": ["number", "null"]})
    }
}
