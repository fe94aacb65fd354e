//! The schemas of points and weights.

use schemars::json_schema;

use super::per_direction::Pair;
use super::points::{PointGrid, PointList, SectionList};
use super::schema::schema_of;
use piad_fit::data::{MAX_DIMENSION, MAX_SURFACE_DIMENSION};

/// A data point.
pub(crate) enum Point {}

schema_of!(
    Point,
    "Point",
    json_schema!({
        "description": format!("A point with 1 to {MAX_DIMENSION} coordinates, on surfaces at most {MAX_SURFACE_DIMENSION}; all points of a job have the same number of them."),
        "type": "array",
        "items": {"type": "number"},
        "minItems": 1,
        "maxItems": MAX_DIMENSION,
        "examples": [[0.95, 0.0114]],
    })
);

schema_of!(PointList, "Points", generator => json_schema!({
    "description": "The data points of a curve, in their order.",
    "type": "array",
    "items": generator.subschema_for::<Point>(),
    "minItems": 2,
    "examples": [[[0, 0], [1, 2], [3, 1], [4, 3]]],
}));

/// The list of scattered points.
pub(crate) enum ScatteredPoints {}

schema_of!(
    ScatteredPoints,
    "ScatteredPoints",
    json_schema!({
        "description": "The scattered data points of a surface, in any order.",
        "type": "array",
        "items": {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 1,
            "maxItems": MAX_SURFACE_DIMENSION,
        },
        "minItems": 4,
        "examples": [[[0, 0, 1], [0.3, 1.2, 2], [1, 0.7, 1], [0.6, 0.1, 3]]],
    })
);

schema_of!(
    SectionList,
    "Sections",
    json_schema!({
        "description": "Sections of a surface, curves across it: lists of points in their order, each with as many as it has.",
        "type": "array",
        "items": {
            "type": "array",
            "items": {
                "type": "array",
                "items": {"type": "number"},
                "minItems": 2,
                "maxItems": MAX_SURFACE_DIMENSION,
            },
            "minItems": 2,
        },
        "minItems": 2,
        "examples": [[[[0, 0, 0], [1, 0, 1], [3, 0, 0]], [[0, 2, 0], [2, 2, 2], [3, 2, 1], [4, 2, 0]]]],
    })
);

schema_of!(
    PointGrid,
    "PointGrid",
    json_schema!({
        "description": "The data points of a surface: rows (u) of columns (v), all of the same length. Numbers instead of points, at least four of them in a row, are heights, points of one coordinate. Least-squares fits may have null for missing points.",
        "type": "array",
        "items": {
            "type": "array",
            // A point as above: client generators do not understand a list that is a choice of a reference.
            "items": {
                "type": ["array", "number", "null"],
                "items": {"type": "number"},
                "minItems": 1,
                "maxItems": MAX_SURFACE_DIMENSION,
            },
            "minItems": 2,
        },
        "minItems": 2,
        "examples": [[[[0, 0, 0], [0, 1, 1]], [[1, 0, 1], [1, 1, 0]]]],
    })
);

/// Weights of a curve, or of a direction.
pub(crate) enum CurveWeights {}

schema_of!(
    CurveWeights,
    "Weights",
    json_schema!({
        "description": "One weight for each data point; with rational \"fixed\" alternatively one for each control point, end copies included.",
        "type": "array",
        "items": {"type": "number", "exclusiveMinimum": 0},
        "minItems": 2,
        "examples": [[1, 2, 2, 1]],
    })
);

/// Weights of a surface.
pub(crate) enum SurfaceWeights {}

schema_of!(SurfaceWeights, "SurfaceWeights", generator => {
    let line = generator.subschema_for::<CurveWeights>();
    json_schema!({
        "description": "Rows of weights, one for each data point, or weights of both directions whose products they are.",
        "oneOf": [
            {"title": "Rows", "type": "array", "items": line, "minItems": 2},
            generator.subschema_for::<Pair<CurveWeights>>(),
        ],
        "examples": [[[1, 1], [1, 2]], {"u": [1, 2], "v": [1, 1]}],
    })
});

/// Weights in an edit, of a curve or of a surface.
pub(crate) enum NewWeights {}

schema_of!(NewWeights, "NewWeights", generator => json_schema!({
    "description": "New weights of all data points: of a curve a list, of a surface as in a job.",
    "anyOf": [
        generator.subschema_for::<CurveWeights>(),
        generator.subschema_for::<SurfaceWeights>(),
    ],
    "examples": [[1, 2, 2, 1]],
}));
