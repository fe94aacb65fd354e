//! What files of version 1 of the format have in other fields. It is read only: what is written has the
//! version of today.

use std::sync::Arc;

use prost::{Message, Oneof};

use super::super::StoreError;
use super::error::damaged;
use super::fields::{grid, number};
use super::points::PointsMessage;
use crate::fit::basis::{Polynomial, knots::Knots};
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::method::{
    Adaptive, Convex, Custom, EndPoints, Ending, Extended, LeastSquares, Local, Method, Start,
    Sweeps, Threshold, Variant, Weighted,
};
use crate::fit::parameters::Parametrization;
use crate::fit::problem::{Request, Tolerance, Weights};
use crate::model::stream::StreamSpec;

/// What a header has in other fields.
#[derive(Clone, PartialEq, Message)]
struct Header {
    /// A JSON text.
    #[prost(string, optional, tag = "5")]
    stream: Option<String>,
    #[prost(message, optional, tag = "10")]
    method: Option<MethodMessage>,
}

/// A problem.
#[derive(Clone, PartialEq, Message)]
struct Input {
    #[prost(message, optional, tag = "1")]
    points: Option<PointsMessage>,
    #[prost(uint64, tag = "2")]
    rows: u64,
    #[prost(uint64, tag = "3")]
    columns: u64,
    #[prost(uint64, repeated, tag = "4")]
    missing: Vec<u64>,
    #[prost(message, optional, tag = "5")]
    u: Option<Direction>,
    #[prost(message, optional, tag = "6")]
    v: Option<Direction>,
    #[prost(uint32, tag = "7")]
    weights: u32,
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

#[derive(Clone, PartialEq, Message)]
struct Direction {
    #[prost(uint32, tag = "1")]
    basis: u32,
    #[prost(uint64, tag = "2")]
    degree: u64,
    #[prost(uint32, tag = "3")]
    knots: u32,
    #[prost(double, repeated, tag = "4")]
    knot_values: Vec<f64>,
    #[prost(uint32, tag = "5")]
    parameters: u32,
    #[prost(double, repeated, tag = "6")]
    parameter_values: Vec<f64>,
    #[prost(bool, tag = "7")]
    closed: bool,
    #[prost(bool, tag = "8")]
    weighted: bool,
    #[prost(double, repeated, tag = "9")]
    weights: Vec<f64>,
}

#[derive(Clone, PartialEq, Message)]
struct MethodMessage {
    #[prost(oneof = "Kind", tags = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11")]
    kind: Option<Kind>,
}

#[derive(Clone, PartialEq, Oneof)]
enum Kind {
    #[prost(message, tag = "1")]
    Global(()),
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
    Transpose(()),
    #[prost(message, tag = "7")]
    Convex(()),
    #[prost(message, tag = "8")]
    Chebyshev(()),
    #[prost(message, tag = "9")]
    Direct(()),
    #[prost(message, tag = "10")]
    LeastSquares(ControlPoints),
    #[prost(message, tag = "11")]
    Custom(Matrices),
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Number {
    #[prost(double, optional, tag = "1")]
    value: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct ControlPoints {
    #[prost(uint64, tag = "1")]
    u: u64,
    #[prost(uint64, tag = "2")]
    v: u64,
    #[prost(uint32, tag = "3")]
    variant: u32,
    #[prost(double, optional, tag = "4")]
    mu: Option<f64>,
}

#[derive(Clone, PartialEq, Message)]
struct Matrices {
    #[prost(message, repeated, tag = "1")]
    u: Vec<Row>,
    #[prost(message, repeated, tag = "2")]
    v: Vec<Row>,
    #[prost(bool, tag = "3")]
    has_v: bool,
}

#[derive(Clone, PartialEq, Message)]
struct Row {
    #[prost(double, repeated, tag = "1")]
    entries: Vec<f64>,
}

/// The method of the header in these bytes, and what it says of streams.
pub(super) fn choices(bytes: &[u8]) -> Result<(Method, Option<StreamSpec>), StoreError> {
    let header = Header::decode(bytes).map_err(damaged)?;
    let method = header.method.ok_or_else(|| damaged("no method"))?.read()?;
    let stream = header.stream.as_deref().map(serde_json::from_str);
    Ok((method, stream.transpose().map_err(damaged)?))
}

/// The problem in these bytes, as it was asked for.
pub(super) fn request(bytes: &[u8]) -> Result<Request, StoreError> {
    let input = Input::decode(bytes).map_err(damaged)?;
    let points = input.points.ok_or_else(|| damaged("no points"))?;
    let points = points.into_points()?;
    let grid = grid(input.rows, input.columns)?;
    let missing = numbers(input.missing)?;
    let outside = missing.iter().any(|index| *index >= grid.count());
    if points.len() != grid.count() || outside || (input.v.is_none() && grid.columns > 1) {
        return Err(damaged("points and their arrangement do not fit together"));
    }
    let selected = input.selects.then(|| numbers(input.selected)).transpose()?;
    let start = input.start.map(PointsMessage::into_points).transpose()?;
    let method = input.method.ok_or_else(|| damaged("no method"))?;
    Ok(Request {
        start_breaks: None,
        points: Arc::new(points),
        grid,
        missing,
        u: input.u.ok_or_else(|| damaged("no direction"))?.read()?,
        v: input.v.map(Direction::read).transpose()?,
        weights: match input.weights {
            1 => Weights::Homogeneous(input.weight_values),
            2 => Weights::FixedGrid(input.weight_values),
            _ => Weights::None,
        },
        method: method.read()?,
        selected: selected.map(Arc::from),
        start: start.map(Arc::new),
        lambda_min: input.lambda_min,
        scattered: None,
        tolerance: Some(match input.relative {
            true => Tolerance::Relative(input.tolerance),
            false => Tolerance::Absolute(input.tolerance),
        }),
        max_iterations: number(input.max_iterations)?,
    })
}

fn numbers(values: Vec<u64>) -> Result<Vec<usize>, StoreError> {
    values.into_iter().map(number).collect()
}

impl Direction {
    fn read(self) -> Result<DirectionChoice, StoreError> {
        let knots = match self.knots {
            1 => Knots::Data,
            2 => Knots::Averaged,
            3 => Knots::Explicit(Arc::new(self.knot_values)),
            _ => Knots::Usual,
        };
        Ok(DirectionChoice {
            basis: match self.basis {
                1 => BasisChoice::Polynomial(Polynomial::Bernstein),
                2 => BasisChoice::Polynomial(Polynomial::SaidBall),
                3 => BasisChoice::Polynomial(Polynomial::WangBall),
                _ => BasisChoice::BSpline {
                    degree: number(self.degree)?,
                    knots,
                },
            },
            parameters: match self.parameters {
                1 => Parametrization::Centripetal,
                2 => Parametrization::Uniform,
                3 => Parametrization::Explicit(Arc::new(self.parameter_values)),
                _ => Parametrization::ChordLength,
            },
            closed: self.closed,
            control_points: None,
            ends: None,
            weights: self.weighted.then_some(self.weights),
        })
    }
}

impl MethodMessage {
    fn read(self) -> Result<Method, StoreError> {
        Ok(match self.kind.ok_or_else(|| damaged("no method"))? {
            Kind::Global(()) => Method::Global,
            Kind::Weighted(Number { value: omega }) => Method::Weighted(Weighted { omega }),
            Kind::Local(row_by_row) => Method::Local(Local {
                sweeps: row_by_row.then_some(Sweeps::Rows),
                ..Local::default()
            }),
            Kind::Adaptive(threshold) => Method::Adaptive(Adaptive {
                threshold: Threshold::All(threshold),
                omega: 1.0,
            }),
            Kind::Extended(from_data) => Method::Extended(Extended {
                start: match from_data {
                    true => Start::Data,
                    false => Start::Transformed,
                },
                transformed_error: false,
            }),
            Kind::Transpose(()) => Method::Transpose,
            Kind::Convex(()) => Method::Convex(Convex::default()),
            Kind::Chebyshev(()) => Method::Chebyshev,
            Kind::Direct(()) => Method::Direct,
            Kind::LeastSquares(ControlPoints { u, v, variant, mu }) => {
                Method::LeastSquares(LeastSquares {
                    variant: match variant {
                        1 => Variant::Lspia { mu },
                        2 => Variant::ConjugateGradients,
                        _ => Variant::Diagonal,
                    },
                    ending: Ending::SmallStep,
                    ends: EndPoints::Free,
                    ..LeastSquares::new(number(u)?, number(v)?)
                })
            }
            Kind::Custom(Matrices { u, v, has_v }) => {
                Method::Custom(Custom::new(rows(u), has_v.then(|| rows(v))))
            }
        })
    }
}

fn rows(rows: Vec<Row>) -> Vec<Vec<f64>> {
    rows.into_iter().map(|row| row.entries).collect()
}

#[cfg(test)]
mod tests {
    use super::super::version_2;
    use super::*;
    use crate::job::samples::problem;

    #[test]
    fn what_does_not_fit_together_is_damage() {
        let kept = problem();
        let kept = kept.request();
        let whole = Input {
            points: Some(PointsMessage::new(&kept.points)),
            rows: 20,
            columns: 1,
            u: Some(Direction {
                degree: 3,
                knots: 1,
                parameters: 2,
                ..Direction::default()
            }),
            method: Some(MethodMessage {
                kind: Some(Kind::Global(())),
            }),
            max_iterations: 10,
            ..Input::default()
        };
        let mut read = request(&whole.encode_to_vec()).unwrap();
        version_2::complete(&mut read);
        assert_eq!(format!("{read:?}"), format!("{kept:?}"));
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
            assert!(request(&input.encode_to_vec()).is_err(), "{k}");
        }
    }
}
