//! Creating, editing, listing, showing, cancelling and deleting jobs, and their events.

use serde_json::{Value, json};

use super::geometry::NAMED;
use super::{NEGOTIATION, NEW_JOB, OF_A_JOB, WITH_A_JOB, events, job};
use crate::api::json::request::edit::EditRequest;
use crate::api::json::request::job::JobRequest;
use crate::api::json::view::job::JobPage;
use crate::api::json::view::points::PointsView;
use crate::api::json::view::result::FitResult;
use crate::api::openapi::operation::{Operation, Tag, json_of};
use crate::api::openapi::parameters::READER_ON_DISCONNECT;
use crate::api::problem::Kind;

/// The parameters of an event stream, for which a job may set defaults. The last one is only for the
/// stream of a new job.
const STREAM: [&str; 10] = [
    "view",
    "samples",
    "every",
    "milestones",
    "pace",
    "changed",
    "describe",
    "encoding",
    "digits",
    "on_disconnect",
];

/// The operation answers with the new job.
fn answered_with_job(operation: Operation) -> Operation {
    operation
        .answer(
            201,
            "The new job as it stands, or with `Prefer: wait` when it has ended. Also if it was made before, for the same key.",
            &job(),
            &["Location", "Idempotency-Replayed", "Preference-Applied"],
        )
        .links(201, &WITH_A_JOB)
        .problems(&NEW_JOB)
}

/// The operation answers with the events of the new job.
fn answered_with_events(operation: Operation) -> Operation {
    operation
        .answer(
            200,
            "The event stream of the new job. It ends with the job.",
            &events(),
            &["Location", "Idempotency-Replayed"],
        )
        .problems(&NEW_JOB)
}

/// `POST /v1/fit`
pub fn fit() -> Operation {
    Operation::new(
        Tag::Geometry,
        "fit",
        "Fit, and answer with the geometry",
        "One request, one answer: the curve or surface of a fit that converges, which is computed while the request waits and kept nowhere. With an Accept header also as a file or a message. A fit that does not come within its tolerance is answered with 422 and how near it came; a client that goes away ends its fit. For fits that take longer than proxies wait, make a job. The body may also be a file of points, as for `/v1/jobs`; what a job says of its streams has no meaning here.",
    )
    .parameters(&["encoding"])
    .body::<JobRequest>(job_examples())
    .answer(200, "The result; its id is that of no job.", &[json_of::<FitResult<'_>>()], NAMED)
    .problems(&NEW_JOB)
    .problems(&[Kind::NotConverged, Kind::NoExport])
}

/// `POST /v1/jobs`
pub fn create() -> Operation {
    let operation = Operation::new(
        Tag::Jobs,
        "createJob",
        "Fit a curve or a surface",
        "Makes a job. It runs whether anybody looks or not. An Accept header that asks for events has the answer of `/v1/jobs/stream`, with its parameters. The body may also be a file of points (`text/csv`, `text/plain`), as `/v1/points` reads them; then the other fields stand in the query, by their paths.",
    )
    .parameters(&["Prefer", "Idempotency-Key"])
    .body::<JobRequest>(job_examples());
    answered_with_job(operation)
}

/// `POST /v1/jobs/stream`
pub fn create_stream() -> Operation {
    let operation = Operation::new(
        Tag::Events,
        "createJobStream",
        "Fit a curve or a surface, and follow the fit",
        "Makes a job as `/v1/jobs` does; the answer is its event stream. Some choices of parameters rule others out; that is answered with 400.",
    )
    .parameters(&[&["Idempotency-Key"], &STREAM[..]].concat())
    .body::<JobRequest>(job_examples());
    answered_with_events(operation)
}

/// `POST /v1/points`
pub fn points() -> Operation {
    Operation::new(
        Tag::Jobs,
        "readPoints",
        "Read a file of points",
        "The points of a file as a job has them, and what was found out about it: CSV with any separator, tables with blanks, point clouds (XYZ), airfoils (`.dat`). A surface is seen by blank lines between rows, or by x and y that form a lattice. Nothing is fitted or kept. `/v1/jobs` takes the same files; what else there is to say of the job stands in the query then, by its path: `?curve.degree=3&method.kind=chebyshev&stop.tolerance=1e-4`.",
    )
    .parameters(&["surface.size"])
    .text_body("Lines of numbers, in UTF-8.", "x,y\n1,0.0013\n0.95,0.0114\n0.9,0.0208\n")
    .json::<PointsView>(200, "The points.")
    .problems(&[
        Kind::InvalidRequest,
        Kind::NotAcceptable,
        Kind::BodyTimeout,
        Kind::BodyTooLarge,
        Kind::UnsupportedMediaType,
        Kind::UnsupportedEncoding,
        Kind::InvalidFit,
        Kind::Busy,
    ])
}

fn job_examples() -> Value {
    json!({
        "curve": {
            "summary": "A cubic B-spline through points",
            "value": {
                "name": "wing section",
                "curve": {"points": [[1.0, 0.0013], [0.95, 0.0114], [0.9, 0.0208], [0.8, 0.0375], [0.7, 0.0518]]},
            },
        },
        "surface": {
            "summary": "A surface, with all that can be said of it",
            "value": {
                "surface": {
                    "points": [
                        [[0, 0, 0], [0, 1, 1], [0, 2, 0], [0, 3, 1]],
                        [[1, 0, 1], [1, 1, 3], [1, 2, 1], [1, 3, 2]],
                        [[2, 0, 0], [2, 1, 1], [2, 2, 0], [2, 3, 1]],
                    ],
                    "basis": {"u": {"kind": "bspline", "degree": 2, "knots": "averaged"}, "v": {"kind": "bspline"}},
                    "parameters": "centripetal",
                    "closed": {"u": false, "v": false},
                },
                "method": {"kind": "weighted", "omega": "auto"},
                "stop": {"tolerance": 1e-6, "max_iterations": 500},
                "stream": {"view": "samples", "samples": "20x30", "milestones": [0.1, 0.01]},
            },
        },
        "rational": {
            "summary": "A rational curve, whose weights evolve",
            "value": {
                "curve": {"points": [[0, 0], [1, 2], [3, 2], [4, 0]], "weights": [1, 2, 2, 1], "parameters": "uniform"},
                "rational": "homogeneous",
            },
        },
        "local": {
            "summary": "Only two control points move",
            "value": {
                "curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3], [6, 2]]},
                "method": {"kind": "local", "indices": [1, 2]},
            },
        },
        "least_squares": {
            "summary": "Fewer control points than data",
            "value": {
                "curve": {"points": [[0, 0], [1, 2], [2, 1], [3, 3], [4, 0], [5, 1], [6, 2], [7, 0]], "parameters": "uniform"},
                "method": {"kind": "least_squares", "control_points": 5, "variant": "cg"},
            },
        },
    })
}

/// `POST /v1/jobs/{id}/edits`
pub fn edit() -> Operation {
    let operation = Operation::new(
        Tag::Jobs,
        "editJob",
        "Change a fit and go on from there",
        "Makes a new job that starts from the control points of another one, which may still be running. Parameters and knots stay those of the parent, so that a moved point moves no other. Everything that is not given stays as it is. An Accept header that asks for events has the answer of `/v1/jobs/{id}/edits/stream`, with its parameters.",
    )
    .parameters(&["id", "Prefer", "Idempotency-Key"])
    .body::<EditRequest>(edit_examples());
    answered_with_job(operation).problems(&[Kind::UnknownJob, Kind::NotFound])
}

/// `POST /v1/jobs/{id}/edits/stream`
pub fn edit_stream() -> Operation {
    let operation = Operation::new(
        Tag::Events,
        "editJobStream",
        "Change a fit, and follow the new one",
        "Makes a new job as `/v1/jobs/{id}/edits` does; the answer is its event stream.",
    )
    .parameters(&[&["id", "Idempotency-Key"], &STREAM[..]].concat())
    .body::<EditRequest>(edit_examples());
    answered_with_events(operation).problems(&[Kind::UnknownJob, Kind::NotFound])
}

fn edit_examples() -> Value {
    json!({
        "move": {
            "summary": "Move a point, and fit what is around it again",
            "value": {
                "points": [{"index": 2, "point": [0.9, 0.03]}],
                "method": {"kind": "local", "indices": [1, 2, 3]},
            },
        },
        "stop": {
            "summary": "Go on from an iteration, with another method and more exactly",
            "value": {
                "name": "wing section, exact",
                "iteration": 0,
                "method": {"kind": "chebyshev"},
                "stop": {"relative_tolerance": 1e-12},
            },
        },
    })
}

/// `GET /v1/jobs`
pub fn list() -> Operation {
    Operation::new(
        Tag::Jobs,
        "listJobs",
        "List jobs",
        "The jobs that the server has, the newest first.",
    )
    .parameters(&["state", "limit", "cursor"])
    .answer(200, "A page of the list.", &[json_of::<JobPage<'_>>()], &[])
    .problems(&NEGOTIATION)
}

/// `GET /v1/jobs/{id}`
pub fn get() -> Operation {
    Operation::new(
        Tag::Jobs,
        "getJob",
        "Show a job",
        "Its state, the iteration that it has reached, the distances there, and where to go on.",
    )
    .parameters(&["id"])
    .answer(200, "The job as it stands.", &job(), &[])
    .problems(&OF_A_JOB)
}

/// `DELETE /v1/jobs/{id}`
pub fn delete() -> Operation {
    Operation::new(
        Tag::Jobs,
        "deleteJob",
        "Forget a job",
        "Stops the job if it is running, and deletes it with all that belongs to it. Edits of it need it no more.",
    )
    .parameters(&["id"])
    .answer(204, "It is gone.", &[], &[])
    .problems(&[Kind::UnknownJob, Kind::NotFound, Kind::StoreFull])
}

/// `POST /v1/jobs/{id}/cancel`
pub fn cancel() -> Operation {
    Operation::new(
        Tag::Jobs,
        "cancelJob",
        "Stop a job",
        "Ends the job where it is. The iterations that were computed stay.",
    )
    .parameters(&["id"])
    .answer(200, "The job, which is cancelled.", &job(), &[])
    .problems(&OF_A_JOB)
    .problems(&[Kind::AlreadyEnded])
}

/// `GET /v1/jobs/{id}/events`
pub fn watch() -> Operation {
    Operation::new(
        Tag::Events,
        "watchJob",
        "Follow a job",
        "Its events: the job, every iteration from 0 on in order and without gaps, the end. The stream runs at the pace of its reader and goes on after the last event that the client names (`?last_event_id=7` is for clients that cannot set headers). Some choices rule others out; that is answered with 400.",
    )
    .parameters(
        &[
            &["id", "Last-Event-ID", READER_ON_DISCONNECT],
            &STREAM[..STREAM.len() - 1],
        ]
        .concat(),
    )
    .answer(
        200,
        "The event stream. It ends with the job.",
        &events(),
        &["Piad-Resumed-After"],
    )
    .answer(204, "The client has seen the end; there is nothing more.", &[], &[])
    .problems(&OF_A_JOB)
}

/// `GET /v1/jobs/{id}/input`
pub fn input() -> Operation {
    Operation::new(
        Tag::Jobs,
        "getInput",
        "Show what was asked for",
        "A body that would ask for the same fit again. An edit shows the changed fit.",
    )
    .parameters(&["id"])
    .answer(
        200,
        "The job as it was accepted.",
        &[json_of::<JobRequest>()],
        NAMED,
    )
    .problems(&OF_A_JOB)
}
