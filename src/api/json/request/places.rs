//! Locations of the parts of the model in the JSON of a request.

use crate::api::problem::{self, Locator};
use crate::model::edit::EditRequest;
use crate::model::ends::{EndsForm, EndsInput};
use crate::model::errors::{ChangePart, SpecPart};
use crate::model::job::JobRequest;
use crate::model::method::{self, MethodForm, MethodInput};
use crate::model::named::Named;
use crate::model::per_direction::{PerDirection, direction};
use crate::model::scattered::SurfaceParameters;
use crate::model::shape::CurveInput;
use crate::model::surface::SurfaceInput;
use piad_fit::data::Grid;
use piad_fit::invalid::{Axis, Place as P};

const CURVE: &str = "/curve";
const SURFACE: &str = "/surface";

/// The parts of the request that have a value for each direction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Places {
    /// The object with the parts of the curve or surface; `None` for edits, which have them as
    /// fields.
    root: &'static str,
    /// The number of columns of a surface; `None` for a curve.
    columns: Option<usize>,
    /// True if there is a degree instead of a basis.
    degree_alone: bool,
    basis_each: bool,
    parameters_each: bool,
    closed_each: bool,
    weights_each: bool,
    ends_each: bool,
    /// The form of the ends of u and v.
    ends: [EndsForm; 2],
    /// True if the points are scattered.
    scattered: bool,
    /// True if the points are in sections.
    sections: bool,
    /// The form of the method.
    method: MethodForm,
}

impl Places {
    /// The locations of a job.
    pub(crate) fn of_job(request: &JobRequest) -> Self {
        let places = match (&request.curve, &request.surface) {
            (Some(curve), None) => Self::of_curve(curve),
            (None, Some(surface)) => Self::of_surface(surface),
            _ => Self::default(),
        };
        Self {
            method: method_form(request.method.as_ref()),
            ..places
        }
    }

    /// The locations of an edit, of a surface with points in this grid or of a curve.
    pub(crate) fn of_edit(request: &EditRequest, surface: Option<Grid>) -> Self {
        Self {
            columns: surface.and_then(columns),
            weights_each: true,
            method: method_form(request.method.as_ref()),
            ..Self::default()
        }
    }

    fn of_curve(curve: &CurveInput) -> Self {
        Self {
            root: CURVE,
            degree_alone: curve.degree.is_some(),
            ends: [ends_form(curve.ends.as_ref(), false), EndsForm::default()],
            ..Self::default()
        }
    }

    fn of_surface(surface: &SurfaceInput) -> Self {
        fn is_each<T>(value: &Option<PerDirection<T>>) -> bool {
            value.as_ref().is_some_and(PerDirection::is_each)
        }
        let (ends_u, ends_v) = match &surface.ends {
            None => (None, None),
            Some(PerDirection::Both(ends)) => (ends.0.as_ref(), ends.0.as_ref()),
            Some(PerDirection::Each { u, v }) => (u.0.as_ref(), v.0.as_ref()),
        };
        Self {
            root: SURFACE,
            columns: surface
                .points
                .as_ref()
                .and_then(|points| columns(points.grid)),
            degree_alone: surface.degree.is_some(),
            basis_each: is_each(&surface.basis) || is_each(&surface.degree),
            parameters_each: matches!(
                &surface.parameters,
                Some(SurfaceParameters::Grid(PerDirection::Each { .. }))
            ),
            scattered: surface.scattered.is_some() || surface.sections.is_some(),
            sections: surface.sections.is_some(),
            closed_each: is_each(&surface.closed),
            weights_each: is_each(&surface.weights),
            ends_each: is_each(&surface.ends),
            ends: [ends_u, ends_v].map(|ends| ends_form(ends, true)),
            method: MethodForm::default(),
        }
    }

    /// The locations of a stored job, for its bases only.
    pub(crate) fn of_input(surface: Option<Grid>, basis_each: bool) -> Self {
        Self {
            root: if surface.is_some() { SURFACE } else { CURVE },
            columns: surface.and_then(columns),
            basis_each,
            scattered: surface.is_some_and(|grid| !grid.is_rows()),
            ..Self::default()
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

    /// A part of the ends of a direction.
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

    /// The value of a setting of the method for a point.
    fn setting(&self, name: &str, index: usize) -> String {
        format!("/method/{name}/{}", self.index(index))
    }

    /// The location of a point in a list or a grid.
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
            P::Section(index) if self.sections => format!("{root}/sections/{index}"),
            P::Section(index) => format!("{root}/parameters/sections/{index}"),
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
            P::Triangle(index) => format!("{root}/parameters/triangles/{index}"),
            P::Parameters(axis) => self.parameters(axis),
            P::Parameter(axis, index) => format!("{}/{index}", self.parameters(axis)),
            P::Closed(axis) => self.part("closed", self.closed_each, axis),
            P::Order => format!("{root}/order"),
            P::RepeatedPoints => format!("{root}/repeated_points"),
            P::Polyline => format!("{root}/polyline"),
            P::Trim => format!("{root}/trim"),
            P::TrimDistance => format!("{root}/trim/distance"),
            P::Corners(axis) if root == SURFACE => self.part("creases", true, axis),
            P::Corners(_) => format!("{root}/corners"),
            P::Corner(axis, index) => format!("{}/{index}", self.pointer(P::Corners(axis))),
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

/// The columns of points that are in rows.
fn columns(grid: Grid) -> Option<usize> {
    grid.is_rows().then_some(grid.columns)
}

/// The form of the ends of a direction.
fn ends_form(ends: Option<&EndsInput>, surface: bool) -> EndsForm {
    ends.map(|ends| ends.form(surface)).unwrap_or_default()
}

fn method_form(method: Option<&MethodInput>) -> MethodForm {
    method.map(MethodInput::form).unwrap_or_default()
}

/// The pointer of a list, or of an element of it.
fn numbered(list: &str, index: Option<usize>) -> String {
    index.map_or_else(|| list.to_owned(), |index| format!("{list}/{index}"))
}

impl Locator for Places {
    fn of(&self, place: SpecPart) -> String {
        match place {
            SpecPart::Whole => String::new(),
            SpecPart::Name => "/name".to_owned(),
            SpecPart::Fit(place) => self.pointer(place),
            SpecPart::Rational => "/rational".to_owned(),
            SpecPart::MaxIterations => "/stop/max_iterations".to_owned(),
            SpecPart::Stream(choice, None) => format!("/stream/{}", choice.name()),
            SpecPart::Stream(choice, Some(index)) => format!("/stream/{}/{index}", choice.name()),
            SpecPart::Spacing(axis) => numbered("/surface/spacing", axis),
            SpecPart::Origin(axis) => numbered("/surface/origin", axis),
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
