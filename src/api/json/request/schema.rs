//! Schemas of requests: names and numbers that are read by hand, and which fields go together.

use schemars::{Schema, json_schema};
use serde_json::{Value, json};

use super::basis::{BasisKind, KnotRule, ParameterRule};
use super::edit::IterationRequest;
use super::method::{Index, Kind, Matrix, Omega};
use crate::api::json::per_direction::Pair;
use crate::api::json::read::values::Count;
use crate::api::json::schema::alternatives::{Alternative, Constant, or_name, split};
use crate::api::json::schema::schema_of;
use crate::fit::basis::MAX_DEGREE;
use crate::fit::method::LARGEST;

/// How data points get their parameters.
pub(super) enum Parameters {}

schema_of!(
    Parameters,
    "ParameterChoice",
    json_schema!({
        "description": "How the data points get their parameters: a rule, or strictly increasing numbers, one for each point; for a closed curve one more, at which it is back at the first.",
        "anyOf": [
            {"type": "string", "enum": ParameterRule::NAMES},
            {"type": "array", "items": {"type": "number"}, "minItems": 2},
        ],
        "default": "chord_length",
        "examples": ["centripetal", [0, 0.2, 0.7, 1]],
    })
);

/// The degree of a B-spline that is as usual otherwise.
pub(super) enum Degree {}

schema_of!(
    Degree,
    "Degree",
    json_schema!({
        "description": "The degree of a B-spline.",
        "type": "integer",
        "minimum": 1,
        "maximum": MAX_DEGREE,
        "examples": [3],
    })
);

/// Where the pieces of a B-spline meet.
pub(super) enum KnotChoice {}

schema_of!(
    KnotChoice,
    "KnotChoice",
    json_schema!({
        "description": "Where the pieces of a B-spline meet: at the parameters of the data, at averages of them, or at the numbers of a clamped knot vector.",
        "anyOf": [
            {"type": "string", "enum": KnotRule::NAMES},
            {"type": "array", "items": {"type": "number"}, "minItems": 4},
        ],
        "examples": ["data", [0, 0, 0, 0, 1, 1, 1, 1]],
    })
);

schema_of!(
    Omega,
    "Omega",
    json_schema!({
        "description": "A relaxation between 0 and 2, or \"auto\": 2 / (1 + λ_min), the best one.",
        "anyOf": [
            {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 2},
            {"type": "string", "const": "auto"},
        ],
        "default": "auto",
        "examples": ["auto", 1.5],
    })
);

schema_of!(
    Index,
    "PointIndex",
    json_schema!({
        "description": "The index of a data point, from 0: of a curve a number, of a surface [row, column].",
        "anyOf": [
            {"type": "integer", "minimum": 0},
            {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 2, "maxItems": 2},
        ],
        "examples": [17, [2, 3]],
    })
);

schema_of!(
    IterationRequest,
    "IterationChoice",
    json_schema!({
        "description": "The number of an iteration, or the last one.",
        "anyOf": [
            {"type": "integer", "minimum": 0},
            {"type": "string", "const": "last"},
        ],
        "default": "last",
        "examples": ["last", 5],
    })
);

schema_of!(
    Matrix,
    "Matrix",
    json_schema!({
        "description": "The rows of a square matrix, with a row and a column for each control point of the direction.",
        "type": "array",
        "items": {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 2,
            "maxItems": LARGEST,
        },
        "minItems": 2,
        "maxItems": LARGEST,
        "examples": [[[1, 0], [0, 1]]],
    })
);

/// The number of control points of a least-squares fit.
pub(super) enum ControlPoints {}

schema_of!(ControlPoints, "ControlPointCount", generator => {
    let count = json_schema!({"type": "integer", "minimum": 2});
    json_schema!({
        "description": "A number of control points, not greater than that of data points; on surfaces of both directions, or one for each.",
        "anyOf": [count, generator.subschema_for::<Pair<Count>>()],
        "examples": [12, {"u": 8, "v": 6}],
    })
});

/// A job is about a curve or a surface.
pub(super) fn job(schema: &mut Schema) {
    let shared = ["name", "rational", "method", "stop", "stream"];
    let alternatives = [
        Alternative {
            title: "CurveJob",
            description: "A fit of a curve.",
            needs: &["curve"],
            ..Alternative::default()
        },
        Alternative {
            title: "SurfaceJob",
            description: "A fit of a surface.",
            needs: &["surface"],
            ..Alternative::default()
        },
    ];
    split(schema, &shared, &alternatives);
}

/// Only B-splines have a degree and knots to choose.
pub(super) fn basis(schema: &mut Schema) {
    let polynomial = |title, description, is| Alternative {
        title,
        description,
        is,
        ..Alternative::default()
    };
    let alternatives = [
        Alternative {
            title: "BSpline",
            description: "A B-spline of a degree.",
            is: &[("kind", Constant::Name("bspline"))],
            takes: &["degree", "knots"],
            ..Alternative::default()
        },
        polynomial(
            "Bernstein",
            "A Bézier curve or surface; its degree is control points − 1, up to 1000.",
            &[("kind", Constant::Name("bernstein"))],
        ),
        polynomial(
            "SaidBall",
            "A polynomial in the Said–Ball basis; its degree is control points − 1, up to 1000.",
            &[("kind", Constant::Name("said_ball"))],
        ),
        polynomial(
            "WangBall",
            "A polynomial in the Wang–Ball basis; its degree is control points − 1, up to 1000.",
            &[("kind", Constant::Name("wang_ball"))],
        ),
    ];
    split(schema, &[], &alternatives);
    or_name(schema, BasisKind::NAMES.to_vec());
}

/// Each kind of method has settings of its own.
pub(super) fn method(schema: &mut Schema) {
    split(schema, &[], &METHODS);
    let needy = METHODS
        .iter()
        .filter(|method| method.is.len() == 1 && !method.needs.is_empty());
    let needy: Vec<&str> = needy.filter_map(|method| method.kind()).collect();
    let names = Kind::NAMES.iter().filter(|name| !needy.contains(name));
    or_name(schema, names.copied().collect());
}

/// The settings of a method.
pub(in crate::api) fn settings(kind: &str) -> Vec<&'static str> {
    let mut settings = Vec::new();
    for method in METHODS.iter().filter(|method| method.kind() == Some(kind)) {
        let fixed = method.is.iter().map(|(name, _)| name);
        for name in method.needs.iter().chain(method.takes).chain(fixed) {
            if *name != "kind" && !settings.contains(name) {
                settings.push(*name);
            }
        }
    }
    settings
}

const METHODS: [Alternative; 13] = [
    Alternative {
        title: "Global",
        description: "Classical progressive iterative approximation.",
        is: &[("kind", Constant::Name("global"))],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "Weighted",
        description: "The same with steps of another length.",
        is: &[("kind", Constant::Name("weighted"))],
        needs: &[],
        takes: &["omega"],
    },
    Alternative {
        title: "Local",
        description: "Only chosen control points move.",
        is: &[("kind", Constant::Name("local"))],
        needs: &["indices"],
        takes: &["row_by_row"],
    },
    Alternative {
        title: "RowByRow",
        description: "All control points of a surface move, one row after the other.",
        is: &[
            ("kind", Constant::Name("local")),
            ("row_by_row", Constant::Bool(true)),
        ],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "Adaptive",
        description: "Only control points move whose data points are far away, chosen anew at every iteration.",
        is: &[("kind", Constant::Name("adaptive"))],
        needs: &["threshold"],
        takes: &[],
    },
    Alternative {
        title: "Extended",
        description: "Exact after as many iterations as there are points, by a QR decomposition.",
        is: &[("kind", Constant::Name("extended"))],
        needs: &[],
        takes: &["start"],
    },
    Alternative {
        title: "Transpose",
        description: "Converges for any basis, slowly.",
        is: &[("kind", Constant::Name("transpose"))],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "Convex",
        description: "Planar curves whose control polygons keep the turns of the data.",
        is: &[("kind", Constant::Name("convex"))],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "Chebyshev",
        description: "Chebyshev semi-iteration: a third of the iterations of `global` on B-splines.",
        is: &[("kind", Constant::Name("chebyshev"))],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "Direct",
        description: "Solves for the limit: iteration 1 is exact.",
        is: &[("kind", Constant::Name("direct"))],
        needs: &[],
        takes: &[],
    },
    Alternative {
        title: "LeastSquares",
        description: "Fewer control points than data points.",
        is: &[("kind", Constant::Name("least_squares"))],
        needs: &["control_points"],
        takes: &["variant"],
    },
    Alternative {
        title: "LeastSquaresStep",
        description: "Fewer control points than data points, with steps of a given length.",
        is: &[
            ("kind", Constant::Name("least_squares")),
            ("variant", Constant::Name("lspia")),
        ],
        needs: &["control_points", "mu"],
        takes: &[],
    },
    Alternative {
        title: "Custom",
        description: "Any transform, given as a matrix.",
        is: &[("kind", Constant::Name("custom"))],
        needs: &["transform"],
        takes: &[],
    },
];

pub(super) fn example_job() -> Value {
    json!({"name": "wing section", "curve": example_curve(), "stop": example_stop()})
}

pub(super) fn example_edit() -> Value {
    json!({"points": [example_move()], "method": {"kind": "local", "indices": [1, 2, 3]}})
}

pub(super) fn example_curve() -> Value {
    json!({
        "points": [[1.0, 0.0013], [0.95, 0.0114], [0.9, 0.0208], [0.8, 0.0375]],
        "basis": {"kind": "bspline", "degree": 3, "knots": "data"},
        "parameters": "chord_length",
    })
}

pub(super) fn example_surface() -> Value {
    json!({
        "points": [
            [[0, 0, 0], [0, 1, 1], [0, 2, 0]],
            [[1, 0, 1], [1, 1, 3], [1, 2, 1]],
            [[2, 0, 0], [2, 1, 1], [2, 2, 0]],
        ],
        "basis": {"u": {"kind": "bspline", "degree": 2}, "v": {"kind": "bernstein"}},
        "parameters": "uniform",
    })
}

pub(super) fn example_basis() -> Value {
    json!({"kind": "bspline", "degree": 3, "knots": "data"})
}

pub(super) fn example_stop() -> Value {
    json!({"tolerance": 1e-6, "max_iterations": 1000})
}

pub(super) fn example_method() -> Value {
    json!({"kind": "weighted", "omega": "auto"})
}

pub(super) fn example_move() -> Value {
    json!({"index": 2, "point": [0.9, 0.03]})
}
