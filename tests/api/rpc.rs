//! The gRPC service: the same jobs as those of REST, bit for bit.

mod batch;
mod ends;
mod errors;
mod jobs;

use serde_json::{Value, json};
use tonic::metadata::AsciiMetadataValue;
use tonic::service::Interceptor;
use tonic::service::interceptor::InterceptedService;
use tonic::transport::{Channel, Endpoint};
use tonic::{Request, Status, Streaming};

use crate::data;
use crate::messages::fitting_service_client::FittingServiceClient;
use crate::messages::{self as pb, job_input, watch_job_response::Event};
use crate::numbers::flat;
use crate::support::{Server, authorization};

/// A client of the service.
pub type RpcClient = FittingServiceClient<InterceptedService<Channel, Authorization>>;

/// Sends the token of tests, if there is one.
#[derive(Clone)]
pub struct Authorization(Option<AsciiMetadataValue>);

impl Interceptor for Authorization {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(value) = &self.0 {
            request
                .metadata_mut()
                .insert("authorization", value.clone());
        }
        Ok(request)
    }
}

/// A client of a server, on the port of REST.
pub async fn connect(server: &Server) -> RpcClient {
    connect_to(server.url.clone()).await
}

/// A client of the server at this URL.
pub async fn connect_to(url: String) -> RpcClient {
    let endpoint = Endpoint::from_shared(url).unwrap();
    let channel = endpoint.connect().await.unwrap();
    let value = authorization().map(|text| text.parse().unwrap());
    FittingServiceClient::with_interceptor(channel, Authorization(value))
        .max_decoding_message_size(usize::MAX)
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

async fn create(client: &mut RpcClient, input: pb::JobInput) -> pb::Job {
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

pub async fn watch(
    client: &mut RpcClient,
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
    let knots = [json["knots"].get("u"), json["knots"].get("v")];
    match (json.get("knots"), knots) {
        (Some(_), [Some(u), Some(v)]) => {
            assert_same(&message.knots_u, u);
            assert_same(&message.knots_v, v);
        }
        (Some(knots), _) => assert_same(&message.knots_u, knots),
        (None, _) => assert!(message.knots_u.is_empty() && message.knots_v.is_empty()),
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
        Some(pb::iteration::Geometry::Deltas(_)) => panic!("JSON has no counterpart"),
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
        json!({"curve": {"points": data::helix()}, "stop": {"tolerance": 0.01},
            "method": {"kind": "least_squares", "control_points": "auto", "max_control_points": 20, "correct_parameters": true}}),
        json!({"surface": {"points": data::peaks(12)}, "stop": {"tolerance": 0.5}, "method": {"kind": "least_squares", "control_points": "auto"}}),
        json!({"surface": {"points": data::peaks(12)}, "stop": {"tolerance": 0.5},
            "method": {"kind": "least_squares", "control_points": "auto", "fairness": 1e-10, "constraints": [{"index": [3, 4]}]}}),
        json!({"surface": {"points": data::peaks(5), "weights": {"u": [1, 2, 3, 2, 1], "v": [1, 1, 2, 1, 1]}}, "rational": "fixed",
            "method": {"kind": "adaptive", "threshold": 0.01}}),
    ];
    for job in jobs {
        let story = server.fit(&job).await;
        let id = story["id"].as_str().unwrap();
        // A request in JSON is repeated as a message, and vice versa.
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
        let details = end["warnings"].as_array().unwrap().iter();
        let details = details.map(|it| it["detail"].as_str().unwrap());
        assert!(details.eq(messages.end.warnings.iter().map(|it| it.detail.as_str())));

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
