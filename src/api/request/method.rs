//! The JSON of a method, and its settings.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};

use super::{invalid, schema};
use crate::api::numbers::Number;
use crate::api::per_direction::PerDirection;
use crate::api::problem::Problem;
use crate::api::strict::{Count, Name, whole};
use crate::fit::method::{LeastSquares, Method, Start, Variant};
use crate::fit::points::Grid;

/// How the control points move from iteration to iteration.
// Which settings belong to which kind is checked after reading, so that the error can say it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Method", transform = schema::method, example = schema::example_method())]
pub(in crate::api) struct MethodRequest {
    /// The kind of the method.
    pub(in crate::api) kind: Name<Kind>,
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
    pub(in crate::api) start: Option<Name<StartRequest>>,
    /// The number of control points; on surfaces of both directions, or one for each.
    #[schemars(with = "Option<schema::ControlPoints>")]
    pub(in crate::api) control_points: Option<PerDirection<Count>>,
    /// The step.
    pub(in crate::api) variant: Option<Name<VariantRequest>>,
    /// The length of the step; without one 1 / (largest column sum).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) mu: Option<Number>,
}

/// A kind of method.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
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
}

/// What iteration 0 of the extended method is: the transformed data, or the data themselves.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "ExtendedStart", extend("default" = "transformed"), example = &"transformed")]
pub(in crate::api) enum StartRequest {
    Transformed,
    Data,
}

/// The step of a least-squares fit: with a diagonal matrix, with one number, or of conjugate
/// gradients, which is the fastest.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "LeastSquaresVariant", extend("default" = "diagonal"), example = &"diagonal")]
pub(in crate::api) enum VariantRequest {
    Diagonal,
    Lspia,
    Cg,
}

impl Kind {
    /// The kind of method that settings of its own belong to, as clients write it.
    fn name(self) -> &'static str {
        match self {
            Self::Global => "global",
            Self::Weighted => "weighted",
            Self::Local => "local",
            Self::Adaptive => "adaptive",
            Self::Extended => "extended",
            Self::Transpose => "transpose",
            Self::Convex => "convex",
            Self::Chebyshev => "chebyshev",
            Self::Direct => "direct",
            Self::LeastSquares => "least_squares",
        }
    }
}

/// A method, and the points that it selects, if it does.
pub(super) type Chosen = (Method, Option<Vec<usize>>);

impl MethodRequest {
    /// Whether the two directions have numbers of control points of their own.
    pub(super) fn has_control_points_each(&self) -> bool {
        self.control_points.is_some_and(|count| count.is_each())
    }

    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(super) fn method(self, grid: Grid, surface: bool) -> Result<Chosen, Problem> {
        self.check_settings()?;
        let selected = self.selected(grid, surface)?;
        let method = match self.kind.0 {
            Kind::Global => Method::Global,
            Kind::Weighted => Method::Weighted {
                omega: match self.omega {
                    None | Some(Omega::Auto) => None,
                    Some(Omega::Given(omega)) => Some(omega),
                },
            },
            Kind::Local => self.local(selected.is_some())?,
            Kind::Adaptive => match self.threshold {
                Some(Number(threshold)) => Method::Adaptive { threshold },
                None => {
                    return Err(invalid(
                        "/method",
                        "adaptive needs a threshold, in data units",
                    ));
                }
            },
            Kind::Extended => Method::Extended {
                start: match self.start {
                    None | Some(Name(StartRequest::Transformed)) => Start::Transformed,
                    Some(Name(StartRequest::Data)) => Start::Data,
                },
            },
            Kind::Transpose => Method::Transpose,
            Kind::Convex => Method::Convex,
            Kind::Chebyshev => Method::Chebyshev,
            Kind::Direct => Method::Direct,
            Kind::LeastSquares => Method::LeastSquares(self.least_squares(surface)?),
        };
        Ok((method, selected))
    }

    /// Refuses settings of other methods.
    fn check_settings(&self) -> Result<(), Problem> {
        let settings = [
            ("omega", self.omega.is_some(), Kind::Weighted),
            ("indices", self.indices.is_some(), Kind::Local),
            ("row_by_row", self.row_by_row.is_some(), Kind::Local),
            ("threshold", self.threshold.is_some(), Kind::Adaptive),
            ("start", self.start.is_some(), Kind::Extended),
            (
                "control_points",
                self.control_points.is_some(),
                Kind::LeastSquares,
            ),
            ("variant", self.variant.is_some(), Kind::LeastSquares),
            ("mu", self.mu.is_some(), Kind::LeastSquares),
        ];
        for (name, given, kind) in settings {
            if given && kind != self.kind.0 {
                return Err(invalid(
                    &format!("/method/{name}"),
                    format!("{name} is a setting of the method {:?}", kind.name()),
                ));
            }
        }
        if self.mu.is_some() && self.variant != Some(Name(VariantRequest::Lspia)) {
            return Err(invalid(
                "/method/mu",
                "mu is a setting of the variant \"lspia\"",
            ));
        }
        Ok(())
    }

    fn local(&self, selects: bool) -> Result<Method, Problem> {
        let row_by_row = self.row_by_row.unwrap_or(false);
        if !selects && !row_by_row {
            let detail = "local needs the indices of the points to adjust, or row_by_row";
            return Err(invalid("/method", detail));
        }
        Ok(Method::Local { row_by_row })
    }

    fn selected(&self, grid: Grid, surface: bool) -> Result<Option<Vec<usize>>, Problem> {
        let Some(given) = &self.indices else {
            return Ok(None);
        };
        let mut indices = Vec::with_capacity(given.len());
        for (k, index) in given.iter().enumerate() {
            let index = index.of_point(grid, surface);
            let pointer = || format!("/method/indices/{k}");
            indices.push(index.map_err(|detail| invalid(&pointer(), detail))?);
        }
        Ok(Some(indices))
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
            None | Some(Name(VariantRequest::Diagonal)) => Variant::Diagonal,
            Some(Name(VariantRequest::Lspia)) => Variant::Lspia {
                mu: self.mu.map(|Number(mu)| mu),
            },
            Some(Name(VariantRequest::Cg)) => Variant::ConjugateGradients,
        };
        Ok(LeastSquares { u, v, variant })
    }
}

/// The relaxation of weighted PIA: a number or `"auto"`.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) enum Omega {
    Auto,
    Given(f64),
}

impl<'de> Deserialize<'de> for Omega {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OmegaVisitor;
        impl Visitor<'_> for OmegaVisitor {
            type Value = Omega;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number between 0 and 2, or \"auto\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Omega, E> {
                match text {
                    "auto" => Ok(Omega::Auto),
                    _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
                }
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Omega, E> {
                Ok(Omega::Given(value))
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Omega, E> {
                Ok(Omega::Given(value as f64))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Omega, E> {
                Ok(Omega::Given(value as f64))
            }
        }
        deserializer.deserialize_any(OmegaVisitor)
    }
}

/// The index of a point: of a curve `i`, of a surface `[row, column]`.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) enum Index {
    Single(usize),
    Pair(usize, usize),
    /// `row · columns + column` on surfaces: how messages number points.
    Flat(usize),
}

impl Index {
    /// The index in the list of all points, row by row. Whether a point of a curve exists is
    /// checked with the problem.
    pub(super) fn of_point(self, grid: Grid, surface: bool) -> Result<usize, String> {
        match (self, surface) {
            (Self::Single(i), false) => Ok(i),
            (Self::Flat(i), _) if i < grid.count() => Ok(i),
            (Self::Flat(i), _) => Err(format!("{i} is not one of the {} points", grid.count())),
            (Self::Pair(i, j), true) if i < grid.rows && j < grid.columns => {
                Ok(i * grid.columns + j)
            }
            (Self::Pair(i, j), true) => {
                let Grid { rows, columns } = grid;
                Err(format!(
                    "[{i}, {j}] lies outside the {rows} rows and {columns} columns"
                ))
            }
            (Self::Pair(..), false) => Err("the points of a curve have single indices".to_owned()),
            (Self::Single(_), true) => {
                Err("the points of a surface have indices [row, column]".to_owned())
            }
        }
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IndexVisitor;
        impl<'de> Visitor<'de> for IndexVisitor {
            type Value = Index;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the index of a point, or [row, column]")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Index, E> {
                // Too large for this machine is too large for any list of points.
                Ok(Index::Single(usize::try_from(value).unwrap_or(usize::MAX)))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Index, E> {
                match whole(value) {
                    Some(index) => self.visit_u64(index),
                    None => Err(E::invalid_type(Unexpected::Float(value), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Index, A::Error> {
                let row = list.next_element()?;
                let column = list.next_element()?;
                let more: Option<Count> = list.next_element()?;
                match (row, column, more) {
                    (Some(Count(row)), Some(Count(column)), None) => Ok(Index::Pair(row, column)),
                    _ => Err(A::Error::custom(
                        "an index of a surface has two numbers, [row, column]",
                    )),
                }
            }
        }
        deserializer.deserialize_any(IndexVisitor)
    }
}
