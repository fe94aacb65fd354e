//! Examples for several answers.

use serde_json::{Value, json};

/// The id of the job of all examples.
pub(crate) const ID: &str = "019aa7a4-6a3c-7c5e-8a55-5b9d2c5f1f10";

/// Its distances.
pub(super) fn error() -> Value {
    json!({"max": 4.1e-7, "rms": 2.3e-7, "sum": 2.1e-6, "at": 4})
}

/// Its paths.
pub(super) fn links() -> Value {
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

/// Its paths when it has ended.
pub(super) fn end_links() -> Value {
    json!({"self": format!("/v1/jobs/{ID}"), "result": format!("/v1/jobs/{ID}/result")})
}

/// The job as a resource.
pub(super) fn job() -> Value {
    json!({
        "id": ID, "name": "wing section", "kind": "curve", "state": "converged", "reason": null, "detail": null, "warnings": [], "points": 4,
        "method": {"kind": "global"}, "stop": {"tolerance": 1e-6, "max_iterations": 1000}, "stream": null,
        "iteration": 23, "predicted": {"rate": 0.8, "iterations": 23}, "error": error(), "progress": 1.0,
        "created_at": "2026-11-21T16:31:51.123456789Z", "started_at": "2026-11-21T16:31:51.1236Z",
        "finished_at": "2026-11-21T16:31:51.1240Z", "links": links(),
    })
}

/// Its first event.
pub(crate) fn job_event() -> Value {
    json!({
        "id": ID, "name": null, "kind": "curve", "points": 4, "dimension": 2, "control_points": 6,
        "basis": "bspline", "degree": 3, "closed": false, "ends": {"start": "repeated", "end": "repeated"}, "rational": null,
        "method": {"kind": "global", "lambda_min": 0.2},
        "predicted": {"rate": 0.8, "iterations": 60}, "stop": {"tolerance": 1e-6, "max_iterations": 1000},
        "links": links(), "warnings": [], "weights": null,
        "knots": [0, 0, 0, 0, 1, 2, 3, 3, 3, 3], "parameters": [0, 1, 2, 3],
    })
}

/// One of its iterations.
pub(crate) fn iteration() -> Value {
    json!({
        "iteration": 1, "error": error(), "rate": 0.7, "moved": 4,
        "control_points": [[0, 0], [0, 0], [1, 2.4], [3.1, 0.6], [4, 3], [4, 3]],
    })
}

/// Its last event.
pub(crate) fn end() -> Value {
    json!({
        "state": "converged", "reason": null, "detail": null, "iterations": 23, "error": error(), "elapsed": 0.00015,
        "warnings": [], "links": end_links(),
    })
}

/// Its result.
pub(super) fn result() -> Value {
    json!({
        "id": ID, "name": null, "kind": "curve", "state": "converged", "iteration": 23, "error": error(),
        "basis": "bspline", "degree": 3, "closed": false, "rational": null, "knots": [0, 0, 0, 0, 1, 2, 3, 3, 3, 3],
        "parameters": [0, 1, 2, 3],
        "control_points": [[0, 0], [0, 0], [1, 2.4], [3.1, 0.6], [4, 3], [4, 3]],
    })
}

/// The result without the fields of the job.
pub(super) fn geometry() -> Value {
    json!({
        "basis": "bspline", "degree": 3, "closed": false, "rational": null, "knots": [0, 0, 0, 0, 1, 2, 3, 3, 3, 3],
        "parameters": [0, 1, 2, 3],
        "control_points": [[0, 0], [0, 0], [1, 2.4], [3.1, 0.6], [4, 3], [4, 3]],
    })
}

/// An item of a batch.
pub(super) fn batch_item() -> Value {
    json!({
        "index": 0, "name": "wing section", "state": "converged", "iteration": 23, "error": error(),
        "curve": geometry(),
    })
}

/// The problem of another job.
pub(crate) fn problem() -> Value {
    json!({
        "type": "/problems/invalid-fit", "title": "The job is not a fit that can be computed", "status": 422,
        "detail": "/curve/points/2: point 2 equals point 1",
        "errors": [{"pointer": "/curve/points/2", "detail": "point 2 equals point 1"}],
        "request_id": ID,
    })
}
