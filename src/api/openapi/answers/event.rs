//! Events: what is said of a job at first, at each iteration and at its end.

use serde_json::{Value, json};

use super::job::{ID, detail, error_example, id, links_example, warnings};
use super::{Named, a, count, number, numbers, object, or_null, path, per_direction, text};
use crate::api::openapi::operation::reference;

pub(super) fn schemas() -> Vec<Named> {
    vec![
        ("JobEvent", job()),
        ("Prediction", prediction()),
        ("EndEvent", end()),
        ("EndLinks", end_links()),
        ("ServerSentEvent", server_sent_event()),
        ("EventLine", line()),
    ]
}

fn job() -> Value {
    object(
        "The data of the `job` event: all that does not change from iteration to iteration.",
        &[
            ("id", id("The id of the job.")),
            ("name", or_null(text("The client's name for it."))),
            ("kind", a("Kind", "Curve or surface.")),
            ("points", count("The number of data points.")),
            (
                "dimension",
                json!({"description": "The number of coordinates.", "type": "integer", "minimum": 1, "maximum": 3}),
            ),
            (
                "control_points",
                per_direction(
                    "The number of control points in each event, end copies included.",
                    json!({"type": "integer"}),
                ),
            ),
            (
                "basis",
                per_direction("The basis.", reference("schemas", "BasisKind")),
            ),
            (
                "degree",
                per_direction("The degree.", json!({"type": "integer", "minimum": 1})),
            ),
            (
                "closed",
                per_direction("Whether it is periodic.", json!({"type": "boolean"})),
            ),
            (
                "rational",
                or_null(a("Rational", "How weights are used, if there are any.")),
            ),
            (
                "method",
                a(
                    "AppliedMethod",
                    "The method, with numbers that were computed for it.",
                ),
            ),
            (
                "predicted",
                a(
                    "Prediction",
                    "How fast it converges, by what is known at iteration 0.",
                ),
            ),
            ("stop", a("AppliedStop", "When it ends.")),
            ("links", a("Links", "The paths of the job.")),
            ("warnings", warnings()),
            (
                "weights",
                per_direction(
                    "Fixed weights of the control points, end copies included.",
                    or_null(numbers()),
                ),
            ),
            (
                "knots",
                per_direction(
                    "The knots; null for the Ball bases, which have none.",
                    or_null(numbers()),
                ),
            ),
            (
                "parameters",
                per_direction("The parameters of the data points.", numbers()),
            ),
        ],
        &[(
            "encoding",
            json!({
                "description": "How weights, knots and parameters are written, if they are binary: as little-endian numbers of 64 bits.",
                "type": "string",
                "const": "base64",
            }),
        )],
        json!({
            "id": ID, "name": null, "kind": "curve", "points": 4, "dimension": 2, "control_points": 6,
            "basis": "bspline", "degree": 3, "closed": false, "rational": null, "method": {"kind": "global", "lambda_min": 0.2},
            "predicted": {"rate": 0.8, "iterations": 60}, "stop": {"tolerance": 1e-6, "max_iterations": 1000},
            "links": links_example(), "warnings": [], "weights": null,
            "knots": [0, 0, 0, 0, 1, 2, 3, 3, 3, 3], "parameters": [0, 1, 2, 3],
        }),
    )
}

fn prediction() -> Value {
    object(
        "What is known of the convergence.",
        &[
            (
                "rate",
                or_null(number(
                    "The factor by which the error shrinks in each iteration, in the long run.",
                )),
            ),
            (
                "iterations",
                or_null(count(
                    "About how many iterations it takes in all; null where nobody knows.",
                )),
            ),
        ],
        &[],
        json!({"rate": 0.8, "iterations": 60}),
    )
}

fn end() -> Value {
    object(
        "The data of the `end` event.",
        &[
            ("state", a("State", "The final state.")),
            (
                "reason",
                or_null(a(
                    "Reason",
                    "Why it ended, where the state does not say it.",
                )),
            ),
            ("detail", detail()),
            ("iterations", count("The number of the last iteration.")),
            (
                "error",
                or_null(a("FitError", "The distances at that iteration.")),
            ),
            (
                "elapsed",
                or_null(number(
                    "Seconds from the beginning of the computation to the end.",
                )),
            ),
            ("links", a("EndLinks", "Where to go on.")),
        ],
        &[("problem", a("Problem", "Why it failed."))],
        json!({
            "state": "converged", "reason": null, "detail": null, "iterations": 23, "error": error_example(), "elapsed": 0.00015,
            "links": {"self": format!("/v1/jobs/{ID}"), "result": format!("/v1/jobs/{ID}/result")},
        }),
    )
}

fn end_links() -> Value {
    object(
        "Paths of a job that has ended.",
        &[
            ("self", path("The job.")),
            ("result", path("The final curve or surface.")),
        ],
        &[],
        json!({"self": format!("/v1/jobs/{ID}"), "result": format!("/v1/jobs/{ID}/result")}),
    )
}

/// One of the events of a stream: its fields, with data that are one line of JSON.
fn server_sent_event() -> Value {
    let data = |schema: &str| {
        json!({
            "description": "What is to be said of it, as JSON.",
            "type": "string",
            "contentMediaType": "application/json",
            "contentSchema": reference("schemas", schema),
        })
    };
    let number = json!({"description": "The number of the iteration.", "type": "string", "pattern": "^[0-9]+$"});
    json!({
        "description": "Server-sent events, each with these fields: `job` without an id, then `iteration` with the number of the iteration as its id, in order and without gaps unless they are asked for, then `end` with the id `end`. Comments keep quiet streams open.",
        "oneOf": alternatives(&data, number),
        "examples": [{"event": "iteration", "id": "1", "data": "{\"iteration\":1,\"error\":{…},\"moved\":4,\"control_points\":[…]}"}],
    })
}

/// One of the lines of a stream.
fn line() -> Value {
    json!({
        "description": "The same events, each as a line of JSON. There are no comments.",
        "oneOf": alternatives(&|schema| a(schema, "What is to be said of it."), count("The number of the iteration.")),
        "examples": [{
            "event": "iteration",
            "id": 1,
            "data": {"iteration": 1, "error": error_example(), "moved": 4, "control_points": [[0, 0], [1, 2], [3, 1], [4, 3]]},
        }],
    })
}

/// The three events, with `data` of a schema and `number` as the id of an iteration.
fn alternatives(data: &dyn Fn(&str) -> Value, number: Value) -> [Value; 3] {
    let end = json!({"description": "The id of the event.", "type": "string", "const": "end"});
    let event = |name: &str, id: Option<Value>, schema: &str| {
        let mut event = json!({
            "description": format!("The `{name}` event."),
            "type": "object",
            "properties": {
                "event": {"description": "What has happened.", "type": "string", "const": name},
                "data": data(schema),
            },
            "required": ["event", "data"],
        });
        if let Some(id) = id {
            event["properties"]["id"] = id;
            event["required"] = json!(["event", "id", "data"]);
        }
        event
    };
    [
        event("job", None, "JobEvent"),
        event("iteration", Some(number), "Iteration"),
        event("end", Some(end), "EndEvent"),
    ]
}
