//! The kinds of methods, and names of settings.

use schemars::JsonSchema;

use crate::api::json::read::names;
use crate::fit::method::{EndPoints, Start, Sweeps, Variant};

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

/// The step of a least-squares fit: with a diagonal matrix, with one number, of conjugate gradients,
/// the fastest iteration, or `direct` to the minimum, which iteration 1 is then.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresVariant", extend("default" = "cg"), example = &"cg")]
pub(in crate::api) enum VariantRequest {
    Diagonal,
    Lspia,
    Cg,
    Direct,
}

/// Where a least-squares fit ends: where its gradient says that the minimum is near, or as soon as the
/// residual shrinks by less than a millionth in one iteration.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresEnding", extend("default" = "minimum"), example = &"minimum")]
pub(in crate::api) enum EndingRequest {
    Minimum,
    SmallStep,
}

/// Whether a least-squares fit passes through its end points: the first and the last data point of an
/// open curve, the corners of an open surface; or `free`, where they are data points like others.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresEnds", extend("default" = "interpolated"), example = &"free")]
pub(in crate::api) enum EndPointsRequest {
    Interpolated,
    Free,
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
names!(EndingRequest, "ending of the method least_squares", [
    "minimum" => Minimum,
    "small_step" => SmallStep,
]);
names!(VariantRequest, "variant of the method least_squares", [
    "diagonal" => Diagonal,
    "lspia" => Lspia,
    "cg" => Cg,
    "direct" => Direct,
]);
names!(EndPointsRequest, "choice of ends of the method least_squares", [
    "interpolated" => Interpolated,
    "free" => Free,
]);

/// The name of a start of the extended method.
pub(in crate::api) fn start_name(start: Start) -> &'static str {
    match start {
        Start::Transformed => "transformed",
        Start::Data => "data",
    }
}

impl From<SweepsRequest> for Sweeps {
    fn from(request: SweepsRequest) -> Self {
        match request {
            SweepsRequest::Rows => Self::Rows,
            SweepsRequest::Columns => Self::Columns,
        }
    }
}

/// The name of the lines of sweeps.
pub(in crate::api) fn sweeps_name(sweeps: Sweeps) -> &'static str {
    match sweeps {
        Sweeps::Rows => "rows",
        Sweeps::Columns => "columns",
    }
}

/// The name of a least-squares variant.
pub(in crate::api) fn variant_name(variant: Variant) -> &'static str {
    match variant {
        Variant::Diagonal => "diagonal",
        Variant::Lspia { .. } => "lspia",
        Variant::ConjugateGradients => "cg",
        Variant::Direct => "direct",
    }
}

/// The choice of end points, where one is named.
pub(super) fn end_points(ends: Option<EndPointsRequest>) -> EndPoints {
    match ends {
        None => EndPoints::Usual,
        Some(EndPointsRequest::Interpolated) => EndPoints::Interpolated,
        Some(EndPointsRequest::Free) => EndPoints::Free,
    }
}

/// The name of a choice of end points, if it is not the usual one.
pub(super) fn end_points_name(ends: EndPoints) -> Option<&'static str> {
    match ends {
        EndPoints::Usual => None,
        EndPoints::Interpolated => Some("interpolated"),
        EndPoints::Free => Some("free"),
    }
}
