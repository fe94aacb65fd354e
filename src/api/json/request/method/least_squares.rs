//! The settings of a least-squares fit.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::constraint::ConstraintRequest;
use super::counts::{ControlPointCount, ControlPoints, MostControlPoints, given};
use super::kinds::VariantRequest;
use crate::api::json::lists::WeightList;
use crate::api::json::request::settings::{DataWeights, each_point};
use crate::fit::invalid::{Place, Setting};
use crate::fit::method::{
    AS_MANY_AS_DATA, Automatic, BY_KNOTS, Constraint, EndPoints, Fairness, LeastSquares,
    MOST_CONDITIONS, Variant,
};
use crate::fit::points::Grid;
use crate::model::either::{PerDirection, Whole, read_at_most, whole};
use crate::model::method::mu_without_lspia;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};

/// No more constraints than can hold.
#[derive(Debug)]
struct Constraints(Vec<ConstraintRequest>);

impl<'de> Deserialize<'de> for Constraints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_at_most(deserializer, MOST_CONDITIONS, "constraints").map(Self)
    }
}

/// The order of the derivative of fairness where none is given.
const FAIRNESS_ORDER: usize = 2;

/// The settings of least squares.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::api) struct LeastSquaresRequest {
    /// The number of control points; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<ControlPoints>")]
    pub(super) control_points: Option<PerDirection<ControlPointCount>>,
    /// With control_points `auto`: the most control points. Without it as many as data points.
    #[schemars(with = "Option<MostControlPoints>")]
    pub(super) max_control_points: Option<PerDirection<Whole>>,
    /// With control_points `auto`, for curves: whether the parameters of the data move to the points of the curve that are nearest to them, so that errors are distances from the curve. Without it false.
    correct_parameters: Option<bool>,
    /// The step.
    variant: Option<VariantRequest>,
    /// The length of the step; without one 1 / (largest column sum).
    #[schemars(extend("exclusiveMinimum" = 0))]
    mu: Option<f64>,
    /// Whether it passes through its end points at every iteration.
    end_points: Option<EndPoints>,
    /// How much each data point counts in the sum of squares: of a curve a list of numbers that are not
    /// negative, of a surface rows of them.
    #[schemars(with = "Option<DataWeights>")]
    data_weights: Option<WeightList>,
    /// How smooth it is to be: a multiple of the integral of the squared derivative is added to the sum
    /// of squares. It is free of units: with n data points whose parameters have the range l, the
    /// multiple is `fairness · l^(2r − 1) / n` on curves and `fairness · (l_u l_v)^(r − 1) / n` on
    /// surfaces.
    #[schemars(extend("minimum" = 0))]
    fairness: Option<f64>,
    /// The order r of that derivative.
    #[serde(default, deserialize_with = "whole")]
    #[schemars(range(min = 2, max = 3), extend("default" = 2))]
    fairness_order: Option<usize>,
    /// What every iteration obeys: points to pass through and derivatives.
    #[schemars(with = "Option<Vec<ConstraintRequest>>", length(min = 1, max = MOST_CONDITIONS))]
    constraints: Option<Constraints>,
}

impl LeastSquaresRequest {
    /// The settings for data points arranged in `grid`.
    pub(super) fn settings(self, grid: Grid, surface: bool) -> OrMistakes<LeastSquares> {
        self.check_mu()?;
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
        let constraints = self
            .constraints
            .map_or_else(Vec::new, |it| it.0)
            .into_iter();
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
        let most = most.map(|most| most.map(|Whole(count)| count));
        let most = most.map_or((AS_MANY_AS_DATA, AS_MANY_AS_DATA), PerDirection::split);
        let (u, v) = given.unwrap_or(most);
        Ok(LeastSquares {
            variant: match self.variant {
                None | Some(VariantRequest::Cg) => Variant::ConjugateGradients,
                Some(VariantRequest::Diagonal) => Variant::Diagonal,
                Some(VariantRequest::Lspia) => Variant::Lspia { mu: self.mu },
                Some(VariantRequest::Direct) => Variant::Direct,
            },
            ends: self.end_points.unwrap_or(EndPoints::Usual),
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

    /// Refuses a step that the variant does not have.
    pub(super) fn check_mu(&self) -> OrMistakes<()> {
        match self.mu.is_some() && self.variant != Some(VariantRequest::Lspia) {
            true => Err(mu_without_lspia().into()),
            false => Ok(()),
        }
    }
}
