//! The settings of a least-squares fit.

use super::MethodRequest;
use super::counts::given;
use super::kinds::{EndingRequest, VariantRequest, end_points};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::request::settings::each_point;
use crate::fit::invalid::{Place, Setting};
use crate::fit::method::{
    AS_MANY_AS_DATA, Automatic, BY_KNOTS, Constraint, Ending, Fairness, LeastSquares, Variant,
};
use crate::fit::points::Grid;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};

/// The order of the derivative of fairness where none is given.
const FAIRNESS_ORDER: usize = 2;

impl MethodRequest {
    pub(super) fn least_squares(self, grid: Grid, surface: bool) -> OrMistakes<LeastSquares> {
        if self.control_points.is_some_and(|count| count.is_each()) && !surface {
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
        let given = self
            .control_points
            .map_or(Ok(Some((BY_KNOTS, BY_KNOTS))), given);
        let given = given.map_err(|detail| Mistake::at_text("/method/control_points", detail))?;
        let most = self.max_control_points;
        if most.is_some_and(|most| most.is_each()) && !surface {
            let detail = "a curve has one number of control points";
            return Err(Mistake::at_text("/method/max_control_points", detail).into());
        }
        let automatic = given.is_none();
        let unused = [
            ("max_control_points", most.is_some()),
            ("correct_parameters", self.correct_parameters.is_some()),
        ];
        if let Some((name, _)) = unused.iter().find(|(_, given)| *given && !automatic) {
            let detail = format!("{name} is a setting of fits with control_points \"auto\"");
            return Err(Mistake::at_text(format!("/method/{name}"), detail).into());
        }
        let most = most.map_or((AS_MANY_AS_DATA, AS_MANY_AS_DATA), PerDirection::split);
        let (u, v) = given.unwrap_or(most);
        Ok(LeastSquares {
            variant: match self.variant {
                None | Some(VariantRequest::Cg) => Variant::ConjugateGradients,
                Some(VariantRequest::Diagonal) => Variant::Diagonal,
                Some(VariantRequest::Lspia) => Variant::Lspia { mu: self.mu },
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
            automatic: automatic.then(|| Automatic {
                correct_parameters: self.correct_parameters.unwrap_or(false),
            }),
            ..LeastSquares::new(u, v)
        })
    }
}
