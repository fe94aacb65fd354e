//! The schema of the parameters of a surface.

use schemars::{Schema, json_schema};
use serde_json::Value;

use super::domains::Domains;
use super::projection::ProjectionSurface;
use super::{FootPoints, MeshUnfoldingInput, SurfaceParameters};
use crate::model::basis::ParametersInput;
use crate::model::named::Named;
use crate::model::per_direction::PerDirection;
use crate::model::schema::schema_of;
use piad_fit::parameters::MAX_TRIANGLES;

schema_of!(SurfaceParameters, "SurfaceParameters", generator => {
    let of_grid: Schema = PerDirection::<ParametersInput>::json_schema(generator);
    let mut choices = match of_grid.get("oneOf") {
        Some(Value::Array(choices)) => choices.clone(),
        _ => vec![of_grid.to_value()],
    };
    let mut base = generator.subschema_for::<FootPoints>();
    base.insert("description".to_owned(), "The other job.".into());
    let mut domains = generator.subschema_for::<Domains>();
    domains.insert("description".to_owned(), "How far they go where that is not from the least to the largest parameter.".into());
    let scattered = [
        json_schema!({
            "title": "Pairs",
            "description": "Of scattered points: u and v of each.",
            "type": "array",
            "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            "minItems": 2,
        }),
        json_schema!({
            "description": "Of scattered points: their places on a plane, a cylinder or a sphere near them, whichever unfolds them best; so it is where no parameters are given. The notices of the job have the choice.",
            "type": "string",
            "const": "auto",
        }),
        json_schema!({
            "description": "Of scattered points: their coordinates in the plane that lies nearest to them, along the sides of the least rectangle around them.",
            "type": "string",
            "const": "project",
        }),
        json_schema!({
            "title": "Projection",
            "description": "Of scattered points: `plane` is the same; of `cylinder` u goes around the cylinder nearest to them, and v along it; of `sphere` u is the longitude and v the latitude on the sphere nearest to them, both as lengths; `xy`, `xz` and `yz` are two of their coordinates. Where the points go all around, u is closed; where they come to a pole of the sphere, all control points there are one.",
            "type": "object",
            "properties": {
                "project": {"type": "string", "enum": ProjectionSurface::names(), "description": "The surface.", "examples": ["cylinder"]},
                "axis": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "description": "The direction of the axis of a cylinder, or of a pole of a sphere.", "examples": [[0, 0, 1]]},
                "center": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "description": "A point on the axis of a cylinder, or the centre of a sphere.", "examples": [[0, 0, 0]]},
            },
            "required": ["project"],
            "additionalProperties": false,
            "examples": [{"project": "xy"}, {"project": "cylinder", "axis": [0, 0, 1]}],
        }),
        json_schema!({
            "title": "PairsAndDomains",
            "description": "Of scattered points: u and v of each, and how far the directions go.",
            "type": "object",
            "properties": {
                "pairs": {
                    "type": "array",
                    "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
                    "minItems": 2,
                    "description": "u and v of each point.",
                },
                "domains": domains,
            },
            "required": ["pairs"],
            "additionalProperties": false,
        }),
        json_schema!({
            "title": "SectionCounts",
            "description": "Of scattered points that are sections, one after the other: the number of points of each.",
            "type": "object",
            "properties": {
                "sections": {
                    "type": "array",
                    "items": {"type": "integer", "minimum": 2},
                    "minItems": 2,
                    "description": "The number of points of each section.",
                    "examples": [[24, 40, 31]],
                },
            },
            "required": ["sections"],
            "additionalProperties": false,
        }),
        json_schema!({
            "title": "MeshParameters",
            "description": "Of scattered points that are the vertices of a mesh, one piece without handles: the triangles between them. Where a plane, a cylinder or a sphere unfolds all triangles, the parameters are the places on it; else mean value coordinates (Floater 2003). A mesh with one boundary loop fills a rectangle, if its boundary is smooth between the corners; one with two loops is closed in u; a closed one is unrolled by a sphere. Loops shorter than a quarter of the longest one are holes. The notices of the job have the choice, and the triangles that are turned over.",
            "type": "object",
            "properties": {
                "triangles": {
                    "type": "array",
                    "items": {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 3, "maxItems": 3},
                    "minItems": 1,
                    "maxItems": MAX_TRIANGLES,
                    "description": "The indices of the corners of each triangle, from 0, in either sense.",
                    "examples": [[[0, 1, 2], [2, 1, 3]]],
                },
                "unfolding": {"type": "string", "enum": MeshUnfoldingInput::names(), "default": "auto", "description": "`mean_value`: no plane, cylinder or sphere is tried.", "examples": ["mean_value"]},
            },
            "required": ["triangles"],
            "additionalProperties": false,
        }),
        json_schema!({
            "title": "FootPointParameters",
            "description": "Of scattered points: the parameters of the nearest points of the surface of another job.",
            "type": "object",
            "properties": {
                "foot_points": base,
            },
            "required": ["foot_points"],
            "additionalProperties": false,
        }),
    ];
    choices.extend(scattered.into_iter().map(Schema::to_value));
    json_schema!({
        "description": "How the data points get their parameters: rows and columns by a rule or by numbers, for both directions or for each; scattered points by pairs, by a projection, as sections, by the triangles of a mesh or by their foot points on another surface.",
        "oneOf": choices,
        "examples": ["centripetal", [[0, 0], [0.3, 1.2], [1, 0.7]], {"project": "xy"}],
    })
});
