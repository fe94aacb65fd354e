//! The gRPC service: the same jobs as those of REST, bit for bit.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tonic::transport::{Channel, Endpoint};
use tonic::{Code, Status, Streaming};
use tonic_types::StatusExt;

use crate::data;
use crate::messages::fitting_service_client::FittingServiceClient;
use crate::messages::{self as pb, job_input, watch_job_response::Event};
use crate::support::{Server, Story};

/// A client of the service, on the port of REST.
pub async fn connect(server: &Server) -> FittingServiceClient<Channel> {
    let endpoint = Endpoint::from_shared(server.url.clone()).unwrap();
    let channel = endpoint.connect().await.unwrap();
    FittingServiceClient::new(channel).max_decoding_message_size(usize::MAX)
}

/// The coordinates of a list or grid of points, one after the other.
pub fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(flat).collect(),
        Value::Null => vec![f64::NAN],
        value => vec![value.as_f64().unwrap()],
    }
}

pub fn curve(points: &Value) -> pb::JobInput {
    let dimension = points[0].as_array().unwrap().len() as u32;
    let curve = pb::Curve {
        dimension,
        points: flat(points),
        ..pb::Curve::default()
    };
    pb::JobInput {
        geometry: Some(job_input::Geometry::Curve(curve)),
        ..pb::JobInput::default()
    }
}

pub fn stop(tolerance: f64, max_iterations: u64) -> Option<pb::StopRules> {
    Some(pb::StopRules {
        rule: Some(pb::stop_rules::Rule::Tolerance(tolerance)),
        max_iterations: Some(max_iterations),
    })
}

fn endless() -> pb::JobInput {
    pb::JobInput {
        stop: stop(0.0, 1_000_000_000),
        ..curve(&data::wave(100))
    }
}

async fn create(client: &mut FittingServiceClient<Channel>, input: pb::JobInput) -> pb::Job {
    let request = pb::CreateJobRequest {
        input: Some(input),
        ..pb::CreateJobRequest::default()
    };
    client
        .create_job(request)
        .await
        .unwrap()
        .into_inner()
        .job
        .unwrap()
}

async fn watch(
    client: &mut FittingServiceClient<Channel>,
    id: &str,
    resume_after: Option<u64>,
    stream: pb::StreamOptions,
) -> Streaming<pb::WatchJobResponse> {
    let request = pb::WatchJobRequest {
        id: id.to_owned(),
        resume_after,
        stream: Some(stream),
    };
    client.watch_job(request).await.unwrap().into_inner()
}

/// A whole stream of messages.
pub struct Messages {
    pub job: pb::JobDescription,
    pub iterations: Vec<pb::Iteration>,
    pub milestones: Vec<Option<f64>>,
    pub end: pb::JobEnd,
}

impl Messages {
    pub async fn read(mut stream: Streaming<pb::WatchJobResponse>) -> Self {
        let mut all = Vec::new();
        while let Some(message) = stream.message().await.unwrap() {
            all.push(message);
        }
        Self::of(all)
    }

    pub fn of(all: Vec<pb::WatchJobResponse>) -> Self {
        let mut all = all.into_iter();
        let Some(Event::Job(job)) = all.next().unwrap().event else {
            panic!("the job comes first");
        };
        let (mut iterations, mut milestones) = (Vec::new(), Vec::new());
        loop {
            let message = all.next().expect("an end");
            match message.event.unwrap() {
                Event::Iteration(iteration) => {
                    iterations.push(iteration);
                    milestones.push(message.milestone);
                }
                Event::End(end) => {
                    assert!(all.next().is_none(), "nothing follows the end");
                    return Self {
                        job,
                        iterations,
                        milestones,
                        end,
                    };
                }
                Event::Job(_) => panic!("a second job"),
            }
        }
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    // JSON has null for whatever is not finite.
    let number = |x: &f64| if x.is_finite() { *x } else { f64::NAN };
    numbers.iter().map(|x| number(x).to_bits()).collect()
}

fn assert_same(numbers: &[f64], json: &Value) {
    assert_eq!(bits(numbers), bits(&flat(json)));
}

fn index(value: &Value, columns: u32) -> u32 {
    match value.as_array() {
        None => value.as_u64().unwrap() as u32,
        Some(pair) => pair[0].as_u64().unwrap() as u32 * columns + pair[1].as_u64().unwrap() as u32,
    }
}

/// An iteration in both languages is the same.
pub fn assert_same_iteration(message: &pb::Iteration, json: &Value, columns: u32) {
    assert_eq!(json["iteration"], message.iteration);
    assert_eq!(json["moved"], message.moved);
    assert_eq!(json["rate"].as_f64(), message.rate);
    let error = message.error.unwrap();
    assert_eq!(json["error"]["max"].as_f64(), Some(error.max));
    assert_eq!(json["error"]["rms"].as_f64(), Some(error.rms));
    assert_eq!(json["error"]["sum"].as_f64(), Some(error.sum));
    assert_eq!(index(&json["error"]["at"], columns), error.at);
    for (name, number) in [
        ("fixed_max", error.fixed_max),
        ("homogeneous", error.homogeneous),
        ("gradient", error.gradient),
        ("transformed", error.transformed),
    ] {
        assert_eq!(json["error"][name].as_f64(), number, "{name}");
    }
    match message.geometry.as_ref() {
        None => assert!(json.get("control_points").is_none()),
        Some(pb::iteration::Geometry::ControlNet(net)) => {
            assert_same(&net.points, &json["control_points"]);
            let count = (net.rows * net.columns * net.dimension) as usize;
            assert_eq!(net.points.len(), count);
            match json.get("weights") {
                None => assert!(net.weights.is_empty()),
                Some(weights) => assert_same(&net.weights, weights),
            }
        }
        Some(pb::iteration::Geometry::Samples(samples)) => {
            assert_same(&samples.points, &json["samples"]);
            let parameters = &json["parameters"];
            match parameters.get("u") {
                None => assert_same(&samples.parameters_u, parameters),
                Some(u) => {
                    assert_same(&samples.parameters_u, u);
                    assert_same(&samples.parameters_v, &parameters["v"]);
                }
            }
        }
        Some(pb::iteration::Geometry::Changes(changes)) => {
            let entries = json["changed"].as_array().unwrap();
            assert_eq!(entries.len(), changes.indices.len());
            let points: Value = entries.iter().map(|entry| entry[1].clone()).collect();
            assert_same(&changes.points, &points);
        }
    }
}

/// The same job over REST and over gRPC, each as JSON and as messages.
#[tokio::test]
async fn every_kind_of_job_is_the_same_in_both_languages() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let cosine: Vec<f64> = (0..100).map(|i| 2.0 + f64::from(i).cos()).collect();
    let jobs = [
        data::small_job(),
        json!({"name": "an arc", "curve": {"points": data::wave(100), "weights": cosine, "closed": true}}),
        json!({"curve": {"points": data::helix(), "weights": cosine[..30], "basis": {"kind": "bernstein"}},
            "rational": "fixed", "stop": {"max_iterations": 20}}),
        json!({"curve": {"points": data::helix(), "parameters": "centripetal", "basis": {"kind": "bspline", "degree": 5, "knots": "averaged"}},
            "method": {"kind": "weighted", "omega": 0.7}}),
        json!({"surface": {"points": data::peaks(12), "basis": {"u": {"kind": "bspline", "degree": 2}, "v": {"kind": "said_ball"}},
            "parameters": {"u": "uniform", "v": "centripetal"}}, "method": {"kind": "extended", "start": "data"}, "stop": {"max_iterations": 7}}),
        json!({"surface": {"points": data::peaks(12)}, "method": {"kind": "local", "indices": [[3, 4], [5, 6]]}}),
        json!({"surface": {"points": data::peaks(12)}, "stop": {"tolerance": 1e-3},
            "method": {"kind": "least_squares", "control_points": {"u": 5, "v": 6}, "variant": "cg"},
            "stream": {"milestones": [9, 3, 2], "encoding": "base64"}}),
        json!({"curve": {"points": data::helix()}, "method": {"kind": "least_squares", "control_points": 9}}),
        json!({"surface": {"points": data::peaks(5), "weights": {"u": [1, 2, 3, 2, 1], "v": [1, 1, 2, 1, 1]}}, "rational": "fixed",
            "method": {"kind": "adaptive", "threshold": 0.01}}),
    ];
    for job in jobs {
        let story = server.fit(&job).await;
        let id = story["id"].as_str().unwrap();
        // What JSON has asked for is asked for again by a message, and the other way round.
        let request = pb::GetInputRequest { id: id.to_owned() };
        let input = client.get_input(request).await.unwrap().into_inner();
        let request = pb::FitRequest {
            input: input.input.clone(),
            ..pb::FitRequest::default()
        };
        let mut fit = client.fit(request).await.unwrap().into_inner();
        let Some(pb::fit_response::Event::Job(again)) = fit.message().await.unwrap().unwrap().event
        else {
            panic!("the job comes first");
        };
        while fit.message().await.unwrap().is_some() {}
        let path = |id: &str, part: &str| format!("/v1/jobs/{id}/{part}");
        let inputs = [id, &again.id].map(|id| path(id, "input"));
        assert_eq!(server.json(&inputs[0]).await, server.json(&inputs[1]).await);
        let request = pb::GetInputRequest {
            id: again.id.clone(),
        };
        let twice = client.get_input(request).await.unwrap().into_inner();
        assert_eq!(twice.input, input.input);

        // Its events in both languages.
        let messages =
            Messages::read(watch(&mut client, &again.id, None, pb::StreamOptions::default()).await)
                .await;
        let events = server.get(&format!("{}?encoding=json", path(&again.id, "events")));
        let (iterations, end) = crate::support::read_thinned(events.send().await.unwrap()).await;
        let columns = messages.job.columns;
        assert_eq!(messages.iterations.len(), iterations.len());
        assert!(!iterations.is_empty());
        for (message, json) in messages.iterations.iter().zip(&iterations) {
            assert_same_iteration(message, json, columns);
        }
        for (milestone, json) in messages.milestones.iter().zip(&iterations) {
            assert_eq!(json.get("milestone").and_then(Value::as_f64), *milestone);
        }
        assert_eq!(end["iterations"], messages.end.iterations);
        assert_eq!(end["elapsed"].as_f64(), messages.end.elapsed);

        // Its result.
        let request = pb::GetResultRequest {
            id: again.id.clone(),
            ..pb::GetResultRequest::default()
        };
        let result = client
            .get_result(request)
            .await
            .unwrap()
            .into_inner()
            .result
            .unwrap();
        let json = server.json(&path(&again.id, "result")).await;
        let Some(pb::fit_result::Geometry::ControlNet(net)) = &result.geometry else {
            panic!("control points");
        };
        assert_same(&net.points, &json["control_points"]);
        let (u, v) = (result.u.unwrap(), result.v);
        match (&json["knots"], v) {
            (Value::Object(knots), Some(v)) => {
                assert_same(&u.knots, &knots["u"]);
                if !knots["v"].is_null() {
                    assert_same(&v.knots, &knots["v"]);
                }
                assert_eq!(json["degree"], json!({"u": u.degree, "v": v.degree}));
            }
            (knots, None) if !knots.is_null() => assert_same(&u.knots, knots),
            _ => assert!(u.knots.is_empty()),
        }
    }
}

#[tokio::test]
async fn streams_resume_after_an_iteration_and_show_what_they_are_asked_for() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let story = server.stream(&data::small_job()).await;
    let id = story.job["id"].as_str().unwrap();
    let plain = pb::StreamOptions::default();
    let rest = Messages::read(watch(&mut client, id, Some(5), plain.clone()).await).await;
    assert_eq!(rest.iterations.len(), story.iterations.len() - 6);
    for (message, json) in rest.iterations.iter().zip(&story.iterations[6..]) {
        assert_same_iteration(message, json, 1);
    }
    let beyond = Messages::read(watch(&mut client, id, Some(u64::MAX), plain.clone()).await).await;
    assert!(beyond.iterations.is_empty());
    for (query, options) in [
        (
            "view=samples&samples=17&every=4",
            pb::StreamOptions {
                view: pb::View::Samples.into(),
                samples_u: 17,
                every: Some(4),
                ..plain.clone()
            },
        ),
        (
            "view=errors&milestones=1e-2,1e-4",
            pb::StreamOptions {
                view: pb::View::Errors.into(),
                milestones: Some(pb::Milestones {
                    distances: vec![1e-2, 1e-4],
                }),
                ..plain
            },
        ),
    ] {
        let events = server.get(&format!("/v1/jobs/{id}/events?{query}"));
        let (iterations, _) = crate::support::read_thinned(events.send().await.unwrap()).await;
        let messages = Messages::read(watch(&mut client, id, None, options).await).await;
        assert_eq!(messages.iterations.len(), iterations.len(), "{query}");
        for (message, json) in messages.iterations.iter().zip(&iterations) {
            assert_same_iteration(message, json, 1);
        }
    }
}

#[tokio::test]
async fn changes_of_local_fits_come_alone() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let job = json!({"curve": {"points": data::wave(100), "weights": vec![1; 100]},
        "method": {"kind": "local", "indices": [0, 7, 99]}});
    let created = server.fit(&job).await;
    let id = created["id"].as_str().unwrap();
    let options = pb::StreamOptions {
        changed: Some(true),
        ..pb::StreamOptions::default()
    };
    let messages = Messages::read(watch(&mut client, id, None, options).await).await;
    let path = format!("/v1/jobs/{id}/events?changed=true");
    let story = Story::read(server.get(&path).send().await.unwrap()).await;
    for (message, json) in messages.iterations.iter().zip(&story.iterations) {
        assert_same_iteration(message, json, 1);
    }
    let Some(pb::iteration::Geometry::Changes(changes)) = &messages.iterations[3].geometry else {
        panic!("only the first is complete");
    };
    // The end points are there twice.
    assert_eq!(changes.indices, [0, 1, 8, 100, 101]);
    assert_eq!(changes.weights.len(), 5);
}

#[tokio::test]
async fn jobs_are_listed_cancelled_edited_and_deleted() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let running = create(&mut client, endless()).await;
    let mut stream = watch(&mut client, &running.id, None, pb::StreamOptions::default()).await;
    for _ in 0..10 {
        stream.message().await.unwrap().unwrap();
    }
    let id = || running.id.clone();
    let cancelled = client.cancel_job(pb::CancelJobRequest { id: id() }).await;
    let cancelled = cancelled.unwrap().into_inner().job.unwrap();
    assert_eq!(cancelled.state(), pb::JobState::Cancelled);
    let mut last = None;
    while let Some(message) = stream.message().await.unwrap() {
        last = message.event;
    }
    let Some(Event::End(end)) = last else {
        panic!("an end");
    };
    assert_eq!(end.state(), pb::JobState::Cancelled);
    let edit = pb::Edit {
        name: Some("moved".to_owned()),
        iteration: Some(3),
        moved: vec![5],
        points: vec![1.5, 2.5],
        stop: stop(1e-6, 1000),
        ..pb::Edit::default()
    };
    let request = pb::EditJobRequest {
        id: id(),
        edit: Some(edit),
        idempotency_key: "the edit".to_owned(),
    };
    let edited = client.edit_job(request.clone()).await.unwrap().into_inner();
    let replayed = client.edit_job(request).await.unwrap().into_inner();
    let (edited, again) = (edited.job.unwrap(), replayed.job.unwrap());
    assert!(replayed.replayed && edited.id == again.id);
    assert_eq!(
        edited.parent.unwrap(),
        pb::Parent {
            id: id(),
            iteration: 3
        }
    );
    let stream = watch(&mut client, &edited.id, None, pb::StreamOptions::default()).await;
    Messages::read(stream).await;
    let ended = client.cancel_job(pb::CancelJobRequest { id: again.id });
    let status = ended.await.unwrap_err();
    assert_eq!(status.code(), Code::FailedPrecondition);
    let path = format!("/v1/jobs/{}/input", edited.id);
    assert_eq!(
        server.json(&path).await["curve"]["points"][5],
        json!([1.5, 2.5])
    );

    let list = |state: pb::JobState, page_size, page_token| pb::ListJobsRequest {
        state: state.into(),
        page_size,
        page_token,
    };
    let all = pb::JobState::Unspecified;
    let first = client
        .list_jobs(list(all, 1, String::new()))
        .await
        .unwrap()
        .into_inner();
    assert_eq!(first.jobs[0].id, edited.id);
    let second = client
        .list_jobs(list(all, 1, first.next_page_token))
        .await
        .unwrap()
        .into_inner();
    assert_eq!(second.jobs[0].id, running.id);
    assert_eq!(second.next_page_token, "");
    let cancelled = list(pb::JobState::Cancelled, 0, String::new());
    let only = client.list_jobs(cancelled).await.unwrap().into_inner();
    assert_eq!(only.jobs.len(), 1);

    client
        .delete_job(pb::DeleteJobRequest { id: id() })
        .await
        .unwrap();
    let gone = client.get_job(pb::GetJobRequest { id: id() }).await;
    assert_eq!(gone.unwrap_err().code(), Code::NotFound);
}

#[tokio::test]
async fn the_same_key_gives_the_same_job() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let mut request = pb::CreateJobRequest {
        input: Some(curve(&data::helix())),
        idempotency_key: "a key".to_owned(),
    };
    let first = client
        .create_job(request.clone())
        .await
        .unwrap()
        .into_inner();
    let second = client
        .create_job(request.clone())
        .await
        .unwrap()
        .into_inner();
    assert!(!first.replayed && second.replayed);
    assert_eq!(first.job.unwrap().id, second.job.unwrap().id);
    request.input = Some(curve(&data::lemniscate()));
    let refused = client.create_job(request).await.unwrap_err();
    assert_eq!(refused.code(), Code::InvalidArgument);
    assert_eq!(
        refused.get_details_error_info().unwrap().reason,
        "KEY_TAKEN"
    );
}

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
async fn several_mistakes_are_told_at_once() {
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
            "1 to 3",
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
            "30 is not one of the 30 points",
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
        id: "nobody".to_owned(),
    };
    let status = client.get_job(request).await.unwrap_err();
    assert_eq!(
        status.get_details_error_info().unwrap().reason,
        "UNKNOWN_JOB"
    );
}

#[tokio::test]
async fn a_job_can_end_with_its_client() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    for (on_disconnect, expected) in [
        (pb::OnDisconnect::Cancel, "cancelled"),
        (pb::OnDisconnect::Continue, "running"),
    ] {
        let request = pb::FitRequest {
            input: Some(endless()),
            stream: Some(pb::StreamOptions {
                on_disconnect: on_disconnect.into(),
                ..pb::StreamOptions::default()
            }),
            ..pb::FitRequest::default()
        };
        let mut stream = client.fit(request).await.unwrap().into_inner();
        stream.message().await.unwrap().unwrap();
        drop(stream);
        let begin = Instant::now();
        loop {
            tokio::time::sleep(Duration::from_millis(50)).await;
            let state = server.json("/v1/jobs").await["jobs"][0]["state"].clone();
            if state == expected && begin.elapsed() > Duration::from_millis(300) {
                break;
            }
            assert!(begin.elapsed() < Duration::from_secs(20), "{state}");
        }
    }
}

#[tokio::test]
async fn a_client_that_watches_cannot_end_the_job() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let job = create(&mut client, endless()).await;
    let request = pb::WatchJobRequest {
        id: job.id,
        stream: Some(pb::StreamOptions {
            on_disconnect: pb::OnDisconnect::Cancel.into(),
            ..pb::StreamOptions::default()
        }),
        ..pb::WatchJobRequest::default()
    };
    let status = client.watch_job(request).await.unwrap_err();
    assert_eq!(status.code(), Code::InvalidArgument);
    let violations = status.get_details_bad_request().unwrap().field_violations;
    assert_eq!(violations[0].field, "stream.on_disconnect");
}

/// A client that does not read holds a bounded number of frames, and nobody else.
#[tokio::test]
async fn a_client_that_does_not_read_holds_up_nobody() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let job = create(&mut client, endless()).await;
    let stuck = watch(&mut client, &job.id, None, pb::StreamOptions::default()).await;
    let mut other = connect(&server).await;
    let mut reading = watch(&mut other, &job.id, None, pb::StreamOptions::default()).await;
    for _ in 0..3000 {
        reading.message().await.unwrap().unwrap();
    }
    assert_eq!(server.fit(&data::small_job()).await["state"], "converged");
    drop(stuck);
}

#[tokio::test]
async fn streams_end_when_the_server_stops() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let job = create(&mut client, endless()).await;
    let mut stream = watch(&mut client, &job.id, None, pb::StreamOptions::default()).await;
    stream.message().await.unwrap().unwrap();
    let reader = tokio::spawn(async move {
        loop {
            match stream.message().await {
                Ok(Some(_)) => {}
                ended => return ended,
            }
        }
    });
    let begin = Instant::now();
    server.stop().await;
    assert!(begin.elapsed() < Duration::from_secs(3));
    let status = reader.await.unwrap().unwrap_err();
    assert_eq!(status.code(), Code::Unavailable);
    assert!(status.get_details_retry_info().is_some());
}

/// A message may be as large as a body of REST.
#[tokio::test]
async fn messages_have_the_limit_of_bodies() {
    let server = Server::with(|config| config.max_body = "1KiB".parse().unwrap()).await;
    let mut client = connect(&server).await;
    create(&mut client, curve(&data::helix())).await;
    let request = pb::CreateJobRequest {
        input: Some(curve(&data::wave(100))),
        ..pb::CreateJobRequest::default()
    };
    let status = client.create_job(request).await.unwrap_err();
    assert_eq!(status.code(), Code::ResourceExhausted);
}

/// What is no call of a service is a resource that does not exist, or a call that is not implemented.
#[tokio::test]
async fn other_paths_stay_those_of_rest() {
    let server = Server::start().await;
    let response = server.get("/piad.v1/nothing").send().await.unwrap();
    assert_eq!(crate::support::problem(response).await.0, 404);
    let request = server.post("/piad.v1.FittingService/Nothing");
    let response = request
        .header("content-type", "application/grpc")
        .send()
        .await
        .unwrap();
    assert_eq!(response.headers()["grpc-status"], "12");
}
