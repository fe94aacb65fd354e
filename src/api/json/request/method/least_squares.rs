//! The settings of a least-squares fit.

use super::kinds::{EndingRequest, VariantRequest, end_points};
use super::{MethodRequest, incomplete};
use crate::api::json::request::settings::each_point;
use crate::fit::invalid::{Place, Setting};
use crate::fit::method::{Constraint, Ending, Fairness, LeastSquares, Variant};
use crate::fit::points::Grid;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};

/// The order of the derivative of fairness where none is given.
const FAIRNESS_ORDER: usize = 2;

impl MethodRequest {
    pub(super) fn least_squares(self, grid: Grid, surface: bool) -> OrMistakes<LeastSquares> {
        let Some(control_points) = self.control_points else {
            return incomplete(
                "least_squares needs control_points: their number, on surfaces also {\"u\": …, \"v\": …}",
            );
        };
        if control_points.is_each() && !surface {
            let detail = "a curve has one number of control points";
            return Err(Mistake::at_text("/method/control_points", detail).into());
        }
        let wrong =
            |setting, detail: String| Mistake::at(SpecPart::Fit(Place::Setting(setting)), detail);
        if self.fairness_order.is_some() && self.fairness.is_none() {
            let detail = "fairness_order is that of fairness, which is not given".to_owned();
            return Err(wrong(Setting::FairnessOrder, detail).into());
        }
        let weights = self.data_weights.map(|weights| {
            let weights = each_point(weights, grid, surface, "weights of data");
            weights.map_err(|detail| wrong(Setting::DataWeights, detail))
        });
        let constraints = self.constraints.unwrap_or_default().into_iter();
        let constraints = constraints.enumerate().map(|(index, constraint)| {
            let wrong = |detail| Mistake::at(SpecPart::Fit(Place::Constraint(index)), detail);
            constraint.spec(grid, surface).map_err(wrong)
        });
        let constraints: Result<Vec<Constraint>, Mistake> = constraints.collect();
        let (u, v) = control_points.split();
        Ok(LeastSquares {
            variant: match self.variant {
                None | Some(VariantRequest::Diagonal) => Variant::Diagonal,
                Some(VariantRequest::Lspia) => Variant::Lspia { mu: self.mu },
                Some(VariantRequest::Cg) => Variant::ConjugateGradients,
                Some(VariantRequest::Direct) => Variant::Direct,
            },
            ending: match self.ending {
                None | Some(EndingRequest::Minimum) => Ending::Minimum,
                Some(EndingRequest::SmallStep) => Ending::SmallStep,
            },
            ends: end_points(self.ends),
            constraints: constraints?.into(),
            fairness: self.fairness.map(|value| Fairness {
                value,
                order: self.fairness_order.unwrap_or(FAIRNESS_ORDER),
            }),
            data_weights: weights.transpose()?,
            ..LeastSquares::new(u, v)
        })
    }
}
