//! What operators and generic clients expect of a gRPC server: reflection and health.

use std::time::{Duration, Instant};

use futures_util::stream;
use tonic::Code;
use tonic::transport::{Channel, Endpoint};
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_client::HealthClient;
use tonic_reflection::pb::{v1, v1alpha};

use crate::support::Server;

const SERVICE: &str = "piad.v1.FittingService";

async fn channel(server: &Server) -> Channel {
    let endpoint = Endpoint::from_shared(server.url.clone()).unwrap();
    endpoint.connect().await.unwrap()
}

#[tokio::test]
async fn reflection_lists_the_service() {
    use v1::server_reflection_request::MessageRequest;
    use v1::server_reflection_response::MessageResponse;
    let server = Server::start().await;
    let channel = channel(&server).await;
    let mut client = v1::server_reflection_client::ServerReflectionClient::new(channel.clone());
    let ask = |request| v1::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(request),
    };
    let requests = [
        MessageRequest::ListServices(String::new()),
        MessageRequest::FileContainingSymbol("piad.v1.JobInput".to_owned()),
    ];
    let requests = stream::iter(requests.map(ask));
    let mut answers = client
        .server_reflection_info(requests)
        .await
        .unwrap()
        .into_inner();
    let services = answers.message().await.unwrap().unwrap().message_response;
    let Some(MessageResponse::ListServicesResponse(services)) = services else {
        panic!("services");
    };
    let names: Vec<&str> = services.service.iter().map(|it| it.name.as_str()).collect();
    assert!(names.contains(&SERVICE), "{names:?}");
    assert!(names.contains(&"grpc.health.v1.Health"), "{names:?}");
    let file = answers.message().await.unwrap().unwrap().message_response;
    assert!(matches!(
        file,
        Some(MessageResponse::FileDescriptorResponse(_))
    ));

    // Older clients know the alpha version only.
    let mut client = v1alpha::server_reflection_client::ServerReflectionClient::new(channel);
    let request = v1alpha::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(
            v1alpha::server_reflection_request::MessageRequest::ListServices(String::new()),
        ),
    };
    let request = stream::iter([request]);
    let mut answers = client
        .server_reflection_info(request)
        .await
        .unwrap()
        .into_inner();
    let answer = answers.message().await.unwrap().unwrap();
    assert!(format!("{answer:?}").contains(SERVICE));
}

#[tokio::test]
async fn health_is_told_and_ends_with_the_server() {
    let server = Server::start().await;
    let mut client = HealthClient::new(channel(&server).await);
    for service in ["", SERVICE] {
        let request = || HealthCheckRequest {
            service: service.to_owned(),
        };
        let begin = Instant::now();
        // The service is announced as soon as the server is there.
        loop {
            match client.check(request()).await {
                Ok(answer) => {
                    let status = answer.into_inner().status();
                    assert_eq!(status, ServingStatus::Serving);
                    break;
                }
                Err(status) => assert_eq!(status.code(), Code::NotFound),
            }
            assert!(begin.elapsed() < Duration::from_secs(5));
        }
    }
    let request = HealthCheckRequest {
        service: "nobody".to_owned(),
    };
    let unknown = client.check(request).await.unwrap_err();
    assert_eq!(unknown.code(), Code::NotFound);
    let request = HealthCheckRequest {
        service: SERVICE.to_owned(),
    };
    let mut watch = client.watch(request).await.unwrap().into_inner();
    let first = watch.message().await.unwrap().unwrap();
    assert_eq!(first.status(), ServingStatus::Serving);
    let begin = Instant::now();
    server.stop().await;
    assert!(begin.elapsed() < Duration::from_secs(3));
    // Whether it still hears that the server does not serve any more is a matter of luck.
    let ended = loop {
        match watch.message().await {
            Ok(Some(answer)) => assert_eq!(answer.status(), ServingStatus::NotServing),
            ended => break ended,
        }
    };
    assert_eq!(ended.unwrap_err().code(), Code::Unavailable);
}
