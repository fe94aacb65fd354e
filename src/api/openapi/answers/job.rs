//! Jobs as resources.

use serde_json::{Value, json};

use super::{
    Named, a, count, flag, list, number, object, or_null, path, per_direction, text, time,
};
use crate::fit::invalid::Axis;
use crate::fit::outcome::Stall;
use crate::fit::warning::Warning;
use crate::job::state::{Reason, State};

pub(super) const ID: &str = "019aa7a4-6a3c-7c5e-8a55-5b9d2c5f1f10";

pub(super) fn schemas() -> Vec<Named> {
    vec![
        ("State", state()),
        ("Reason", reason()),
        ("Warning", warning()),
        ("Kind", kind()),
        ("FitError", fit_error()),
        ("AppliedMethod", applied_method()),
        ("AppliedStop", applied_stop()),
        ("Parent", parent()),
        ("Links", links()),
        ("Job", job()),
        ("JobPage", page()),
        ("Limit", limit()),
    ]
}

fn state() -> Value {
    json!({
        "description": "Where a job is in its life: queued → running → converged (within the tolerance) | exhausted (at max_iterations) | stalled (the method cannot go on) | failed | cancelled.",
        "type": "string",
        "enum": State::ALL.map(State::name),
        "examples": ["converged"],
    })
}

fn reason() -> Value {
    let stalls = [
        Stall::Convexity,
        Stall::Nilpotent,
        Stall::Rounding,
        Stall::Diverging,
    ];
    let stalls = stalls.map(|stall| Reason::Stalled(stall).name());
    let names: Vec<&str> = [Reason::Stationary.name()]
        .into_iter()
        .chain(stalls)
        .collect();
    json!({
        "description": "Why a job ended, where its state does not say it.",
        "type": "string",
        "enum": names,
        "examples": ["stationary"],
    })
}

pub(super) fn warnings() -> Value {
    list(
        "What is doubtful about it; some of that is found out only when the job begins to run.",
        a("Warning", "A warning."),
    )
}

fn warning() -> Value {
    object(
        "What is doubtful about a fit that is computed even so.",
        &[
            (
                "code",
                json!({
                    "description": "What it is. `few_points`: with knots at the data the degree is no less than the number of points. `even_degree`: with knots at the data an even degree makes a moved point be felt along the whole curve. `rounding`: rounding will leave more of an extended fit than the tolerance. `shorter_interval`: Chebyshev steps by the least eigenvalue would make distances rise far, and others are taken. `ill_conditioned`: the slowest part of the error will hardly have changed after the last iteration. `without_data`: control points of a least-squares fit have no data and stay. There may be others in later versions.",
                    "type": "string",
                    "examples": Warning::CODES,
                }),
            ),
            ("pointer", text("A JSON pointer into the input of the job.")),
            (
                "detail",
                text("What is doubtful here, why, and what to do about it."),
            ),
        ],
        &[],
        json!({
            "code": "even_degree", "pointer": "/curve/basis/degree",
            "detail": Warning::EvenDegree { axis: Axis::U, degree: 4 }.detail(),
        }),
    )
}

pub(super) fn detail() -> Value {
    or_null(text("The reason in words, with what is left."))
}

fn kind() -> Value {
    json!({
        "description": "What is fitted.",
        "type": "string",
        "enum": ["curve", "surface"],
        "examples": ["curve"],
    })
}

pub(super) fn error_example() -> Value {
    json!({"max": 4.1e-7, "rms": 2.3e-7, "sum": 2.1e-6, "at": 4})
}

fn fit_error() -> Value {
    object(
        "Distances from the data points; of local fits from the adjusted ones. Null where a distance is infinite.",
        &[
            ("max", or_null(number("The largest distance."))),
            (
                "rms",
                or_null(number("The root mean square of the distances.")),
            ),
            ("sum", or_null(number("The sum of the distances."))),
            (
                "at",
                a("PointIndex", "The data point with the largest distance."),
            ),
        ],
        &[
            (
                "fixed_max",
                or_null(number(
                    "Local fits: the largest distance of the points that are not adjusted.",
                )),
            ),
            (
                "homogeneous",
                or_null(number(
                    "Homogeneous fits: the largest distance in homogeneous coordinates.",
                )),
            ),
            (
                "gradient",
                or_null(number(
                    "Least squares: the gradient, which is zero at the minimum.",
                )),
            ),
        ],
        error_example(),
    )
}

fn applied_method() -> Value {
    object(
        "The method of a job, with numbers that were computed for it.",
        &[("kind", a("MethodKind", "The kind."))],
        &[
            (
                "omega",
                or_null(number(
                    "Weighted: the relaxation; null until it is computed.",
                )),
            ),
            (
                "adjusted",
                or_null(count("Local: how many control points may move.")),
            ),
            (
                "row_by_row",
                flag("Local: whether rows are swept one after the other."),
            ),
            (
                "threshold",
                number("Adaptive: the distance beyond which control points move."),
            ),
            (
                "start",
                a("ExtendedStart", "Extended: what iteration 0 is."),
            ),
            (
                "control_points",
                per_direction(
                    "Least squares: the number of control points.",
                    json!({"type": "integer"}),
                ),
            ),
            (
                "variant",
                a("LeastSquaresVariant", "Least squares: the step."),
            ),
            (
                "lambda_min",
                number(
                    "The least eigenvalue of the collocation matrix, where it is known; of local fits of few points that of their block.",
                ),
            ),
        ],
        json!({"kind": "weighted", "omega": 1.37, "lambda_min": 0.46}),
    )
}

fn applied_stop() -> Value {
    object(
        "When the iteration ends.",
        &[
            (
                "tolerance",
                number("The largest allowed distance, in data units."),
            ),
            (
                "max_iterations",
                count("The last iteration that is computed."),
            ),
        ],
        &[],
        json!({"tolerance": 1e-6, "max_iterations": 1000}),
    )
}

fn parent() -> Value {
    object(
        "The job of which another one is an edit.",
        &[
            ("id", id("Its id.")),
            (
                "iteration",
                count("The iteration from whose control points the edit started."),
            ),
        ],
        &[],
        json!({"id": ID, "iteration": 38}),
    )
}

pub(super) fn id(description: &str) -> Value {
    json!({"description": description, "type": "string", "format": "uuid"})
}

pub(super) fn links_example() -> Value {
    let part = |name: &str| format!("/v1/jobs/{ID}{name}");
    json!({
        "self": part(""),
        "events": part("/events"),
        "input": part("/input"),
        "result": part("/result"),
        "edits": part("/edits"),
        "limit": part("/limit"),
        "cancel": part("/cancel"),
    })
}

fn links() -> Value {
    object(
        "Paths of a job.",
        &[
            ("self", path("The job.")),
            ("events", path("Its event stream.")),
            ("input", path("The job as it was asked for.")),
            ("result", path("The final curve or surface.")),
            ("edits", path("Where edits are posted.")),
            ("limit", path("Where the fixed points of a local fit end.")),
            ("cancel", path("Where a POST stops it.")),
        ],
        &[],
        links_example(),
    )
}

fn job() -> Value {
    object(
        "A fit as it stands.",
        &[
            ("id", id("Its id; ids grow with time.")),
            ("name", or_null(text("The client's name for it."))),
            ("kind", a("Kind", "Curve or surface.")),
            ("state", a("State", "Where it is in its life.")),
            (
                "reason",
                or_null(a(
                    "Reason",
                    "Why it ended, where the state does not say it.",
                )),
            ),
            ("detail", detail()),
            ("warnings", warnings()),
            ("points", count("The number of data points.")),
            ("method", a("AppliedMethod", "The method.")),
            ("stop", a("AppliedStop", "When it ends.")),
            (
                "stream",
                or_null(a(
                    "StreamDefaults",
                    "What its streams are like, if the job says it.",
                )),
            ),
            ("iteration", or_null(count("The last iteration so far."))),
            (
                "predicted",
                a(
                    "Prediction",
                    "How fast it converges, by what is known at that iteration.",
                ),
            ),
            (
                "error",
                or_null(a("FitError", "The distances at that iteration.")),
            ),
            (
                "progress",
                json!({"description": "How far it is.", "type": "number", "minimum": 0, "maximum": 1}),
            ),
            ("created_at", time("When it was accepted.")),
            ("started_at", or_null(time("When it began to run."))),
            ("finished_at", or_null(time("When it ended."))),
            ("links", a("Links", "Its paths.")),
        ],
        &[
            ("parent", a("Parent", "The job of which it is an edit.")),
            ("problem", a("Problem", "Why it failed.")),
        ],
        json!({
            "id": ID, "name": "wing section", "kind": "curve", "state": "converged", "reason": null, "detail": null, "warnings": [], "points": 4,
            "method": {"kind": "global"}, "stop": {"tolerance": 1e-6, "max_iterations": 1000}, "stream": null,
            "iteration": 23, "predicted": {"rate": 0.8, "iterations": 23}, "error": error_example(), "progress": 1.0,
            "created_at": "2026-11-21T16:31:51.123456789Z", "started_at": "2026-11-21T16:31:51.1236Z",
            "finished_at": "2026-11-21T16:31:51.1240Z", "links": links_example(),
        }),
    )
}

fn page() -> Value {
    object(
        "A page of the list of jobs.",
        &[
            ("jobs", list("Jobs, the newest first.", a("Job", "A job."))),
            ("next", or_null(path("The next page, if there is one."))),
        ],
        &[],
        json!({"jobs": [], "next": null}),
    )
}

fn limit() -> Value {
    let difference = list(
        "From the limit to the data point.",
        json!({"type": "number"}),
    );
    object(
        "Where the difference vectors of the fixed points of a local fit end.",
        &[
            (
                "points",
                list("The fixed data points.", a("PointIndex", "A data point.")),
            ),
            (
                "differences",
                list("Their difference vectors, in the same order.", difference),
            ),
            ("max", number("The length of the longest of them.")),
        ],
        &[],
        json!({"points": [0, 3], "differences": [[0.0, 0.0], [0.1, -0.2]], "max": 0.223606797749979}),
    )
}
