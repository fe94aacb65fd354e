//! Iterations and results: errors and geometry in their various forms.

use serde_json::{Value, json};

use super::job::{ID, error_example, id};
use super::{Named, a, count, number, numbers, object, or_null, per_direction, text};
use crate::api::openapi::operation::reference;

pub(super) fn schemas() -> Vec<Named> {
    vec![
        ("Iteration", iteration()),
        ("FitResult", result()),
        ("BadWeight", bad_weight()),
        ("Net", net()),
        ("NetWeights", net_weights()),
        ("Changes", changes()),
        ("SampleParameters", sample_parameters()),
        ("BinaryEncoding", binary_encoding()),
        ("Shape", shape()),
    ]
}

fn iteration() -> Value {
    object(
        "An iteration: the data of an `iteration` event. Which geometry there is depends on `view` and `changed`.",
        &[
            ("iteration", count("Its number, from 0.")),
            ("error", a("FitError", "The distances from the data.")),
            (
                "moved",
                count("How many control points the last step has moved."),
            ),
        ],
        &[
            (
                "milestone",
                number(
                    "The smallest milestone that this iteration is the first to reach; with `milestones`.",
                ),
            ),
            (
                "rate",
                or_null(number("The factor of the error in the last step.")),
            ),
            (
                "predicted",
                count(
                    "About how many iterations it takes in all, by what is known here; absent where nobody knows.",
                ),
            ),
            (
                "bad_weight",
                a("BadWeight", "A weight that no CAD kernel takes."),
            ),
            (
                "encoding",
                a(
                    "BinaryEncoding",
                    "How the arrays are written, if they are binary.",
                ),
            ),
            (
                "shape",
                a(
                    "Shape",
                    "The shape of `control_points` or `samples`, if they are binary.",
                ),
            ),
            (
                "control_points",
                a(
                    "Net",
                    "The complete control points, end copies included; with view=control_points.",
                ),
            ),
            (
                "weights",
                a(
                    "NetWeights",
                    "Homogeneous fits: the weights of the control points.",
                ),
            ),
            (
                "changed",
                a(
                    "Changes",
                    "The control points that moved; with changed=true.",
                ),
            ),
            (
                "parameters",
                a("SampleParameters", "The parameters of the samples."),
            ),
            (
                "samples",
                a("Net", "Points of the curve or surface; with view=samples."),
            ),
        ],
        json!({
            "iteration": 1, "error": error_example(), "rate": 0.7, "moved": 4,
            "control_points": [[0, 0], [0, 0], [1, 2.4], [3.1, 0.6], [4, 3], [4, 3]],
        }),
    )
}

fn result() -> Value {
    object(
        "The final curve or surface: geometry that can be read without anything else.",
        &[
            ("id", id("The id of the job.")),
            ("name", or_null(text("The client's name for it."))),
            ("kind", a("Kind", "Curve or surface.")),
            ("state", a("State", "The final state.")),
            ("iteration", count("The number of the last iteration.")),
            ("error", a("FitError", "The distances from the data.")),
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
                "knots",
                per_direction(
                    "The knots, in base64 always with 64 bits; null for the Ball bases, which have none.",
                    or_null(numbers()),
                ),
            ),
            (
                "control_points",
                a("Net", "The complete control points, end copies included."),
            ),
        ],
        &[
            (
                "bad_weight",
                a("BadWeight", "A weight that no CAD kernel takes."),
            ),
            (
                "encoding",
                a(
                    "BinaryEncoding",
                    "How the arrays are written, if they are binary.",
                ),
            ),
            (
                "shape",
                a(
                    "Shape",
                    "The shape of `control_points`, if they are binary.",
                ),
            ),
            (
                "weights",
                a("NetWeights", "The weights of the control points."),
            ),
        ],
        json!({
            "id": ID, "name": null, "kind": "curve", "state": "converged", "iteration": 23, "error": error_example(),
            "basis": "bspline", "degree": 3, "closed": false, "rational": null, "knots": [0, 0, 0, 0, 1, 2, 3, 3, 3, 3],
            "control_points": [[0, 0], [0, 0], [1, 2.4], [3.1, 0.6], [4, 3], [4, 3]],
        }),
    )
}

fn bad_weight() -> Value {
    object(
        "A control point whose weight is not positive at this iteration.",
        &[
            (
                "control_point",
                a(
                    "PointIndex",
                    "The control point, by the index of its data point.",
                ),
            ),
            ("weight", number("Its weight.")),
            ("detail", text("What is wrong with it.")),
        ],
        &[],
        json!({"control_point": 4, "weight": -0.01, "detail": "a weight of a control point is not positive at this level"}),
    )
}

fn net() -> Value {
    let point = json!({"type": "array", "items": {"type": ["number", "null"]}, "minItems": 1, "maxItems": 3});
    json!({
        "description": "Points: of a curve a list, of a surface rows of columns; coordinates at infinity are null. Or all of their numbers in base64.",
        "anyOf": [
            {"title": "Line", "type": "array", "items": point},
            {"title": "Rows", "type": "array", "items": {"type": "array", "items": point}},
            {"title": "Binary", "type": "string", "contentEncoding": "base64"},
        ],
        "examples": [[[0, 0], [1, 2], [3, 1], [4, 3]]],
    })
}

fn net_weights() -> Value {
    let line = json!({"type": "array", "items": {"type": "number"}});
    let binary = json!({"type": "string", "contentEncoding": "base64"});
    let direction = |text: &str| {
        let mut numbers = numbers();
        numbers["description"] = json!(text);
        numbers
    };
    json!({
        "description": "Weights of control points: of a curve a list, of a surface rows of columns, or fixed ones of each direction. Or the same in base64.",
        "anyOf": [
            line,
            {"title": "Rows", "type": "array", "items": line},
            {
                "title": "PerDirection",
                "type": "object",
                "properties": {"u": direction("Of the rows."), "v": direction("Of the columns.")},
                "required": ["u", "v"],
            },
            binary,
        ],
        "examples": [[1, 1.5, 2, 1]],
    })
}

fn changes() -> Value {
    json!({
        "description": "Places of the complete control points, with the point that is there now and in homogeneous fits its weight.",
        "type": "array",
        "items": {
            "type": "array",
            "prefixItems": [
                reference("schemas", "PointIndex"),
                {"type": "array", "items": {"type": ["number", "null"]}, "minItems": 1, "maxItems": 3},
                {"type": "number"},
            ],
            "minItems": 2,
            "maxItems": 3,
        },
        "examples": [[[5, [0.97, 0.21, 3.25]]]],
    })
}

fn sample_parameters() -> Value {
    let mut parameters = per_direction(
        "The parameters of samples; of a surface those of the rows and of the columns. Or the same in base64.",
        numbers(),
    );
    parameters["examples"] = json!([[0, 0.5, 1]]);
    parameters
}

fn binary_encoding() -> Value {
    json!({
        "description": "Arrays are little-endian numbers of 64 or 32 bits in base64, the last index running fastest.",
        "type": "string",
        "enum": ["base64", "base64_f32"],
        "examples": ["base64"],
    })
}

fn shape() -> Value {
    json!({
        "description": "The number of points in each direction, and of coordinates. Weights have the same without the last number.",
        "type": "array",
        "items": {"type": "integer", "minimum": 0},
        "minItems": 2,
        "maxItems": 3,
        "examples": [[102, 3]],
    })
}
