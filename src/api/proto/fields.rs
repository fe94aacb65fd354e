//! Locations of the parts of the model in a message.

use crate::api::problem::{self, Locator, Problem};
use crate::model::errors::{ChangePart, SpecPart, ValidationError};
use crate::model::stream::choices::ChoiceError;
use crate::proto::ends::EndsLayout;
use crate::proto::messages::{self as pb, job_input::Geometry};
use crate::proto::{method, stream};
use piad_fit::invalid::{Axis, Place as P, Side};

/// The layout of the arrays of a message.
#[derive(Clone, Debug, Default)]
pub(crate) struct MessageLayout {
    /// The field with the parts of the curve or surface; `None` for edits.
    root: &'static str,
    /// The number of coordinates of a point.
    pub(super) dimension: usize,
    /// The number of columns of a surface.
    columns: usize,
    /// Edits: for each point that changes, its entry in `moved` and in `weighted`.
    pub(super) changes: Vec<(Option<usize>, Option<usize>)>,
    /// The points are scattered.
    scattered: bool,
    method: method::SettingsLayout,
    ends: EndsLayout,
}

impl MessageLayout {
    /// The layout of a job.
    pub(crate) fn of(input: &pb::JobInput) -> Self {
        let (root, dimension, columns) = match &input.geometry {
            None => ("", 1, 0),
            Some(Geometry::Curve(curve)) => (CURVE, curve.dimension, 0),
            Some(Geometry::Surface(it)) => (SURFACE, it.dimension, it.columns),
        };
        Self {
            root,
            dimension: dimension as usize,
            columns: columns as usize,
            scattered: matches!(
                &input.geometry,
                Some(Geometry::Surface(it)) if it.scattered.is_some()
            ),
            method: method::SettingsLayout::of(input.method.as_ref()),
            ends: EndsLayout::of(input),
            ..Self::default()
        }
    }

    /// The layout of a job, for the parts of the curve or surface only.
    pub(crate) fn of_shape(surface: bool) -> Self {
        Self {
            root: if surface { SURFACE } else { CURVE },
            ..Self::default()
        }
    }

    /// The layout of an edit.
    pub(super) fn of_edit(method: Option<&pb::Method>) -> Self {
        Self {
            method: method::SettingsLayout::of(method),
            ..Self::default()
        }
    }

    /// A part of a direction, which surfaces have two of.
    fn direction(&self, axis: Axis, part: &str) -> String {
        let axis = match (self.root, axis) {
            (SURFACE, Axis::U) => "u.",
            (SURFACE, Axis::V) => "v.",
            _ => "",
        };
        format!("{}.{axis}{part}", self.root)
    }

    /// The first number of a point.
    fn point(&self, index: usize) -> String {
        format!("{}.points[{}]", self.root, index * self.dimension)
    }

    /// The vectors of an end.
    fn end(&self, axis: Axis, side: Side, order: usize, index: Option<usize>) -> String {
        let number = usize::from(axis == Axis::V);
        let field = self.ends.field(number, side, order, index);
        self.direction(axis, &format!("ends.{}.{field}", side.name()))
    }

    /// The field of a part of the fitting problem.
    fn field(&self, place: P) -> String {
        let root = self.root;
        let is_edit = root.is_empty();
        match place {
            P::Points => format!("{root}.points"),
            P::Point(index) | P::Line(Axis::V, index) => self.point(index),
            P::Line(Axis::U, index) => self.point(index * self.columns.max(1)),
            P::Section(index) => format!("{root}.scattered.sections[{index}]"),
            P::Basis(axis) => self.direction(axis, "basis"),
            P::Degree(axis) => self.direction(axis, "basis.degree"),
            P::Knots(axis) => self.direction(axis, "basis.knots"),
            P::Knot(axis, index) => self.direction(axis, &format!("basis.knots[{index}]")),
            P::Parameters(_) if self.scattered => format!("{root}.scattered"),
            P::Parameter(axis, index) if self.scattered => {
                let number = 2 * index + usize::from(axis == Axis::V);
                format!("{root}.scattered.values[{number}]")
            }
            P::Triangle(index) => format!("{root}.scattered.triangles[{}]", 3 * index),
            P::Parameters(axis) => self.direction(axis, "parameters"),
            P::Parameter(axis, index) => {
                self.direction(axis, &format!("parameters.values[{index}]"))
            }
            P::Closed(axis) => self.direction(axis, "closed"),
            P::Order => format!("{root}.unordered"),
            P::RepeatedPoints => format!("{root}.merge_repeated"),
            P::Polyline => format!("{root}.polyline"),
            P::Trim => format!("{root}.trim"),
            P::TrimDistance => format!("{root}.trim.distance"),
            P::Corners(axis) if root == SURFACE => self.direction(axis, "creases"),
            P::Corner(axis, index) if root == SURFACE => {
                self.direction(axis, &format!("creases[{index}]"))
            }
            P::Corners(axis) => self.direction(axis, "corners"),
            P::Corner(axis, index) => self.direction(axis, &format!("corners.at.indices[{index}]")),
            P::Ends(axis) => self.direction(axis, "ends"),
            P::End(axis, side) => self.direction(axis, &format!("ends.{}", side.name())),
            P::EndOrder(axis, side, order) => self.end(axis, side, order, None),
            P::EndVector(axis, side, order, index) => self.end(axis, side, order, Some(index)),
            P::Weights if is_edit => "weights.values".to_owned(),
            P::Weights => format!("{root}.weights"),
            P::Weight(index) if is_edit => format!("weights.values[{index}]"),
            P::Weight(index) => format!("{root}.weights[{index}]"),
            P::AxisWeights(axis) if is_edit => format!("weights.{}", name(axis)),
            P::AxisWeights(axis) => self.direction(axis, "weights"),
            P::AxisWeight(axis, index) => {
                format!("{}[{index}]", self.field(P::AxisWeights(axis)))
            }
            P::Tolerance => "stop.tolerance".to_owned(),
            P::RelativeTolerance => "stop.relative_tolerance".to_owned(),
            place => method::field(place, self.method),
        }
    }

    /// A point that an edit changes.
    fn change(&self, k: usize, part: ChangePart) -> String {
        let (moved, weighted) = self.changes.get(k).copied().unwrap_or_default();
        match (part, moved, weighted) {
            (ChangePart::Weight, _, Some(k)) => format!("point_weights[{k}]"),
            (ChangePart::Index, Some(k), _) => format!("moved[{k}]"),
            (_, Some(k), _) => format!("points[{}]", k * self.dimension),
            (_, None, Some(k)) => format!("weighted[{k}]"),
            (_, None, None) => "points".to_owned(),
        }
    }
}

impl Locator for MessageLayout {
    fn of(&self, place: SpecPart) -> String {
        match place {
            SpecPart::Whole => String::new(),
            SpecPart::Name => "name".to_owned(),
            SpecPart::Fit(place) => self.field(place),
            SpecPart::Rational => "rational".to_owned(),
            SpecPart::MaxIterations => "stop.max_iterations".to_owned(),
            SpecPart::Stream(choice, None) => format!("stream.{}", stream::field(choice)),
            SpecPart::Stream(choice, Some(index)) => {
                format!("stream.{}[{index}]", stream::field(choice))
            }
            SpecPart::Spacing(None) | SpecPart::Origin(None) => "surface.placement".to_owned(),
            SpecPart::Spacing(Some(axis)) => format!("surface.placement.d{}", coordinate(axis)),
            SpecPart::Origin(Some(axis)) => format!("surface.placement.{}", coordinate(axis)),
            SpecPart::FootPoints => "surface.scattered.foot_points.job".to_owned(),
            SpecPart::FootPointsIteration => "surface.scattered.foot_points.iteration".to_owned(),
            SpecPart::Iteration => "iteration".to_owned(),
            SpecPart::Ephemeral => "ephemeral".to_owned(),
            SpecPart::Session => "session".to_owned(),
            SpecPart::Change(k, part) => self.change(k, part),
        }
    }

    fn place(&self, text: String) -> problem::Location {
        problem::Location::Field(text)
    }
}

/// An error of a request.
pub(crate) fn wrong(error: ValidationError) -> Problem {
    Problem::of_errors(error.into(), &MessageLayout::default())
}

/// An error of a choice, which is a field of the message `within`.
pub(crate) fn wrong_choice(error: ChoiceError, within: &str) -> Problem {
    match error.by_request() {
        Some((choice, detail)) => {
            Problem::at_field(format!("{within}{}", stream::field(choice)), detail)
        }
        None => error.into(),
    }
}

fn coordinate(axis: usize) -> &'static str {
    match axis {
        0 => "x",
        _ => "y",
    }
}

const CURVE: &str = "curve";
const SURFACE: &str = "surface";

fn name(axis: Axis) -> &'static str {
    match axis {
        Axis::U => "u",
        Axis::V => "v",
    }
}
