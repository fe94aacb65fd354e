//! The requested settings of a least-squares fit.

use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Serialize};

use super::constraint::ConstraintInput;
use super::counts::{ControlPointCount, ControlPoints, MostControlPoints, given};
use super::form::MethodForm;
use crate::model::errors::{OrErrors, SpecPart, ValidationError};
use crate::model::lists::PointNumbers;
use crate::model::named::{names, setting};
use crate::model::per_direction::PerDirection;
use crate::model::schema::{names as schema_of_names, schema_of};
use crate::model::serde_helpers::{AtMost, Whole, number_or_word, whole};
use crate::model::settings::DataWeights;
use piad_fit::data::Grid;
use piad_fit::invalid::{Place, Setting};
use piad_fit::method::{
    AS_MANY_AS_DATA, BY_KNOTS, Constraint, EndPoints, Fairness, KnotSelection, LeastSquares,
    MOST_CONDITIONS, Variant,
};

number_or_word!(
    /// A multiple of the energy, or `"auto"`: by the noise of the data.
    FairnessInput(f64),
    "auto",
    "a number that is not negative, or \"auto\""
);

/// The forms of fairness in a request.
pub(crate) enum FairnessSchema {}

schema_of!(FairnessSchema, "Fairness", _generator => json_schema!({
    "description": "A multiple of the energy, zero or greater; or `auto`: the one that generalised cross-validation chooses for data with noise of unknown size. It stands in the `job` event and in the result.",
    "oneOf": [{"type": "number", "minimum": 0}, {"type": "string", "const": "auto"}],
    "examples": [1e-9, "auto"],
}));

/// The order of the derivative of fairness where none is given.
const FAIRNESS_ORDER: usize = 2;

/// The settings of least squares.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LeastSquaresInput {
    /// The number of control points; on surfaces of both directions, or one for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<ControlPoints>")]
    pub control_points: Option<PerDirection<ControlPointCount>>,
    /// With control_points `auto`: the most control points. Default: the number of data points.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<MostControlPoints>")]
    pub max_control_points: Option<PerDirection<Whole>>,
    /// With control_points `auto`, of curves and of scattered points: true if the parameters of the data move to the points of the curve or surface that are nearest to them, so that errors are distances from it. Without it false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correct_parameters: Option<bool>,
    /// The step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) variant: Option<VariantKind>,
    /// The length of the step; without one 1 / (largest column sum).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mu: Option<f64>,
    /// Interpolation of the end points at every iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_points: Option<EndPointsInput>,
    /// How much each data point counts in the sum of squares: of a curve a list of numbers that are not
    /// negative, of a surface rows of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<DataWeights>")]
    pub data_weights: Option<PointNumbers>,
    /// How smooth it is to be: this multiple of the integral of the squared derivative is added to the
    /// mean of the squared distances, over parameters scaled to [0, 1]; on surfaces by one factor, so
    /// that the longer range is 1. Such a fit ends at the minimum of that sum.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<FairnessSchema>")]
    pub fairness: Option<FairnessInput>,
    /// The order r of that derivative.
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(range(min = 2, max = 3), extend("default" = 2))]
    pub fairness_order: Option<usize>,
    /// Of surfaces: the stiffness over the spans of knots in which no datum lies, such as holes and ragged borders of
    /// scans. This multiple of the integral of the squared first derivatives there is added, too. Without it 1e-6 if
    /// there is `fairness`, otherwise 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub gap_stiffness: Option<f64>,
    /// Of curves and scattered points: points that are far from where their neighbours predict them are left out. They
    /// are listed as `outliers`. Default: `false`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robust: Option<bool>,
    /// Constraints of every iteration: points to pass through and derivatives.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<ConstraintInput>>", length(min = 1, max = MOST_CONDITIONS))]
    pub(crate) constraints: Option<AtMost<ConstraintInput, MOST_CONDITIONS>>,
}

impl LeastSquaresInput {
    /// Their form.
    pub(super) fn form(&self) -> MethodForm {
        let most = self.max_control_points;
        MethodForm {
            each: self.control_points.is_some_and(|count| count.is_each())
                || most.is_some_and(|most| most.is_each()),
            limited: most.is_some(),
        }
    }

    /// The settings for data points arranged in `grid`.
    pub(super) fn settings(self, grid: Grid, surface: bool) -> OrErrors<LeastSquares> {
        let wrong = |setting, detail: &str| {
            let place = SpecPart::Fit(Place::Setting(setting));
            ValidationError::at(place, detail)
        };
        if self.mu.is_some() && self.variant != Some(VariantKind::Lspia) {
            let detail = "mu is a setting of the variant \"lspia\"";
            return Err(wrong(Setting::Mu, detail).into());
        }
        let (u, v, automatic) = self.counts(surface)?;
        if self.fairness_order.is_some() && self.fairness.is_none() {
            let detail = "fairness_order is that of fairness, which is not given";
            return Err(wrong(Setting::FairnessOrder, detail).into());
        }
        let weights = self.data_weights.map(|weights| {
            let weights = weights.of_points(grid, surface, "weights of data");
            weights.map_err(|detail| wrong(Setting::DataWeights, &detail))
        });
        let constraints = self.constraints.map_or_else(Vec::new, |it| it.0);
        let constraints = constraints.into_iter().enumerate().map(|(index, it)| {
            let wrong =
                |detail| ValidationError::at(SpecPart::Fit(Place::Constraint(index)), detail);
            it.constraint(grid, surface).map_err(wrong)
        });
        let constraints: Result<Vec<Constraint>, ValidationError> = constraints.collect();
        Ok(LeastSquares {
            variant: match self.variant {
                None | Some(VariantKind::Cg) => Variant::ConjugateGradients,
                Some(VariantKind::Diagonal) => Variant::Diagonal,
                Some(VariantKind::Lspia) => Variant::Lspia { mu: self.mu },
                Some(VariantKind::Direct) => Variant::Direct,
            },
            ends: self
                .end_points
                .map_or(EndPoints::Usual, |EndPointsInput(ends)| ends),
            constraints: constraints?.into(),
            fairness: self.fairness.map(|FairnessInput(value)| Fairness {
                value: value.unwrap_or(0.0),
                order: self.fairness_order.unwrap_or(FAIRNESS_ORDER),
                by_data: value.is_none(),
            }),
            gap_stiffness: self.gap_stiffness,
            robust: self.robust.unwrap_or(false),
            data_weights: weights.transpose()?.map(Into::into),
            automatic,
            ..LeastSquares::new(u, v)
        })
    }

    /// The numbers of control points of both directions, or the most of an automatic fit.
    fn counts(
        &self,
        surface: bool,
    ) -> Result<(usize, usize, Option<KnotSelection>), ValidationError> {
        let wrong =
            |name, detail: &str| ValidationError::at_text(format!("/method/{name}"), detail);
        let (counts, most) = (self.control_points, self.max_control_points);
        let each = [
            ("control_points", counts.is_some_and(|it| it.is_each())),
            ("max_control_points", most.is_some_and(|it| it.is_each())),
        ];
        if let Some((name, _)) = each.iter().find(|(_, each)| *each && !surface) {
            return Err(wrong(*name, "a curve has one number of control points"));
        }
        let given = counts.map_or(Ok(Some((BY_KNOTS, BY_KNOTS))), given);
        let given = given.map_err(|detail| wrong("control_points", detail))?;
        let Some((u, v)) = given else {
            let most = most.map(|most| most.map(|Whole(count)| count).split());
            let (u, v) = most.unwrap_or((AS_MANY_AS_DATA, AS_MANY_AS_DATA));
            let correct_parameters = self.correct_parameters.unwrap_or(false);
            return Ok((u, v, Some(KnotSelection { correct_parameters })));
        };
        let unused = [
            ("max_control_points", most.is_some()),
            ("correct_parameters", self.correct_parameters.is_some()),
        ];
        if let Some((name, _)) = unused.iter().find(|(_, given)| *given) {
            let detail = format!("{name} is a setting of fits with control_points \"auto\"");
            return Err(wrong(*name, &detail));
        }
        Ok((u, v, None))
    }

    /// Settings that are not defaults, in the form of a request.
    pub(crate) fn of(settings: &LeastSquares, grid: Grid, surface: bool) -> Self {
        let counts = match surface {
            false => PerDirection::Both(Whole(settings.u)),
            true => PerDirection::Each {
                u: Whole(settings.u),
                v: Whole(settings.v),
            },
        };
        let automatic = settings.automatic.as_ref();
        let limited = automatic.is_some() && settings.u != AS_MANY_AS_DATA;
        let corrected = automatic.is_some_and(|it| it.correct_parameters);
        let constraints = settings.constraints.iter();
        let constraints = constraints.map(|it| ConstraintInput::of(it, grid, surface));
        let weights = settings.data_weights.as_deref();
        Self {
            control_points: Some(match automatic {
                None => counts.map(|count| ControlPointCount(Some(count))),
                Some(_) => PerDirection::Both(ControlPointCount(None)),
            }),
            max_control_points: limited.then_some(counts),
            correct_parameters: corrected.then_some(true),
            variant: automatic.is_none().then(|| settings.variant.into()),
            mu: match settings.variant {
                Variant::Lspia { mu } => mu,
                _ => None,
            },
            end_points: (settings.ends != EndPoints::Usual)
                .then_some(EndPointsInput(settings.ends)),
            data_weights: weights.map(|it| PointNumbers::new(it.to_vec(), grid, surface)),
            fairness: settings
                .fairness
                .map(|it| FairnessInput((!it.by_data).then_some(it.value))),
            fairness_order: settings.fairness.map(|fairness| fairness.order),
            gap_stiffness: settings.gap_stiffness,
            robust: settings.robust.then_some(true),
            constraints: Some(AtMost(constraints.collect())).filter(|it| !it.0.is_empty()),
        }
    }
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

names!(VariantKind, "least-squares variant", [
    "diagonal" => Diagonal,
    "lspia" => Lspia,
    "cg" => Cg,
    "direct" => Direct,
]);
setting!(
    /// The requested choice of end points.
    EndPointsInput(EndPoints), "choice of end points of the method least_squares", [
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
    EndPointsInput,
    "LeastSquaresEnds",
    schema_of_names::<Self>(
        "How a least-squares fit treats its end points, which are the first and the last data point of an open curve and the corners of an open surface: it passes through them, or (`free`) they are data points like others."
    )
);
