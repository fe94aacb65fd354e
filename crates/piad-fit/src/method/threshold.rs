//! The distances up to which adaptive PIA leaves points alone.

use std::sync::Arc;

use crate::invalid::{Invalid, Place, Setting, one_for_each};

/// One distance for all points, or one for each, in data units. Clones share them.
///
/// ```
/// use piad_fit::method::Threshold;
///
/// assert_eq!(Threshold::All(0.1).largest(), 0.1);
/// let each = Threshold::Each([0.1, 0.5, 0.2].into());
/// assert_eq!(each.largest(), 0.5);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Threshold {
    /// The same for all points.
    All(f64),
    /// One for each point; of a surface row by row.
    Each(Arc<[f64]>),
}

impl Threshold {
    /// The largest one.
    pub fn largest(&self) -> f64 {
        match self {
            Self::All(threshold) => *threshold,
            Self::Each(each) => each.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Returns true if each point has its own.
    pub fn is_each(&self) -> bool {
        matches!(self, Self::Each(_))
    }

    /// The threshold of a point.
    pub(super) fn of(&self, index: usize) -> f64 {
        match self {
            Self::All(threshold) => *threshold,
            Self::Each(each) => each[index],
        }
    }

    /// Refuses thresholds that are not greater than 0, at which points would move forever, and
    /// lists that are not one for each of `count` points.
    pub(super) fn check(&self, count: usize) -> Result<(), Invalid> {
        let each = match self {
            Self::All(threshold) => {
                return Invalid::unless_positive(Setting::Threshold, *threshold);
            }
            Self::Each(each) => each,
        };
        let (given, expected) = (each.len(), count);
        if given != expected {
            return Err(Invalid::at(
                Place::Setting(Setting::Threshold),
                one_for_each(given, "thresholds", expected),
            ));
        }
        let wrong = |value: &f64| !(*value > 0.0 && value.is_finite());
        match each.iter().position(wrong) {
            None => Ok(()),
            Some(index) => Err(Invalid::at(
                Place::Threshold(index),
                format!(
                    "threshold {index} is {value}; thresholds are finite and greater than 0",
                    value = each[index]
                ),
            )),
        }
    }
}
