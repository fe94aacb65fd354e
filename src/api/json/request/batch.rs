//! The schema of a batch in JSON, which is read item by item.

use schemars::json_schema;

use crate::model::job::JobRequest;
use crate::model::schema::schema_of;

/// Many jobs, and their defaults.
pub(crate) enum BatchRequest {}

schema_of!(BatchRequest, "BatchRequest", generator => {
    json_schema!({
        "description": "Many curves and surfaces to fit. `defaults` stands before `items`, which are read as they come.",
        "type": "object",
        "properties": {
            "defaults": {
                "description": "Fields of a job, without points, for the items that do not say them.",
                "type": "object",
                "additionalProperties": true,
            },
            "items": {
                "description": "The jobs.",
                "type": "array",
                "items": generator.subschema_for::<JobRequest>(),
            },
        },
        "required": ["items"],
        "additionalProperties": false,
        "examples": [{
            "defaults": {"stop": {"tolerance": 0.01}},
            "items": [{"name": "a", "curve": {"points": [[0, 0], [1, 2], [3, 2], [4, 0]]}}],
        }],
    })
});
