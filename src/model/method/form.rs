//! The form of a method in JSON, and the locations of its settings.

use crate::model::per_direction::direction;
use piad_fit::invalid::Place as P;

/// The form of a method.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MethodForm {
    /// The directions have a setting each.
    pub each: bool,
    /// The numbers of control points are limits.
    pub limited: bool,
}

/// The JSON pointer to a setting, or a part of it; everything else is the method.
pub(crate) fn pointer(place: P, MethodForm { each, limited }: MethodForm) -> String {
    let setting = match place {
        P::Setting(setting) => setting.name().to_owned(),
        P::Index(index) => format!("indices/{index}"),
        P::Constraint(index) => format!("constraints/{index}"),
        P::ControlPoints(axis) if limited => {
            format!("max_control_points{}", direction(each, axis))
        }
        P::ControlPoints(axis) => format!("control_points{}", direction(each, axis)),
        P::Transform(axis) => format!("transform{}", direction(each, axis)),
        P::TransformRow(axis, row) => format!("transform{}/{row}", direction(each, axis)),
        P::TransformEntry(axis, row, column) => {
            format!("transform{}/{row}/{column}", direction(each, axis))
        }
        _ => return "/method".to_owned(),
    };
    format!("/method/{setting}")
}
