//! Single iterations, results, and the limits of local fits.

use super::{Content, OF_A_JOB};
use crate::api::openapi::operation::{Operation, Tag, json_of, message_of};
use crate::api::problem::Kind;
use crate::export::Format;
use serde_json::json;

/// A level as JSON, as a message or as a file.
fn level(schema: &str, message: &str) -> Vec<Content> {
    let files = Format::ALL.map(|format| {
        let schema = match format {
            Format::Step => {
                "ISO 10303-21 with the schema of AP214: the exact B-spline curve or surface."
            }
            Format::Iges => "IGES 5.3: entity 126 or 128, the exact B-spline curve or surface.",
            Format::Obj => {
                "Wavefront OBJ with free-form geometry: the exact B-spline curve or surface."
            }
            Format::Gltf => "glTF 2.0 as one binary file: a mesh with normals, or a line.",
            Format::Svg => {
                "A drawing with data points and control polygon, and how the error has fallen."
            }
            Format::Csv => "Samples with their parameters.",
        };
        let schema = json!({"description": schema, "contentMediaType": format.media_type()});
        (format.media_type(), json!({"schema": schema}))
    });
    let levels = [json_of(schema), message_of(message)];
    levels.into_iter().chain(files).collect()
}

/// `GET /v1/jobs/{id}/iterations/{k}`
pub fn iteration() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getIteration",
        "Show an iteration",
        "The curve or surface of any iteration that was reached, at any time. One that a running job has not reached yet is waited for. Parameters that do not belong to the format are answered with 400.",
    )
    .parameters(&["id", "k", "format", "view", "samples", "encoding", "digits"])
    .answer(
        200,
        "The iteration, in the format of the query or of the Accept header.",
        &level("Iteration", "Iteration"),
        &["Content-Disposition"],
    )
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoSuchIteration, Kind::NoExport])
}

/// `GET /v1/jobs/{id}/result`
pub fn result() -> Operation {
    Operation::new(
        Tag::Geometry,
        "getResult",
        "Show the result",
        "The final curve or surface, with all digits: digits=auto is answered with 400, as are parameters that do not belong to the format.",
    )
    .parameters(&["id", "format", "view", "samples", "encoding", "digits"])
    .answer(
        200,
        "The result, in the format of the query or of the Accept header.",
        &level("ResultAnswer", "FitResult"),
        &["Content-Disposition"],
    )
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoResult, Kind::NoExport])
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
    .json(200, "The difference vectors of the fixed points.", "Limit")
    .problems(&OF_A_JOB)
    .problems(&[Kind::NoLimit])
}
