//! Single iterations, results, and the limits of local fits.

use super::{Content, OF_A_JOB};
use crate::api::json::view::deviation::DeviationView;
use crate::api::json::view::level::IterationEvent;
use crate::api::json::view::limit::LimitView;
use crate::api::json::view::result::FitResult;
use crate::api::openapi::operation::{Operation, Tag, json_of};
use crate::api::problem::Kind;
use crate::export::Format;
use serde_json::json;

/// The headers of answers that are kept in files.
pub(super) const NAMED: &[&str] = &["Content-Disposition"];

/// Those of answers that are waited for.
const WAITED: &[&str] = &["Content-Disposition", "Preference-Applied"];

/// The files of a level. For generated clients all of them are bytes.
fn files() -> [Content; Format::ALL.len()] {
    Format::ALL.map(|format| {
        let description = match format {
            Format::Step => {
                "ISO 10303-21 with the schema of AP214: the exact B-spline curve or surface."
            }
            Format::Iges => "IGES 5.3: entity 126 or 128, the exact B-spline curve or surface.",
            Format::Obj => {
                "Wavefront OBJ with free-form geometry: the exact B-spline curve or surface."
            }
            Format::Gltf => "glTF 2.0 as one binary file: a mesh with normals, or a line.",
            Format::Stl => "STL in its binary form: the triangles of a surface; curves have none (409).",
            Format::Dxf => "DXF of AutoCAD R12: a polyline of a curve, a polygon mesh of a surface.",
            Format::Svg => {
                "A drawing with control polygon and data points, in the colours of their distance, and how the error has fallen."
            }
            Format::Csv => "Samples with their parameters.",
        };
        let schema = json!({"type": "string", "format": "binary", "description": description});
        (format.media_type(), json!({"schema": schema}))
    })
}

/// `GET /v1/jobs/{id}/iterations/{k}`
pub fn iteration() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getIteration",
        "Show an iteration",
        "The curve or surface of any iteration that was reached, at any time. One that a running job has not reached yet is waited for: as long as `Prefer: wait` says, or 10 seconds; then 503 tells how far the job is. With `?format=` or an Accept header also as a file.",
    )
    .parameters(&["id", "k", "view", "samples", "encoding", "digits", "Prefer"])
    .answer(200, "The iteration.", &[json_of::<IterationEvent>()], WAITED)
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoSuchIteration,
        Kind::NoExport,
        Kind::NotReached,
        Kind::Stopping,
    ])
}

/// `GET /v1/jobs/{id}/iterations/{k}/{format}`
pub fn iteration_file() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getIterationFile",
        "Show an iteration as a file",
        "The curve or surface of an iteration in a file format.",
    )
    .parameters(&["id", "k", "format", "samples", "dots", "units", "Prefer"])
    .answer(200, "The file.", &files(), WAITED)
    .problems(&OF_A_JOB)
    .problems(&[
        Kind::NoSuchIteration,
        Kind::NoExport,
        Kind::NotReached,
        Kind::Stopping,
    ])
}

/// `GET /v1/jobs/{id}/result`
pub fn result() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getResult",
        "Show the result",
        "The final curve or surface, with all digits. With `?format=` or an Accept header also as a file. Other views of it are those of the iteration `last`.",
    )
    .parameters(&["id", "encoding"])
    .answer(200, "The result.", &[json_of::<FitResult<'_>>()], NAMED)
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoResult, Kind::NoExport])
}

/// `GET /v1/jobs/{id}/result/{format}`
pub fn result_file() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getResultFile",
        "Show the result as a file",
        "The final curve or surface in a file format.",
    )
    .parameters(&["id", "format", "samples", "dots", "units"])
    .answer(200, "The file.", &files(), NAMED)
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoResult, Kind::NoExport])
}

/// `GET /v1/jobs/{id}/deviation`
pub fn deviation() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getDeviation",
        "Measure how far the data are",
        "Distances of the data from the nearest points of the curve or surface (foot points), of the last iteration so far or of any other. The errors of iterations are distances at the parameters of the data, which are larger.",
    )
    .parameters(&["id", "iteration", "list"])
    .json::<DeviationView>(200, "The distances.")
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoSuchIteration, Kind::NoDeviation])
}

/// `GET /v1/jobs/{id}/limit`
pub fn limit() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getLimit",
        "Show where fixed points end",
        "Local fits adjust some points. In the limit the curve or surface passes the others at a distance, which is known in closed form.",
    )
    .parameters(&["id"])
    .json::<LimitView>(200, "The difference vectors of the fixed points.")
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoLimit])
}
