//! Calls and clients that end, or should: both by gRPC.

use tonic::Code;
use tonic_types::StatusExt;

use super::{connect, create, curve, endless, watch};
use crate::data;
use crate::messages as pb;
use crate::support::{NEVER, Server, base};

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
        // The server has seen that the client is gone.
        server.until("piad_streams_open", 0.0).await;
        let job = server.json("/v1/jobs").await["jobs"][0].clone();
        server.until_state(base(&job), expected).await;
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

/// A client that does not read holds a bounded number of frames, and does not delay others.
#[tokio::test]
async fn a_client_that_does_not_read_delays_no_other() {
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
    // Waiting for the grace period would take forever.
    let server = Server::with(|config| config.grace = NEVER).await;
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
    server.stop().await;
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
