//! Problems as they were asked for, as protobuf messages.
//!
//! The problem itself follows from what was asked for: it is computed again when it is read.

use std::sync::Arc;

use prost::{Enumeration, Message, Oneof};

use super::super::StoreError;
use super::direction::DirectionMessage;
use super::error::damaged;
use super::fields::{grid, number};
use super::points::PointsMessage;
use crate::fit::direction::DirectionChoice;
use crate::fit::method::{
    Adaptive, Custom, Extended, LeastSquares, Local, Method, Start, Variant, Weighted,
};
use crate::fit::problem::{Problem, Request, Tolerance, Weights};

/// A problem as it was asked for.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Input {
    #[prost(message, optional, tag = "1")]
    points: Option<PointsMessage>,
    #[prost(uint64, tag = "2")]
    rows: u64,
    #[prost(uint64, tag = "3")]
    columns: u64,
    #[prost(uint64, repeated, tag = "4")]
    missing: Vec<u64>,
    #[prost(message, optional, tag = "5")]
    u: Option<DirectionMessage>,
    #[prost(message, optional, tag = "6")]
    v: Option<DirectionMessage>,
    #[prost(enumeration = "WeightsCode", tag = "7")]
    weights: i32,
    #[prost(double, repeated, tag = "8")]
    weight_values: Vec<f64>,
    #[prost(message, optional, tag = "9")]
    method: Option<MethodMessage>,
    #[prost(bool, tag = "10")]
    selects: bool,
    #[prost(uint64, repeated, tag = "11")]
    selected: Vec<u64>,
    #[prost(message, optional, tag = "12")]
    start: Option<PointsMessage>,
    #[prost(double, tag = "13")]
    tolerance: f64,
    #[prost(bool, tag = "14")]
    relative: bool,
    #[prost(uint64, tag = "15")]
    max_iterations: u64,
    #[prost(double, optional, tag = "16")]
    lambda_min: Option<f64>,
}

/// A method with its settings.
#[derive(Clone, PartialEq, Message)]
pub(super) struct MethodMessage {
    #[prost(oneof = "MethodCase", tags = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11")]
    case: Option<MethodCase>,
}

#[derive(Clone, PartialEq, Oneof)]
enum MethodCase {
    #[prost(message, tag = "1")]
    Global(Nothing),
    #[prost(message, tag = "2")]
    Weighted(Number),
    /// Row by row?
    #[prost(bool, tag = "3")]
    Local(bool),
    /// The threshold.
    #[prost(double, tag = "4")]
    Adaptive(f64),
    /// From the data?
    #[prost(bool, tag = "5")]
    Extended(bool),
    #[prost(message, tag = "6")]
    Transpose(Nothing),
    #[prost(message, tag = "7")]
    Convex(Nothing),
    #[prost(message, tag = "8")]
    Chebyshev(Nothing),
    #[prost(message, tag = "9")]
    Direct(Nothing),
    #[prost(message, tag = "10")]
    LeastSquares(LeastSquaresMessage),
    #[prost(message, tag = "11")]
    Custom(CustomMessage),
}

/// The matrices of a custom transform; without `v` that of both directions is `u`.
#[derive(Clone, PartialEq, Message)]
struct CustomMessage {
    #[prost(message, repeated, tag = "1")]
    u: Vec<RowMessage>,
    #[prost(message, repeated, tag = "2")]
    v: Vec<RowMessage>,
    #[prost(bool, tag = "3")]
    has_v: bool,
}

#[derive(Clone, PartialEq, Message)]
struct RowMessage {
    #[prost(double, repeated, tag = "1")]
    entries: Vec<f64>,
}

impl RowMessage {
    fn of(rows: &[Vec<f64>]) -> Vec<Self> {
        let row = |entries: &Vec<f64>| Self {
            entries: entries.clone(),
        };
        rows.iter().map(row).collect()
    }

    fn rows(messages: Vec<Self>) -> Vec<Vec<f64>> {
        messages.into_iter().map(|row| row.entries).collect()
    }
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Nothing {}

#[derive(Clone, Copy, PartialEq, Message)]
struct Number {
    #[prost(double, optional, tag = "1")]
    value: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct LeastSquaresMessage {
    #[prost(uint64, tag = "1")]
    u: u64,
    #[prost(uint64, tag = "2")]
    v: u64,
    #[prost(enumeration = "VariantCode", tag = "3")]
    variant: i32,
    #[prost(double, optional, tag = "4")]
    mu: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum WeightsCode {
    None = 0,
    Homogeneous = 1,
    FixedGrid = 2,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum VariantCode {
    Diagonal = 0,
    Lspia = 1,
    ConjugateGradients = 2,
}

impl Input {
    /// What was asked for.
    pub(super) fn new(problem: &Problem) -> Self {
        let request = problem.request();
        let (weights, weight_values) = match &request.weights {
            Weights::None => (WeightsCode::None, Vec::new()),
            Weights::Homogeneous(values) => (WeightsCode::Homogeneous, values.clone()),
            Weights::FixedGrid(values) => (WeightsCode::FixedGrid, values.clone()),
        };
        let (tolerance, relative) = match request.tolerance {
            Tolerance::Absolute(value) => (value, false),
            Tolerance::Relative(value) => (value, true),
        };
        let wide = |indices: &[usize]| indices.iter().map(|&index| index as u64).collect();
        Self {
            points: Some(PointsMessage::new(&request.points)),
            rows: request.grid.rows as u64,
            columns: request.grid.columns as u64,
            missing: wide(&request.missing),
            u: Some((&request.u).into()),
            v: request.v.as_ref().map(DirectionMessage::from),
            weights: weights as i32,
            weight_values,
            method: Some((&request.method).into()),
            selects: request.selected.is_some(),
            selected: wide(request.selected.as_deref().unwrap_or_default()),
            start: request.start.as_deref().map(PointsMessage::new),
            tolerance,
            relative,
            max_iterations: request.max_iterations as u64,
            lambda_min: request.lambda_min,
        }
    }

    /// What was asked for, to be computed again.
    pub(super) fn into_request(self) -> Result<Request, StoreError> {
        let code = self.weights();
        let points = self.points.ok_or_else(|| damaged("no points"))?;
        let points = points.into_points()?;
        let grid = grid(self.rows, self.columns)?;
        let missing = narrow(self.missing)?;
        let outside = missing.iter().any(|index| *index >= grid.count());
        if points.len() != grid.count() || outside || (self.v.is_none() && grid.columns > 1) {
            return Err(damaged("points and their arrangement do not fit together"));
        }
        let selected = self.selects.then(|| narrow(self.selected)).transpose()?;
        let start = self.start.map(PointsMessage::into_points).transpose()?;
        Ok(Request {
            points: Arc::new(points),
            grid,
            missing,
            u: self.u.ok_or_else(|| damaged("no direction"))?.try_into()?,
            v: self.v.map(DirectionChoice::try_from).transpose()?,
            weights: match code {
                WeightsCode::None => Weights::None,
                WeightsCode::Homogeneous => Weights::Homogeneous(self.weight_values),
                WeightsCode::FixedGrid => Weights::FixedGrid(self.weight_values),
            },
            method: self
                .method
                .ok_or_else(|| damaged("no method"))?
                .try_into()?,
            selected: selected.map(Arc::from),
            start: start.map(Arc::new),
            tolerance: match self.relative {
                true => Tolerance::Relative(self.tolerance),
                false => Tolerance::Absolute(self.tolerance),
            },
            max_iterations: number(self.max_iterations)?,
            lambda_min: self.lambda_min,
        })
    }
}

fn narrow(indices: Vec<u64>) -> Result<Vec<usize>, StoreError> {
    indices.into_iter().map(number).collect()
}

impl From<&Method> for MethodMessage {
    fn from(method: &Method) -> Self {
        let case = match *method {
            Method::Global => MethodCase::Global(Nothing {}),
            Method::Weighted(Weighted { omega: value }) => MethodCase::Weighted(Number { value }),
            Method::Local(Local { row_by_row }) => MethodCase::Local(row_by_row),
            Method::Adaptive(Adaptive { threshold }) => MethodCase::Adaptive(threshold),
            Method::Extended(Extended { start }) => MethodCase::Extended(start == Start::Data),
            Method::Transpose => MethodCase::Transpose(Nothing {}),
            Method::Convex => MethodCase::Convex(Nothing {}),
            Method::Chebyshev => MethodCase::Chebyshev(Nothing {}),
            Method::Direct => MethodCase::Direct(Nothing {}),
            Method::LeastSquares(LeastSquares { u, v, variant }) => {
                let (variant, mu) = match variant {
                    Variant::Diagonal => (VariantCode::Diagonal, None),
                    Variant::Lspia { mu } => (VariantCode::Lspia, mu),
                    Variant::ConjugateGradients => (VariantCode::ConjugateGradients, None),
                };
                MethodCase::LeastSquares(LeastSquaresMessage {
                    u: u as u64,
                    v: v as u64,
                    variant: variant as i32,
                    mu,
                })
            }
            Method::Custom(ref custom) => MethodCase::Custom(CustomMessage {
                u: RowMessage::of(custom.u()),
                v: RowMessage::of(custom.v().unwrap_or_default()),
                has_v: custom.v().is_some(),
            }),
        };
        Self { case: Some(case) }
    }
}

impl TryFrom<MethodMessage> for Method {
    type Error = StoreError;

    fn try_from(message: MethodMessage) -> Result<Self, StoreError> {
        Ok(match message.case.ok_or_else(|| damaged("no method"))? {
            MethodCase::Global(_) => Self::Global,
            MethodCase::Weighted(Number { value: omega }) => Self::Weighted(Weighted { omega }),
            MethodCase::Local(row_by_row) => Self::Local(Local { row_by_row }),
            MethodCase::Adaptive(threshold) => Self::Adaptive(Adaptive { threshold }),
            MethodCase::Extended(true) => Self::Extended(Extended { start: Start::Data }),
            MethodCase::Extended(false) => Self::Extended(Extended {
                start: Start::Transformed,
            }),
            MethodCase::Transpose(_) => Self::Transpose,
            MethodCase::Convex(_) => Self::Convex,
            MethodCase::Chebyshev(_) => Self::Chebyshev,
            MethodCase::Direct(_) => Self::Direct,
            MethodCase::LeastSquares(message) => Self::LeastSquares(LeastSquares {
                u: number(message.u)?,
                v: number(message.v)?,
                variant: match message.variant() {
                    VariantCode::Diagonal => Variant::Diagonal,
                    VariantCode::Lspia => Variant::Lspia { mu: message.mu },
                    VariantCode::ConjugateGradients => Variant::ConjugateGradients,
                },
            }),
            MethodCase::Custom(CustomMessage { u, v, has_v }) => {
                let v = has_v.then(|| RowMessage::rows(v));
                Self::Custom(Custom::new(RowMessage::rows(u), v))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples::problem;

    #[test]
    fn what_does_not_fit_together_is_damage() {
        let whole = Input::new(&problem());
        assert!(whole.clone().into_request().is_ok());
        let damages: [fn(&mut Input); 5] = [
            |input| input.rows += 1,
            |input| (input.rows, input.columns) = (1 << 33, 1 << 33),
            |input| (input.rows, input.columns) = (10, 2),
            |input| input.missing = vec![20],
            |input| input.points = Some(PointsMessage::default()),
        ];
        for (k, damage) in damages.into_iter().enumerate() {
            let mut input = whole.clone();
            damage(&mut input);
            assert!(input.into_request().is_err(), "{k}");
        }
    }
}
