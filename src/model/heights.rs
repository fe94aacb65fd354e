//! Heights in a plane: rows of numbers become points of space.

use std::sync::Arc;

use super::errors::{OrErrors, SpecPart, ValidationError, ValidationErrors};
use super::points::PointGrid;
use piad_fit::data::Points;

/// The positions of the heights of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    /// The steps from column to column along x, and from row to row along y.
    spacing: [f64; 2],
    /// The place of the first height.
    origin: [f64; 2],
}

impl Placement {
    /// The positions by a spacing and an origin, if there is a spacing.
    pub(super) fn new(
        spacing: Option<[f64; 2]>,
        origin: Option<[f64; 2]>,
        is_scattered: bool,
    ) -> OrErrors<Option<Self>> {
        let mut errors = ValidationErrors::default();
        let Some(spacing) = spacing else {
            if origin.is_some() {
                let detail = "it is the place of heights with a spacing, which is missing";
                errors.push(ValidationError::at(SpecPart::Origin(None), detail));
            }
            return errors.or(None);
        };
        if is_scattered {
            let detail = "it is that of rows of heights, and these points are scattered";
            errors.push(ValidationError::at(SpecPart::Spacing(None), detail));
        }
        let origin = origin.unwrap_or_default();
        for (axis, step) in spacing.into_iter().enumerate() {
            if step == 0.0 || !step.is_finite() {
                let detail = format!("the step is {step}, and it is a number other than 0");
                errors.push(ValidationError::at(SpecPart::Spacing(Some(axis)), detail));
            }
        }
        for (axis, start) in origin.into_iter().enumerate() {
            if !start.is_finite() {
                let detail = format!("the coordinate is {start}, and it is a finite number");
                errors.push(ValidationError::at(SpecPart::Origin(Some(axis)), detail));
            }
        }
        errors.or(Some(Self { spacing, origin }))
    }

    /// The points [x, y, z] of heights: x grows from column to column, and y from row to row.
    pub(super) fn points(
        self,
        heights: PointGrid,
        is_closed: bool,
    ) -> Result<PointGrid, ValidationError> {
        let wrong = |detail: String| ValidationError::at(SpecPart::Spacing(None), detail);
        let dimension = heights.points.dimension();
        if dimension != 1 {
            let detail =
                format!("it is that of heights, and these points have {dimension} coordinates");
            return Err(wrong(detail));
        }
        if is_closed {
            let detail =
                "heights at equal steps do not return to their start, and the surface is closed";
            return Err(wrong(detail.to_owned()));
        }
        let (columns, rows) = (heights.grid.columns, heights.grid.rows);
        let last =
            |axis: usize, count: usize| self.origin[axis] + count as f64 * self.spacing[axis];
        if !(last(0, columns).is_finite() && last(1, rows).is_finite()) {
            let detail = "the heights lie beyond the range of numbers";
            return Err(wrong(detail.to_owned()));
        }
        let places = |axis: usize, count: usize| {
            let (start, step) = (self.origin[axis], self.spacing[axis]);
            let places = (0..count).map(move |i| start + i as f64 * step);
            places.collect::<Vec<f64>>()
        };
        let x = places(0, columns).repeat(rows);
        let y = places(1, rows).into_iter();
        let y: Vec<f64> = y.flat_map(|y| std::iter::repeat_n(y, columns)).collect();
        let z = heights.points.lane(0).to_vec();
        let points = Arc::new(Points::from_lanes([x, y, z]));
        Ok(PointGrid { points, ..heights })
    }
}
