//! What the server says of itself, and problem objects.

use serde_json::{Value, json};

use super::{Named, a, count, flag, list, object, path, text};
use crate::api::openapi::operation::reference;
use crate::api::problem::Kind;

pub(super) fn schemas() -> Vec<Named> {
    vec![
        ("Problem", problem()),
        ("FieldError", field_error()),
        ("ProblemType", problem_type()),
        ("ProblemTypes", problem_types()),
        ("Index", index()),
        ("Health", health()),
        ("Capabilities", capabilities()),
        ("BasisCapability", basis()),
        ("MethodCapability", method()),
        ("Formats", formats()),
        ("Grpc", grpc()),
        ("Limits", limits()),
    ]
}

fn problem() -> Value {
    let types = Kind::ALL.map(|kind| format!("/problems/{}", kind.entry().slug));
    object(
        "What is wrong (RFC 9457).",
        &[
            (
                "type",
                json!({"description": "The kind of problem; the server explains it there.", "type": "string", "enum": types}),
            ),
            ("title", text("What the kind is called.")),
            (
                "status",
                json!({"description": "The status of the answer.", "type": "integer", "minimum": 400, "maximum": 599}),
            ),
            ("detail", text("What is wrong, for people.")),
        ],
        &[
            (
                "errors",
                list(
                    "The single things that are wrong.",
                    reference("schemas", "FieldError"),
                ),
            ),
            (
                "request_id",
                text("The id of the request, as X-Request-Id has it."),
            ),
        ],
        json!({
            "type": "/problems/invalid-fit", "title": "The job is not a fit that can be computed", "status": 422,
            "detail": "/curve/points/2: point 2 equals point 1",
            "errors": [{"pointer": "/curve/points/2", "detail": "point 2 equals point 1"}],
            "request_id": super::job::ID,
        }),
    )
}

fn field_error() -> Value {
    let pointer = json!({"description": "A JSON pointer (RFC 6901) into the body.", "type": "string", "format": "json-pointer"});
    object(
        "One thing that is wrong. It names its place in one way.",
        &[("detail", text("Why it is wrong."))],
        &[
            ("pointer", pointer),
            ("parameter", text("The query parameter.")),
            ("header", text("The header.")),
            (
                "field",
                text("The path of the field of a protobuf message."),
            ),
        ],
        json!({"pointer": "/curve/points/2", "detail": "point 2 equals point 1"}),
    )
}

fn problem_type() -> Value {
    object(
        "What the `type` of a problem object stands for.",
        &[
            ("type", path("The type.")),
            ("title", text("What it is called.")),
            (
                "status",
                json!({"description": "The status of answers with it.", "type": "integer", "minimum": 400, "maximum": 599}),
            ),
            ("meaning", text("What it means and what to do about it.")),
        ],
        &[],
        json!({"type": "/problems/queue-full", "title": "The server has as many jobs as it takes", "status": 503, "meaning": "Send the job again after the number of seconds in Retry-After."}),
    )
}

fn problem_types() -> Value {
    json!({
        "description": "All types of problem objects.",
        "type": "array",
        "items": reference("schemas", "ProblemType"),
        "examples": [[]],
    })
}

fn index() -> Value {
    object(
        "What the server is.",
        &[
            ("name", text("Its name.")),
            ("version", text("Its version.")),
            ("description", text("What it does.")),
            (
                "links",
                json!({
                    "description": "Where to go on.",
                    "type": "object",
                    "additionalProperties": path("A path."),
                }),
            ),
        ],
        &[],
        json!({"name": "piad", "version": "0.1.0", "description": "Curve and surface fitting", "links": {"jobs": "/v1/jobs"}}),
    )
}

fn health() -> Value {
    object(
        "How the server is.",
        &[(
            "status",
            json!({"description": "The word for it.", "type": "string", "enum": ["alive", "ready"]}),
        )],
        &[],
        json!({"status": "ready"}),
    )
}

fn names(description: &str) -> Value {
    list(description, json!({"type": "string"}))
}

fn capabilities() -> Value {
    let bases = list("The bases.", reference("schemas", "BasisCapability"));
    let methods = list("The methods.", reference("schemas", "MethodCapability"));
    object(
        "What the server can do, and its limits.",
        &[
            ("version", text("The version of the server.")),
            ("geometry", names("What is fitted.")),
            (
                "dimensions",
                list(
                    "How many coordinates points have.",
                    json!({"type": "integer"}),
                ),
            ),
            ("bases", bases),
            ("parameters", names("How data points get their parameters.")),
            ("rational", names("How weights are used.")),
            ("methods", methods),
            ("views", names("What is shown of an iteration.")),
            (
                "encodings",
                names("How arrays of numbers are written in JSON."),
            ),
            ("digits", names("How many digits coordinates have.")),
            ("paces", names("What slow clients get.")),
            ("stream", names("The parameters of event streams.")),
            ("formats", a("Formats", "Media types.")),
            ("grpc", a("Grpc", "The same service in gRPC.")),
            ("limits", a("Limits", "Limits of this server.")),
        ],
        &[],
        example(),
    )
}

fn example() -> Value {
    json!({
        "version": "0.1.0", "geometry": ["curve", "surface"], "dimensions": [1, 2, 3], "bases": [], "parameters": ["chord_length"],
        "rational": ["homogeneous"], "methods": [], "views": ["control_points"], "encodings": ["json"], "digits": ["full"],
        "paces": ["all"], "stream": ["view"], "formats": formats_example(), "grpc": grpc_example(), "limits": limits_example(),
    })
}

fn basis() -> Value {
    let range = json!({
        "description": "The degrees.",
        "type": "object",
        "properties": {"min": count("The lowest."), "max": count("The highest.")},
        "required": ["min", "max"],
    });
    object(
        "A basis.",
        &[
            ("kind", a("BasisKind", "Its kind.")),
            ("degree", range),
            ("closed", flag("Whether it can be periodic.")),
        ],
        &[("knots", names("How knots are chosen."))],
        json!({"kind": "bernstein", "degree": {"min": 1, "max": 1000}, "closed": false}),
    )
}

fn method() -> Value {
    object(
        "A method. All of them fit curves.",
        &[
            ("kind", a("MethodKind", "Its kind.")),
            ("settings", names("Its settings.")),
            ("surface", flag("Whether it fits surfaces.")),
            (
                "homogeneous",
                flag("Whether it fits in homogeneous coordinates."),
            ),
        ],
        &[],
        json!({"kind": "weighted", "settings": ["omega"], "surface": true, "homogeneous": true}),
    )
}

fn formats_example() -> Value {
    json!({"jobs": ["application/json"], "events": ["text/event-stream"], "result": ["model/step"]})
}

fn formats() -> Value {
    object(
        "Media types.",
        &[
            ("jobs", names("Of jobs.")),
            ("events", names("Of event streams.")),
            ("result", names("Of iterations and results.")),
        ],
        &[],
        formats_example(),
    )
}

fn grpc_example() -> Value {
    json!({"service": "piad.v1.FittingService", "reflection": ["grpc.reflection.v1"], "health": "grpc.health.v1"})
}

fn grpc() -> Value {
    object(
        "The same service in gRPC, on the same port.",
        &[
            ("service", text("Its name.")),
            ("reflection", names("The reflection services.")),
            ("health", text("The health service.")),
        ],
        &[],
        grpc_example(),
    )
}

fn limits_example() -> Value {
    json!({
        "body_bytes": 268435456, "points": 4000000, "samples": 1000000, "milestones": 100, "iterations": 1000000, "jobs": 10000, "jobs_per_peer": 5000,
        "memory_bytes": 8589934592_u64, "retained_jobs": 1000, "retained_bytes": 1073741824, "retained_seconds": 604800,
    })
}

fn limits() -> Value {
    object(
        "Limits of this server.",
        &[
            ("body_bytes", count("The largest request body.")),
            ("points", count("The most data points of a job.")),
            ("samples", count("The most samples of an iteration.")),
            ("milestones", count("The most milestones of a stream.")),
            ("iterations", count("The largest max_iterations.")),
            ("jobs", count("The most jobs that have not ended.")),
            (
                "jobs_per_peer",
                count("The most jobs from one address that have not ended."),
            ),
            ("memory_bytes", count("Memory for running jobs.")),
            ("retained_jobs", count("The most ended jobs that are kept.")),
            (
                "retained_bytes",
                count("Room for the data and results of ended jobs."),
            ),
            ("retained_seconds", count("How long ended jobs are kept.")),
        ],
        &[],
        limits_example(),
    )
}
