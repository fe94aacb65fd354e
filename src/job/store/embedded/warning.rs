//! What was doubtful about a job when it was accepted, as protobuf messages.

use prost::{Enumeration, Message};

use crate::fit::invalid::Axis;
use crate::fit::warning::Warning;

/// A warning about a direction.
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
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
enum Code {
    Unknown = 0,
    FewPoints = 1,
    EvenDegree = 2,
}

impl WarningMessage {
    /// Nothing of what follows from the forecast, which is kept itself.
    pub(super) fn new(warning: &Warning) -> Option<Self> {
        let (code, axis, degree, count) = match *warning {
            Warning::FewPoints {
                axis,
                degree,
                count,
            } => (Code::FewPoints, axis, degree, count),
            Warning::EvenDegree { axis, degree } => (Code::EvenDegree, axis, degree, 0),
            _ => return None,
        };
        Some(Self {
            code: code as i32,
            of_v: axis == Axis::V,
            degree: degree as u64,
            count: count as u64,
        })
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
        }
    }
}
