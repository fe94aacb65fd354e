//! The JSON of a method, and its settings.

use std::sync::Arc;

use schemars::JsonSchema;

use super::invalid::invalid;
use super::schema;
use super::settings::{ControlPoints, Index, Matrix, Omega};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::values::{Count, Number};
use crate::api::json::read::{Read, names, object};
use crate::api::problem::Problem;
use crate::fit::method::{
    Adaptive, Custom, Extended, LeastSquares, Local, Method, Start, Variant, Weighted,
};
use crate::fit::points::Grid;

/// How the control points move from iteration to iteration.
// Which settings belong to which kind is checked after reading, so that the error can say it.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "Method", transform = schema::method, example = schema::example_method())]
pub(in crate::api) struct MethodRequest {
    /// The kind of the method.
    pub(in crate::api) kind: Kind,
    /// The relaxation. The best one is computed if it is `auto`.
    pub(in crate::api) omega: Option<Omega>,
    /// The data points whose control points may move.
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub(in crate::api) indices: Option<Vec<Index>>,
    /// Surfaces: one row after the other, in sweeps until all are within the tolerance.
    pub(in crate::api) row_by_row: Option<bool>,
    /// Only control points move whose data point is further away than this, in data units.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) threshold: Option<Number>,
    /// What iteration 0 is.
    pub(in crate::api) start: Option<StartRequest>,
    /// The number of control points; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<ControlPoints>")]
    pub(in crate::api) control_points: Option<PerDirection<Count>>,
    /// The step.
    pub(in crate::api) variant: Option<VariantRequest>,
    /// The length of the step; without one 1 / (largest column sum).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) mu: Option<Number>,
    /// The transform U in `X ← X + U (P − B X)`; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<PerDirection<Matrix>>")]
    pub(in crate::api) transform: Option<PerDirection<Matrix>>,
}

/// A kind of method.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq, Eq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "MethodKind", example = &"global")]
pub(in crate::api) enum Kind {
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

/// The step of a least-squares fit: with a diagonal matrix, with one number, or of conjugate
/// gradients, which is the fastest.
#[derive(Clone, Copy, Debug, JsonSchema, PartialEq)]
#[schemars(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresVariant", extend("default" = "diagonal"), example = &"diagonal")]
pub(in crate::api) enum VariantRequest {
    Diagonal,
    Lspia,
    Cg,
}

object!(
    MethodRequest,
    "an object with a kind, or the name of a kind",
    [
        kind,
        omega,
        indices,
        row_by_row,
        threshold,
        start,
        control_points,
        variant,
        mu,
        transform,
    ],
    of_name: |name, at| Kind::reader().text(name, at).map(MethodRequest::of)
);
names!(Kind, "kind of method", [
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
names!(VariantRequest, "variant of the method least_squares", [
    "diagonal" => Diagonal,
    "lspia" => Lspia,
    "cg" => Cg,
]);

/// A method, and the points that it selects, if it does.
pub(super) type Chosen = (Method, Option<Arc<[usize]>>);

impl MethodRequest {
    /// A method without settings.
    pub(in crate::api) fn of(kind: Kind) -> Self {
        Self {
            kind,
            omega: None,
            indices: None,
            row_by_row: None,
            threshold: None,
            start: None,
            control_points: None,
            variant: None,
            mu: None,
            transform: None,
        }
    }

    /// Whether the two directions have numbers of control points of their own.
    pub(super) fn has_control_points_each(&self) -> bool {
        self.control_points.is_some_and(|count| count.is_each())
    }

    /// Whether the two directions have transforms of their own.
    pub(super) fn has_transform_each(&self) -> bool {
        self.transform.as_ref().is_some_and(PerDirection::is_each)
    }

    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(super) fn method(self, grid: Grid, surface: bool) -> Result<Chosen, Problem> {
        self.check_settings()?;
        let selected = self.selected(grid, surface)?;
        let method = match self.kind {
            Kind::Global => Method::Global,
            Kind::Weighted => Method::Weighted(Weighted {
                omega: match self.omega {
                    None | Some(Omega::Auto) => None,
                    Some(Omega::Given(omega)) => Some(omega),
                },
            }),
            Kind::Local => self.local(selected.is_some())?,
            Kind::Adaptive => match self.threshold {
                Some(Number(threshold)) => Method::Adaptive(Adaptive { threshold }),
                None => {
                    return Err(invalid(
                        "/method",
                        "adaptive needs a threshold, in data units",
                    ));
                }
            },
            Kind::Extended => Method::Extended(Extended {
                start: match self.start {
                    None | Some(StartRequest::Transformed) => Start::Transformed,
                    Some(StartRequest::Data) => Start::Data,
                },
            }),
            Kind::Transpose => Method::Transpose,
            Kind::Convex => Method::Convex,
            Kind::Chebyshev => Method::Chebyshev,
            Kind::Direct => Method::Direct,
            Kind::LeastSquares => Method::LeastSquares(self.least_squares(surface)?),
            Kind::Custom => Method::Custom(match self.transform {
                Some(PerDirection::Both(Matrix(u))) => Custom::new(u, None),
                Some(PerDirection::Each { u, v }) => Custom::new(u.0, Some(v.0)),
                None => {
                    let detail = "custom needs a transform: the rows of a matrix, on surfaces also {\"u\": …, \"v\": …}";
                    return Err(invalid("/method", detail));
                }
            }),
        };
        Ok((method, selected))
    }

    /// Refuses settings of other methods.
    pub(super) fn check_settings(&self) -> Result<(), Problem> {
        let given = [
            ("omega", self.omega.is_some()),
            ("indices", self.indices.is_some()),
            ("row_by_row", self.row_by_row.is_some()),
            ("threshold", self.threshold.is_some()),
            ("start", self.start.is_some()),
            ("control_points", self.control_points.is_some()),
            ("variant", self.variant.is_some()),
            ("mu", self.mu.is_some()),
            ("transform", self.transform.is_some()),
        ];
        let own = schema::settings(self.kind.name());
        let of_others = given
            .into_iter()
            .filter(|(name, given)| *given && !own.contains(name));
        let mut wrong: Vec<Problem> = of_others
            .map(|(name, _)| {
                let mut kinds = Kind::NAMES.iter();
                let method = kinds.find(|kind| schema::settings(kind).contains(&name));
                let method = method.unwrap_or(&"");
                let detail = format!("{name} is a setting of the method {method:?}");
                invalid(&format!("/method/{name}"), detail)
            })
            .collect();
        let lspia = self.variant == Some(VariantRequest::Lspia);
        if self.kind == Kind::LeastSquares && self.mu.is_some() && !lspia {
            let detail = "mu is a setting of the variant \"lspia\"";
            wrong.push(invalid("/method/mu", detail));
        }
        Problem::of_all(wrong).map_or(Ok(()), Err)
    }

    fn local(&self, selects: bool) -> Result<Method, Problem> {
        let row_by_row = self.row_by_row.unwrap_or(false);
        if !selects && !row_by_row {
            let detail = "local needs the indices of the points to adjust, or row_by_row";
            return Err(invalid("/method", detail));
        }
        Ok(Method::Local(Local { row_by_row }))
    }

    fn selected(&self, grid: Grid, surface: bool) -> Result<Option<Arc<[usize]>>, Problem> {
        let Some(given) = &self.indices else {
            return Ok(None);
        };
        let mut indices = Vec::with_capacity(given.len());
        for (k, index) in given.iter().enumerate() {
            let index = index.of_point(grid, surface);
            let pointer = || format!("/method/indices/{k}");
            indices.push(index.map_err(|detail| invalid(&pointer(), detail))?);
        }
        Ok(Some(indices.into()))
    }

    fn least_squares(&self, surface: bool) -> Result<LeastSquares, Problem> {
        let Some(control_points) = self.control_points else {
            let detail = "least_squares needs control_points: their number, on surfaces also {\"u\": …, \"v\": …}";
            return Err(invalid("/method", detail));
        };
        if control_points.is_each() && !surface {
            let detail = "a curve has one number of control points";
            return Err(invalid("/method/control_points", detail));
        }
        let (Count(u), Count(v)) = control_points.split();
        let variant = match self.variant {
            None | Some(VariantRequest::Diagonal) => Variant::Diagonal,
            Some(VariantRequest::Lspia) => Variant::Lspia {
                mu: self.mu.map(|Number(mu)| mu),
            },
            Some(VariantRequest::Cg) => Variant::ConjugateGradients,
        };
        Ok(LeastSquares { u, v, variant })
    }
}
