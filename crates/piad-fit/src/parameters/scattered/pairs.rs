//! u and v of scattered points, and the extents of both directions.

use std::sync::Arc;

use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};

/// u and v of scattered points, and how far both directions go.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pairs {
    /// u and v of each point.
    pub values: Arc<Points>,
    /// The extents of u and v.
    pub domains: [Domain; 2],
}

/// The extent of a direction of scattered points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Domain {
    /// From the least to the largest parameter.
    #[default]
    Data,
    /// It is closed, and repeats after this length.
    Closed(f64),
    /// From one number to another one. At a pole all points of that edge of the surface coincide.
    Between {
        /// Both ends.
        ends: [f64; 2],
        /// True at an end that is a pole.
        poles: [bool; 2],
    },
}

impl Domain {
    /// The length after which a closed direction repeats.
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Closed(period) => Some(period),
            Self::Data | Self::Between { .. } => None,
        }
    }

    /// The ends that are poles.
    pub fn poles(self) -> [bool; 2] {
        match self {
            Self::Between { poles, .. } => poles,
            Self::Data | Self::Closed(_) => [false; 2],
        }
    }
}

impl Domain {
    /// Refuses ends that are no range, or do not hold all parameters, and poles of u.
    pub(super) fn check(self, values: &[f64], axis: Axis) -> Result<(), Invalid> {
        let Self::Between { ends, poles } = self else {
            return Ok(());
        };
        let [low, high] = ends;
        let wrong = |detail: String| Err(Invalid::at(Place::Parameters(axis), detail));
        if !(low.is_finite() && high.is_finite() && low < high) {
            return wrong(format!(
                "{low} and {high} are not the ends of a direction: the first must be less than the second"
            ));
        }
        if poles != [false; 2] && axis == Axis::U {
            return wrong("poles are ends of v".to_owned());
        }
        match values.iter().position(|t| !(low..=high).contains(t)) {
            Some(index) => Err(Invalid::parameter_outside(
                axis,
                index,
                values[index],
                (low, high),
            )),
            None => Ok(()),
        }
    }
}

impl Pairs {
    /// The pairs of a surface from the least to the largest parameter of each direction.
    pub fn open(values: Arc<Points>) -> Self {
        Self {
            values,
            domains: [Domain::Data; 2],
        }
    }

    /// u or v of all points, and its domain.
    pub(crate) fn direction(&self, axis: usize) -> (Vec<f64>, Domain) {
        (self.values.lane(axis).to_vec(), self.domains[axis])
    }

    /// Those of some of the points.
    pub(crate) fn of(&self, indices: impl Iterator<Item = usize> + Clone) -> Self {
        Self {
            values: Arc::new(self.values.selected(indices)),
            ..*self
        }
    }
}
