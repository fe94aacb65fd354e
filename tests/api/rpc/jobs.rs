//! Jobs by gRPC: their streams, lists, edits and keys.

use serde_json::json;
use tonic::Code;
use tonic_types::StatusExt;

use super::{Messages, assert_same_iteration, connect, create, curve, endless, stop, watch};
use crate::data;
use crate::messages::{self as pb, watch_job_response::Event};
use crate::support::{Server, Story};

#[tokio::test]
async fn streams_resume_after_an_iteration_with_the_requested_view() {
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
    let last = story.iterations.len() as u64 - 1;
    let beyond = Messages::read(watch(&mut client, id, Some(last), plain.clone()).await).await;
    assert!(beyond.iterations.is_empty());
    let request = pb::WatchJobRequest {
        id: id.to_owned(),
        resume_after: Some(u64::MAX),
        stream: None,
    };
    let refused = client.watch_job(request).await.unwrap_err();
    assert_eq!(refused.code(), tonic::Code::InvalidArgument);
    assert!(refused.message().starts_with("resume_after: "), "{refused}");
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
