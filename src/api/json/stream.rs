//! The `stream` object of a job in JSON.

use schemars::{JsonSchema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::schema::{names, schema_of};
use crate::model::named::Named;
use crate::model::stream::{
    Describe, Digits, Encoding, MOST_MILESTONES, MOST_SAMPLES, OnDisconnect, Pace, Samples,
    StreamSpec, View,
};

/// How a number of samples of a surface is written.
pub const SAMPLE_GRID: &str = "^[1-9][0-9]{0,5}x[1-9][0-9]{0,5}$";

/// A distance to be reached.
pub enum Milestone {}

schema_of!(StreamSpec, "StreamDefaults", generator => json_schema!({
    "description": "What the event streams of a job are like if they do not say it themselves. Some choices rule others out.",
    "type": "object",
    "additionalProperties": false,
    "properties": {
        "view": optional::<View>(generator, "What the events show."),
        "samples": optional::<Samples>(generator, "How many samples they have; with the view `samples`."),
        "every": {
            "description": "Only iterations that are multiples of this number, and the last.",
            "type": ["integer", "null"],
            "minimum": 1,
            "maximum": u64::MAX,
            "default": 1,
        },
        "milestones": {
            "description": "Only the first iteration whose largest error is within each of these distances, which decrease.",
            "type": ["array", "null"],
            "items": generator.subschema_for::<Milestone>(),
            "maxItems": MOST_MILESTONES,
            "default": [],
        },
        "pace": optional::<Pace>(generator, "What a client gets that is slower than the fit."),
        "changed": {
            "description": "After a first complete event only control points that moved.",
            "type": ["boolean", "null"],
            "default": false,
        },
        "describe": optional::<Describe>(generator, "What the `job` event says of the job."),
        "encoding": optional::<Encoding>(generator, "How arrays of numbers are written."),
        "digits": optional::<Digits>(generator, "How many digits coordinates have."),
        "on_disconnect": optional::<OnDisconnect>(generator, "What becomes of the job when its client goes away."),
    },
    "examples": [{"view": "samples", "samples": 200, "every": 5}],
}));

/// A field that may be null.
fn optional<T: JsonSchema>(generator: &mut SchemaGenerator, description: &str) -> Value {
    let schema = generator.subschema_for::<Option<T>>();
    let mut schema = schema.to_value();
    schema["description"] = json!(description);
    schema
}

schema_of!(
    Samples,
    "Samples",
    json_schema!({
        "description": "A number of samples for a curve, \"rows x columns\" for a surface: at least 2 in each direction and 1,000,000 in all. Without it 200, or 40x40.",
        "oneOf": [
            {"type": "integer", "minimum": 2, "maximum": MOST_SAMPLES},
            {"type": "string", "pattern": SAMPLE_GRID},
        ],
        "examples": [200, "40x40"],
    })
);

schema_of!(
    View,
    "View",
    names(
        "What is shown of an iteration: its complete control points, points of the curve or surface, or its errors alone.",
        "control_points",
        &View::names(),
    )
);
schema_of!(
    Encoding,
    "NumberEncoding",
    names(
        "How arrays of numbers are written: as JSON, or as little-endian numbers of 64 or 32 bits in base64.",
        "json",
        &Encoding::names(),
    )
);
schema_of!(
    Digits,
    "Digits",
    names(
        "How many digits coordinates have: all, or as many as the current error deserves, rounded by at most 1 % of it.",
        "full",
        &Digits::names(),
    )
);
schema_of!(
    Pace,
    "Pace",
    names(
        "What a client gets that is slower than the fit: all iterations, or the latest.",
        "all",
        &Pace::names(),
    )
);
schema_of!(
    Describe,
    "Describe",
    names(
        "What the `job` event says of the job: all, or nothing that is as long as the data: no knots, parameters or fixed weights.",
        "full",
        &Describe::names(),
    )
);
schema_of!(
    OnDisconnect,
    "OnDisconnect",
    names(
        "What becomes of the job when the client goes away that made it with a stream.",
        "continue",
        &OnDisconnect::names(),
    )
);
schema_of!(
    Milestone,
    "Milestone",
    json_schema!({
        "description": "A distance in data units; milestones decrease.",
        "type": "number",
        "exclusiveMinimum": 0,
        "examples": [0.01],
    })
);
