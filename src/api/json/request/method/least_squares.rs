//! The JSON of the settings of least squares.

use schemars::JsonSchema;

use super::{MethodRequest, incomplete};
use crate::api::json::read::names;
use crate::fit::method::{Ending, LeastSquares, Variant};
use crate::model::mistakes::{Mistake, OrMistakes};

/// The step of a least-squares fit: with a diagonal matrix, with one number, of conjugate gradients,
/// the fastest iteration, or `direct` to the minimum, which iteration 1 is then.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresVariant", extend("default" = "diagonal"), example = &"diagonal")]
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

impl MethodRequest {
    pub(super) fn least_squares(&self, surface: bool) -> OrMistakes<LeastSquares> {
        let Some(control_points) = self.control_points else {
            return incomplete(
                "least_squares needs control_points: their number, on surfaces also {\"u\": …, \"v\": …}",
            );
        };
        if control_points.is_each() && !surface {
            let detail = "a curve has one number of control points";
            return Err(Mistake::at_text("/method/control_points", detail).into());
        }
        let (u, v) = control_points.split();
        let variant = match self.variant {
            None | Some(VariantRequest::Diagonal) => Variant::Diagonal,
            Some(VariantRequest::Lspia) => Variant::Lspia { mu: self.mu },
            Some(VariantRequest::Cg) => Variant::ConjugateGradients,
            Some(VariantRequest::Direct) => Variant::Direct,
        };
        let ending = match self.ending {
            None | Some(EndingRequest::Minimum) => Ending::Minimum,
            Some(EndingRequest::SmallStep) => Ending::SmallStep,
        };
        Ok(LeastSquares {
            variant,
            ending,
            ..LeastSquares::new(u, v)
        })
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
