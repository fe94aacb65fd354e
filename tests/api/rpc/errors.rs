//! Errors of a call are located at the invalid field.

use serde_json::json;
use tonic::{Code, Status};
use tonic_types::StatusExt;

use super::{Messages, connect, create, curve, stop, watch};
use crate::data;
use crate::messages::{self as pb, job_input};
use crate::numbers::flat;
use crate::support::Server;

fn assert_violation(status: &Status, field: &str, reason: &str) {
    assert_eq!(status.code(), Code::InvalidArgument, "{status:?}");
    let bad = status.get_details_bad_request().expect("field violations");
    let violation = &bad.field_violations[0];
    assert_eq!(violation.field, field, "{violation:?}");
    assert!(violation.description.contains(reason), "{violation:?}");
    let info = status.get_details_error_info().unwrap();
    assert_eq!(info.domain, "piad");
}

#[tokio::test]
async fn several_errors_are_reported_together() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let bad_rule = pb::Parameters {
        rule: 99,
        ..pb::Parameters::default()
    };
    let mut input = curve(&data::helix());
    let Some(job_input::Geometry::Curve(it)) = &mut input.geometry else {
        panic!("a curve");
    };
    it.parameters = Some(bad_rule);
    input.rational = 99;
    input.stream = Some(pb::StreamOptions {
        samples_v: 3,
        ..pb::StreamOptions::default()
    });
    let request = pb::CreateJobRequest {
        input: Some(input),
        ..pb::CreateJobRequest::default()
    };
    let status = client.create_job(request).await.unwrap_err();
    let bad = status.get_details_bad_request().unwrap();
    let fields = bad.field_violations.iter().map(|it| it.field.as_str());
    let expected = [
        "input.curve.parameters.rule",
        "input.stream.samples_u",
        "input.rational",
    ];
    assert_eq!(fields.collect::<Vec<_>>(), expected);
    for field in expected {
        assert!(status.message().contains(field), "{status:?}");
    }
}

#[tokio::test]
async fn errors_name_the_fields_that_are_wrong() {
    let server = Server::with(|config| config.max_points = 1000).await;
    let mut client = connect(&server).await;
    let points = json!([[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 1, 0], [3, 1, 0]]);
    let good = || curve(&data::helix());
    let of_curve = |change: &dyn Fn(&mut pb::Curve)| {
        let mut input = good();
        let Some(job_input::Geometry::Curve(curve)) = &mut input.geometry else {
            panic!("a curve");
        };
        change(curve);
        input
    };
    let of_surface = |change: &dyn Fn(&mut pb::Surface)| {
        let mut surface = pb::Surface {
            dimension: 3,
            rows: 5,
            columns: 6,
            points: flat(&data::peaks(6))[..90].to_vec(),
            ..pb::Surface::default()
        };
        change(&mut surface);
        pb::JobInput {
            geometry: Some(job_input::Geometry::Surface(surface)),
            ..pb::JobInput::default()
        }
    };
    let with = |kind| pb::JobInput {
        method: Some(pb::Method { kind: Some(kind) }),
        ..good()
    };
    let local = |indices: &[u32]| {
        with(pb::method::Kind::Local(pb::method::Local {
            indices: indices.to_vec(),
            ..pb::method::Local::default()
        }))
    };
    let weighted = pb::method::Weighted {
        omega: Some(f64::NAN),
    };
    let cases = [
        (pb::JobInput::default(), "input", "a curve or a surface"),
        (
            curve(&points),
            "input.curve.points[6]",
            "point 2 equals point 1",
        ),
        (
            of_curve(&|it| it.points[7] = f64::NAN),
            "input.curve.points[6]",
            "finite",
        ),
        (
            of_curve(&|it| it.dimension = 0),
            "input.curve.dimension",
            "1 to 16",
        ),
        (
            of_curve(&|it| it.points.truncate(89)),
            "input.curve.points",
            "89 numbers",
        ),
        (
            of_curve(&|it| it.points = vec![0.5; 3003]),
            "input.curve.points",
            "the limit here",
        ),
        (
            of_curve(&|it| it.weights = vec![1.0; 29]),
            "input.curve.weights",
            "29 weights",
        ),
        (
            of_curve(&|it| {
                it.parameters = Some(pb::Parameters {
                    rule: 0,
                    values: vec![0.0; 30],
                })
            }),
            "input.curve.parameters.values[1]",
            "increase",
        ),
        (
            of_curve(&|it| {
                it.parameters = Some(pb::Parameters {
                    rule: 9,
                    values: vec![],
                })
            }),
            "input.curve.parameters.rule",
            "9 is no value",
        ),
        (
            of_curve(&|it| {
                it.basis = Some(pb::Basis {
                    degree: Some(0),
                    ..pb::Basis::default()
                })
            }),
            "input.curve.basis.degree",
            "below 1",
        ),
        (
            of_surface(&|it| it.points[3 * 8] = f64::INFINITY),
            "input.surface.points[24]",
            "finite",
        ),
        (
            of_surface(&|it| it.rows = 7),
            "input.surface.points",
            "7 rows",
        ),
        (
            of_surface(&|it| it.missing = vec![30]),
            "input.surface.missing[0]",
            "30 is not one",
        ),
        (
            of_surface(&|it| it.weights = vec![-1.0; 30]),
            "input.surface.weights[0]",
            "greater than 0",
        ),
        (
            of_surface(&|it| {
                it.v = Some(pb::SurfaceDirection {
                    basis: Some(pb::Basis {
                        knots: vec![0.0; 4],
                        ..pb::Basis::default()
                    }),
                    ..pb::SurfaceDirection::default()
                })
            }),
            "input.surface.v.basis.knots",
            "4 knots given",
        ),
        (
            local(&[3, 30]),
            "input.method.local.indices[1]",
            "there are 30 points",
        ),
        (local(&[3, 3]), "input.method.local.indices[1]", "repeats"),
        (
            with(pb::method::Kind::Weighted(weighted)),
            "input.method.weighted.omega",
            "NaN",
        ),
        (
            pb::JobInput {
                stop: stop(-1.0, 10),
                ..good()
            },
            "input.stop.tolerance",
            "zero or greater",
        ),
        (
            pb::JobInput {
                rational: 1,
                ..good()
            },
            "input.rational",
            "no weights",
        ),
        (
            pb::JobInput {
                name: Some("x".repeat(201)),
                ..good()
            },
            "input.name",
            "200",
        ),
        (
            pb::JobInput {
                stream: Some(pb::StreamOptions {
                    every: Some(0),
                    ..pb::StreamOptions::default()
                }),
                ..good()
            },
            "input.stream.every",
            "positive",
        ),
    ];
    for (input, field, reason) in cases {
        let request = pb::CreateJobRequest {
            input: Some(input),
            ..pb::CreateJobRequest::default()
        };
        let status = client.create_job(request).await.unwrap_err();
        assert_violation(&status, field, reason);
    }
    // Options of the call are checked before there is a job.
    let request = pb::FitRequest {
        input: Some(good()),
        stream: Some(pb::StreamOptions {
            changed: Some(true),
            every: Some(2),
            ..pb::StreamOptions::default()
        }),
        ..pb::FitRequest::default()
    };
    let status = client.fit(request).await.unwrap_err();
    assert_violation(&status, "stream.changed", "do not go together");
    assert_eq!(server.json("/v1/jobs").await["jobs"], json!([]));

    let id = create(&mut client, good()).await.id;
    // A job that has not ended has nothing to start from.
    Messages::read(watch(&mut client, &id, None, pb::StreamOptions::default()).await).await;
    let edit = |edit| pb::EditJobRequest {
        id: id.clone(),
        edit: Some(edit),
        ..pb::EditJobRequest::default()
    };
    let moved = |moved: &[u32], points: &[f64]| pb::Edit {
        moved: moved.to_vec(),
        points: points.to_vec(),
        ..pb::Edit::default()
    };
    let weighted = pb::Edit {
        weighted: vec![1],
        point_weights: vec![2.0],
        ..moved(&[1], &[0.0; 3])
    };
    for (message, field, reason) in [
        (pb::Edit::default(), "edit", "changes something"),
        (moved(&[1, 30], &[0.0; 6]), "edit.moved[1]", "30 is not one"),
        (moved(&[1, 1], &[0.0; 6]), "edit.moved[1]", "moved before"),
        (moved(&[1, 2], &[0.0; 4]), "edit.points[0]", "2 coordinates"),
        (moved(&[1, 2], &[0.0; 5]), "edit.points", "5 coordinates"),
        (
            moved(&[1, 2], &[0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0]),
            "edit.points[3]",
            "finite",
        ),
        (weighted, "edit.point_weights[0]", "homogeneous"),
        (
            pb::Edit {
                weights: Some(pb::Weights {
                    values: vec![1.0, 2.0],
                    ..pb::Weights::default()
                }),
                weighted: vec![3],
                point_weights: vec![2.0],
                ..pb::Edit::default()
            },
            "edit.weights.values",
            "2 weights for 30 points",
        ),
        (
            pb::Edit {
                iteration: Some(u64::MAX),
                ..moved(&[1], &[0.0; 3])
            },
            "edit.iteration",
            "before",
        ),
        (
            pb::Edit {
                ephemeral: true,
                ..moved(&[1], &[0.0; 3])
            },
            "edit.ephemeral",
            "exists only as a stream",
        ),
    ] {
        let status = client.edit_job(edit(message)).await.unwrap_err();
        assert_violation(&status, field, reason);
    }
    let request = pb::GetIterationRequest {
        id: id.clone(),
        samples_u: 7,
        ..pb::GetIterationRequest::default()
    };
    let status = client.get_iteration(request).await.unwrap_err();
    assert_violation(&status, "samples_u", "not samples");
    let request = pb::GetIterationRequest {
        id,
        iteration: Some(1_000_000),
        ..pb::GetIterationRequest::default()
    };
    let status = client.get_iteration(request).await.unwrap_err();
    assert_eq!(status.code(), Code::NotFound);
    let request = pb::GetJobRequest {
        id: "unknown".to_owned(),
    };
    let status = client.get_job(request).await.unwrap_err();
    assert_eq!(
        status.get_details_error_info().unwrap().reason,
        "UNKNOWN_JOB"
    );
}
