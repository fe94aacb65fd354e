//! Numbers, lists and enumerations of messages.

use crate::model::errors::ValidationError;
use crate::model::lists::PointNumbers;
use crate::model::settings::Index;
use piad_fit::data::Grid;

/// The geometry that a method is for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MethodTarget {
    /// The arrangement of the data points.
    pub grid: Grid,
    /// True if they are those of a surface.
    pub surface: bool,
    /// The most indices of points.
    pub most: usize,
}

impl MethodTarget {
    /// The index of a data point.
    pub(crate) fn index(self, index: u32) -> Index {
        let is_rows = self.surface && self.grid.is_rows();
        Index::new(index as usize, is_rows.then_some(self.grid.columns))
    }

    /// Numbers of data points, if there are any.
    pub(crate) fn numbers(self, numbers: Vec<f64>) -> Option<PointNumbers> {
        some(numbers).map(|numbers| PointNumbers::new(numbers, self.grid, self.surface))
    }
}

/// Numbers of points, which are limited by the size of a request.
pub(crate) fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// A list, if it is not empty.
pub(crate) fn some<T>(list: Vec<T>) -> Option<Vec<T>> {
    (!list.is_empty()).then_some(list)
}

/// The value of an enumeration; unknown values are errors of this field.
pub(crate) fn known<E: TryFrom<i32>>(value: i32, field: &str) -> Result<E, ValidationError> {
    E::try_from(value).map_err(|_| {
        let detail = format!("{value} is no value of this enumeration");
        ValidationError::at_text(field, detail)
    })
}

/// The value of an enumeration; `None` if it is not specified.
pub(crate) fn chosen<T: Copy, E: Copy + PartialEq + TryFrom<i32>>(
    table: &[(T, E)],
    value: i32,
    field: &str,
) -> Result<Option<T>, ValidationError> {
    let value: E = known(value, field)?;
    let found = table.iter().find(|(_, known)| *known == value);
    Ok(found.map(|(chosen, _)| *chosen))
}

/// The value of an enumeration; unspecified without a choice.
pub(crate) fn value<T: Copy + PartialEq, E: Copy + Default>(
    table: &[(T, E)],
    chosen: Option<T>,
) -> E {
    let found = table.iter().find(|(known, _)| Some(*known) == chosen);
    found.map_or(E::default(), |(_, value)| *value)
}

/// Lists have at most the allowed number of elements, which is checked before they are processed.
pub(crate) fn check_count(
    count: usize,
    most: usize,
    things: &str,
    field: &str,
) -> Result<(), ValidationError> {
    if count > most {
        let detail = format!("{count} {things} are more than {most}, the limit here");
        return Err(ValidationError::at_text(field, detail));
    }
    Ok(())
}
