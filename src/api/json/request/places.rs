//! Where in the JSON of a request the parts of the model stand.

use super::ends::EndsForm;
use super::method::{self, MethodForm};
use crate::api::json::per_direction::direction;
use crate::api::problem::{self, Words};
use crate::fit::invalid::{Axis, Place as P};
use crate::fit::points::Grid;
use crate::model::mistakes::{ChangePart, SpecPart};
use crate::model::named::Named;

/// Which parts of the request have a value for each direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Places {
    /// What the parts of the curve or surface stand in; they are fields of edits themselves.
    pub(super) root: &'static str,
    /// The number of columns of a surface; `None` for a curve.
    pub(super) columns: Option<usize>,
    /// There is a degree instead of a basis.
    pub(super) degree_alone: bool,
    pub(super) basis_each: bool,
    pub(super) parameters_each: bool,
    pub(super) closed_each: bool,
    pub(super) weights_each: bool,
    pub(super) ends_each: bool,
    /// How the ends of u and v are written.
    pub(super) ends: [EndsForm; 2],
    /// The points are scattered.
    pub(super) scattered: bool,
    /// How the method is written.
    pub(super) method: MethodForm,
}

impl Places {
    /// Of a curve with one value for everything.
    pub fn of_curve() -> Self {
        Self {
            root: "/curve",
            ..Self::default()
        }
    }

    /// Of a surface with one value for both directions.
    pub fn of_surface(grid: Grid) -> Self {
        Self {
            root: "/surface",
            columns: grid.is_rows().then_some(grid.columns),
            ..Self::default()
        }
    }

    /// Of a job as it is shown, of whose parts only the bases are looked for.
    pub fn of_input(surface: Option<Grid>, basis_each: bool) -> Self {
        Self {
            basis_each,
            scattered: surface.is_some_and(|grid| !grid.is_rows()),
            ..surface.map_or_else(Self::of_curve, Self::of_surface)
        }
    }

    fn part(&self, name: &str, each: bool, axis: Axis) -> String {
        format!("{}/{name}{}", self.root, direction(each, axis))
    }

    fn basis(&self, axis: Axis) -> String {
        self.part("basis", self.basis_each, axis)
    }

    fn parameters(&self, axis: Axis) -> String {
        self.part("parameters", self.parameters_each, axis)
    }

    fn weights(&self, axis: Axis) -> String {
        self.part("weights", self.weights_each, axis)
    }

    /// A part of how a direction ends.
    fn ends(&self, axis: Axis, place: P) -> String {
        let form = self.ends[usize::from(axis == Axis::V)];
        self.part("ends", self.ends_each, axis) + &form.pointer(place)
    }

    /// A point or its weight in a list or a grid.
    fn element(&self, name: &str, index: usize) -> String {
        format!("{}/{name}/{}", self.root, self.index(index))
    }

    /// The field of the points.
    fn points(&self) -> &'static str {
        match self.scattered {
            true => "scattered",
            false => "points",
        }
    }

    /// What a setting of the method has for a point.
    fn setting(&self, name: &str, index: usize) -> String {
        format!("/method/{name}/{}", self.index(index))
    }

    /// The place of a point in a list or a grid.
    fn index(&self, index: usize) -> String {
        match self.columns {
            None => index.to_string(),
            Some(columns) => format!("{}/{}", index / columns, index % columns),
        }
    }

    /// The JSON pointer to a part of the fitting problem.
    fn pointer(&self, place: P) -> String {
        let root = self.root;
        match place {
            P::Points => format!("{root}/{}", self.points()),
            P::Point(index) => self.element(self.points(), index),
            P::Line(Axis::U, index) => format!("{root}/points/{index}"),
            P::Line(Axis::V, index) => format!("{root}/points/0/{index}"),
            P::Basis(axis) => self.basis(axis),
            P::Degree(axis) if self.degree_alone => self.part("degree", self.basis_each, axis),
            P::Degree(axis) => format!("{}/degree", self.basis(axis)),
            P::Knots(axis) => format!("{}/knots", self.basis(axis)),
            P::Knot(axis, index) => format!("{}/knots/{index}", self.basis(axis)),
            P::Parameters(_) if self.scattered => format!("{root}/parameters"),
            P::Parameter(axis, index) if self.scattered => {
                let number = usize::from(axis == Axis::V);
                format!("{root}/parameters/{index}/{number}")
            }
            P::Parameters(axis) => self.parameters(axis),
            P::Parameter(axis, index) => format!("{}/{index}", self.parameters(axis)),
            P::Closed(axis) => self.part("closed", self.closed_each, axis),
            P::Ends(axis) | P::End(axis, _) | P::EndOrder(axis, ..) | P::EndVector(axis, ..) => {
                self.ends(axis, place)
            }
            P::Weights => format!("{root}/weights"),
            P::Weight(index) => self.element("weights", index),
            P::AxisWeights(axis) => self.weights(axis),
            P::AxisWeight(axis, index) => format!("{}/{index}", self.weights(axis)),
            P::Threshold(index) => self.setting("threshold", index),
            P::DataWeight(index) => self.setting("data_weights", index),
            P::Tolerance => "/stop/tolerance".to_owned(),
            P::RelativeTolerance => "/stop/relative_tolerance".to_owned(),
            place => method::pointer(place, self.method),
        }
    }
}

impl Words for Places {
    fn of(&self, place: SpecPart) -> String {
        match place {
            SpecPart::Whole => String::new(),
            SpecPart::Name => "/name".to_owned(),
            SpecPart::Fit(place) => self.pointer(place),
            SpecPart::Rational => "/rational".to_owned(),
            SpecPart::MaxIterations => "/stop/max_iterations".to_owned(),
            SpecPart::Stream(choice, None) => format!("/stream/{}", choice.name()),
            SpecPart::Stream(choice, Some(index)) => format!("/stream/{}/{index}", choice.name()),
            SpecPart::FootPoints => "/surface/parameters/foot_points/job".to_owned(),
            SpecPart::FootPointsIteration => "/surface/parameters/foot_points/iteration".to_owned(),
            SpecPart::Iteration => "/iteration".to_owned(),
            SpecPart::Ephemeral => "/ephemeral".to_owned(),
            SpecPart::Session => "/session".to_owned(),
            SpecPart::Change(k, part) => {
                let part = match part {
                    ChangePart::Whole => "",
                    ChangePart::Index => "/index",
                    ChangePart::Point => "/point",
                    ChangePart::Weight => "/weight",
                };
                format!("/points/{k}{part}")
            }
        }
    }

    fn place(&self, text: String) -> problem::Location {
        problem::Location::Pointer(text)
    }
}
