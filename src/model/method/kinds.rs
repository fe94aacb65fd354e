//! The kinds of methods, and names of settings.

use schemars::{JsonSchema, json_schema};

use crate::fit::method::{EndPoints, Start, Sweeps, Variant};
use crate::model::named::{Named, names};
use crate::model::schema::{names as schema_of_names, schema_of};

/// A kind of method.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "MethodKind", example = &"global")]
pub(crate) enum MethodKind {
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

/// The step of a least-squares fit: with a diagonal matrix, with one number, of conjugate gradients,
/// the fastest iteration, or `direct` to the minimum, which iteration 1 is then.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresVariant", extend("default" = "cg"), example = &"cg")]
pub(crate) enum VariantKind {
    Diagonal,
    Lspia,
    Cg,
    Direct,
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
names!(Start, "start of the method extended", [
    "transformed" => Transformed,
    "data" => Data,
]);
names!(Sweeps, "kind of sweeps", [
    "rows" => Rows,
    "columns" => Columns,
]);
names!(VariantKind, "variant of the method least_squares", [
    "diagonal" => Diagonal,
    "lspia" => Lspia,
    "cg" => Cg,
    "direct" => Direct,
]);
names!(EndPoints, "choice of end points of the method least_squares", [
    "interpolated" => Interpolated,
    "free" => Free,
]);

impl From<Variant> for VariantKind {
    fn from(variant: Variant) -> Self {
        match variant {
            Variant::Diagonal => Self::Diagonal,
            Variant::Lspia { .. } => Self::Lspia,
            Variant::ConjugateGradients => Self::Cg,
            Variant::Direct => Self::Direct,
        }
    }
}

schema_of!(
    Start,
    "ExtendedStart",
    schema_of_names::<Self>(
        "What iteration 0 of the extended method is: the transformed data, or the data themselves."
    )
);
schema_of!(
    Sweeps,
    "Sweeps",
    json_schema!({
        "description": "The lines of points of a surface that sweeps go by.",
        "type": "string",
        "enum": Sweeps::names(),
        "examples": ["columns"],
    })
);
schema_of!(
    EndPoints,
    "LeastSquaresEnds",
    schema_of_names::<Self>(
        "Whether a least-squares fit passes through its end points: the first and the last data point of an open curve, the corners of an open surface; or `free`, where they are data points like others."
    )
);
