//! `FitBatch`: a stream of items, and one of what came of them.

use std::time::Duration;

use futures_util::stream;
use tokio::sync::mpsc;
use tokio::time::timeout;
use tonic::{Code, Status, Streaming};
use tonic_types::StatusExt;

use super::{connect, curve, endless, stop};
use crate::data;
use crate::messages::fit_batch_request::Part as Sent;
use crate::messages::fit_batch_response::Part;
use crate::messages::{self as pb, fit_result::Geometry, job_input};
use crate::support::{PATIENCE, Server};

fn item(input: pb::JobInput) -> pb::FitBatchRequest {
    let part = Some(Sent::Item(input));
    pb::FitBatchRequest { part }
}

fn options(options: pb::BatchOptions) -> pb::FitBatchRequest {
    let part = Some(Sent::Options(options));
    pb::FitBatchRequest { part }
}

fn named(name: &str, input: pb::JobInput) -> pb::JobInput {
    let name = Some(name.to_owned());
    pb::JobInput { name, ..input }
}

/// All responses of a call that ends well.
async fn all(
    server: &Server,
    requests: Vec<pb::FitBatchRequest>,
) -> (Vec<pb::BatchItem>, pb::BatchTotals) {
    let mut client = connect(server).await;
    let answer = client.fit_batch(stream::iter(requests)).await.unwrap();
    let (items, end) = read(answer.into_inner()).await;
    (items, end.unwrap().expect("totals"))
}

/// The items of an answer, and its totals or the status at its end.
async fn read(
    mut answer: Streaming<pb::FitBatchResponse>,
) -> (Vec<pb::BatchItem>, Result<Option<pb::BatchTotals>, Status>) {
    let (mut items, mut totals) = (Vec::new(), None);
    loop {
        match answer.message().await {
            Err(status) => return (items, Err(status)),
            Ok(None) => return (items, Ok(totals)),
            Ok(Some(response)) => match response.part.unwrap() {
                Part::Item(item) => {
                    assert!(totals.is_none(), "nothing follows the totals");
                    assert_eq!(item.index, items.len() as u64);
                    items.push(item);
                }
                Part::Totals(it) => totals = Some(it),
            },
        }
    }
}

/// The same results as those of jobs, bit for bit, but for their ids.
#[tokio::test]
async fn items_are_what_jobs_are() {
    let server = Server::start().await;
    let surface = data::peaks(60);
    let rows: Vec<f64> = surface
        .as_array()
        .unwrap()
        .iter()
        .flat_map(crate::numbers::flat)
        .collect();
    let surface = pb::Surface {
        dimension: 3,
        rows: 60,
        columns: 60,
        points: rows,
        ..pb::Surface::default()
    };
    let surface = pb::JobInput {
        geometry: Some(job_input::Geometry::Surface(surface)),
        ..pb::JobInput::default()
    };
    let wrong = curve(&serde_json::json!([[0, 0], [1, 1], [1, 1]]));
    let short = pb::JobInput {
        stop: stop(1e-9, 3),
        ..curve(&data::helix())
    };
    let inputs = [
        named("wave", curve(&data::wave(50))),
        surface,
        named("long", curve(&data::wave(5000))),
        named("wrong", wrong),
        short,
    ];
    let (items, totals) = all(&server, inputs.iter().cloned().map(item).collect()).await;
    assert_eq!((totals.items, totals.converged, totals.failed), (5, 3, 2));
    assert!(totals.seconds > 0.0);
    let mut client = connect(&server).await;
    for index in [0, 1, 2, 4] {
        let request = pb::FitRequest {
            input: Some(inputs[index].clone()),
            ..pb::FitRequest::default()
        };
        let mut events = client.fit(request).await.unwrap().into_inner();
        let mut id = String::new();
        while let Some(event) = events.message().await.unwrap() {
            if let Some(pb::fit_response::Event::Job(job)) = event.event {
                id = job.id;
            }
        }
        let request = pb::GetResultRequest {
            id,
            ..pb::GetResultRequest::default()
        };
        let kept = client.get_result(request).await.unwrap().into_inner();
        let kept = pb::FitResult {
            id: String::new(),
            ..kept.result.unwrap()
        };
        assert_eq!(items[index].result.as_ref(), Some(&kept), "{index}");
        assert_eq!(items[index].name, inputs[index].name);
        assert_eq!(items[index].state, kept.state);
    }
    let problem = items[3].problem.as_ref().unwrap();
    assert_eq!(problem.r#type, "/problems/invalid-fit");
    assert_eq!(problem.errors[0].field, "item.curve.points[4]");
    assert_eq!(
        (items[3].state(), &items[3].result),
        (pb::JobState::Failed, &None)
    );
    let problem = items[4].problem.as_ref().unwrap();
    assert_eq!(problem.r#type, "/problems/not-converged");
    assert_eq!(items[4].state(), pb::JobState::Exhausted);
}

/// Options come first, and hold for all items.
#[tokio::test]
async fn items_have_the_options_of_the_first_message() {
    let server = Server::start().await;
    let defaults = pb::JobInput {
        stop: stop(0.5, 7),
        ..pb::JobInput::default()
    };
    let chosen = pb::BatchOptions {
        defaults: Some(defaults),
        view: pb::View::Samples.into(),
        samples_u: 9,
        samples_v: 0,
    };
    let strict = pb::JobInput {
        stop: stop(1e-12, 5),
        ..curve(&data::wave(20))
    };
    let requests = vec![options(chosen), item(curve(&data::wave(20))), item(strict)];
    let (items, _) = all(&server, requests).await;
    let states: Vec<_> = items.iter().map(pb::BatchItem::state).collect();
    assert_eq!(states, [pb::JobState::Converged, pb::JobState::Exhausted]);
    let results = items.iter().map(|item| item.result.as_ref().unwrap());
    for (result, iteration) in results.zip([0, 5]) {
        let Some(Geometry::Samples(samples)) = &result.geometry else {
            panic!("samples");
        };
        assert_eq!((samples.rows, samples.points.len()), (9, 18));
        assert_eq!(result.iteration, iteration);
    }
    let (none, totals) = all(&server, vec![]).await;
    assert_eq!((none.len(), totals.items), (0, 0));
}

/// The status of a call that ends early has the reason, after the previous responses.
#[tokio::test]
async fn wrong_messages_end_the_call() {
    let server = Server::with(|config| config.max_body = "20kB".parse().unwrap()).await;
    let good = || item(curve(&data::wave(20)));
    let none = pb::BatchOptions::default;
    let nothing = pb::FitBatchRequest { part: None };
    let unknown = pb::BatchOptions { view: 77, ..none() };
    let large = item(curve(&data::wave(2000)));
    let mut client = connect(&server).await;
    for (requests, before, code, reason) in [
        (
            vec![good(), options(none())],
            1,
            Code::InvalidArgument,
            "options: they are in the first message alone",
        ),
        (
            vec![good(), nothing],
            1,
            Code::InvalidArgument,
            "item: it is missing",
        ),
        (
            vec![options(unknown), good()],
            0,
            Code::InvalidArgument,
            "options.view",
        ),
        (
            vec![good(), good(), large],
            2,
            Code::ResourceExhausted,
            "a message is larger than 20000 bytes",
        ),
    ] {
        let answer = client.fit_batch(stream::iter(requests)).await.unwrap();
        let (items, end) = read(answer.into_inner()).await;
        let status = end.unwrap_err();
        assert_eq!((items.len(), status.code()), (before, code), "{status:?}");
        assert!(status.message().contains(reason), "{status:?}");
        assert!(status.get_details_error_info().is_some());
    }
}

/// Responses come while requests are sent, and a client that goes away ends its fits.
#[tokio::test]
async fn both_streams_are_open_at_a_time() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let (sender, requests) = mpsc::channel(1);
    let requests = stream::unfold(requests, |mut requests| async {
        Some((requests.recv().await?, requests))
    });
    let mut answer = client.fit_batch(requests).await.unwrap().into_inner();
    for index in 0..3 {
        sender.send(item(curve(&data::wave(20)))).await.unwrap();
        let response = timeout(PATIENCE, answer.message()).await.unwrap();
        let Some(Part::Item(item)) = response.unwrap().unwrap().part else {
            panic!("an item");
        };
        assert_eq!(item.index, index);
    }
    sender.send(item(endless())).await.unwrap();
    server.until("piad_jobs_running", 1.0).await;
    tokio::time::sleep(Duration::from_millis(50)).await;
    drop((answer, sender));
    server.until("piad_jobs_running", 0.0).await;
}
