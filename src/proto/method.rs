//! Methods and their settings in messages.

use super::least_squares;
use super::messages::{self as pb, method as m, method::Kind};
use super::values::{MethodTarget, check_count, chosen, some, value};
use crate::model::errors::{SpecPart, ValidationError};
use crate::model::method::{
    AdaptiveInput, ConvexInput, CustomInput, ExtendedInput, LocalInput, MethodInput, StartInput,
    SweepsInput, WeightedInput,
};
use crate::model::per_direction::PerDirection;
use crate::model::serde_helpers::AtMost;
use crate::model::settings::{self, Matrix, Thresholds};
use piad_fit::engine::Forecast;
use piad_fit::invalid::{Axis, Place, Setting};
use piad_fit::method::{
    Adaptive, Convex, Extended, LARGEST, Local, Method, Omega, Start, Sweeps, Threshold, Weighted,
};

const STARTS: [(StartInput, m::Start); 2] = [
    (StartInput(Start::Transformed), m::Start::Transformed),
    (StartInput(Start::Data), m::Start::Data),
];

const SWEEPS: [(SweepsInput, m::Sweeps); 2] = [
    (SweepsInput(Sweeps::Rows), m::Sweeps::Rows),
    (SweepsInput(Sweeps::Columns), m::Sweeps::Columns),
];

/// The method of a message.
pub(crate) fn input(
    method: Option<pb::Method>,
    target: MethodTarget,
) -> Result<Option<MethodInput>, ValidationError> {
    let Some(method) = method else {
        return Ok(None);
    };
    let Some(kind) = method.kind else {
        return Err(ValidationError::at_text("method", "it has no kind"));
    };
    Ok(Some(match kind {
        Kind::Global(_) => MethodInput::Global,
        Kind::Weighted(m::Weighted { omega }) => MethodInput::Weighted(WeightedInput {
            omega: omega.map(|omega| settings::Omega(Some(omega))),
        }),
        Kind::Local(it) => MethodInput::Local(local(it, target)?),
        Kind::Adaptive(it) => MethodInput::Adaptive(adaptive(it, target)?),
        Kind::Extended(extended) => MethodInput::Extended(ExtendedInput {
            start: chosen(&STARTS, extended.start, "method.extended.start")?,
            transformed_error: Some(extended.transformed_error),
        }),
        Kind::Transpose(_) => MethodInput::Transpose,
        Kind::Convex(m::Convex { step_tolerance }) => {
            MethodInput::Convex(ConvexInput { step_tolerance })
        }
        Kind::Chebyshev(_) => MethodInput::Chebyshev,
        Kind::Direct(_) => MethodInput::Direct,
        Kind::LeastSquares(it) => {
            MethodInput::LeastSquares(least_squares::input(it, target)?.into())
        }
        Kind::Custom(it) => MethodInput::Custom(custom(&it)?),
    }))
}

fn local(local: m::Local, target: MethodTarget) -> Result<LocalInput, ValidationError> {
    let field = "method.local.indices";
    check_count(local.indices.len(), target.most, "indices", field)?;
    let omega = match (local.omega, local.auto_omega) {
        (Some(_), true) => {
            let place = SpecPart::Fit(Place::Setting(Setting::Omega));
            return Err(ValidationError::at(
                place,
                "a number is given beside auto_omega",
            ));
        }
        (None, false) => None,
        (omega, _) => Some(settings::Omega(omega)),
    };
    let indices = some(local.indices);
    Ok(LocalInput {
        indices: indices.map(|it| it.into_iter().map(|index| target.index(index)).collect()),
        sweeps: chosen(&SWEEPS, local.sweeps, "method.local.sweeps")?,
        omega,
    })
}

/// One threshold, or one for each point.
fn adaptive(settings: m::Adaptive, target: MethodTarget) -> Result<AdaptiveInput, ValidationError> {
    let field = "method.adaptive.thresholds";
    let m::Adaptive {
        threshold,
        omega,
        thresholds,
    } = settings;
    check_count(thresholds.len(), target.most, "thresholds", field)?;
    if threshold != 0.0 && !thresholds.is_empty() {
        let detail = "one threshold is given for all points, and one for each";
        return Err(ValidationError::at_text(field, detail));
    }
    let each = target.numbers(thresholds).map(Thresholds::Each);
    Ok(AdaptiveInput {
        threshold: Some(each.unwrap_or(Thresholds::All(threshold))),
        omega: omega.map(|omega| settings::Omega(Some(omega))),
    })
}

/// The matrices of a transform.
fn custom(custom: &m::Custom) -> Result<CustomInput, ValidationError> {
    let u = matrix(&custom.transform_u, "method.custom.transform_u")?;
    let transform = match custom.transform_v.is_empty() {
        true => PerDirection::Both(u),
        false => PerDirection::Each {
            u,
            v: matrix(&custom.transform_v, "method.custom.transform_v")?,
        },
    };
    Ok(CustomInput {
        transform: Some(transform),
    })
}

/// The rows of a square matrix.
fn matrix(entries: &[f64], field: &str) -> Result<Matrix, ValidationError> {
    let count = entries.len();
    check_count(count, LARGEST * LARGEST, "entries", field)?;
    let rows = count.isqrt();
    if rows * rows != count || count == 0 {
        let detail = format!("{count} entries are no square matrix");
        return Err(ValidationError::at_text(field, detail));
    }
    let rows = entries.chunks_exact(rows).map(|row| AtMost(row.to_vec()));
    Ok(AtMost(rows.collect()))
}

/// The layout of the settings of a method.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SettingsLayout {
    /// The numbers of columns of the square matrices of a transform for u and v.
    columns: (usize, usize),
    /// The directions have numbers of control points each, or the points thresholds.
    each: bool,
    /// The name of the method.
    kind: &'static str,
}

impl SettingsLayout {
    /// The layout of a method.
    pub(crate) fn of(method: Option<&pb::Method>) -> Self {
        let mut layout = Self::default();
        let kind = method.and_then(|method| method.kind.as_ref());
        layout.kind = match kind {
            Some(Kind::Local(_)) => "local",
            Some(Kind::Adaptive(_)) => "adaptive",
            Some(Kind::Convex(_)) => "convex",
            _ => "weighted",
        };
        match kind {
            Some(Kind::Custom(custom)) => {
                let columns = |entries: &[f64]| entries.len().isqrt();
                layout.columns = (columns(&custom.transform_u), columns(&custom.transform_v));
            }
            Some(Kind::LeastSquares(settings)) => layout.each = settings.control_points_v != 0,
            Some(Kind::Adaptive(settings)) => layout.each = !settings.thresholds.is_empty(),
            _ => {}
        }
        layout
    }
}

/// The field of a setting or of a part of it; all other fields are those of the method.
pub(crate) fn field(place: Place, layout: SettingsLayout) -> String {
    let columns = layout.columns;
    let transform = |axis, first: Option<(usize, usize)>| {
        let (name, columns) = match axis {
            Axis::V if columns.1 > 0 => ("transform_v", columns.1),
            _ => ("transform_u", columns.0),
        };
        let entry = first.map(|(row, column)| format!("[{}]", row * columns + column));
        format!("method.custom.{name}{}", entry.unwrap_or_default())
    };
    match place {
        Place::Setting(Setting::Threshold) if layout.each => {
            "method.adaptive.thresholds".to_owned()
        }
        Place::DataWeight(index) => format!("method.least_squares.data_weights[{index}]"),
        Place::Constraint(index) => format!("method.least_squares.constraints[{index}]"),
        Place::Threshold(index) => format!("method.adaptive.thresholds[{index}]"),
        Place::Setting(setting) => {
            let kind = match setting {
                Setting::Omega | Setting::Threshold => layout.kind,
                Setting::StepTolerance => "convex",
                Setting::Mu
                | Setting::DataWeights
                | Setting::EndPoints
                | Setting::Constraints
                | Setting::Fairness
                | Setting::FairnessOrder
                | Setting::GapStiffness
                | Setting::Robust
                | Setting::Variant => "least_squares",
                Setting::CorrectParameters => "least_squares.automatic",
                Setting::Indices | Setting::Sweeps => "local",
            };
            format!("method.{kind}.{}", setting.name())
        }
        Place::Index(index) => format!("method.local.indices[{index}]"),
        Place::ControlPoints(Axis::V) if layout.each => {
            "method.least_squares.control_points_v".to_owned()
        }
        Place::ControlPoints(_) => "method.least_squares.control_points_u".to_owned(),
        Place::Transform(axis) => transform(axis, None),
        Place::TransformRow(axis, row) => transform(axis, Some((row, 0))),
        Place::TransformEntry(axis, row, column) => transform(axis, Some((row, column))),
        _ => "method".to_owned(),
    }
}

/// The method as requested, with its lists and the indices of the points that it selects.
pub(crate) fn requested(method: &Method, surface: bool, indices: Vec<u32>) -> pb::Method {
    let mut message = message(method, surface, None);
    match (&mut message.kind, method) {
        (Some(Kind::Local(local)), _) => local.indices = indices,
        (Some(Kind::Adaptive(message)), Method::Adaptive(adaptive)) => {
            if let Threshold::Each(each) = &adaptive.threshold {
                message.thresholds = each.to_vec();
            }
        }
        (Some(Kind::LeastSquares(message)), Method::LeastSquares(settings)) => {
            least_squares::lists(message, settings);
        }
        (Some(Kind::Custom(message)), Method::Custom(custom)) => {
            message.transform_u = custom.u().concat();
            message.transform_v = custom.v().map(<[Vec<f64>]>::concat).unwrap_or_default();
        }
        _ => {}
    }
    message
}

/// The method with its settings, and the ω that was computed for it; without the indices and thresholds
/// of points and the entries of matrices.
pub(crate) fn message(method: &Method, surface: bool, forecast: Option<Forecast>) -> pb::Method {
    let kind = match *method {
        Method::Global => Kind::Global(m::Global {}),
        Method::Weighted(Weighted { omega }) => Kind::Weighted(m::Weighted {
            omega: forecast.and_then(|it| it.omega).or(omega),
        }),
        Method::Local(settings) => Kind::Local(local_message(settings, forecast)),
        Method::Adaptive(Adaptive {
            ref threshold,
            omega,
        }) => Kind::Adaptive(m::Adaptive {
            threshold: match threshold {
                Threshold::All(threshold) => *threshold,
                Threshold::Each(_) => 0.0,
            },
            omega: (omega != 1.0).then_some(omega),
            thresholds: Vec::new(),
        }),
        Method::Extended(Extended {
            start,
            transformed_error,
        }) => Kind::Extended(m::Extended {
            start: value(&STARTS, Some(StartInput(start))).into(),
            transformed_error,
        }),
        Method::Transpose => Kind::Transpose(m::Transpose {}),
        Method::Convex(convex) => Kind::Convex(m::Convex {
            step_tolerance: (convex != Convex::default()).then_some(convex.step_tolerance),
        }),
        Method::Chebyshev => Kind::Chebyshev(m::Chebyshev {}),
        Method::Direct => Kind::Direct(m::Direct {}),
        Method::LeastSquares(ref settings) => {
            Kind::LeastSquares(least_squares::message(settings, surface))
        }
        Method::Custom(_) => Kind::Custom(m::Custom::default()),
    };
    pb::Method { kind: Some(kind) }
}

/// Without the indices of points.
fn local_message(settings: Local, forecast: Option<Forecast>) -> m::Local {
    let Local { omega, sweeps } = settings;
    let given = omega.other_than_one().and_then(Omega::given);
    let omega_used = forecast.and_then(|it| it.omega).or(given);
    m::Local {
        indices: Vec::new(),
        omega: omega_used,
        auto_omega: omega == Omega::Best && omega_used.is_none(),
        sweeps: value(&SWEEPS, sweeps.map(SweepsInput)).into(),
    }
}
