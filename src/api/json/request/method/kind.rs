//! The names of methods, and of choices that some of them have.

use schemars::JsonSchema;

use crate::api::json::read::names;
use crate::fit::method::{Start, Sweeps};

/// A kind of method.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "MethodKind", example = &"global")]
pub(in crate::api) enum MethodKind {
    Global,
    Weighted,
    Local,
    Adaptive,
    Extended,
    Transpose,
    Convex,
    Chebyshev,
    Direct,
    LeastSquares,
    Custom,
}

/// What iteration 0 of the extended method is: the transformed data, or the data themselves.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "ExtendedStart", extend("default" = "transformed"), example = &"transformed")]
pub(in crate::api) enum StartRequest {
    Transformed,
    Data,
}

/// The lines of points of a surface that sweeps go by.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "Sweeps", example = &"columns")]
pub(in crate::api) enum SweepsRequest {
    Rows,
    Columns,
}

names!(MethodKind, "kind of method", [
    "global" => Global,
    "weighted" => Weighted,
    "local" => Local,
    "adaptive" => Adaptive,
    "extended" => Extended,
    "transpose" => Transpose,
    "convex" => Convex,
    "chebyshev" => Chebyshev,
    "direct" => Direct,
    "least_squares" => LeastSquares,
    "custom" => Custom,
]);
names!(StartRequest, "start of the method extended", [
    "transformed" => Transformed,
    "data" => Data,
]);
names!(SweepsRequest, "kind of sweeps", [
    "rows" => Rows,
    "columns" => Columns,
]);
impl From<SweepsRequest> for Sweeps {
    fn from(request: SweepsRequest) -> Self {
        match request {
            SweepsRequest::Rows => Self::Rows,
            SweepsRequest::Columns => Self::Columns,
        }
    }
}

/// The name of a start of the extended method.
pub(in crate::api) fn start_name(start: Start) -> &'static str {
    match start {
        Start::Transformed => "transformed",
        Start::Data => "data",
    }
}

/// The name of the lines of sweeps.
pub(in crate::api) fn sweeps_name(sweeps: Sweeps) -> &'static str {
    match sweeps {
        Sweeps::Rows => "rows",
        Sweeps::Columns => "columns",
    }
}
