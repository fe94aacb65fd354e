//! The schemas of stream options.

use schemars::json_schema;

use super::samples::{MOST_SAMPLES, Samples};
use super::words::{Describe, Digits, Encoding, OnDisconnect, Pace, View};
use crate::model::schema::{names, schema_of};

/// The pattern of a number of samples of a surface.
pub(crate) const SAMPLE_GRID: &str = "^[1-9][0-9]{0,5}x[1-9][0-9]{0,5}$";

/// A distance to be reached.
pub(crate) enum Milestone {}

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
    names::<Self>(
        "What is shown of an iteration: its complete control points, points of the curve or surface, or its errors alone."
    )
);
schema_of!(
    Encoding,
    "NumberEncoding",
    names::<Self>(
        "How arrays of numbers are written: as JSON, or as little-endian numbers of 64 or 32 bits in base64. In streams also as differences, `delta`: after a first complete event each one says by how many steps every number moves, packed and in base64; the last one comes complete with 64 bits."
    )
);
schema_of!(
    Digits,
    "Digits",
    names::<Self>(
        "How many digits coordinates have: all, or as many as the current error deserves, rounded by at most 1 % of it."
    )
);
schema_of!(
    Pace,
    "Pace",
    names::<Self>("What a client gets that is slower than the fit: all iterations, or the latest.")
);
schema_of!(
    Describe,
    "Describe",
    names::<Self>(
        "What the `job` event says of the job: all, or nothing that is as long as the data: no knots, parameters or fixed weights."
    )
);
schema_of!(
    OnDisconnect,
    "OnDisconnect",
    names::<Self>("What becomes of the job when the client goes away that made it with a stream.")
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
