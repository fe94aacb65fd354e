//! Constraints of least squares in messages: errors name fields, and jobs omit lists.

use serde_json::{Value, json};

use crate::data;
use crate::messages::method::constraint::{At, Wanted};
use crate::messages::{self as pb, job_input::Geometry, method as m, method::Kind};
use crate::numbers::flat;
use crate::rpc::{connect, curve};
use crate::support::{Server, base};

fn constraint(at: At, wanted: Wanted) -> m::Constraint {
    m::Constraint {
        at: Some(at),
        wanted: Some(wanted),
    }
}

fn vector(coordinates: &[f64]) -> m::Vector {
    m::Vector {
        coordinates: coordinates.to_vec(),
    }
}

fn derivative(order_u: u32, order_v: u32, coordinates: &[f64]) -> Wanted {
    Wanted::Derivative(m::Derivative {
        order_u,
        order_v,
        vector: Some(vector(coordinates)),
    })
}

fn across(order: u32, control_points: &[&[f64]]) -> Wanted {
    Wanted::Across(m::Across {
        order,
        control_points: control_points.iter().map(|it| vector(it)).collect(),
    })
}

fn with(constraints: Vec<m::Constraint>) -> m::LeastSquares {
    m::LeastSquares {
        constraints,
        ..plain()
    }
}

fn plain() -> m::LeastSquares {
    m::LeastSquares {
        control_points_u: 6,
        ..m::LeastSquares::default()
    }
}

fn input(surface: bool, settings: m::LeastSquares) -> pb::JobInput {
    let method = Some(pb::Method {
        kind: Some(Kind::LeastSquares(settings)),
    });
    if !surface {
        let points = json!(
            (0..12)
                .map(|i| [f64::from(i), f64::from(i * i % 7)])
                .collect::<Vec<_>>()
        );
        return pb::JobInput {
            method,
            ..curve(&points)
        };
    }
    let surface = pb::Surface {
        dimension: 3,
        rows: 8,
        columns: 8,
        points: flat(&json!(data::peaks(8))),
        ..pb::Surface::default()
    };
    pb::JobInput {
        geometry: Some(Geometry::Surface(surface)),
        method,
        ..pb::JobInput::default()
    }
}

#[tokio::test]
async fn wrong_settings_are_named() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let at_point = constraint(At::Index(3), derivative(1, 0, &[1.0, 0.0]));
    let nowhere = m::Constraint {
        at: None,
        ..at_point.clone()
    };
    let nothing = m::Constraint {
        at: Some(At::Side(1)),
        wanted: None,
    };
    let net = [&[0.0, 0.0, 0.0][..]; 6];
    let cases = [
        (false, with(vec![nowhere]), "constraints[0]", "nowhere"),
        (
            false,
            with(vec![at_point.clone(), nothing]),
            "constraints[1]",
            "a point or a derivative",
        ),
        (
            false,
            with(vec![constraint(At::Side(0), derivative(1, 0, &[1.0, 0.0]))]),
            "constraints[0]",
            "side is not given",
        ),
        (
            false,
            with(vec![constraint(At::Side(7), derivative(1, 0, &[1.0, 0.0]))]),
            "constraints[0].side",
            "7 is no value",
        ),
        (
            true,
            with(vec![constraint(At::Boundary(9), across(0, &net))]),
            "constraints[0].boundary",
            "9 is no value",
        ),
        (
            true,
            with(vec![constraint(At::Boundary(0), across(0, &net))]),
            "constraints[0]",
            "boundary is not given",
        ),
        (
            true,
            with(vec![constraint(At::Boundary(1), across(2, &net))]),
            "constraints[0]",
            "order 0 or 1",
        ),
        (
            true,
            with(vec![constraint(At::Boundary(1), across(0, &[]))]),
            "constraints[0]",
            "or none",
        ),
        (
            true,
            with(vec![constraint(
                At::Boundary(1),
                across(0, &[&[0.0], &[0.0, 1.0]]),
            )]),
            "constraints[0]",
            "different dimensions",
        ),
        (
            true,
            with(vec![constraint(At::Boundary(1), across(0, &net[1..]))]),
            "constraints[0]",
            "5 control points along a boundary of 6",
        ),
        (
            true,
            with(vec![constraint(At::Index(3), derivative(2, 1, &[0.0; 3]))]),
            "constraints[0]",
            "orders up to two",
        ),
        (
            false,
            with(vec![constraint(At::Index(3), derivative(0, 1, &[0.0; 2]))]),
            "constraints[0]",
            "of curves in u",
        ),
        (
            false,
            with(vec![constraint(At::Index(3), derivative(1, 0, &[]))]),
            "constraints[0]",
            "a vector",
        ),
        (
            false,
            with(vec![constraint(
                At::Index(3),
                derivative(1, 0, &[1.0, f64::NAN]),
            )]),
            "constraints[0]",
            "not a finite number",
        ),
        (
            false,
            with(vec![constraint(
                At::Parameter(f64::NAN),
                derivative(0, 0, &[1.0, 1.0]),
            )]),
            "constraints[0]",
            "outside",
        ),
        (
            false,
            with(vec![
                at_point.clone(),
                constraint(At::Index(3), derivative(1, 0, &[-1.0, 0.0])),
            ]),
            "constraints[1]",
            "together with constraint 0",
        ),
        (
            false,
            with(vec![at_point; 1001]),
            "constraints",
            "more than 1000 constraints",
        ),
        (
            false,
            m::LeastSquares {
                end_points: 3,
                ..plain()
            },
            "end_points",
            "3 is no value",
        ),
        (
            false,
            m::LeastSquares {
                fairness_order: 2,
                ..plain()
            },
            "fairness_order",
            "not given",
        ),
        (
            false,
            m::LeastSquares {
                fairness: Some(f64::INFINITY),
                ..plain()
            },
            "fairness",
            "finite",
        ),
        (
            false,
            m::LeastSquares {
                fairness: Some(0.1),
                fairness_order: 4,
                ..plain()
            },
            "fairness_order",
            "is 4; expected 2 or 3",
        ),
        (
            false,
            m::LeastSquares {
                data_weights: vec![1.0; 11],
                ..plain()
            },
            "data_weights",
            "11 weights of data for 12 points",
        ),
        (
            true,
            m::LeastSquares {
                data_weights: (0..64).map(|i| 20.0 - f64::from(i)).collect(),
                ..plain()
            },
            "data_weights[21]",
            "not negative",
        ),
    ];
    for (surface, settings, field, reason) in cases {
        let request = pb::CreateJobRequest {
            input: Some(input(surface, settings)),
            ..pb::CreateJobRequest::default()
        };
        let refused = client.create_job(request).await.unwrap_err();
        let place = format!("input.method.least_squares.{field}: ");
        assert!(refused.message().starts_with(&place), "{refused:?} {field}");
        assert!(refused.message().contains(reason), "{refused:?} {reason}");
    }
}

/// Descriptions of jobs have the settings, and no lists; the input has these, too.
#[tokio::test]
async fn jobs_leave_lists_out() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let asked = m::LeastSquares {
        control_points_u: 6,
        control_points_v: 5,
        variant: m::Variant::Direct.into(),
        end_points: m::EndPoints::Free.into(),
        data_weights: (0..64).map(|i| 0.1 * f64::from(i)).collect(),
        fairness: Some(1e-5),
        fairness_order: 2,
        constraints: vec![
            constraint(At::Boundary(2), across(1, &[&[1.0, 0.0, -0.5][..]; 5])),
            m::Constraint {
                at: Some(At::Index(9)),
                wanted: None,
            },
            constraint(
                At::Parameters(m::SurfaceParameters { u: 2.5, v: 2.5 }),
                derivative(0, 1, &[0.0, 1.0, 0.1]),
            ),
        ],
        ..m::LeastSquares::default()
    };
    let request = pb::CreateJobRequest {
        input: Some(input(true, asked.clone())),
        ..pb::CreateJobRequest::default()
    };
    let job = client.create_job(request).await.unwrap().into_inner();
    let job = job.job.unwrap();
    let shown = m::LeastSquares {
        data_weights: Vec::new(),
        constraints: Vec::new(),
        ..asked.clone()
    };
    let kind = job.method.unwrap().kind.unwrap();
    assert_eq!(kind, Kind::LeastSquares(shown));
    let id = pb::GetInputRequest { id: job.id };
    let kept = client.get_input(id).await.unwrap().into_inner();
    let kind = kept.input.unwrap().method.unwrap().kind.unwrap();
    assert_eq!(kind, Kind::LeastSquares(asked));
}

/// In JSON the error is located at the invalid part of the constraint.
#[tokio::test]
async fn parts_of_constraints_are_named() {
    let server = Server::start().await;
    let good = json!({"index": 2});
    let fourth = |bad: Value| json!([good, {"index": 5}, {"index": 9}, bad]);
    let job = |constraints: Value| {
        json!({
            "curve": {"points": data::wave(30)},
            "method": {"kind": "least_squares", "control_points": 20, "constraints": constraints},
        })
    };
    let cases = [
        (fourth(json!({"at": 3, "point": [0, 0]})), "/3/at", "start"),
        (
            fourth(json!({"at": {"place": 3}, "point": [0, 0]})),
            "/3/at/place",
            "unknown field",
        ),
        (
            fourth(json!({"at": {"index": "x"}, "point": [0, 0]})),
            "/3/at/index",
            "index of a point",
        ),
        (
            fourth(json!({"at": {"parameter": [0, 1, 2]}, "point": [0, 0]})),
            "/3/at/parameter/2",
            "two parameters",
        ),
        (
            fourth(json!({"at": {"parameter": null}, "point": [0, 0]})),
            "/3/at/parameter",
            "parameter",
        ),
        (
            fourth(json!({"at": "end", "point": "here"})),
            "/3/point",
            "list of numbers",
        ),
        (
            fourth(json!({"at": "end", "point": [0, "y"]})),
            "/3/point/1",
            "number",
        ),
        (
            fourth(json!({"at": "end", "index": 4, "point": [0, 0]})),
            "/3",
            "nothing else",
        ),
        (
            fourth(json!({"at": {"index": [1, 2]}, "point": [0, 0]})),
            "/3",
            "single indices",
        ),
        (fourth(json!("end")), "/3", "index"),
        (fourth(json!(null)), "/3", "index"),
        (json!({"index": 2}), "", "expected a list"),
        (json!(vec![good.clone(); 1001]), "/1000", "at most 1000"),
    ];
    for (constraints, place, reason) in cases {
        let pointer = format!("/method/constraints{place}");
        server
            .assert_refused(&job(constraints), &pointer, reason)
            .await;
    }
    // A weight of a surface has a row and a column.
    let mut weights = vec![vec![1.0; 8]; 8];
    weights[2][5] = -1.0;
    let surface = json!({
        "surface": {"points": data::peaks(8)},
        "method": {"kind": "least_squares", "control_points": 6, "data_weights": weights},
    });
    server
        .assert_refused(&surface, "/method/data_weights/2/5", "not negative")
        .await;
}

/// An edit that moves a point keeps the settings, and an edit can have others.
#[tokio::test]
async fn edits_keep_the_settings_or_have_others() {
    let server = Server::start().await;
    let weights: Vec<f64> = (0..30).map(|i| 1.0 + 0.1 * f64::from(i)).collect();
    let method = json!({
        "kind": "least_squares", "control_points": 12, "variant": "direct", "end_points": "free",
        "data_weights": weights, "fairness": 1e-4, "fairness_order": 3,
        "constraints": [{"index": 7}, {"at": "end", "derivative": [1.0, 0.5]}],
    });
    let job = server
        .fit(&json!({"curve": {"points": data::wave(30)}, "method": method}))
        .await;
    let moved = json!({"points": [{"index": 7, "point": [2.0, 3.0]}]});
    let child = edited(&server, &job, &moved).await;
    let input = server.json(&format!("{}/input", base(&child))).await;
    assert_eq!(input["method"], method);
    // It passes through the point where that is now: the result is that of the same job from the start.
    let again = server.fit(&input).await;
    let net = async |job: &Value| {
        let result = server.json(&format!("{}/result", base(job))).await;
        flat(&result["control_points"])
    };
    let (child, again) = (net(&child).await, net(&again).await);
    let largest = child
        .iter()
        .zip(&again)
        .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    assert!(largest < 1e-9, "{largest:e}");
    let other = json!({"method": {"kind": "least_squares", "control_points": 12, "variant": "direct", "data_weights": [1]}});
    let edits = server.post(&format!("{}/edits", base(&job)));
    let refused = edits.json(&other).send().await.unwrap();
    let (status, answer) = crate::support::problem(refused).await;
    assert_eq!(
        (status, &answer["errors"][0]["pointer"]),
        (422, &json!("/method/data_weights"))
    );
}

async fn edited(server: &Server, job: &Value, edit: &Value) -> Value {
    let edits = server.post(&format!("{}/edits", base(job)));
    let edited = edits.header("prefer", "wait=30").json(edit).send().await;
    edited.unwrap().json().await.unwrap()
}
