//! What was doubtful about a job when it was accepted, as protobuf messages.

use prost::{Enumeration, Message};

use crate::fit::invalid::Axis;
use crate::fit::warning::Warning;

/// A warning about a direction, or about the points.
#[derive(Clone, Copy, PartialEq, Message)]
pub(super) struct WarningMessage {
    #[prost(enumeration = "Code", tag = "1")]
    code: i32,
    #[prost(bool, tag = "2")]
    of_v: bool,
    #[prost(uint64, tag = "3")]
    degree: u64,
    #[prost(uint64, tag = "4")]
    count: u64,
    #[prost(double, tag = "5")]
    diagonal: f64,
    #[prost(double, tag = "6")]
    inner: f64,
    #[prost(double, tag = "7")]
    tolerance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum Code {
    Unknown = 0,
    FewPoints = 1,
    EvenDegree = 2,
    Outliers = 3,
}

impl WarningMessage {
    /// Nothing of what follows from the forecast, which is kept itself.
    pub(super) fn new(warning: &Warning) -> Option<Self> {
        let of = |code: Code| Self {
            code: code as i32,
            ..Self::default()
        };
        let of_direction = |code, axis, degree: usize| Self {
            of_v: axis == Axis::V,
            degree: degree as u64,
            ..of(code)
        };
        match *warning {
            Warning::FewPoints {
                axis,
                degree,
                count,
            } => Some(Self {
                count: count as u64,
                ..of_direction(Code::FewPoints, axis, degree)
            }),
            Warning::EvenDegree { axis, degree } => {
                Some(of_direction(Code::EvenDegree, axis, degree))
            }
            Warning::Outliers {
                diagonal,
                inner,
                tolerance,
            } => Some(Self {
                diagonal,
                inner,
                tolerance,
                ..of(Code::Outliers)
            }),
            _ => None,
        }
    }

    /// A warning of a later program is left out: nothing depends on it.
    pub(super) fn meaning(&self) -> Option<Warning> {
        let axis = if self.of_v { Axis::V } else { Axis::U };
        let degree = usize::try_from(self.degree).ok()?;
        let count = usize::try_from(self.count).ok()?;
        match self.code() {
            Code::Unknown => None,
            Code::FewPoints => Some(Warning::FewPoints {
                axis,
                degree,
                count,
            }),
            Code::EvenDegree => Some(Warning::EvenDegree { axis, degree }),
            Code::Outliers => Some(Warning::Outliers {
                diagonal: self.diagonal,
                inner: self.inner,
                tolerance: self.tolerance,
            }),
        }
    }
}
