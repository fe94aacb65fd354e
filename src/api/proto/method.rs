//! Methods and their settings in messages.

use super::bounds::check_count;
use super::messages::{self as pb, method::Kind};
use super::names::{count, known, some};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::values::{Count, Number};
use crate::api::json::request::method::{
    Kind as MethodKind, MethodRequest, StartRequest, VariantRequest,
};
use crate::api::json::request::settings::{Index, Matrix, Omega};
use crate::api::problem::Problem;
use crate::fit::method::{
    Adaptive, Extended, LARGEST, LeastSquares, Local, Method, Start, Variant, Weighted,
};
use crate::fit::system::Forecast;

/// The method that a message asks for.
pub(in crate::api) fn request(
    method: Option<pb::Method>,
    most_points: usize,
) -> Result<Option<MethodRequest>, Problem> {
    let Some(method) = method else {
        return Ok(None);
    };
    let Some(kind) = method.kind else {
        return Err(Problem::at_field("method", "it has no kind"));
    };
    if let Kind::Local(local) = &kind {
        let field = "method.local.indices";
        check_count(local.indices.len(), most_points, "indices", field)?;
    }
    let request = match kind {
        Kind::Global(_) => MethodRequest::of(MethodKind::Global),
        Kind::Weighted(weighted) => MethodRequest {
            omega: weighted.omega.map(Omega::Given),
            ..MethodRequest::of(MethodKind::Weighted)
        },
        Kind::Local(local) => MethodRequest {
            indices: some(local.indices).map(|indices| {
                let indices = indices.into_iter();
                indices.map(|index| Index::Flat(index as usize)).collect()
            }),
            row_by_row: Some(local.row_by_row),
            ..MethodRequest::of(MethodKind::Local)
        },
        Kind::Adaptive(adaptive) => MethodRequest {
            threshold: Some(Number(adaptive.threshold)),
            ..MethodRequest::of(MethodKind::Adaptive)
        },
        Kind::Extended(extended) => MethodRequest {
            start: match known(extended.start, "method.extended.start")? {
                pb::method::Start::Unspecified => None,
                pb::method::Start::Transformed => Some(StartRequest::Transformed),
                pb::method::Start::Data => Some(StartRequest::Data),
            },
            ..MethodRequest::of(MethodKind::Extended)
        },
        Kind::Transpose(_) => MethodRequest::of(MethodKind::Transpose),
        Kind::Convex(_) => MethodRequest::of(MethodKind::Convex),
        Kind::Chebyshev(_) => MethodRequest::of(MethodKind::Chebyshev),
        Kind::Direct(_) => MethodRequest::of(MethodKind::Direct),
        Kind::LeastSquares(settings) => {
            least_squares_request(settings, MethodRequest::of(MethodKind::LeastSquares))?
        }
        Kind::Custom(custom) => MethodRequest {
            transform: Some(transform(&custom)?),
            ..MethodRequest::of(MethodKind::Custom)
        },
    };
    Ok(Some(request))
}

fn least_squares_request(
    settings: pb::method::LeastSquares,
    plain: MethodRequest,
) -> Result<MethodRequest, Problem> {
    let (u, v) = (settings.control_points_u, settings.control_points_v);
    let control_points = match v {
        0 => PerDirection::Both(Count(u as usize)),
        v => PerDirection::Each {
            u: Count(u as usize),
            v: Count(v as usize),
        },
    };
    Ok(MethodRequest {
        control_points: Some(control_points),
        variant: match known(settings.variant, "method.least_squares.variant")? {
            pb::method::Variant::Unspecified => None,
            pb::method::Variant::Diagonal => Some(VariantRequest::Diagonal),
            pb::method::Variant::Lspia => Some(VariantRequest::Lspia),
            pb::method::Variant::Cg => Some(VariantRequest::Cg),
        },
        mu: settings.mu.map(Number),
        ..plain
    })
}

/// The matrices of a transform.
fn transform(custom: &pb::method::Custom) -> Result<PerDirection<Matrix>, Problem> {
    let u = matrix(&custom.transform_u, "method.custom.transform_u")?;
    if custom.transform_v.is_empty() {
        return Ok(PerDirection::Both(u));
    }
    let v = matrix(&custom.transform_v, "method.custom.transform_v")?;
    Ok(PerDirection::Each { u, v })
}

/// The rows of a square matrix.
fn matrix(entries: &[f64], field: &str) -> Result<Matrix, Problem> {
    let count = entries.len();
    check_count(count, LARGEST * LARGEST, "entries", field)?;
    let rows = count.isqrt();
    if rows * rows != count || count == 0 {
        let detail = format!("{count} entries are no square matrix");
        return Err(Problem::at_field(field, detail));
    }
    let rows = entries.chunks_exact(rows).map(<[f64]>::to_vec);
    Ok(Matrix(rows.collect()))
}

/// The method as it was asked for.
pub fn asked(method: &Method, indices: Vec<u32>) -> pb::Method {
    match method {
        Method::Custom(custom) => {
            let custom = pb::method::Custom {
                transform_u: custom.u().concat(),
                transform_v: custom.v().map(<[Vec<f64>]>::concat).unwrap_or_default(),
            };
            pb::Method {
                kind: Some(Kind::Custom(custom)),
            }
        }
        method => message(method, indices, None),
    }
}

/// The method with its settings, and the ω that was computed for it.
pub fn message(method: &Method, indices: Vec<u32>, forecast: Option<Forecast>) -> pb::Method {
    use pb::method as m;
    let kind = match *method {
        Method::Global => Kind::Global(m::Global {}),
        Method::Weighted(Weighted { omega }) => Kind::Weighted(m::Weighted {
            omega: forecast.and_then(|it| it.omega).or(omega),
        }),
        Method::Local(Local { row_by_row }) => Kind::Local(m::Local {
            indices,
            row_by_row,
        }),
        Method::Adaptive(Adaptive { threshold }) => Kind::Adaptive(m::Adaptive { threshold }),
        Method::Extended(Extended { start }) => Kind::Extended(m::Extended {
            start: match start {
                Start::Transformed => m::Start::Transformed,
                Start::Data => m::Start::Data,
            }
            .into(),
        }),
        Method::Transpose => Kind::Transpose(m::Transpose {}),
        Method::Convex => Kind::Convex(m::Convex {}),
        Method::Chebyshev => Kind::Chebyshev(m::Chebyshev {}),
        Method::Direct => Kind::Direct(m::Direct {}),
        Method::LeastSquares(settings) => Kind::LeastSquares(least_squares(settings)),
        Method::Custom(_) => Kind::Custom(m::Custom::default()),
    };
    pb::Method { kind: Some(kind) }
}

fn least_squares(settings: LeastSquares) -> pb::method::LeastSquares {
    use pb::method::Variant as V;
    let (variant, mu) = match settings.variant {
        Variant::Diagonal => (V::Diagonal, None),
        Variant::Lspia { mu } => (V::Lspia, mu),
        Variant::ConjugateGradients => (V::Cg, None),
    };
    pb::method::LeastSquares {
        control_points_u: count(settings.u),
        control_points_v: count(settings.v),
        variant: variant.into(),
        mu,
    }
}
