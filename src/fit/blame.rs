//! Which part of a problem each mistake is about.

use super::invalid::{Axis, Invalid as I, Place, Setting};

impl I {
    /// The part of the problem that is wrong.
    pub fn place(&self) -> Place {
        match *self {
            I::TooFewPoints { .. } | I::TooLarge | I::NoPoints => Place::Points,
            I::MissingPoint { index } | I::NotFinite { index, .. } => Place::Point(index),
            I::NoNeighbours { axis, index, .. }
            | I::EqualPoints { axis, index, .. }
            | I::EqualLines { axis, index, .. }
            | I::FirstRepeated { axis, index } => Place::Line(axis, index),
            I::ParameterCount { axis, .. }
            | I::ParameterRange { axis }
            | I::ClosedParameterCount { axis, .. } => Place::Parameters(axis),
            I::Several { ref first, .. } => first.place(),
            I::Scattered(ref mistake) => mistake.place(),
            I::ParameterOrder { axis, index, .. }
            | I::ParameterNotFinite { axis, index, .. }
            | I::ParameterOutside { axis, index, .. } => Place::Parameter(axis, index),
            I::DegreeAboveLimit { axis, chosen, .. } if !chosen => Place::Basis(axis),
            I::DegreeTooLow { axis, .. }
            | I::DegreeTooHigh { axis, .. }
            | I::DegreeAboveLimit { axis, .. }
            | I::ClosedDegree { axis, .. } => Place::Degree(axis),
            I::KnotRange { axis }
            | I::LeastSquaresKnots { axis }
            | I::SpreadKnots { axis }
            | I::KnotCount { axis, .. }
            | I::SchoenbergWhitney { axis, .. }
            | I::ClosedKnots { axis } => Place::Knots(axis),
            I::KnotOrder { axis, index, .. }
            | I::KnotNotFinite { axis, index, .. }
            | I::KnotsNotClamped { axis, index, .. }
            | I::KnotMultiplicity { axis, index, .. } => Place::Knot(axis, index),
            I::TooFewControlPoints { axis, .. } | I::ControlPointCount { axis, .. } => {
                Place::ControlPoints(axis)
            }
            I::Ends(ref mistake) => mistake.place(),
            I::LeastSquares(ref mistake) => mistake.place(),
            I::Constraints(ref mistake) => mistake.place(),
            I::ClosedPolynomial { axis } => Place::Closed(axis),
            I::WeightCount { .. } | I::NotSeparable | I::WeightsTooLarge => Place::Weights,
            I::Weight { index, .. } | I::WeightTooSmall { index, .. } => Place::Weight(index),
            I::AxisWeight { axis, index, .. } => Place::AxisWeight(axis, index),
            I::AxisWeightCount { axis, .. } => Place::AxisWeights(axis),
            _ => self.place_of_method(),
        }
    }

    /// The setting of the method or the stop rule that is wrong.
    fn place_of_method(&self) -> Place {
        match *self {
            I::Omega { .. } => Place::Setting(Setting::Omega),
            I::NotPositive { setting, .. } => Place::Setting(setting),
            I::ThresholdCount { .. } => Place::Setting(Setting::Threshold),
            I::PartOfStep { .. } => Place::Setting(Setting::StepTolerance),
            I::Threshold { index, .. } => Place::Threshold(index),
            I::NoIndices => Place::Setting(Setting::Indices),
            I::IndexOutside { index, .. } | I::IndexRepeated { index } => Place::Index(index),
            I::SweepsOfCurve { setting } => Place::Setting(setting),
            I::TransformTooLarge { axis, .. } | I::TransformRows { axis, .. } => {
                Place::Transform(axis)
            }
            I::TransformColumns { axis, row, .. } => Place::TransformRow(axis, row),
            I::TransformEntry {
                axis, row, column, ..
            } => Place::TransformEntry(axis, row, column),
            I::TransformOfCurve => Place::Transform(Axis::V),
            I::Tolerance { relative, .. } if !relative => Place::Tolerance,
            I::Tolerance { .. } | I::ToleranceTooLarge { .. } => Place::RelativeTolerance,
            // The method itself does not suit the problem.
            _ => Place::Method,
        }
    }
}
