//! Where in a request the parts of a problem stand.

use crate::fit::invalid::{Axis, Invalid, Place};

/// Which parts of the request have a value for each direction.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::api) struct Places {
    /// The number of columns of a surface; `None` for a curve.
    pub(super) surface_columns: Option<usize>,
    /// There is a degree instead of a basis.
    pub(super) degree_alone: bool,
    pub(super) basis_each: bool,
    pub(super) parameters_each: bool,
    pub(super) closed_each: bool,
    pub(super) weights_each: bool,
    pub(super) control_points_each: bool,
    pub(super) transform_each: bool,
}

impl Places {
    /// Of a job as it is shown, of whose parts only the bases are looked for.
    pub(in crate::api) fn of_input(surface_columns: Option<usize>, basis_each: bool) -> Self {
        Self {
            surface_columns,
            basis_each,
            ..Self::default()
        }
    }

    pub(super) fn root(&self) -> &'static str {
        match self.surface_columns {
            None => "/curve",
            Some(_) => "/surface",
        }
    }

    pub(super) fn basis(&self, axis: Axis) -> String {
        self.part("basis", self.basis_each, axis)
    }

    pub(super) fn parameters(&self, axis: Axis) -> String {
        self.part("parameters", self.parameters_each, axis)
    }

    fn weights(&self, axis: Axis) -> String {
        self.part("weights", self.weights_each, axis)
    }

    fn part(&self, name: &str, each: bool, axis: Axis) -> String {
        format!("{}/{name}{}", self.root(), direction(each, axis))
    }

    /// A point or its weight in a list or a grid.
    fn element(&self, name: &str, index: usize) -> String {
        let root = self.root();
        match self.surface_columns {
            None => format!("{root}/{name}/{index}"),
            Some(columns) => format!("{root}/{name}/{}/{}", index / columns, index % columns),
        }
    }

    /// The JSON pointer to what is wrong.
    pub(super) fn pointer(&self, error: &Invalid) -> String {
        self.pointer_to(error.place())
    }

    /// The JSON pointer to a part of the problem.
    pub(in crate::api) fn pointer_to(&self, place: Place) -> String {
        let root = self.root();
        match place {
            Place::Points => format!("{root}/points"),
            Place::Point(index) => self.element("points", index),
            Place::Line(Axis::U, index) => format!("{root}/points/{index}"),
            Place::Line(Axis::V, index) => format!("{root}/points/0/{index}"),
            Place::Basis(axis) => self.basis(axis),
            Place::Degree(axis) if self.degree_alone => self.part("degree", self.basis_each, axis),
            Place::Degree(axis) => format!("{}/degree", self.basis(axis)),
            Place::Knots(axis) => format!("{}/knots", self.basis(axis)),
            Place::Knot(axis, index) => format!("{}/knots/{index}", self.basis(axis)),
            Place::Parameters(axis) => self.parameters(axis),
            Place::Parameter(axis, index) => format!("{}/{index}", self.parameters(axis)),
            Place::Closed(axis) => self.part("closed", self.closed_each, axis),
            Place::Weights => format!("{root}/weights"),
            Place::Weight(index) => self.element("weights", index),
            Place::AxisWeights(axis) => self.weights(axis),
            Place::AxisWeight(axis, index) => format!("{}/{index}", self.weights(axis)),
            Place::Method => "/method".to_owned(),
            Place::Setting(setting) => format!("/method/{}", setting.name()),
            Place::Transform(_) | Place::TransformRow(..) | Place::TransformEntry(..) => {
                transform(place, self.transform_each)
            }
            Place::Index(index) => format!("/method/indices/{index}"),
            Place::ControlPoints(axis) => format!(
                "/method/control_points{}",
                direction(self.control_points_each, axis)
            ),
            Place::Tolerance => "/stop/tolerance".to_owned(),
            Place::RelativeTolerance => "/stop/relative_tolerance".to_owned(),
        }
    }
}

/// A matrix, or a part of it; everything else is the method.
pub(super) fn transform(place: Place, each: bool) -> String {
    let matrix = |axis| format!("/method/transform{}", direction(each, axis));
    match place {
        Place::Transform(axis) => matrix(axis),
        Place::TransformRow(axis, row) => format!("{}/{row}", matrix(axis)),
        Place::TransformEntry(axis, row, column) => format!("{}/{row}/{column}", matrix(axis)),
        _ => "/method".to_owned(),
    }
}

pub(super) fn direction(each: bool, axis: Axis) -> &'static str {
    match (each, axis) {
        (false, _) => "",
        (true, Axis::U) => "/u",
        (true, Axis::V) => "/v",
    }
}
