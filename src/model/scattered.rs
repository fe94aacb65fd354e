//! How scattered points get their parameters: by themselves, or from the surface of another job.

use std::sync::Arc;

use super::mistakes::{Mistake, SpecPart};
use crate::fit::foot::foot_points;
use crate::fit::nurbs::Nurbs;
use crate::fit::points::Points;
use crate::fit::scattered::Scattered;

/// How scattered points get their parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum ScatteredSpec {
    /// As they are given, or from a plane.
    Own(Scattered),
    /// Those of their foot points on the surface of another job.
    FootPoints(BaseSpec),
}

/// An iteration of another job.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseSpec {
    /// The id of the job.
    pub job: String,
    /// The iteration; without one, its last.
    pub iteration: Option<usize>,
}

impl ScatteredSpec {
    /// The parameters as the fit gets them: foot points become given parameters, so that the new
    /// job does not depend on the other one any more.
    pub(super) fn resolve(
        self,
        points: &Points,
        base: Result<&Nurbs, Mistake>,
    ) -> Result<Scattered, Mistake> {
        match self {
            Self::Own(scattered) => Ok(scattered),
            Self::FootPoints(_) => match foot_points(base?, points) {
                Ok(pairs) => Ok(Scattered::Given(Arc::new(pairs))),
                Err(reason) => Err(Mistake::at(SpecPart::FootPoints, reason.to_string())),
            },
        }
    }
}

/// What is said of a surface that nobody has looked for.
pub fn no_base() -> Mistake {
    Mistake::at(SpecPart::FootPoints, "other jobs are not known here")
}
