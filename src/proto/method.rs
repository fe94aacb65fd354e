//! Methods and their settings in messages.

use super::least_squares;
use super::messages::{self as pb, method as m, method::Kind};
use super::values::{MethodTarget, check_count, known, some};
use crate::fit::invalid::{Axis, Place, Setting};
use crate::fit::method::{
    Adaptive, Convex, Custom, Extended, LARGEST, Local, Method, Omega, Start, Sweeps, Threshold,
    Weighted,
};
use crate::fit::system::Forecast;
use crate::model::method::{MethodSpec, sweeps};
use crate::model::mistakes::{self as model, Mistake, OrMistakes};

/// The method that a message asks for.
pub fn spec(method: Option<pb::Method>, scope: MethodTarget) -> OrMistakes<Option<MethodSpec>> {
    let Some(method) = method else {
        return Ok(None);
    };
    let Some(kind) = method.kind else {
        return Err(Mistake::at_text("method", "it has no kind").into());
    };
    let method = match kind {
        Kind::Global(_) => Method::Global,
        Kind::Weighted(m::Weighted { omega }) => Method::Weighted(Weighted { omega }),
        Kind::Local(local) => return self::local(local, scope).map(Some),
        Kind::Adaptive(settings) => Method::Adaptive(adaptive(settings, scope)?),
        Kind::Extended(extended) => Method::Extended(Extended {
            start: match known(extended.start, "method.extended.start")? {
                m::Start::Unspecified | m::Start::Transformed => Start::Transformed,
                m::Start::Data => Start::Data,
            },
            transformed_error: extended.transformed_error,
        }),
        Kind::Transpose(_) => Method::Transpose,
        Kind::Convex(m::Convex { step_tolerance }) => {
            let convex = step_tolerance.map(|step_tolerance| Convex { step_tolerance });
            Method::Convex(convex.unwrap_or_default())
        }
        Kind::Chebyshev(_) => Method::Chebyshev,
        Kind::Direct(_) => Method::Direct,
        Kind::LeastSquares(settings) => Method::LeastSquares(least_squares::spec(settings, scope)?),
        Kind::Custom(custom) => Method::Custom(self::custom(&custom)?),
    };
    Ok(Some(method.into()))
}

fn local(local: m::Local, scope: MethodTarget) -> OrMistakes<MethodSpec> {
    let (field, points) = ("method.local.indices", scope.points);
    check_count(local.indices.len(), scope.most, "indices", field)?;
    let outside = |index: &u32| *index as usize >= points;
    if let Some(k) = local.indices.iter().position(outside) {
        let detail = format!("{} is not one of the {points} points", local.indices[k]);
        return Err(Mistake::at(model::SpecPart::Fit(Place::Index(k)), detail).into());
    }
    let method = local_settings(&local, scope.surface)?;
    let indices = some(local.indices);
    let selected = indices.map(|indices| indices.into_iter().map(|it| it as usize).collect());
    MethodSpec::local(selected, method)
}

/// The settings of a local fit besides its points.
fn local_settings(local: &m::Local, surface: bool) -> Result<Local, Mistake> {
    if local.omega.is_some() && local.auto_omega {
        let place = model::SpecPart::Fit(Place::Setting(Setting::Omega));
        return Err(Mistake::at(place, "a number is given beside auto_omega"));
    }
    let lines = match known(local.sweeps, "method.local.sweeps")? {
        m::Sweeps::Unspecified => None,
        m::Sweeps::Rows => Some(Sweeps::Rows),
        m::Sweeps::Columns => Some(Sweeps::Columns),
    };
    let given = local.omega.map_or_else(Omega::default, Omega::Given);
    Ok(Local {
        omega: if local.auto_omega { Omega::Best } else { given },
        sweeps: sweeps(lines, surface)?,
    })
}

/// One threshold, or one for each point.
fn adaptive(settings: m::Adaptive, scope: MethodTarget) -> OrMistakes<Adaptive> {
    let field = "method.adaptive.thresholds";
    let m::Adaptive {
        threshold,
        omega,
        thresholds,
    } = settings;
    check_count(thresholds.len(), scope.most, "thresholds", field)?;
    if threshold != 0.0 && !thresholds.is_empty() {
        let detail = "one threshold is given for all points, and one for each";
        return Err(Mistake::at_text(field, detail).into());
    }
    Ok(Adaptive {
        threshold: match thresholds.is_empty() {
            true => Threshold::All(threshold),
            false => Threshold::Each(thresholds.into()),
        },
        omega: omega.unwrap_or(1.0),
    })
}

/// The method as outlines of jobs have it, of its message without the indices and thresholds of points
/// and the entries of matrices.
pub fn outline(method: Option<pb::Method>, surface: bool) -> OrMistakes<Method> {
    match method.as_ref().and_then(|method| method.kind.as_ref()) {
        Some(Kind::Local(local)) => Ok(Method::Local(local_settings(local, surface)?)),
        Some(Kind::Custom(_)) => Ok(Method::Custom(Custom::new(Vec::new(), None))),
        Some(Kind::Adaptive(adaptive)) if adaptive.threshold == 0.0 => {
            Ok(Method::Adaptive(Adaptive {
                threshold: Threshold::Each([].into()),
                omega: adaptive.omega.unwrap_or(1.0),
            }))
        }
        _ => {
            let target = MethodTarget {
                points: usize::MAX,
                surface,
                most: usize::MAX,
            };
            let spec = spec(method, target)?;
            Ok(spec.map_or(Method::Global, |spec| spec.method))
        }
    }
}

/// The matrices of a transform.
fn custom(custom: &m::Custom) -> OrMistakes<Custom> {
    let u = matrix(&custom.transform_u, "method.custom.transform_u")?;
    let v = some(custom.transform_v.clone());
    let v = v.map(|entries| matrix(&entries, "method.custom.transform_v"));
    Ok(Custom::new(u, v.transpose()?))
}

/// The rows of a square matrix.
fn matrix(entries: &[f64], field: &str) -> Result<Vec<Vec<f64>>, Mistake> {
    let count = entries.len();
    check_count(count, LARGEST * LARGEST, "entries", field)?;
    let rows = count.isqrt();
    if rows * rows != count || count == 0 {
        let detail = format!("{count} entries are no square matrix");
        return Err(Mistake::at_text(field, detail));
    }
    Ok(entries.chunks_exact(rows).map(<[f64]>::to_vec).collect())
}

/// How the settings of a method are laid out.
#[derive(Clone, Copy, Debug, Default)]
pub struct SettingsLayout {
    /// The numbers of columns of the square matrices of a transform for u and v.
    columns: (usize, usize),
    /// The directions have numbers of control points each, or the points thresholds.
    each: bool,
    /// The name of the method.
    kind: &'static str,
}

impl SettingsLayout {
    /// The layout of a method.
    pub fn of(method: Option<&pb::Method>) -> Self {
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

/// The field of a setting, or of a part of it; everything else is the method.
pub fn field(place: Place, layout: SettingsLayout) -> String {
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

/// The method as it was asked for, with its lists and the indices of the points that it selects.
pub fn asked(method: &Method, surface: bool, indices: Vec<u32>) -> pb::Method {
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
pub fn message(method: &Method, surface: bool, forecast: Option<Forecast>) -> pb::Method {
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
            start: match start {
                Start::Transformed => m::Start::Transformed,
                Start::Data => m::Start::Data,
            }
            .into(),
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
        sweeps: match sweeps {
            None => m::Sweeps::Unspecified,
            Some(Sweeps::Rows) => m::Sweeps::Rows,
            Some(Sweeps::Columns) => m::Sweeps::Columns,
        }
        .into(),
    }
}
